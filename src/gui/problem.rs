//! The most severe problem of the moment, in a sentence, and the fix that its button performs. No drawing.

use self::Severity::{Error, Hint, Warning};
use super::playing::Playing;
use super::request::{UiAction, output_words};
use super::tab::Tab;
use crate::app::services::{OutputChoice, PlayRequest, SourceChoice};
use crate::eit::REFERENCE_FRAMES;

/// Slower frame rates miss quick presses, frames/s.
pub const SLOW_FRAMES_PER_S: f64 = 25.0;
/// A press of this many frames is always detected.
pub const SHORTEST_PRESS_FRAMES: f64 = 2.0;

/// The button that goes on with the game of the last session.
pub const CONTINUE: &str = "Continue in my game";
const RETRY: &str = "Try again";
const SIGNALS: &str = "Show signals";
const PAD_WINDOW: &str = "Open the pad window";

/// How severe a problem is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Everything works.
    Hint,
    /// It works, but not as well as it could.
    Warning,
    /// The game gets no input.
    Error,
}

/// A problem.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// How severe it is.
    pub severity: Severity,
    /// What is wrong.
    pub text: String,
    /// The label of its button, and what the button does.
    pub fix: Option<(&'static str, UiAction)>,
}

impl Problem {
    fn new(
        severity: Severity,
        text: impl Into<String>,
        button: &'static str,
        fix: UiAction,
    ) -> Self {
        Self {
            severity,
            text: text.into(),
            fix: Some((button, fix)),
        }
    }
}

/// State of the window that is not part of the game.
#[derive(Clone, Copy, Debug, Default)]
pub struct UiContext<'a> {
    /// Why the last start failed.
    pub failed: Option<&'a str>,
    /// Whether a game is starting.
    pub starting: bool,
    /// Whether keys were sent to a game in the last session.
    pub was_sent: bool,
    /// The output that was chosen last.
    pub last_output: Option<OutputChoice>,
    /// Whether the pad window is open.
    pub is_pad_open: bool,
}

