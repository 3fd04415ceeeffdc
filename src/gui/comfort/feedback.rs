//! Feedback for players who do not watch the pad: press accepted, paused, profile changed, pad disconnected. No drawing.

use std::sync::Arc;

use crate::gui::playing::Playing;
use crate::profile::Profile;

/// How long an accepted press is shown, s, ...
const FLASH_S: f64 = 0.6;
/// ... and words that are to be read.
const READ_S: f64 = 5.0;

/// An event that the player should notice.
#[derive(Clone, Debug, PartialEq)]
pub enum Alert {
    /// An output was pressed.
    Accepted,
    /// Paused.
    Paused,
    /// The pause has ended.
    Resumed,
    /// The profile of this name is in force.
    Profile(String),
    /// The source has ended.
    Disconnected,
}

impl Alert {
    /// How long it is shown, s; a pause and a disconnected pad until they end.
    pub fn shown_s(&self) -> f64 {
        match self {
            Self::Accepted => FLASH_S,
            _ => READ_S,
        }
    }

    /// A word or two.
    pub fn text(&self) -> String {
        match self {
            Self::Accepted => "✔ Accepted".to_owned(),
            Self::Paused => "⏸ Paused".to_owned(),
            Self::Resumed => "▶ Resumed".to_owned(),
            Self::Profile(name) => format!("Profile: {name}"),
            Self::Disconnected => "✖ Pad disconnected".to_owned(),
        }
    }
}

/// Finds alerts by comparing each view with the one before.
#[derive(Clone, Debug, Default)]
pub struct Feedback {
    held: usize,
    paused: bool,
    ended: bool,
    profile: Option<Arc<Profile>>,
    events: u64,
    /// The newest alert and its time by the window's clock, s.
    newest: Option<(Alert, f64)>,
}

impl Feedback {
    /// Compares the game with the last call; returns whether there is a new alert.
    pub fn update(&mut self, playing: &Playing, now_s: f64) -> bool {
        let view = &playing.view;
        let profile_before = self.profile.replace(Arc::clone(&view.profile));
        if self.ended && playing.ended.is_none() && self.shows(&Alert::Disconnected) {
            // Another game has started.
            self.newest = None;
        }
        let alert = if playing.ended.is_some() && !self.ended {
            Some(Alert::Disconnected)
        } else if view.paused != self.paused {
            Some(if view.paused {
                Alert::Paused
            } else {
                Alert::Resumed
            })
        } else if profile_before.is_some_and(|before| before.name != view.profile.name) {
            Some(Alert::Profile(view.profile.name.clone()))
        } else {
            let pressed = view.held.len() > self.held && view.events_so_far != self.events;
            pressed.then_some(Alert::Accepted)
        };
        self.held = view.held.len();
        self.events = view.events_so_far;
        self.paused = view.paused;
        self.ended = playing.ended.is_some();
        let is_new = alert.is_some();
        if let Some(alert) = alert {
            self.newest = Some((alert, now_s));
        }
        is_new
    }

    fn shows(&self, alert: &Alert) -> bool {
        self.newest
            .as_ref()
            .is_some_and(|(newest, _)| newest == alert)
    }

    /// The alert to show and the elapsed share of its time, 0 to 1.
    pub fn shown(&self, now_s: f64) -> Option<(&Alert, f32)> {
        let (alert, since_s) = self.newest.as_ref()?;
        let age = (now_s - since_s) / alert.shown_s();
        let lasts = matches!(alert, Alert::Paused | Alert::Disconnected);
        (lasts || age < 1.0).then_some((alert, age.clamp(0.0, 1.0) as f32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_alert_comes_once() {
        let mut playing = Playing::idle();
        let mut feedback = Feedback::default();
        assert!(!feedback.update(&playing, 0.0));
        playing.view.held = vec!["key:f".parse().expect("a key")];
        playing.view.events_so_far = 1;
        assert!(feedback.update(&playing, 1.0));
        assert_eq!(feedback.shown(1.1).map(|s| s.0), Some(&Alert::Accepted));
        assert!(!feedback.update(&playing, 1.1), "held, not pressed again");
        assert_eq!(feedback.shown(1.0 + FLASH_S), None);
        playing.view.paused = true;
        assert!(feedback.update(&playing, 2.0));
        assert_eq!(feedback.shown(60.0).map(|s| s.0), Some(&Alert::Paused));
        playing.view.paused = false;
        feedback.update(&playing, 61.0);
        assert_eq!(feedback.shown(61.0).map(|s| s.0), Some(&Alert::Resumed));
        playing.ended = Some("disconnected".to_owned());
        feedback.update(&playing, 62.0);
        assert_eq!(
            feedback.shown(99.0).map(|s| s.0),
            Some(&Alert::Disconnected)
        );
    }

    #[test]
    fn a_game_that_starts_after_a_disconnection_ends_its_alert() {
        let mut playing = Playing::idle();
        let mut feedback = Feedback::default();
        playing.ended = Some("disconnected".to_owned());
        feedback.update(&playing, 0.0);
        assert_eq!(feedback.shown(9.0).map(|s| s.0), Some(&Alert::Disconnected));
        playing.ended = None;
        feedback.update(&playing, 10.0);
        assert_eq!(feedback.shown(10.0), None);
    }

    #[test]
    fn a_new_profile_is_named() {
        let mut playing = Playing::idle();
        let mut feedback = Feedback::default();
        feedback.update(&playing, 0.0);
        let mut other = (*playing.view.profile).clone();
        other.name = "racing".to_owned();
        playing.view.profile = Arc::new(other);
        assert!(feedback.update(&playing, 1.0));
        let shown = feedback.shown(1.0).map(|(alert, _)| alert.text());
        assert_eq!(shown.as_deref(), Some("Profile: racing"));
    }
}
