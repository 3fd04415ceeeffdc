//! The console that gelpad runs in: keys of the live view. A closed console is an event of its own (`signals.rs`).

use std::time::Duration;

use crossterm::event::{Event, KeyCode, KeyEventKind, KeyModifiers, poll, read};

pub use crate::platform::terminal_key::{KeyCommand, TerminalLost};

/// Streams of a console are always read.
pub fn can_write<T>(_: &T, _: Duration) -> bool {
    true
}

/// A console, which ends its programs itself.
pub struct Terminal;

impl Terminal {
    /// The terminal of this process.
    pub fn attached() -> Self {
        Self
    }

    /// Whether it is closed: an event tells that.
    pub fn is_lost(&self) -> bool {
        false
    }
}

/// Reads keys from the console.
pub struct Keyboard;

impl Keyboard {
    /// Opens it.
    pub fn open() -> Self {
        Self
    }

    /// Waits for keys, at most `wait`.
    pub fn read(&mut self, wait: Duration) -> Result<Vec<KeyCommand>, TerminalLost> {
        if !poll(wait).map_err(|_| TerminalLost)? {
            return Ok(Vec::new());
        }
        let Event::Key(key) = read().map_err(|_| TerminalLost)? else {
            return Ok(Vec::new());
        };
        // Windows reports releases, too.
        if key.kind == KeyEventKind::Release {
            return Ok(Vec::new());
        }
        let command = match key.code {
            KeyCode::Esc | KeyCode::Char('q') => Some(KeyCommand::Quit),
            KeyCode::Char('p') => Some(KeyCommand::Pause),
            KeyCode::Char('z') => Some(KeyCommand::Rezero),
            KeyCode::Char('c') if key.modifiers.contains(KeyModifiers::CONTROL) => {
                Some(KeyCommand::Interrupt)
            }
            _ => None,
        };
        Ok(command.into_iter().collect())
    }
}
