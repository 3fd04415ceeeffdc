//! The view for comfort: theme, size of text, and feedback for those who do not look at the screen.
//!
//! Sound needs a library of the system on Linux, so there is none: the terminal's bell and pictures take its place.

pub mod feedback;
pub mod look;

use std::io::Write as _;
use std::path::PathBuf;

use egui::{Align2, FontId, Rect, Stroke, ThemePreference, Ui};

use self::feedback::{Feedback, Sign};
use self::look::{Look, TEXT};
use super::desk::Desk;
use super::edit::write_beside;
use super::playing::Playing;
use super::theme;

/// The view's state, and the signs over all views.
pub struct Comfort {
    /// How the window looks.
    pub look: Look,
    feedback: Feedback,
    file: Option<PathBuf>,
    kept: Look,
    /// The zoom that was set last: the window's own keys may have changed it since.
    zoom: f32,
}

impl Comfort {
    /// As it was kept.
    #[must_use]
    pub fn of(desk: &dyn Desk) -> Self {
        let file = desk.own_folder().map(|folder| folder.join("window.toml"));
        let look = file
            .as_ref()
            .and_then(|file| std::fs::read_to_string(file).ok())
            .map_or_else(Look::default, |text| Look::read(&text));
        Self {
            kept: look.clone(),
            zoom: 1.0,
            look,
            feedback: Feedback::default(),
            file,
        }
    }

    /// Makes the window look as it shall, and keeps what has changed.
    pub fn dress(&mut self, ctx: &egui::Context) {
        ctx.set_theme(self.look.theme);
        let now = ctx.zoom_factor();
        if (now - self.zoom).abs() > 1e-3 {
            // Ctrl and plus or minus.
            self.look.text = now.clamp(TEXT.0, TEXT.1);
        }
        if (now - self.look.text).abs() > 1e-3 {
            ctx.set_zoom_factor(self.look.text);
        }
        self.zoom = self.look.text;
        if self.look != self.kept {
            self.kept = self.look.clone();
            if let Some(file) = &self.file
                && let Err(error) = write_beside(file, &self.look.to_toml())
            {
                tracing::warn!("{}: {error}", file.display());
            }
        }
    }

    /// Looks at what happened, and draws its sign over the window.
    pub fn sign(&mut self, ui: &Ui, playing: &Playing) {
        let now_s = ui.ctx().time();
        let is_new = self.feedback.look(playing, now_s);
        if is_new && self.look.bell {
            // A closed stderr is no reason to stop.
            let _ = std::io::stderr().write_all(b"\x07");
        }
        let Some((sign, age)) = self.feedback.shown(now_s) else {
            return;
        };
        if age < 1.0 {
            ui.ctx().request_repaint();
        }
        let palette = theme::of(ui);
        let colour = match sign {
            Sign::Accepted | Sign::GoesOn => palette.good,
            Sign::Profile(_) => palette.accent,
            Sign::Paused => palette.warn,
            Sign::Lost => palette.bad,
        };
        let layer = egui::LayerId::new(egui::Order::Foreground, egui::Id::unique("sign"));
        let painter = ui.ctx().layer_painter(layer);
        let whole = ui.max_rect();
        if self.look.flash {
            let line = Stroke::new(
                10.0 * (1.0 - 0.7 * age),
                colour.gamma_multiply(1.0 - 0.6 * age),
            );
            painter.rect_stroke(whole, 0.0, line, egui::StrokeKind::Inside);
        }
        // A press is seen on the pad; what happens more rarely is written.
        if self.look.words && (*sign != Sign::Accepted || self.look.flash) {
            let words = painter.layout_no_wrap(sign.words(), FontId::proportional(20.0), colour);
            let size = words.size() + egui::vec2(32.0, 14.0);
            let at = egui::pos2(whole.center().x, whole.bottom() - 58.0);
            let card = Rect::from_center_size(at, size);
            painter.rect(
                card,
                9.0,
                palette.card,
                Stroke::new(2.0, colour),
                egui::StrokeKind::Inside,
            );
            let corner = Align2::CENTER_CENTER.align_size_within_rect(words.size(), card);
            painter.galley(corner.min, words, colour);
        }
    }

    /// Draws the view.
    pub fn ui(&mut self, ui: &mut Ui, playing: &Playing) {
        egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            theme::card(ui).show(ui, |ui| {
                ui.set_width(ui.available_width());
                theme::title(ui, "how the window looks");
                ui.horizontal(|ui| {
                    for (theme, words) in [
                        (ThemePreference::Dark, "Dark"),
                        (ThemePreference::Light, "Light"),
                        (ThemePreference::System, "As the desktop"),
                    ] {
                        ui.radio_value(&mut self.look.theme, theme, words);
                    }
                });
                let mut percent = self.look.text * 100.0;
                let slider = egui::Slider::new(&mut percent, TEXT.0 * 100.0..=TEXT.1 * 100.0)
                    .step_by(5.0)
                    .suffix(" %")
                    .text("Size of text");
                // While it is dragged the slider would run away from the mouse.
                if ui.add(slider.update_while_editing(false)).changed() {
                    self.look.text = percent / 100.0;
                }
                ui.weak("Ctrl and + or - do the same.");
            });
            theme::card(ui).show(ui, |ui| {
                ui.set_width(ui.available_width());
                theme::title(ui, "feedback, for those who do not look at the pad");
                ui.checkbox(&mut self.look.flash, "The window's edge lights up with every accepted press");
                ui.checkbox(&mut self.look.words, "Paused, another profile and a lost source are written large");
                ui.checkbox(&mut self.look.bell, "The terminal's bell rings");
                ui.weak("A touch that has to wait (slow keys, dwell) shows a white ring that fills.");
            });
            theme::card(ui).show(ui, |ui| {
                ui.set_width(ui.available_width());
                theme::title(ui, "what holds for you now");
                let settings = &playing.view.profile.settings;
                let ms = crate::types::ms_from_nanos;
                for (what, now) in [
                    ("a touch counts after", ms(settings.slow_keys_ns)),
                    ("a re-press is ignored for", ms(settings.bounce_keys_ns)),
                    ("a touch stays in one place for", ms(settings.dwell_ns)),
                ] {
                    let words = if now > 0.0 { format!("{now:.0} ms") } else { "off".to_owned() };
                    ui.label(format!("{what}: {words}"));
                }
                ui.weak("Set up, step 5, finds these from your own presses; Edit sets them by hand.");
            });
            theme::card(ui).show(ui, |ui| {
                ui.set_width(ui.available_width());
                theme::title(ui, "keys");
                for words in [
                    "F1 to F7: the views",
                    "Tab, Shift+Tab, Space, Enter: every button",
                    "on the pad: 1 to 9 press its regions, Space pins a finger, Esc lifts all",
                    "Record: Space plays, comma and full stop step",
                    "Edit: Ctrl+Z, Ctrl+Shift+Z, Ctrl+S",
                ] {
                    ui.label(words);
                }
            });
        });
    }
}
