//! The seven views: names, icons and function keys.

use egui::Key;

/// A view of the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tab {
    /// The pad and what it presses.
    Play,
    /// The built-in level.
    Practice,
    /// Regions, bindings, thresholds.
    Edit,
    /// Step by step from port to game.
    SetUp,
    /// Recordings.
    Record,
    /// Measured voltages.
    Signals,
    /// Appearance and feedback.
    Comfort,
}

impl Tab {
    /// All views, in the order of the rail.
    pub const ALL: [Self; 7] = [
        Self::Play,
        Self::Practice,
        Self::Edit,
        Self::SetUp,
        Self::Record,
        Self::Signals,
        Self::Comfort,
    ];

    /// Its label.
    pub fn name(self) -> &'static str {
        self.details().0
    }

    pub(super) fn icon(self) -> &'static str {
        self.details().1
    }

    pub(super) fn key(self) -> Key {
        self.details().2
    }

    fn details(self) -> (&'static str, &'static str, Key) {
        match self {
            Self::Play => ("Play", "▶", Key::F1),
            Self::Practice => ("Practice", "★", Key::F2),
            Self::Edit => ("Edit", "✏", Key::F3),
            Self::SetUp => ("Set up", "🔧", Key::F4),
            Self::Record => ("Record", "⏺", Key::F5),
            Self::Signals => ("Signals", "📈", Key::F6),
            Self::Comfort => ("Comfort", "🔔", Key::F7),
        }
    }
}
