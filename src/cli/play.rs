//! `gelpad play`, and the level that plays without arguments.

use std::io::IsTerminal as _;
use std::time::Duration;

use super::args::PlayArgs;
use super::exit::{self, Ending};
use super::input::copy_pipe;
use super::live::{LiveView, Title};
use super::message::say;
use super::progress::SolveBar;
use super::summary::summary_text;
use crate::app::services::{OutputChoice, PlayRequest, SourceChoice};
use crate::app::{
    AppError, FirstUse, Game, PreparedGame, ReloadNotice, TableInProgress, TableSolver,
};
use crate::output::OutputError;
use crate::platform::signals::{HANG_UP, INTERRUPT, Signals};
use crate::platform::terminal::{KeyCommand, Terminal, TerminalLost};
use crate::runtime::{PlayCommand, SessionSummary};

/// Period of the live view and of the checks for signals.
const PERIOD: Duration = Duration::from_millis(33);
/// Longest wait for the output at the end.
const END_LIMIT: Duration = Duration::from_secs(5);

/// Said of a pad that is used for the first time, and some seconds later.
const SOLVING: &str =
    "first use of this pad: touches are found in images until its responses are solved";
const SOLVED: &str = "the responses of this pad are solved: touches are located in the voltages";

/// The level on the simulated pad; no keys are sent.
pub(super) fn play_level() -> anyhow::Result<Ending> {
    let shows_view = can_show_view();
    let request = PlayRequest {
        source: SourceChoice::Level,
        output: OutputChoice::Trace,
        trace_on_stdout: !shows_view,
        ..PlayRequest::default()
    };
    run(&request, shows_view)
}

/// `gelpad play`.
pub(super) fn play(args: &PlayArgs) -> anyhow::Result<Ending> {
    let shows_view = !args.headless && can_show_view();
    let mut request = args.to_request(!shows_view);
    let _copy = match &mut request.source {
        SourceChoice::Replay(file) => copy_pipe(file)?,
        _ => None,
    };
    run(&request, shows_view)
}

/// Whether stdout is a terminal that can be drawn on.
fn can_show_view() -> bool {
    std::io::stdout().is_terminal() && std::env::var_os("TERM").is_none_or(|term| term != "dumb")
}

/// Plays until the source ends, a signal comes or the terminal is closed.
fn run(request: &PlayRequest, shows_view: bool) -> anyhow::Result<Ending> {
    let terminal = Terminal::attached();
    let prepared = prepare(request)?;
    prepared.warnings.iter().for_each(exit::warn);
    if let Some(note) = &prepared.output_note {
        say(note);
    }
    let mut view = match shows_view {
        true => {
            let title = Title {
                source: request.source_label(),
                output: prepared.output.clone(),
            };
            Some(LiveView::open(title, prepared.pad())?)
        }
        false => None,
    };
    // No key is down yet: until here Ctrl-C may end the program immediately.
    let signals = Signals::listen()?;
    let mut game = prepared.start()?;
    let mut ended_by = follow(&mut game, &signals, &terminal, view.as_mut());
    let summary = game.running.end_within(END_LIMIT);
    drop(view);
    // A game whose output was the closed terminal has ended before the loop noticed.
    if terminal.is_lost() {
        ended_by = Some(HANG_UP);
    }
    let Some(summary) = summary else {
        // A recording is complete up to here, though not compressed.
        say("the output does not take its events: gelpad ends without it");
        return Ok(ended_by.map_or(Ending::LostData, Ending::Signal));
    };
    let ending = conclude(summary, ended_by);
    let Some((summary, is_whole)) = game.recording.map(|recording| recording.finish()) else {
        return ending;
    };
    say(&summary);
    match ending {
        Ok(Ending::Done) if !is_whole => Ok(Ending::LostData),
        ending => ending,
    }
}

/// Opens everything. A board plays at once, the first time too: its player waits. Other sources, whose events must not depend on when the
/// table is ready, wait for it.
fn prepare(request: &PlayRequest) -> Result<PreparedGame, AppError> {
    if matches!(request.source, SourceChoice::Serial(_)) && request.record.is_none() {
        return PreparedGame::prepare(request, &FirstUse::PlayAtOnce(&TableSolver::default()));
    }
    let bar = SolveBar::default();
    let wait = FirstUse::Wait(&|done, rows| bar.update(done, rows));
    let prepared = PreparedGame::prepare(request, &wait)?;
    bar.finish();
    Ok(prepared)
}

/// Draws and waits until the game ends; returns the signal that ended it, if one did.
fn follow(
    game: &mut Game,
    signals: &Signals,
    terminal: &Terminal,
    mut view: Option<&mut LiveView>,
) -> Option<i32> {
    let show = |view: &mut Option<&mut LiveView>, notice: String| match view {
        Some(view) => view.show_notice(notice),
        None => say(&notice),
    };
    if game.table.is_some() {
        show(&mut view, SOLVING.to_owned());
    }
    while !game.running.is_finished() {
        if let Some(signal) = signals.received() {
            return Some(signal);
        }
        if terminal.is_lost() {
            return Some(HANG_UP);
        }
        if let Some(reload) = &mut game.reload {
            reload.poll(&mut game.running, &mut |notice| match view.as_deref_mut() {
                Some(view) => view.show_notice(notice.to_string()),
                None => say(&reload_text(&notice)),
            });
        }
        if TableInProgress::hand_over(&mut game.table, &mut game.running) {
            show(&mut view, SOLVED.to_owned());
        }
        if let Some(identifier) = &mut game.identifier {
            identifier.poll(&mut game.running, &mut |notice| show(&mut view, notice));
        }
        let Some(view) = view.as_deref_mut() else {
            std::thread::sleep(PERIOD);
            continue;
        };
        let commands = match view.draw_and_wait(game.running.view(), PERIOD) {
            Ok(commands) => commands,
            Err(TerminalLost) => return Some(HANG_UP),
        };
        for command in commands {
            match command {
                KeyCommand::Quit => return None,
                // A raw terminal delivers Ctrl-C as a key.
                KeyCommand::Interrupt => return Some(INTERRUPT),
                KeyCommand::Pause => game.running.send_command(PlayCommand::Pause),
                KeyCommand::Rezero => game.running.send_command(PlayCommand::Rezero),
            };
        }
    }
    signals.received()
}

/// A notice for a terminal: mistakes in a text are drawn under their lines.
fn reload_text(notice: &ReloadNotice) -> String {
    match notice {
        ReloadNotice::Rejected(AppError::Text(errors)) => {
            format!(
                "the old profile stays: {}",
                exit::render_errors(errors).trim_end()
            )
        }
        notice => notice.to_string(),
    }
}

/// Prints the summary; returns how the game ended.
fn conclude(summary: SessionSummary, ended_by: Option<i32>) -> anyhow::Result<Ending> {
    say(&summary_text(&summary));
    if let Some(thread) = summary.panicked {
        anyhow::bail!("a bug in gelpad ended its {thread} thread; all keys are up");
    }
    if ended_by == Some(HANG_UP) {
        return Ok(Ending::Signal(HANG_UP));
    }
    match summary.output_error {
        Some(OutputError::Closed) => return Ok(Ending::Done),
        Some(error) => return Err(error.into()),
        None => {}
    }
    if let Some(error) = summary.source_error {
        return Err(error.into());
    }
    Ok(match ended_by {
        Some(signal) => Ending::Signal(signal),
        None if summary.lost_frames > 0 => Ending::LostData,
        None => Ending::Done,
    })
}
