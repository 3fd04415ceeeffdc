//! The engine's thread: feeds every input in order, sends events to the output and views to the window.

mod publish;
mod readings;

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread::Thread;
use std::time::{Duration, Instant};

use rtrb::{Consumer, Producer, PushError};

use crate::engine::{Engine, Input};
use crate::runtime::latency::{EngineTimes, OutputStatistics};
use crate::runtime::listen::{EngineStep, StepListener};
use crate::runtime::rebuild::{Built, Rebuilder};
use crate::runtime::schedule::Due;
use crate::runtime::wake::ChangeDetector;
use crate::runtime::{
    Arrival, EngineReport, NAP, PlayCommand, SourceInput, SourceStatus, View, ViewWaker, nanos, now,
};
use crate::source::SourcePace;
use crate::touch::SensingBuilder;
use crate::types::{Control, Event, Nanos};

/// A board that sends no frame for this long is silent: all outputs are released until it sends again.
const SILENCE: Duration = Duration::from_millis(500);
/// The same for a board that stops within a frame whose parts arrive one after another.
const SILENCE_IN_FRAME: Duration = Duration::from_millis(250);
/// The same for gamepads. They have no loose cable, and a busy computer may read them late.
const GAMEPAD_SILENCE: Duration = Duration::from_secs(2);
/// Events that a view keeps for its log.
const VIEW_EVENTS: usize = 64;
/// The engine thread's ends of the queues to and from the other threads.
pub(in crate::runtime) struct EngineQueues {
    pub(in crate::runtime) frames: Consumer<Arrival>,
    pub(in crate::runtime) commands: Consumer<PlayCommand>,
    pub(in crate::runtime) status: Arc<SourceStatus>,
    pub(in crate::runtime) events: Producer<Due>,
    pub(in crate::runtime) output: Thread,
    /// Statistics of the output thread.
    pub(in crate::runtime) emitted: triple_buffer::Output<OutputStatistics>,
    pub(in crate::runtime) views: triple_buffer::Input<View>,
    pub(in crate::runtime) waker: Arc<ViewWaker>,
}

pub(in crate::runtime) struct EngineThread {
    engine: Engine,
    /// None if its thread could not be started: play then continues with the first matrix.
    rebuilder: Option<Rebuilder>,
    /// A finished matrix that the engine has not taken yet.
    built: Option<Built>,
    queues: EngineQueues,
    view: View,
    changes: ChangeDetector,
    listeners: Vec<Box<dyn StepListener>>,
    /// Events of the present input.
    fresh: Vec<Event>,
    times: EngineTimes,
    pace: SourcePace,
    /// How long the source may send nothing before all outputs are released.
    longest_silence: Duration,
    /// Whether the source is silent, and all outputs released.
    is_silent: bool,
    /// Retaken references that were logged.
    logged_retakes: u64,
    /// Times the board had hung that were logged.
    logged_hangs: u64,
    logged_renumberings: u64,
    /// Steps from one frame to the next, and their time, without the time in which the board was away.
    steps: u64,
    played_ns: Nanos,
    /// Time of the last complete frame.
    last_end_ns: Option<Nanos>,
    /// Time and arrival of the last frame or part: they tie the source's time to the clock.
    last_frame: Option<(Nanos, Instant)>,
    /// When the current second of the frame rate began, and the frames until then.
    second: Option<(Instant, u64)>,
}

impl EngineThread {
    /// The state of the engine's thread; to be called on it.
    pub(in crate::runtime) fn new(
        engine: Engine,
        builder: SensingBuilder,
        pace: SourcePace,
        queues: EngineQueues,
        view: View,
        listeners: Vec<Box<dyn StepListener>>,
    ) -> Self {
        Self {
            engine,
            rebuilder: Rebuilder::start(builder, std::thread::current()).ok(),
            built: None,
            queues,
            view,
            changes: ChangeDetector::default(),
            listeners,
            fresh: Vec::new(),
            times: EngineTimes::new(),
            pace,
            longest_silence: SILENCE,
            is_silent: false,
            logged_retakes: 0,
            logged_hangs: 0,
            logged_renumberings: 0,
            steps: 0,
            played_ns: 0,
            last_end_ns: None,
            last_frame: None,
            second: None,
        }
    }

    pub(in crate::runtime) fn run(mut self) -> EngineReport {
        loop {
            self.take_losses();
            self.take_commands();
            if let Ok(Arrival { input, at }) = self.queues.frames.pop() {
                match input {
                    SourceInput::Frame(frame) => self.take_frame(frame, at),
                    SourceInput::Part(part) => self.take_part(part, at),
                    SourceInput::Control(control) => self.take_control(&control, at),
                }
            } else if self.queues.frames.is_abandoned() && self.queues.frames.is_empty() {
                break;
            } else {
                self.wait();
            }
            if self.queues.events.is_abandoned() {
                break;
            }
        }
        self.take_losses();
        let end_ns = match self.pace {
            // A file ends at the same time, however fast it was played.
            SourcePace::ByStamp => self.view.t_ns,
            SourcePace::ByDevice => self.now_ns().max(self.view.t_ns),
        };
        self.input(&Input::End { t_ns: end_ns }, None);
        self.publish();
        EngineReport {
            frames: self.view.frames,
            frames_per_s: self.frames_per_s(),
            lost_frames: self.engine.lost_frames(),
            times: self.times,
        }
    }

    fn take_losses(&mut self) {
        let lost = self.queues.status.lost_frames.swap(0, Ordering::Relaxed);
        if lost > 0 {
            self.input(&Input::Lost { frames: lost }, None);
            self.view.lost_frames += lost;
        }
    }

