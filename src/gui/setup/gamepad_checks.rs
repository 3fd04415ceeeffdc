//! What a virtual gamepad and gamepads as a source need on this computer: lines of `gelpad doctor`, each fix with a button that
//! copies its command.

use egui::Ui;

use crate::app::services::{AppServices, GamepadCheck};
use crate::gui::theme;

/// The checks; made when they are first shown.
#[derive(Default)]
pub(super) struct GamepadChecks {
    lines: Option<Vec<GamepadCheck>>,
}

impl GamepadChecks {
    /// Draws what is wrong, or that nothing is.
    pub(super) fn ui(&mut self, ui: &mut Ui, services: &dyn AppServices) {
        let lines = self.lines.get_or_insert_with(|| services.gamepad_checks());
        let palette = theme::palette_of(ui);
        let mut checks_again = false;
        for line in lines.iter() {
            let (symbol, word, colour) = match line.works {
                true => ("✔", "works", palette.good),
                false => ("✖", "missing", palette.warn),
            };
            ui.horizontal_wrapped(|ui| {
                theme::mark(ui, colour, symbol, word);
                ui.label(format!("{}: {}", line.subject, line.found));
            });
            if let Some(fix) = &line.fix {
                ui.horizontal_wrapped(|ui| {
                    ui.monospace(fix);
                    let copy = theme::small_button(ui, "Copy");
                    let label = format!("Copy {fix}");
                    copy.widget_info(|| {
                        egui::WidgetInfo::labeled(egui::Role::Button, true, label.clone())
                    });
                    if copy.clicked() {
                        ui.ctx().copy_text(fix.clone());
                    }
                });
            }
        }
        if lines.iter().any(|line| !line.works) {
            checks_again = ui.button("⟲ Check again").clicked();
        }
        if checks_again {
            self.lines = None;
        }
    }
}
