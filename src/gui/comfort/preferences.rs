//! Appearance and feedback of the window, saved as `window.toml` in the gelpad folder. Invalid values are ignored.

use egui::ThemePreference;
use toml_edit::{Array, DocumentMut, Item, value};

use super::last_game::LastGame;
use crate::gui::tab::Tab;

/// Smallest and largest scale of the text.
pub const TEXT_SCALE: (f32, f32) = (0.8, 2.0);

/// A pad window with less opacity could not be found again.
const MIN_OPACITY: f32 = 0.2;

/// Appearance and feedback.
#[derive(Clone, Debug, PartialEq)]
pub struct Preferences {
    /// Dark, light, or that of the desktop.
    pub theme: ThemePreference,
    /// Scale of text and everything else, 1 by default.
    pub text_scale: f32,
    /// Flash the edge of the window on every accepted press.
    pub flash: bool,
    /// Show pause, profile change and disconnection in large letters.
    pub large_alerts: bool,
    /// Ring the terminal bell on every alert.
    pub bell: bool,
    /// Best time in the practice level, s.
    pub best_s: Option<f64>,
    /// The view that was shown last.
    pub tab: Tab,
    /// Size of the window, points.
    pub size: Option<[f32; 2]>,
    /// Position of the pad window, points.
    pub pad_window: Option<[f32; 2]>,
    /// Size of the pad window, points.
    pub pad_window_size: Option<[f32; 2]>,
    /// Opacity of the pad window, 0 to 1.
    pub pad_window_opacity: f32,
    /// Whether the pad window was open.
    pub pad_window_open: bool,
    /// The game that was played last.
    pub last_game: LastGame,
}

impl Default for Preferences {
    fn default() -> Self {
        Self {
            theme: ThemePreference::Dark,
            text_scale: 1.0,
            flash: false,
            large_alerts: true,
            bell: false,
            best_s: None,
            tab: Tab::Play,
            size: None,
            pad_window: None,
            pad_window_size: None,
            pad_window_opacity: 1.0,
            pad_window_open: false,
            last_game: LastGame::default(),
        }
    }
}

impl Preferences {
    /// Parses `window.toml`.
    pub fn read(text: &str) -> Self {
        let mut read = Self::default();
        let Ok(document) = text.parse::<DocumentMut>() else {
            return read;
        };
        let flag = |key: &str| document.get(key).and_then(Item::as_bool);
        let number = |key: &str| {
            let item = document.get(key)?;
            item.as_float()
                .or_else(|| item.as_integer().map(|i| i as f64))
                .filter(|number| number.is_finite())
        };
        read.theme = match document.get("theme").and_then(Item::as_str) {
            Some("light") => ThemePreference::Light,
            Some("system") => ThemePreference::System,
            _ => ThemePreference::Dark,
        };
        if let Some(scale) = number("text") {
            read.text_scale = (scale as f32).clamp(TEXT_SCALE.0, TEXT_SCALE.1);
        }
        read.flash = flag("flash").unwrap_or(read.flash);
        read.large_alerts = flag("words").unwrap_or(read.large_alerts);
        read.bell = flag("bell").unwrap_or(read.bell);
        read.best_s = number("best_s").filter(|best| *best > 0.0);
        let tab = document.get("view").and_then(Item::as_str);
        if let Some(tab) = Tab::ALL.into_iter().find(|one| Some(one.name()) == tab) {
            read.tab = tab;
        }
        read.size = pair(document.get("size"));
        read.pad_window = pair(document.get("pad_window"));
        read.pad_window_size = pair(document.get("pad_window_size"));
        if let Some(opacity) = number("pad_window_opacity") {
            read.pad_window_opacity = (opacity as f32).clamp(MIN_OPACITY, 1.0);
        }
        read.pad_window_open = flag("pad_window_open").unwrap_or(false);
        read.last_game = LastGame::read(document.get("last").unwrap_or(&Item::None));
        read
    }

    /// The content of `window.toml`.
    pub fn to_toml(&self) -> String {
        let mut document = DocumentMut::new();
        document["theme"] = value(match self.theme {
            ThemePreference::Dark => "dark",
            ThemePreference::Light => "light",
            ThemePreference::System => "system",
        });
        document["text"] = value((f64::from(self.text_scale) * 100.0).round() / 100.0);
        document["flash"] = value(self.flash);
        document["words"] = value(self.large_alerts);
        document["bell"] = value(self.bell);
        if let Some(best_s) = self.best_s {
            document["best_s"] = value(best_s);
        }
        document["view"] = value(self.tab.name());
        let opacity = f64::from(self.pad_window_opacity);
        document["pad_window_opacity"] = value((opacity * 100.0).round() / 100.0);
        document["pad_window_open"] = value(self.pad_window_open);
        for (key, numbers) in [
            ("size", self.size),
            ("pad_window", self.pad_window),
            ("pad_window_size", self.pad_window_size),
        ] {
            if let Some(numbers) = numbers {
                let rounded = numbers.map(|number| i64::from(number.round() as i32));
                document[key] = value(Array::from_iter(rounded));
            }
        }
        document["last"] = Item::Table(self.last_game.to_table());
        document.to_string()
    }
}

/// Two numbers in a list.
fn pair(item: Option<&Item>) -> Option<[f32; 2]> {
    let list = item?.as_array()?;
    let number = |index: usize| Some(list.get(index)?.as_integer()? as f32);
    Some([number(0)?, number(1)?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::services::PlayRequest;

    #[test]
    fn preferences_are_read_back_and_invalid_values_ignored() {
        let saved = Preferences {
            theme: ThemePreference::Light,
            text_scale: 1.25,
            flash: true,
            large_alerts: false,
            bell: true,
            best_s: Some(41.5),
            tab: Tab::Signals,
            size: Some([900.0, 640.0]),
            pad_window: Some([1500.0, -20.0]),
            pad_window_size: Some([320.0, 300.0]),
            pad_window_opacity: 0.7,
            pad_window_open: true,
            last_game: LastGame::from_request(&PlayRequest {
                user: Some("tremor".to_owned()),
                ..PlayRequest::default()
            }),
        };
        assert_eq!(Preferences::read(&saved.to_toml()), saved);
        assert_eq!(
            Preferences::read("theme = 3\ntext = \"x\""),
            Preferences::default()
        );
        assert_eq!(Preferences::read("no toml ["), Preferences::default());
        assert_eq!(Preferences::read("text = 99").text_scale, TEXT_SCALE.1);
    }
}
