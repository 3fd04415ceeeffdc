//! The last step: checks that pressed keys arrive in the system. During the check they are sent to this window.

use egui::{Event, Ui};

use super::gamepad_checks::GamepadChecks;
use super::paragraph;
use crate::app::services::{OutputChoice, PlayRequest, StartError};
use crate::gui::edit::keyboard;
use crate::gui::play::UiAction;
use crate::gui::playing::Playing;
use crate::gui::regions::output_label;
use crate::gui::request::{GameContext, output_words};
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

    /// Takes the keys that the profile sends before a widget acts on them; the player's others work, so that the keyboard alone leads on.
    pub(super) fn take_keys(&mut self, ui: &Ui, sent: &[Output]) {
        ui.input_mut(|input| {
            input.events.retain(|event| match event {
                Event::Key { key, pressed, .. } => {
                    let output = keyboard::output_for_key(*key);
                    let Some(output) = output.filter(|output| sent.contains(output)) else {
                        return true;
                    };
                    if *pressed && !self.received.contains(&output) {
                        self.received.push(output);
                    }
                    false
                }
                Event::Text(_) => false,
                _ => true,
            });
        });
    }

    pub(super) fn ui(
        &mut self,
        ui: &mut Ui,
        game: GameContext<'_>,
        gamepad: &mut GamepadChecks,
        failed: Option<&StartError>,
    ) -> Option<UiAction> {
        let GameContext { playing, services } = game;
        let failed = failed.filter(|_| playing.request.output != OutputChoice::Nothing);
        self.is_running &= failed.is_none();
        if let Some(failed) = failed.filter(|failed| failed.is_output) {
            return draw_failure(ui, game, gamepad, &failed.reason);
        }
        let send_to = |output| {
            UiAction::Play(PlayRequest {
                output,
                ..playing.request.clone()
            })
        };
        if playing.request.output == OutputChoice::Nothing {
            paragraph(
                ui,
                "No keys are sent yet. Let gelpad press keys on this desktop, then check that they arrive.",
            );
            if theme::primary(ui, "Send to this desktop").clicked() {
                return Some(send_to(OutputChoice::Auto));
            }
        }
        if playing.request.output != OutputChoice::Gamepad {
            ui.add_space(6.0);
            paragraph(
                ui,
                "For games that want a controller, gelpad can be a virtual gamepad:",
            );
            gamepad.ui(ui, services);
            if ui.button("Send to a virtual gamepad").clicked() {
                return Some(send_to(OutputChoice::Gamepad));
            }
            ui.add_space(6.0);
        }
        if playing.request.output == OutputChoice::Nothing {
            return None;
        }
        if let Some(failed) = failed {
            draw_bad(ui, &format!("✖ The game does not start: {}", failed.reason));
            let again = theme::primary(ui, "Try again").clicked();
            return again.then(|| send_to(playing.request.output));
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
            self.list_outputs(ui, playing);
        }
        None
    }

    /// Which outputs have arrived.
    fn list_outputs(&self, ui: &mut Ui, playing: &Playing) {
        let palette = theme::palette_of(ui);
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
}

fn draw_bad(ui: &mut Ui, words: &str) {
    let words = egui::RichText::new(words).color(theme::palette_of(ui).bad);
    ui.add(egui::Label::new(words).wrap());
}

/// The chosen output gets no keys: why, what helps, and the other outputs.
fn draw_failure(
    ui: &mut Ui,
    game: GameContext<'_>,
    gamepad: &mut GamepadChecks,
    why: &str,
) -> Option<UiAction> {
    let GameContext { playing, services } = game;
    let chosen = playing.request.output;
    let words = output_words(chosen);
    draw_bad(
        ui,
        &format!("✖ The chosen output, {words}, gets no keys: {why}"),
    );
    if chosen == OutputChoice::Gamepad {
        gamepad.ui(ui, services);
    }
    let row = ui.horizontal_wrapped(|ui| {
        let again = theme::primary(ui, "Try again").clicked();
        let others = [
            ("Send to this desktop", OutputChoice::Auto),
            ("Send to a virtual gamepad", OutputChoice::Gamepad),
        ];
        let other = others
            .into_iter()
            .filter(|(_, output)| *output != chosen)
            .find_map(|(label, output)| ui.button(label).clicked().then_some(output));
        other.or(again.then_some(chosen))
    });
    let output = row.inner?;
    Some(UiAction::Play(PlayRequest {
        output,
        ..playing.request.clone()
    }))
}
