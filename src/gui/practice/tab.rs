//! The practice view in the window: the level beside the pad, fed with what the game's events are.

use egui::Ui;

use super::{Practice, PracticeView};
use crate::gui::picture::Picture;
use crate::gui::play;
use crate::gui::playing::Playing;
use crate::runtime::View;

/// The level, its view, and how far the events are known.
#[derive(Debug, Default)]
pub struct PracticeTab {
    /// The level.
    pub practice: Practice,
    view: PracticeView,
    events_seen: u64,
}

impl PracticeTab {
    /// Gives the level what is new in a view.
    pub fn take(&mut self, view: &View) {
        self.practice.follow(&view.profile);
        // Fewer than before: another game, whose events count from none.
        let fresh = view
            .events_so_far
            .checked_sub(self.events_seen)
            .unwrap_or(view.events_so_far);
        self.events_seen = view.events_so_far;
        let skip = (view.events.len() as u64).saturating_sub(fresh) as usize;
        for event in view.events.iter().skip(skip) {
            self.practice.event(event);
        }
    }

    /// Draws the level and the pad.
    pub fn ui(&mut self, ui: &mut Ui, picture: &mut Picture, playing: &mut Playing) {
        self.take(&playing.view);
        self.view.paused = playing.view.paused;
        let mut pad = |ui: &mut Ui, room| {
            play::pad(ui, room, picture, playing, false);
        };
        self.view.ui(ui, &mut self.practice, Some(&mut pad));
    }
}
