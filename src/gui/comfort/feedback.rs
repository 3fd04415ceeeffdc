//! What there is to tell a player who does not look at the pad: accepted, waiting, paused, another profile, source lost. Pure:
//! views in, signs out.

use std::sync::Arc;

use crate::gui::playing::Playing;
use crate::profile::Profile;

/// A sign stays for so long, s.
pub const STAYS_S: f64 = 0.6;

/// Something that happened.
#[derive(Clone, Debug, PartialEq)]
pub enum Sign {
    /// An output went down.
    Accepted,
    /// Paused.
    Paused,
    /// Goes on.
    GoesOn,
    /// Another profile, by its name.
    Profile(String),
    /// The source has gone.
    Lost,
}

impl Sign {
    /// In a word or two.
    #[must_use]
    pub fn words(&self) -> String {
        match self {
            Self::Accepted => "✔ accepted".to_owned(),
            Self::Paused => "⏸ paused".to_owned(),
            Self::GoesOn => "▶ goes on".to_owned(),
            Self::Profile(name) => format!("profile: {name}"),
            Self::Lost => "✖ the source is gone".to_owned(),
        }
    }
}

/// What was known before.
#[derive(Clone, Debug, Default)]
pub struct Feedback {
    held: usize,
    paused: bool,
    ended: bool,
    profile: Option<Arc<Profile>>,
    events: u64,
    /// The newest sign, and when it came, by the window's clock, s.
    newest: Option<(Sign, f64)>,
}

impl Feedback {
    /// Looks at a game; whether there is a new sign.
    pub fn look(&mut self, playing: &Playing, now_s: f64) -> bool {
        let view = &playing.view;
        let mut sign = None;
        if view.held.len() > self.held && view.events_so_far != self.events {
            sign = Some(Sign::Accepted);
        }
        if let Some(profile) = &self.profile
            && profile.name != view.profile.name
        {
            sign = Some(Sign::Profile(view.profile.name.clone()));
        }
        if view.paused != self.paused {
            sign = Some(if view.paused {
                Sign::Paused
            } else {
                Sign::GoesOn
            });
        }
        if playing.ended.is_some() && !self.ended {
            sign = Some(Sign::Lost);
        }
        self.held = view.held.len();
        self.events = view.events_so_far;
        self.paused = view.paused;
        self.ended = playing.ended.is_some();
        self.profile = Some(Arc::clone(&view.profile));
        let is_new = sign.is_some();
        if let Some(sign) = sign {
            self.newest = Some((sign, now_s));
        }
        is_new
    }

    /// The sign that is to be seen now, and how much of its time is over, 0 to 1.
    #[must_use]
    pub fn shown(&self, now_s: f64) -> Option<(&Sign, f32)> {
        let (sign, since_s) = self.newest.as_ref()?;
        let age = (now_s - since_s) / STAYS_S;
        // Being paused or lost lasts.
        let lasts = matches!(sign, Sign::Paused | Sign::Lost);
        (lasts || age < 1.0).then_some((sign, age.clamp(0.0, 1.0) as f32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sign_comes_once_when_it_happens() {
        let mut playing = Playing::nothing();
        let mut feedback = Feedback::default();
        assert!(!feedback.look(&playing, 0.0));
        playing.view.held = vec!["key:f".parse().expect("a key")];
        playing.view.events_so_far = 1;
        assert!(feedback.look(&playing, 1.0));
        assert_eq!(feedback.shown(1.1).map(|s| s.0), Some(&Sign::Accepted));
        assert!(
            !feedback.look(&playing, 1.1),
            "it is held, not pressed anew"
        );
        assert_eq!(feedback.shown(1.0 + STAYS_S), None);
        playing.view.paused = true;
        assert!(feedback.look(&playing, 2.0));
        assert_eq!(feedback.shown(60.0).map(|s| s.0), Some(&Sign::Paused));
        playing.view.paused = false;
        feedback.look(&playing, 61.0);
        assert_eq!(feedback.shown(61.0).map(|s| s.0), Some(&Sign::GoesOn));
        playing.ended = Some("gone".to_owned());
        feedback.look(&playing, 62.0);
        assert_eq!(feedback.shown(99.0).map(|s| s.0), Some(&Sign::Lost));
    }

    #[test]
    fn another_profile_is_named() {
        let mut playing = Playing::nothing();
        let mut feedback = Feedback::default();
        feedback.look(&playing, 0.0);
        let mut other = (*playing.view.profile).clone();
        other.name = "racing".to_owned();
        playing.view.profile = Arc::new(other);
        assert!(feedback.look(&playing, 1.0));
        let shown = feedback.shown(1.0).map(|(sign, _)| sign.words());
        assert_eq!(shown.as_deref(), Some("profile: racing"));
    }
}
