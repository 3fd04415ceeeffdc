//! The practice view: the level beside the pad, played by the events of the running game.

use egui::Ui;

use super::game::Practice;
use super::view::PracticeView;
use crate::gui::picture::Picture;
use crate::gui::play;
use crate::gui::playing::Playing;
use crate::runtime::View;

/// The level, its view, and how many events were played.
#[derive(Debug, Default)]
pub struct PracticeTab {
    /// The level.
    pub practice: Practice,
    view: PracticeView,
    events_seen: u64,
}

impl PracticeTab {
    /// Plays the events that are new in a view of the game.
    pub fn play_new_events(&mut self, view: &View) {
        self.practice.set_profile(&view.profile);
        // Fewer than before: another game, which counts from 0.
        let fresh = view
            .events_so_far
            .checked_sub(self.events_seen)
            .unwrap_or(view.events_so_far);
        self.events_seen = view.events_so_far;
        let skip = (view.events.len() as u64).saturating_sub(fresh) as usize;
        for event in view.events.iter().skip(skip) {
            self.practice.push_event(event);
        }
    }

    /// Passes over the events so far, while the level is not shown: a press in another view must not jump here.
    pub fn skip_events(&mut self, view: &View) {
        if self.events_seen != view.events_so_far {
            self.events_seen = view.events_so_far;
            self.practice.release_all();
        }
    }

    /// Draws the level and the pad.
    pub fn ui(&mut self, ui: &mut Ui, picture: &mut Picture, playing: &mut Playing) {
        self.play_new_events(&playing.view);
        self.view.paused = playing.view.paused;
        let mut pad = |ui: &mut Ui, room| {
            play::pad(ui, room, picture, playing, false);
        };
        self.view.ui(ui, &mut self.practice, Some(&mut pad));
    }
}