    fn take_commands(&mut self) {
        while let Ok(command) = self.queues.commands.pop() {
            let t_ns = self.now_ns().max(self.view.t_ns);
            let input = match command {
                PlayCommand::Profile(profile) => Input::Profile { t_ns, profile },
                PlayCommand::Pause => Input::Pause { t_ns },
                PlayCommand::Rezero => Input::Rezero { t_ns },
                PlayCommand::Table(table) => {
                    if let Some(rebuilder) = &mut self.rebuilder {
                        rebuilder.add_table(table);
                    }
                    continue;
                }
                PlayCommand::Pad(builder) => {
                    if let Some(rebuilder) = &mut self.rebuilder {
                        rebuilder.change_pad(builder);
                    }
                    continue;
                }
            };
            self.input(&input, None);
            self.publish();
        }
    }

    /// A gamepad's state: it has no image and does not count as a frame.
    fn take_control(&mut self, control: &Control, at: Instant) {
        self.is_silent = false;
        self.last_frame = Some((control.t_ns, at));
        self.view.t_ns = control.t_ns;
        let taken = now();
        self.longest_silence = GAMEPAD_SILENCE;
        self.input(&Input::Control(*control), Some(at));
        // No touches are located.
        self.times.record(at, taken, taken);
        self.publish();
    }

    /// Requests the matrix that the engine wants, and feeds a finished one.
    fn rebuild(&mut self) {
        let Some(rebuilder) = &mut self.rebuilder else {
            return;
        };
        if let Some(deviations) = self.engine.wanted() {
            rebuilder.request(deviations);
        }
        if let Some(mut newest) = rebuilder.take_built() {
            // One that replaces a waiting one waits too.
            newest.relocates |= self.built.as_ref().is_some_and(|built| built.relocates);
            self.built = Some(newest);
        }
        let is_free =
            self.engine.touches_down().is_empty() && self.engine.held_outputs().next().is_none();
        if let Some(built) = self.built.take_if(|built| is_free || !built.relocates) {
            self.input(&Input::Matrix(built.sensing), None);
        }
    }

    /// Feeds every tick that is due by a time, each with its own due time.
    fn tick_until(&mut self, t_ns: Nanos) {
        while let Some(due_ns) = self.engine.next_due().filter(|due| *due <= t_ns) {
            self.input(&Input::Tick { due_ns }, None);
        }
    }

    /// Sleeps until the next tick is due or a frame arrives, and feeds that tick.
    fn wait(&mut self) {
        self.rebuild();
        let nap = match self.engine.next_due() {
            Some(due) => Duration::from_nanos(due.saturating_sub(self.now_ns())).min(NAP),
            None => NAP,
        };
        if !nap.is_zero() {
            std::thread::park_timeout(nap);
        }
        // Frames from before the disconnection are played first.
        let gone = self.queues.status.is_disconnected.load(Ordering::Acquire);
        if self.queues.frames.is_empty() {
            self.tick_until(self.now_ns());
            if gone {
                self.queues
                    .status
                    .is_disconnected
                    .store(false, Ordering::Relaxed);
                self.fall_silent();
            }
            self.release_if_silent();
        }
    }

    /// Releases everything while a board is silent: no key may stick because of a loose cable.
    fn release_if_silent(&mut self) {
        let quiet = self
            .last_frame
            .is_some_and(|(_, at)| at.elapsed() > self.longest_silence);
        if self.pace == SourcePace::ByDevice && quiet && !self.is_silent {
            self.fall_silent();
            tracing::warn!(
                "the board has been silent for {} ms: all keys are released",
                self.longest_silence.as_millis()
            );
        }
    }

    fn fall_silent(&mut self) {
        if !self.is_silent {
            self.is_silent = true;
            let t_ns = self.now_ns();
            self.input(&Input::End { t_ns }, None);
            self.publish();
        }
    }

    /// The source's time now: that of the last frame plus the clock's time since.
    fn now_ns(&self) -> Nanos {
        self.last_frame
            .map_or(0, |(t_ns, at)| t_ns + nanos(at.elapsed()))
    }

    fn input(&mut self, input: &Input, frame_at: Option<Instant>) {
        self.input_timed(input, frame_at, &mut || {});
    }

    /// Feeds an input; `placed` is called when its touches are located.
    fn input_timed(&mut self, input: &Input, frame_at: Option<Instant>, placed: &mut dyn FnMut()) {
        self.engine
            .input_with_callback(input, &mut self.fresh, placed);
        let made = now();
        // A frame's events are due when it arrives; a tick's at its own time, by the clock since the last frame.
        let due_at = match (input, self.last_frame) {
            (Input::Tick { due_ns }, Some((t_ns, at))) => {
                at + Duration::from_nanos(due_ns.saturating_sub(t_ns))
            }
            _ => frame_at.unwrap_or(made),
        };
        let step = EngineStep {
            input,
            touches: self.engine.touches_down(),
            events: &self.fresh,
        };
        for listener in &mut self.listeners {
            listener.on_step(&step);
        }
        let count = self.fresh.len();
        for (index, event) in self.fresh.drain(..).enumerate() {
            if self.view.events.len() == VIEW_EVENTS {
                self.view.events.pop_front();
            }
            self.view.events.push_back(event);
            self.view.events_so_far += 1;
            let mut due = Due {
                event,
                at: due_at,
                made,
                frame_at,
                ends_batch: index + 1 == count,
            };
            // Events are never dropped: a device that falls 1024 events behind makes the engine wait.
            while let Err(PushError::Full(back)) = self.queues.events.push(due) {
                if self.queues.events.is_abandoned() {
                    return;
                }
                due = back;
                self.queues.output.unpark();
                std::thread::park_timeout(Duration::from_millis(1));
            }
        }
        self.queues.output.unpark();
    }
}
