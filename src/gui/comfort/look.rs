//! How the window looks and answers, as it is kept between two runs: `window.toml` in the player's own folder. Whatever it
//! holds that cannot be used is left aside.

use egui::ThemePreference;
use toml_edit::{DocumentMut, Item, value};

/// Text may be so much smaller and larger.
pub const TEXT: (f32, f32) = (0.8, 2.0);

/// The settings.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// Dark, light, or as the desktop is.
    pub theme: ThemePreference,
    /// Size of text and all else, 1 as designed.
    pub text: f32,
    /// A frame around the window lights up with every accepted press.
    pub flash: bool,
    /// What happens is written large for a moment.
    pub words: bool,
    /// The terminal's bell with every accepted press.
    pub bell: bool,
    /// Best time of the practice level, s.
    pub best_s: Option<f64>,
}

impl Default for Look {
    fn default() -> Self {
        Self {
            theme: ThemePreference::Dark,
            text: 1.0,
            flash: false,
            words: true,
            bell: false,
            best_s: None,
        }
    }
}

impl Look {
    /// Reads it.
    #[must_use]
    pub fn read(text: &str) -> Self {
        let mut look = Self::default();
        let Ok(document) = text.parse::<DocumentMut>() else {
            return look;
        };
        let flag = |key: &str| document.get(key).and_then(Item::as_bool);
        let number = |key: &str| {
            let item = document.get(key)?;
            item.as_float()
                .or_else(|| item.as_integer().map(|i| i as f64))
                .filter(|number| number.is_finite())
        };
        look.theme = match document.get("theme").and_then(Item::as_str) {
            Some("light") => ThemePreference::Light,
            Some("system") => ThemePreference::System,
            _ => ThemePreference::Dark,
        };
        if let Some(text) = number("text") {
            look.text = (text as f32).clamp(TEXT.0, TEXT.1);
        }
        look.flash = flag("flash").unwrap_or(look.flash);
        look.words = flag("words").unwrap_or(look.words);
        look.bell = flag("bell").unwrap_or(look.bell);
        look.best_s = number("best_s").filter(|best| *best > 0.0);
        look
    }

    /// Its text.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut document = DocumentMut::new();
        document["theme"] = value(match self.theme {
            ThemePreference::Dark => "dark",
            ThemePreference::Light => "light",
            ThemePreference::System => "system",
        });
        document["text"] = value((f64::from(self.text) * 100.0).round() / 100.0);
        document["flash"] = value(self.flash);
        document["words"] = value(self.words);
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
    fn what_was_kept_is_read_back_and_what_cannot_be_used_is_left_aside() {
        let look = Look {
            theme: ThemePreference::Light,
            text: 1.25,
            flash: true,
            words: false,
            bell: true,
            best_s: Some(41.5),
        };
        assert_eq!(Look::read(&look.to_toml()), look);
        assert_eq!(Look::read("theme = 3\ntext = \"x\""), Look::default());
        assert_eq!(Look::read("no toml ["), Look::default());
        assert_eq!(Look::read("text = 99").text, TEXT.1);
    }
}
