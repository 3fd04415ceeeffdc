//! Appearance and feedback of the window, saved as `window.toml` in the gelpad folder. Invalid values are ignored.

use egui::ThemePreference;
use toml_edit::{DocumentMut, Item, value};

/// Smallest and largest scale of the text.
pub const TEXT_SCALE: (f32, f32) = (0.8, 2.0);

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
        document.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn preferences_are_read_back_and_invalid_values_ignored() {
        let saved = Preferences {
            theme: ThemePreference::Light,
            text_scale: 1.25,
            flash: true,
            large_alerts: false,
            bell: true,
            best_s: Some(41.5),
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