type Check = fn(&Playing, UiContext<'_>) -> Option<Problem>;

/// All checks; among equally severe problems the first one wins.
const CHECKS: [Check; 12] = [
    failed_start,
    ended,
    paused,
    silent_source,
    first_frames,
    blocked_keys,
    lost_electrodes,
    notice,
    lost_frames,
    slow_frames,
    trial,
    no_pad_to_press,
];

/// The most severe problem, if there is one.
pub fn most_severe(playing: &Playing, context: UiContext<'_>) -> Option<Problem> {
    if context.starting {
        return failed_start(playing, context).or_else(|| Some(plain_hint("Starting …")));
    }
    let problems = CHECKS.iter().filter_map(|check| check(playing, context));
    problems.reduce(|worst, next| {
        if next.severity > worst.severity {
            next
        } else {
            worst
        }
    })
}

fn failed_start(playing: &Playing, context: UiContext<'_>) -> Option<Problem> {
    let mut request = playing.request.clone();
    let button = match request.source {
        SourceChoice::Simulated | SourceChoice::Level => RETRY,
        _ => {
            request.source = SourceChoice::Simulated;
            "Use the simulated pad"
        }
    };
    let fix = UiAction::Play(request);
    Some(Problem::new(Error, context.failed?, button, fix))
}

fn ended(playing: &Playing, _: UiContext<'_>) -> Option<Problem> {
    let fix = UiAction::Play(playing.request.clone());
    Some(Problem::new(Error, playing.ended.clone()?, RETRY, fix))
}

fn paused(playing: &Playing, _: UiContext<'_>) -> Option<Problem> {
    let text = "Paused: all keys are released, no keys are sent";
    let problem = || Problem::new(Error, text, "Resume", UiAction::Pause);
    playing.view.paused.then(problem)
}

fn silent_source(playing: &Playing, _: UiContext<'_>) -> Option<Problem> {
    if !playing.is_silent() {
        return None;
    }
    let source = playing.request.source_label();
    let text = match (&playing.request.source, playing.view.frames) {
        (_, 0) if playing.skip_reason.is_some() => {
            let reason = playing.skip_reason.as_deref().unwrap_or_default();
            format!("{source}: {reason}")
        }
        (SourceChoice::Serial(_), 0) => format!(
            "No data from {source} yet: is this the board's port, at {} baud, and does the board run?",
            playing.request.board.baud
        ),
        _ => format!("No data from {source}: all keys are released. Is it plugged in?"),
    };
    Some(Problem::new(
        Error,
        text,
        "Set up",
        UiAction::Show(Tab::SetUp),
    ))
}

fn first_frames(playing: &Playing, _: UiContext<'_>) -> Option<Problem> {
    let has_images = playing.request.source != SourceChoice::Gamepad;
    let waits = has_images && playing.is_running() && playing.view.frames < REFERENCE_FRAMES as u64;
    waits.then(|| plain_hint("Taking the first frames: leave the pad untouched"))
}

/// What happens now, without a button.
fn plain_hint(text: &str) -> Problem {
    Problem {
        severity: Hint,
        text: text.to_owned(),
        fix: None,
    }
}

fn blocked_keys(playing: &Playing, context: UiContext<'_>) -> Option<Problem> {
    let fix = (PAD_WINDOW, UiAction::PadWindow);
    playing.are_keys_blocked().then(|| Problem {
        severity: Error,
        text: "Click your game: no keys are sent while this window has the focus".to_owned(),
        fix: (playing.is_simulated() && !context.is_pad_open).then_some(fix),
    })
}

fn lost_electrodes(playing: &Playing, _: UiContext<'_>) -> Option<Problem> {
    let lost = &playing.view.lost_electrodes;
    let (which, them) = match lost.as_slice() {
        [] => return None,
        [one] => (format!("Electrode {} is", one + 1), "it"),
        _ => (format!("Electrodes {} are", electrode_list(lost)), "them"),
    };
    let text = format!("{which} loose, shorted or noisy: the pad works without {them}");
    Some(Problem::new(
        Warning,
        text,
        SIGNALS,
        UiAction::Show(Tab::Signals),
    ))
}

/// Electrodes as people number them, from 1: `3, 10`.
pub fn electrode_list(electrodes: &[usize]) -> String {
    let numbers: Vec<String> = electrodes.iter().map(|e| (e + 1).to_string()).collect();
    numbers.join(", ")
}

fn notice(playing: &Playing, _: UiContext<'_>) -> Option<Problem> {
    let text = playing.notice.clone()?;
    Some(Problem::new(Warning, text, "OK", UiAction::Dismiss))
}

fn lost_frames(playing: &Playing, _: UiContext<'_>) -> Option<Problem> {
    let lost = playing.view.lost_frames;
    let text = format!("{lost} frames lost: check the cable, or use a slower frame rate");
    let problem = || Problem::new(Warning, text, SIGNALS, UiAction::Show(Tab::Signals));
    (lost > 0).then(problem)
}

fn slow_frames(playing: &Playing, _: UiContext<'_>) -> Option<Problem> {
    let rate = playing.frames_per_s();
    if rate <= 0.0 || rate >= SLOW_FRAMES_PER_S {
        return None;
    }
    let shortest_ms = SHORTEST_PRESS_FRAMES * 1e3 / rate;
    let text =
        format!("{rate:.0} frames/s: presses shorter than {shortest_ms:.0} ms may be missed");
    Some(Problem::new(
        Warning,
        text,
        "Set up",
        UiAction::Show(Tab::SetUp),
    ))
}

/// The trial at the start: its button sends keys to the game.
pub(super) fn trial(playing: &Playing, context: UiContext<'_>) -> Option<Problem> {
    let output = context.last_output.unwrap_or(OutputChoice::Auto);
    let request = PlayRequest {
        output,
        ..playing.request.clone()
    };
    let text = match output {
        OutputChoice::Auto => "Trial: no keys are sent".to_owned(),
        _ => format!(
            "Trial: no keys are sent. Last output: {}",
            output_words(output)
        ),
    };
    let fix = UiAction::Play(request);
    let label = match context.was_sent {
        true => CONTINUE,
        false => "Send to my game",
    };
    let problem = || Problem::new(Hint, text, label, fix);
    (playing.request.output == OutputChoice::Nothing).then(problem)
}

/// The simulated pad sends keys, but nothing can press it while the game has the focus.
fn no_pad_to_press(playing: &Playing, context: UiContext<'_>) -> Option<Problem> {
    let sends = playing.request.output != OutputChoice::Nothing;
    let text = "To press the simulated pad while your game has the keyboard, open the pad window";
    let problem = || Problem::new(Hint, text, PAD_WINDOW, UiAction::PadWindow);
    (sends && playing.is_simulated() && !context.is_pad_open).then(problem)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(playing: &Playing, context: UiContext<'_>) -> String {
        most_severe(playing, context).map_or(String::new(), |problem| problem.text)
    }

    #[test]
    fn the_most_severe_problem_comes_first_and_the_first_among_equals() {
        let mut playing = Playing::idle();
        let context = UiContext::default();
        assert_eq!(text(&playing, context), "Trial: no keys are sent");
        playing.view.frames_per_s = 12.0;
        assert_eq!(
            text(&playing, context),
            "12 frames/s: presses shorter than 167 ms may be missed"
        );
        playing.view.lost_electrodes = vec![2];
        assert!(text(&playing, context).starts_with("Electrode 3 is loose"));
        playing.view.lost_electrodes = vec![2, 9];
        assert!(text(&playing, context).starts_with("Electrodes 3, 10 are loose"));
        playing.view.paused = true;
        let problem = most_severe(&playing, context).expect("paused");
        assert_eq!(problem.fix, Some(("Resume", UiAction::Pause)));
        let failed = UiContext {
            failed: Some("no such port"),
            ..context
        };
        assert_eq!(text(&playing, failed), "no such port");
    }

    #[test]
    fn the_pad_window_is_offered_until_it_is_open() {
        let mut playing = Playing::idle();
        playing.request.output = OutputChoice::Keyboard;
        let mut context = UiContext::default();
        let problem = most_severe(&playing, context).expect("no pad to press");
        assert_eq!(problem.fix, Some((PAD_WINDOW, UiAction::PadWindow)));
        context.is_pad_open = true;
        assert_eq!(most_severe(&playing, context), None);
    }

    #[test]
    fn the_last_output_is_named_and_used_again() {
        let playing = Playing::idle();
        let context = UiContext {
            was_sent: true,
            last_output: Some(OutputChoice::Gamepad),
            ..UiContext::default()
        };
        let problem = most_severe(&playing, context).expect("a trial");
        assert!(
            problem.text.ends_with("Last output: gamepad"),
            "{problem:?}"
        );
        let Some(("Continue in my game", UiAction::Play(request))) = problem.fix else {
            panic!("{problem:?}");
        };
        assert_eq!(request.output, OutputChoice::Gamepad);
    }

    #[test]
    fn while_a_game_starts_the_window_says_so_and_the_old_one_has_no_problems() {
        let mut playing = Playing::idle();
        playing.ended = Some("disconnected".to_owned());
        let context = UiContext {
            starting: true,
            ..UiContext::default()
        };
        assert_eq!(text(&playing, context), "Starting …");
    }
}
