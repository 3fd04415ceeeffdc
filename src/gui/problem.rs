//! The worst problem in words, and what mends it. Pure: a game and the window's state in, a sentence out.

use super::desk::{From, To};
use super::playing::Playing;

/// A rate below this misses quick presses, frames/s.
const SLOW_FRAMES_PER_S: f64 = 25.0;
/// A press that lasts so many frames is sure to be seen.
const SURE_FRAMES: f64 = 2.0;

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Weight {
    /// Good to know.
    Hint,
    /// It plays, but worse than it could.
    Warning,
    /// It does not play.
    Wrong,
}

/// What a button does about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Mend {
    /// Starts the same again.
    Again,
    /// Goes on after a pause.
    GoOn,
    /// Shows the set-up.
    SetUp,
    /// Shows the signals.
    Signals,
    /// Sends events to the desktop.
    Send,
    /// Opens the pad-only window.
    PadWindow,
    /// Back to the simulated pad.
    Simulate,
    /// It has been read.
    Read,
}

impl Mend {
    /// The button's words.
    #[must_use]
    pub fn words(&self) -> &'static str {
        match self {
            Self::Again => "Try again",
            Self::GoOn => "Go on",
            Self::SetUp => "Set up",
            Self::Signals => "Show signals",
            Self::Send => "Send to my game",
            Self::PadWindow => "Open the pad window",
            Self::Simulate => "Use the simulated pad",
            Self::Read => "All right",
        }
    }
}

/// A problem.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// How bad it is.
    pub weight: Weight,
    /// What it is.
    pub words: String,
    /// What to do about it.
    pub mend: Option<Mend>,
}

/// What else there is to know than the game itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct Around<'a> {
    /// Why the last start failed.
    pub failed: Option<&'a str>,
    /// Whether a game is being started.
    pub starting: bool,
    /// Seconds since the last frame, by the window's clock.
    pub silent_s: f64,
}

/// A source that sends nothing for this long is silent, s.
const SILENT_S: f64 = 1.0;

/// The worst problem, if there is one.
#[must_use]
pub fn worst(playing: &Playing, around: Around<'_>) -> Option<Problem> {
    all(playing, around).into_iter().reduce(|worst, next| {
        if next.weight > worst.weight {
            next
        } else {
            worst
        }
    })
}

/// Every problem, in the order in which they are told among equals.
fn all(playing: &Playing, around: Around<'_>) -> Vec<Problem> {
    let view = &playing.view;
    let mut found = Vec::new();
    let mut add = |weight, words: String, mend| {
        found.push(Problem {
            weight,
            words,
            mend,
        });
    };
    if let Some(why) = around.failed {
        let mend = match playing.choice.from {
            From::Hand | From::Level => Mend::Again,
            From::Serial(_) | From::Replay(_) => Mend::Simulate,
        };
        add(Weight::Wrong, why.to_owned(), Some(mend));
    }
    if around.starting {
        return found;
    }
    if let Some(ended) = &playing.ended {
        add(Weight::Wrong, ended.clone(), Some(Mend::Again));
    }
    if view.paused {
        add(
            Weight::Wrong,
            "Paused: everything is up, nothing is sent".to_owned(),
            Some(Mend::GoOn),
        );
    } else if playing.is_running() && around.silent_s > SILENT_S {
        add(
            Weight::Wrong,
            format!(
                "{} sends nothing: all keys are up. Is it plugged in?",
                playing.choice.source_words()
            ),
            Some(Mend::SetUp),
        );
    }
    if playing.is_hushed() {
        add(
            Weight::Wrong,
            "Click your game: this window has the focus, so no key is sent".to_owned(),
            playing.has_hand().then_some(Mend::PadWindow),
        );
    }
    if !view.lost_electrodes.is_empty() {
        let names: Vec<String> = view
            .lost_electrodes
            .iter()
            .map(|electrode| (electrode + 1).to_string())
            .collect();
        let (which, them) = match names.as_slice() {
            [one] => (format!("Electrode {one} is"), "it"),
            _ => (format!("Electrodes {} are", names.join(", ")), "them"),
        };
        add(
            Weight::Warning,
            format!("{which} loose, shorted or noisy: play goes on without {them}"),
            Some(Mend::Signals),
        );
    }
    if let Some(notice) = &playing.notice {
        add(Weight::Warning, notice.clone(), Some(Mend::Read));
    }
    if view.lost_frames > 0 {
        add(
            Weight::Warning,
            format!(
                "{} frames were lost: a cable, or a board that is too fast for this machine",
                view.lost_frames
            ),
            Some(Mend::Signals),
        );
    }
    if view.frames_per_s > 0.0 && view.frames_per_s < SLOW_FRAMES_PER_S {
        add(
            Weight::Warning,
            format!(
                "{:.0} frames/s: a press under {:.0} ms may be missed",
                view.frames_per_s,
                SURE_FRAMES * 1e3 / view.frames_per_s
            ),
            Some(Mend::SetUp),
        );
    }
    if playing.choice.to == To::Nothing {
        add(
            Weight::Hint,
            "A try-out: nothing leaves this window".to_owned(),
            Some(Mend::Send),
        );
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(playing: &Playing, around: Around<'_>) -> String {
        worst(playing, around).map_or(String::new(), |problem| problem.words)
    }

    #[test]
    fn the_worst_comes_first_and_the_first_among_equals() {
        let mut playing = Playing::nothing();
        let around = Around::default();
        assert!(words(&playing, around).starts_with("A try-out"));
        playing.view.frames_per_s = 12.0;
        assert_eq!(
            words(&playing, around),
            "12 frames/s: a press under 167 ms may be missed"
        );
        playing.view.lost_electrodes = vec![2];
        assert!(words(&playing, around).starts_with("Electrode 3 is loose"));
        playing.view.lost_electrodes = vec![2, 9];
        assert!(words(&playing, around).starts_with("Electrodes 3, 10 are loose"));
        playing.view.paused = true;
        let problem = worst(&playing, around).expect("paused");
        assert_eq!(problem.mend, Some(Mend::GoOn));
        let failed = Around {
            failed: Some("no such port"),
            ..around
        };
        assert_eq!(words(&playing, failed), "no such port");
    }

    #[test]
    fn while_a_game_starts_the_old_one_has_no_problems() {
        let mut playing = Playing::nothing();
        playing.ended = Some("gone".to_owned());
        let around = Around {
            starting: true,
            ..Around::default()
        };
        assert_eq!(worst(&playing, around), None);
    }
}
