//! The game that the window shows: its newest view, recent history, and the commands sent to it.
//!
//! Invariant: the window reads views and sends commands; neither it nor the engine waits for the other.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::Thread;

use super::fingers::Fingers;
use super::history::History;
use super::still;
use crate::app::services::{PlayRequest, SourceChoice, Started, TableInProgress, Watch};
use crate::pad::Pad;
use crate::runtime::{PlayCommand, RunningGame, SessionSummary, View};
use crate::source::LiveFingers;

/// A source without frames for longer than this is silent, s.
pub const SILENT_S: f64 = 1.0;

/// The current game, or the last one.
pub struct Playing {
    /// What was requested.
    pub request: PlayRequest,
    /// The pad.
    pub pad: Pad,
    /// The newest view.
    pub view: View,
    /// The last five seconds.
    pub history: History,
    /// Fingers on the simulated pad.
    pub fingers: Fingers,
    /// Name of the output device.
    pub output: String,
    /// The newest message for the player.
    pub notice: Option<String>,
    /// Why the source skips what the board sends, before the first frame.
    pub skip_reason: Option<String>,
    /// Time since the newest view, s.
    pub silent_s: f64,
    /// Why it ended, if it has.
    pub ended: Option<String>,
    /// Commands sent while no game runs: for tests.
    pub unsent_commands: Vec<PlayCommand>,
    /// The first reference voltages: the base of drift.
    pub first_reference: Vec<f32>,
    /// The pad's response table, until it is solved and sent to the game.
    pub table: Option<Arc<TableInProgress>>,
    hand: Option<LiveFingers>,
    keys_blocked: Option<Arc<AtomicBool>>,
    running: Option<RunningGame>,
    watch: Option<Box<dyn Watch>>,
}

impl Playing {
    /// A view without a running game.
    pub fn without_game(request: PlayRequest, pad: Pad, view: View) -> Self {
        let mut playing = Self {
            request,
            pad,
            view,
            history: History::default(),
            fingers: Fingers::default(),
            output: "nothing".to_owned(),
            notice: None,
            skip_reason: None,
            silent_s: 0.0,
            ended: None,
            unsent_commands: Vec::new(),
            first_reference: Vec::new(),
            table: None,
            hand: None,
            keys_blocked: None,
            running: None,
            watch: None,
        };
        playing.history.add_view(&playing.view);
        playing
    }

    /// The default pad before the first game.
    pub fn idle() -> Self {
        let pad = still::pad();
        let view = still::view_of_pad(&pad, still::profile());
        Self::without_game(PlayRequest::default(), pad, view)
    }

    /// A game that has started.
    pub fn from_started(request: PlayRequest, started: Started) -> Self {
        let Started {
            mut running,
            hand,
            pad,
            output,
            keys_blocked,
            watch,
            warnings,
            table,
        } = started;
        let view = running.view().clone();
        let mut playing = Self::without_game(request, pad, view);
        playing.output = output;
        playing.table = table;
        playing.hand = hand;
        playing.keys_blocked = keys_blocked;
        playing.running = Some(running);
        playing.watch = Some(watch);
        playing.notice = warnings.into_iter().next();
        playing
    }

    /// Whether its threads are running.
    pub fn is_running(&self) -> bool {
        self.running.is_some()
    }

    /// Whether a game runs whose source sends frames all the time. A gamepad at rest sends nothing.
    fn expects_frames(&self) -> bool {
        self.is_running() && self.request.source != SourceChoice::Gamepad
    }

    /// Whether a running game gets no data from its source.
    pub fn is_silent(&self) -> bool {
        self.expects_frames() && !self.view.paused && self.silent_s > SILENT_S
    }

    /// Whether a game has started and no frame has come yet.
    pub fn waits_for_frames(&self) -> bool {
        self.expects_frames() && self.view.frames == 0
    }

    /// Frames per second; 0 while the source is silent.
    pub fn frames_per_s(&self) -> f64 {
        match self.is_silent() {
            true => 0.0,
            false => self.view.frames_per_s,
        }
    }

