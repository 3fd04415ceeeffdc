//! The game that the window shows: the newest view, its story, and the player's wishes.
//!
//! The window reads views and asks; it never waits for the engine, and the engine never for it.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::desk::{Choice, Started, Watch};
use super::fingers::Fingers;
use super::still;
use super::story::Story;
use crate::pad::Pad;
use crate::runtime::{Command, Running, Summary, View};
use crate::source::Hand;

/// What is being played, or was.
pub struct Playing {
    /// What was asked for.
    pub choice: Choice,
    /// The pad.
    pub pad: Pad,
    /// The newest view.
    pub view: View,
    /// The last seconds.
    pub story: Story,
    /// Fingers on the simulated pad.
    pub fingers: Fingers,
    /// A word for the device that events go to.
    pub output: String,
    /// The last thing that the player should know.
    pub notice: Option<String>,
    /// How it ended, if it has.
    pub ended: Option<String>,
    /// What was asked of a game that does not run: for tests.
    pub asked: Vec<Command>,
    /// The voltages of the untouched pad as they first were: what drift is measured from.
    pub first_reference: Vec<f32>,
    hand: Option<Hand>,
    hush: Option<Arc<AtomicBool>>,
    running: Option<Running>,
    watch: Option<Box<dyn Watch>>,
}

impl Playing {
    /// A view without a game.
    #[must_use]
    pub fn still(choice: Choice, pad: Pad, view: View) -> Self {
        let mut playing = Self {
            choice,
            pad,
            view,
            story: Story::default(),
            fingers: Fingers::default(),
            output: "nothing".to_owned(),
            notice: None,
            ended: None,
            asked: Vec::new(),
            first_reference: Vec::new(),
            hand: None,
            hush: None,
            running: None,
            watch: None,
        };
        playing.story.take(&playing.view);
        playing
    }

    /// The untouched pad, before anything runs.
    #[must_use]
    pub fn nothing() -> Self {
        let pad = still::pad();
        let view = still::view_of(&pad, still::profile());
        Self::still(Choice::default(), pad, view)
    }

    /// A game that has been started.
    #[must_use]
    pub fn of(choice: Choice, started: Started) -> Self {
        let Started {
            mut running,
            hand,
            pad,
            output,
            hush,
            watch,
            warnings,
        } = started;
        let view = running.view().clone();
        let mut playing = Self::still(choice, pad, view);
        playing.output = output;
        playing.hand = hand;
        playing.hush = hush;
        playing.running = Some(running);
        playing.watch = Some(watch);
        playing.notice = warnings.into_iter().next();
        playing
    }

    /// Whether its threads run.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.running.is_some()
    }

    /// The threads, for whoever wants to be woken by them.
    #[must_use]
    pub fn running(&self) -> Option<&Running> {
        self.running.as_ref()
    }

    /// Whether the pad is pressed in the window.
    #[must_use]
    pub fn has_hand(&self) -> bool {
        self.choice.from == super::desk::From::Hand
    }

    /// Whether its keys would come back to this window while that has the focus.
    #[must_use]
    pub fn types_keys(&self) -> bool {
        self.hush.is_some()
    }

    /// Takes the newest view; whether there was one.
    pub fn look(&mut self) -> bool {
        let Some(running) = &mut self.running else {
            return false;
        };
        if let Some(watch) = &mut self.watch {
            let notice = &mut self.notice;
            watch.look(running, &mut |words| *notice = Some(words));
        }
        if let Some(hand) = &mut self.hand {
            hand.flush();
        }
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
            self.take_view();
        }
        if is_over && let Some(running) = self.running.take() {
            self.ended = Some(told(&running.join()));
            self.over();
            return true;
        }
        is_new
    }

    /// Tells the story on with the view as it is.
    pub fn take_view(&mut self) {
        self.story.take(&self.view);
        if self.first_reference.is_empty() {
            self.first_reference
                .clone_from(&self.view.signals.reference);
        }
    }

    /// Asks for something.
    pub fn ask(&mut self, command: Command) {
        match &mut self.running {
            Some(running) => {
                if matches!(command, Command::Pause)
                    && let Some(hand) = &mut self.hand
                {
                    // Nobody presses a simulated pad that is paused: it need not be read.
                    let goes_on = running.view().paused;
                    hand.rest(!goes_on);
                }
                if !running.ask(command) {
                    self.notice = Some("too many wishes at once: try again".to_owned());
                }
            }
            None => self.asked.push(command),
        }
    }

    /// Presses the simulated pad with the fingers as they are.
    pub fn press(&mut self) {
        if let Some(hand) = &mut self.hand {
            hand.press(&self.fingers.for_pad());
        }
    }

    /// Says whether this window has the focus: it then gets no keys of its own.
    pub fn hush(&mut self, focused: bool) {
        if let Some(hush) = &self.hush {
            hush.store(focused, Ordering::Relaxed);
        }
    }

    /// Whether keys are held back because this window has the focus.
    #[must_use]
    pub fn is_hushed(&self) -> bool {
        self.hush
            .as_ref()
            .is_some_and(|hush| hush.load(Ordering::Relaxed))
    }

    /// Ends it and waits for its keys to be up; gives back where it recorded to.
    pub fn end(&mut self) -> Option<PathBuf> {
        self.hand = None;
        if let Some(running) = self.running.take() {
            running.stop();
            self.ended = Some(told(&running.join()));
            self.over();
        }
        self.choice.record.clone()
    }

    fn over(&mut self) {
        self.hand = None;
        if let Some(mut watch) = self.watch.take() {
            watch.end();
        }
    }
}

/// How a game ended, in a sentence.
fn told(summary: &Summary) -> String {
    if let Some(thread) = summary.panicked {
        return format!("a bug in gelpad ended its {thread} thread; all keys are up");
    }
    if let Some(error) = &summary.output_error {
        return error.to_string();
    }
    if let Some(error) = &summary.source_error {
        return error.to_string();
    }
    format!(
        "the end: {} frames, {} presses",
        summary.frames, summary.presses
    )
}
