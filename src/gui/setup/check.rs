//! The last step: whether what the pad presses arrives in the system. Keys come back to this window while it checks.

use egui::{Event, Ui};

use super::say;
use crate::gui::desk::{Choice, To};
use crate::gui::edit::keyboard;
use crate::gui::play::Wish;
use crate::gui::playing::Playing;
use crate::gui::regions::short;
use crate::gui::theme;
use crate::types::Output;

/// The step's state.
#[derive(Default)]
pub(super) struct Check {
    /// Whether keys are let through to this window, to be seen.
    checks: bool,
    seen: Vec<Output>,
}

impl Check {
    /// Whether keys are looked at now.
    pub(super) fn checks(&self) -> bool {
        self.checks
    }

    /// Takes the keys that come back to this window, so that nothing here acts on them.
    pub(super) fn take_keys(&mut self, ui: &Ui) {
        ui.input_mut(|input| {
            input.events.retain(|event| match event {
                Event::Key { key, pressed, .. } => {
                    if *pressed
                        && let Some(output) = keyboard::output(*key)
                        && !self.seen.contains(&output)
                    {
                        self.seen.push(output);
                    }
                    false
                }
                Event::Text(_) => false,
                _ => true,
            });
        });
    }

    pub(super) fn ui(&mut self, ui: &mut Ui, playing: &Playing) -> Option<Wish> {
        let palette = theme::of(ui);
        if playing.choice.to == To::Nothing {
            say(
                ui,
                "Nothing is sent yet. Let gelpad press the keys of this desktop, then check that they arrive.",
            );
            return theme::primary(ui, "Send to this desktop")
                .clicked()
                .then(|| {
                    Wish::Play(Choice {
                        to: To::Auto,
                        ..playing.choice.clone()
                    })
                });
        }
        say(ui, &format!("Events go to: {}.", playing.output));
        let words = if self.checks {
            "Stop the check"
        } else {
            "Check: press the pad"
        };
        if ui.button(words).clicked() {
            self.checks = !self.checks;
            self.seen.clear();
        }
        if self.checks {
            for output in &playing.view.profile.outputs {
                let seen = self.seen.contains(output);
                let words = format!(
                    "{} {}",
                    if seen { "✔ the system saw" } else { "…" },
                    short(*output)
                );
                let colour = if seen { palette.good } else { palette.weak };
                ui.colored_label(colour, words);
            }
            ui.weak(
                "A gamepad's buttons do not come to windows: look at them with `gelpad doctor`.",
            );
        }
        None
    }
}