    /// Lets the game unpark a thread whenever it has a new view, after it has counted what the player should see at once.
    pub fn wake_with(&self, thread: Thread, changes: Arc<AtomicU64>) {
        if let Some(running) = &self.running {
            running.wake_on_view(thread, changes);
        }
    }

    /// Whether the source is the simulated pad, pressed in the window.
    pub fn is_simulated(&self) -> bool {
        self.request.source == SourceChoice::Simulated
    }

    /// Reads the newest view, and the end of the game; returns whether anything changed.
    pub fn poll(&mut self) -> bool {
        let Some(running) = &mut self.running else {
            return false;
        };
        if let Some(watch) = &mut self.watch {
            let notice = &mut self.notice;
            watch.poll(running, &mut |message| *notice = message);
        }
        if let Some(hand) = &mut self.hand {
            hand.flush();
        }
        TableInProgress::hand_over(&mut self.table, running);
        self.skip_reason = match self.view.frames {
            0 => running.skip_reason(),
            _ => None,
        };
        let newest = running.view();
        let is_new = newest.frames != self.view.frames
            || newest.events_so_far != self.view.events_so_far
            || newest.paused != self.view.paused
            || !Arc::ptr_eq(&newest.profile, &self.view.profile);
        if is_new {
            self.view.clone_from(newest);
        }
        let is_over = running.is_finished();
        if is_new {
            self.record_view();
        }
        if is_over {
            self.join();
        }
        is_new || is_over
    }

    /// Adds the current view to the history.
    pub fn record_view(&mut self) {
        self.history.add_view(&self.view);
        if self.first_reference.is_empty() {
            self.first_reference
                .clone_from(&self.view.signals.reference);
        }
    }

    /// Sends a command to the engine.
    pub fn send_command(&mut self, command: PlayCommand) {
        match &mut self.running {
            Some(running) => {
                if matches!(command, PlayCommand::Pause)
                    && let Some(hand) = &mut self.hand
                {
                    // A paused simulated pad computes no frames.
                    let resumes = running.view().paused;
                    hand.suspend(!resumes);
                }
                if !running.send_command(command) {
                    self.notice = Some("The engine is busy: try again".to_owned());
                }
            }
            None => self.unsent_commands.push(command),
        }
    }

    /// Sends the fingers to the simulated pad.
    pub fn send_fingers(&mut self) {
        if let Some(hand) = &mut self.hand {
            hand.set_fingers(&self.fingers.for_pad());
        }
    }

    /// Blocks or unblocks key output; blocked while this window has the focus.
    pub fn block_keys(&mut self, block: bool) {
        if let Some(blocked) = &self.keys_blocked {
            blocked.store(block, Ordering::Relaxed);
        }
    }

    /// Whether key output is blocked.
    pub fn are_keys_blocked(&self) -> bool {
        let blocked = self.keys_blocked.as_ref();
        blocked.is_some_and(|blocked| blocked.load(Ordering::Relaxed))
    }

    /// Stops the game and waits until its keys are released. A game that was stopped here is not a pad that disconnected:
    /// only one that had ended before leaves a message.
    pub fn stop(&mut self) {
        self.hand = None;
        let was_running = self.running.as_ref().is_some_and(|running| {
            let is_over = running.is_finished();
            running.stop();
            !is_over
        });
        self.join();
        if was_running {
            self.ended = None;
        }
    }

    /// Waits for the threads of a game that ends.
    fn join(&mut self) {
        let Some(running) = self.running.take() else {
            return;
        };
        self.ended = Some(end_message(&running.join()));
        self.hand = None;
        if let Some(mut watch) = self.watch.take() {
            watch.finish();
        }
    }
}

/// Why a game ended.
fn end_message(summary: &SessionSummary) -> String {
    if let Some(thread) = summary.panicked {
        return format!("A bug in gelpad ended its {thread} thread; all keys are released");
    }
    if let Some(error) = &summary.output_error {
        return error.to_string();
    }
    if let Some(error) = &summary.source_error {
        return error.to_string();
    }
    format!(
        "Ended after {} frames and {} presses",
        summary.frames, summary.presses
    )
}
