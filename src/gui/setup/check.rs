//! The last step: checks that pressed keys arrive in the system. During the check they are sent to this window.

use egui::{Event, Ui};

use super::paragraph;
use crate::app::services::{OutputChoice, PlayRequest};
use crate::gui::edit::keyboard;
use crate::gui::play::UiAction;
use crate::gui::playing::Playing;
use crate::gui::regions::output_label;
use crate::gui::theme;
use crate::types::Output;

/// State of the step.
#[derive(Default)]
pub(super) struct OutputCheck {
    /// Whether keys are sent to this window.
    is_running: bool,
    received: Vec<Output>,
}

impl OutputCheck {
    pub(super) fn is_running(&self) -> bool {
        self.is_running
    }

    /// Takes the keys that arrive in this window before a widget acts on them.
    pub(super) fn take_keys(&mut self, ui: &Ui) {
        ui.input_mut(|input| {
            input.events.retain(|event| match event {
                Event::Key { key, pressed, .. } => {
                    if *pressed
                        && let Some(output) = keyboard::output_for_key(*key)
                        && !self.received.contains(&output)
                    {
                        self.received.push(output);
                    }
                    false
                }
                Event::Text(_) => false,
                _ => true,
            });
        });
    }

    pub(super) fn ui(&mut self, ui: &mut Ui, playing: &Playing) -> Option<UiAction> {
        let palette = theme::palette_of(ui);
        if playing.request.output == OutputChoice::Nothing {
            paragraph(
                ui,
                "No keys are sent yet. Let gelpad press keys on this desktop, then check that they arrive.",
            );
            return theme::primary(ui, "Send to this desktop")
                .clicked()
                .then(|| {
                    UiAction::Play(PlayRequest {
                        output: OutputChoice::Auto,
                        ..playing.request.clone()
                    })
                });
        }
        paragraph(ui, &format!("Keys go to: {}.", playing.output));
        let label = if self.is_running {
            "Stop the check"
        } else {
            "Start the check"
        };
        if ui.button(label).clicked() {
            self.is_running = !self.is_running;
            self.received.clear();
        }
        if self.is_running {
            for output in &playing.view.profile.outputs {
                let (mark, colour) = if self.received.contains(output) {
                    ("✔ received", palette.good)
                } else {
                    ("… press the pad for", palette.weak)
                };
                ui.colored_label(colour, format!("{mark} {}", output_label(*output)));
            }
            ui.weak("Gamepad buttons do not reach this window: check them with `gelpad doctor`.");
        }
        None
    }
}
