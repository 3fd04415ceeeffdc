//! The comfort view: theme, text size, and feedback for players who do not watch the screen.
//!
//! Sound would need a system library on Linux; the terminal bell and visual alerts take its place.

pub mod feedback;
pub mod last_game;
mod person;
pub mod preferences;

use std::io::Write as _;
use std::path::PathBuf;
use std::time::Duration;

use egui::{Align2, Color32, FontId, Rect, Stroke, ThemePreference, Ui};

use self::feedback::{Alert, Feedback};
use self::person::PersonSettings;
use self::preferences::{Preferences, TEXT_SCALE};
use super::edit::write_atomically;
use super::focus_ring::follow_focus;
use super::playing::Playing;
use super::request::UiAction;
use super::theme;
use super::timing_settings::clicked_steps;
use crate::app::services::AppServices;

/// What a button beside the text size adds, %.
const TEXT_STEP_PERCENT: f32 = 10.0;

/// Time between repaints while the edge flashes, s.
const FADE_STEP_S: f64 = 0.033;

/// Keyboard shortcuts.
const SHORTCUTS: [&str; 5] = [
    "F1 to F7: switch views",
    "Tab, Shift+Tab, Space, Enter: reach and press every button",
    "On the pad: 1 to 9 press its regions, Space pins a finger, Esc lifts all fingers",
    "Record: Space plays, comma and full stop step",
    "Edit: Ctrl+Z, Ctrl+Shift+Z, Ctrl+S",
];

/// The state of the view, and the alerts over all views.
pub struct Comfort {
    /// Appearance and feedback.
    pub preferences: Preferences,
    feedback: Feedback,
    person: PersonSettings,
    file: Option<PathBuf>,
    saved: Preferences,
    /// The text size that is being dragged.
    dragged_text_percent: Option<f32>,
    /// The zoom that was set last; egui's own shortcuts may have changed it since.
    zoom: f32,
}

impl Comfort {
    /// Loads the saved preferences.
    pub fn load(services: &dyn AppServices) -> Self {
        let file = services
            .own_folder()
            .map(|folder| folder.join("window.toml"));
        let text = file
            .as_ref()
            .and_then(|file| std::fs::read_to_string(file).ok());
        let preferences = text.map_or_else(Preferences::default, |text| Preferences::read(&text));
        Self {
            saved: preferences.clone(),
            dragged_text_percent: None,
            zoom: 1.0,
            preferences,
            feedback: Feedback::default(),
            person: PersonSettings::default(),
            file,
        }
    }

    /// Applies theme and text size, and saves changed preferences.
    pub fn apply(&mut self, ctx: &egui::Context) {
        ctx.set_theme(self.preferences.theme);
        let now = ctx.zoom_factor();
        if (now - self.zoom).abs() > 1e-3 {
            // The user pressed Ctrl and plus or minus.
            self.preferences.text_scale = now.clamp(TEXT_SCALE.0, TEXT_SCALE.1);
        }
        if (now - self.preferences.text_scale).abs() > 1e-3 {
            ctx.set_zoom_factor(self.preferences.text_scale);
        }
        self.zoom = self.preferences.text_scale;
        // A drag changes places many times: saved when it ends.
        if self.preferences != self.saved && !ctx.input(|input| input.pointer.any_down()) {
            self.save();
        }
    }

    /// Writes the preferences, if they have changed.
    pub fn save(&mut self) {
        if self.preferences != self.saved {
            self.saved = self.preferences.clone();
            if let Some(file) = &self.file
                && let Err(error) = write_atomically(file, &self.saved.to_toml())
            {
                tracing::warn!("{error}");
            }
        }
    }

    /// Finds new alerts and draws the current one over the window.
    pub fn show_feedback(&mut self, ui: &Ui, playing: &Playing) {
        let now_s = ui.ctx().time();
        let is_new = self.feedback.update(playing, now_s);
        if is_new && self.preferences.bell {
            // stderr may be closed.
            let _ = std::io::stderr().write_all(b"\x07");
        }
        let Some((alert, age)) = self.feedback.shown(now_s) else {
            return;
        };
        // The pad itself shows each press; only the flash repeats it.
        let has_text =
            self.preferences.large_alerts && (*alert != Alert::Accepted || self.preferences.flash);
        if age < 1.0 && (self.preferences.flash || has_text) {
            let to_end = alert.shown_s() * f64::from(1.0 - age);
            let next_s = if self.preferences.flash {
                to_end.min(FADE_STEP_S)
            } else {
                to_end
            };
            ui.ctx()
                .request_repaint_after(Duration::from_secs_f64(next_s));
        }
        let palette = theme::palette_of(ui);
        let colour = match alert {
            Alert::Accepted | Alert::Resumed => palette.good,
            Alert::Profile(_) => palette.accent,
            Alert::Paused => palette.warn,
            Alert::Disconnected => palette.bad,
        };
        let layer = egui::LayerId::new(egui::Order::Foreground, egui::Id::unique("sign"));
        let painter = ui.ctx().layer_painter(layer);
        if self.preferences.flash {
            let line = Stroke::new(
                10.0 * (1.0 - 0.7 * age),
                colour.gamma_multiply(1.0 - 0.6 * age),
            );
            painter.rect_stroke(ui.max_rect(), 0.0, line, egui::StrokeKind::Inside);
        }
        if has_text {
            draw_alert(&painter, ui.max_rect(), palette.card, alert.text(), colour);
        }
    }

