//! The keyboard of an X11 display, through enigo, by raw keycode.
//!
//! Keycodes and not symbols: typing a symbol that the layout lacks would make enigo rewrite the keymap, for good.

use enigo::{Direction, Enigo, Keyboard as _, Settings};

use super::{Device, OutputError};
use crate::types::{Action, Event, Output};

/// A connection to the display that `DISPLAY` names.
pub struct Keyboard {
    enigo: Enigo,
}

impl Keyboard {
    /// Connects to the display.
    ///
    /// # Errors
    /// No display, or one that does not take key events.
    pub fn connect() -> Result<Self, OutputError> {
        let Some(display) = std::env::var("DISPLAY")
            .ok()
            .filter(|name| !name.is_empty())
        else {
            return Err(OutputError::NoKeyboard {
                reason: "DISPLAY names no X11 display: start gelpad in a desktop session, or use --output trace"
                    .to_owned(),
            });
        };
        let settings = Settings {
            x11_display: Some(display.clone()),
            linux_delay: 0,
            ..Settings::default()
        };
        match Enigo::new(&settings) {
            Ok(enigo) => Ok(Self { enigo }),
            Err(error) => Err(OutputError::NoKeyboard {
                reason: format!(
                    "the X11 display {display} did not answer ({error}): is it running, and may you use it?"
                ),
            }),
        }
    }
}

impl Device for Keyboard {
    fn name(&self) -> &'static str {
        "keyboard"
    }

    fn takes(&self, output: Output) -> bool {
        matches!(output, Output::Key(_))
    }

    fn send(&mut self, event: &Event) -> Result<(), OutputError> {
        let (output, direction) = match event.action {
            Action::Press(output) => (output, Direction::Press),
            Action::Release(output) => (output, Direction::Release),
            Action::Axis(..) | Action::Motion { .. } | Action::Wheel { .. } => return Ok(()),
        };
        let Output::Key(key) = output else {
            return Ok(());
        };
        self.enigo
            .raw(key.x11_keycode(), direction)
            .map_err(|error| OutputError::Refused {
                device: "keyboard",
                reason: error.to_string(),
            })
    }
}