    /// Draws the view.
    pub fn ui(
        &mut self,
        ui: &mut Ui,
        playing: &Playing,
        services: &dyn AppServices,
    ) -> Option<UiAction> {
        let mut action = None;
        egui::ScrollArea::vertical()
            .auto_shrink(false)
            .show(ui, |ui| {
                theme::titled_card(ui, "Appearance", |ui| self.appearance(ui));
                theme::titled_card(ui, "Feedback if you do not watch the pad", |ui| {
                    self.alerts(ui);
                });
                theme::titled_card(ui, "Settings of one person", |ui| {
                    action = self.person.ui(ui, playing, services);
                });
                theme::titled_card(ui, "Keyboard shortcuts", |ui| {
                    for shortcut in SHORTCUTS {
                        ui.label(shortcut);
                    }
                });
                follow_focus(ui);
            });
        action
    }

    fn appearance(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            for (theme, label) in [
                (ThemePreference::Dark, "Dark"),
                (ThemePreference::Light, "Light"),
                (ThemePreference::System, "Same as desktop"),
            ] {
                ui.radio_value(&mut self.preferences.theme, theme, label);
            }
        });
        self.text_size(ui);
        ui.weak("Shortcut: Ctrl and + or -.");
    }

    /// The size of the text, applied when the mouse lets go: zooming moves the slider away from it.
    fn text_size(&mut self, ui: &mut Ui) {
        let (least, most) = (TEXT_SCALE.0 * 100.0, TEXT_SCALE.1 * 100.0);
        let applied = self.preferences.text_scale * 100.0;
        let mut percent = self.dragged_text_percent.unwrap_or(applied);
        let row = ui.horizontal_wrapped(|ui| {
            // Its number and its name stand beside it.
            ui.spacing_mut().slider_width = (ui.available_width() - 160.0).clamp(60.0, 150.0);
            let slider = egui::Slider::new(&mut percent, least..=most)
                .step_by(5.0)
                .fixed_decimals(0)
                .suffix(" %")
                .text("Text size")
                .update_while_editing(false);
            let is_changed = ui.add(slider).changed();
            (is_changed, clicked_steps(ui, "Text size"))
        });
        let (is_changed, steps) = row.inner;
        if is_changed || steps != 0.0 {
            let wanted = percent + TEXT_STEP_PERCENT * steps as f32;
            self.dragged_text_percent = Some(wanted.clamp(least, most));
        }
        if !ui.input(|input| input.pointer.any_down())
            && let Some(percent) = self.dragged_text_percent.take()
        {
            self.preferences.text_scale = percent / 100.0;
        }
    }

    fn alerts(&mut self, ui: &mut Ui) {
        let preferences = &mut self.preferences;
        for (on, label) in [
            (
                &mut preferences.flash,
                "Flash the window edge on every accepted press",
            ),
            (
                &mut preferences.large_alerts,
                "Show pause, profile change and disconnection in large letters",
            ),
            (&mut preferences.bell, "Ring the terminal bell"),
        ] {
            ui.checkbox(on, label);
        }
        ui.weak("With slow keys or dwell, a white ring fills around a touch until it counts.");
    }
}

/// Draws an alert in large letters at the bottom of the window.
fn draw_alert(painter: &egui::Painter, window: Rect, fill: Color32, text: String, colour: Color32) {
    let text = painter.layout_no_wrap(text, FontId::proportional(20.0), colour);
    let centre = egui::pos2(window.center().x, window.bottom() - 58.0);
    let card = Rect::from_center_size(centre, text.size() + egui::vec2(32.0, 14.0));
    let edge = Stroke::new(2.0, colour);
    painter.rect(card, 9.0, fill, edge, egui::StrokeKind::Inside);
    let corner = Align2::CENTER_CENTER.align_size_within_rect(text.size(), card);
    painter.galley(corner.min, text, colour);
}
