//! The engine's thread: every input in the order in which it comes, events to the output, what there is to see to the views.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread::Thread;
use std::time::{Duration, Instant};

use rtrb::{Consumer, Producer, PushError};

use super::latency::{Emitted, EngineTimes};
use super::listen::{Listener, Step};
use super::rebuild::Rebuilder;
use super::schedule::Due;
use super::{Arrival, Arrived, Command, EngineReport, Losses, NAP, View, Wake, nanos, now};
use crate::eit::REFERENCE_FRAMES;
use crate::engine::{Engine, Input};
use crate::source::Pace;
use crate::types::{Control, Event, Frame, Nanos};

/// A board that sends no frame for this long is silent: its keys come up until it speaks again.
pub(super) const SILENCE: Duration = Duration::from_millis(500);
/// The same for gamepads: no cable hangs half out of them, they are read in this very process, and a computer may be so busy.
const GAMEPAD_SILENCE: Duration = Duration::from_secs(2);
/// Events that a view keeps for its log.
const VIEW_EVENTS: usize = 64;
/// What changes slowly of the signals is looked at once in so many frames.
const SLOW_SIGNALS: u64 = 50;

pub(super) struct EngineThread {
    pub(super) engine: Engine,
    pub(super) rebuilder: Option<Rebuilder>,
    pub(super) frames: Consumer<Arrived>,
    pub(super) commands: Consumer<Command>,
    pub(super) losses: Arc<Losses>,
    pub(super) events: Producer<Due>,
    pub(super) output: Thread,
    pub(super) views: triple_buffer::Input<View>,
    pub(super) wake: Arc<Wake>,
    pub(super) view: View,
    pub(super) listeners: Vec<Box<dyn Listener>>,
    pub(super) fresh: Vec<Event>,
    pub(super) times: EngineTimes,
    /// What the output's thread tells.
    pub(super) emitted: triple_buffer::Output<Emitted>,
    pub(super) pace: Pace,
    /// How long the source may be silent.
    pub(super) longest_silence: Duration,
    /// Whether the board is silent, and its keys up.
    pub(super) silent: bool,
    /// References that were taken anew and told.
    pub(super) retaken_told: u64,
    /// Time of the first frame.
    pub(super) first_ns: Option<Nanos>,
    /// Time and arrival of the last frame: how the source's time runs against the clock's.
    pub(super) last_frame: Option<(Nanos, Instant)>,
    /// When the current second of the frame rate began, and the frames until then.
    pub(super) second: Option<(Instant, u64)>,
}

impl EngineThread {
    pub(super) fn run(mut self) -> EngineReport {
        loop {
            self.take_losses();
            self.take_commands();
            if let Ok(arrived) = self.frames.pop() {
                let Arrived { what, at } = arrived;
                match what {
                    Arrival::Frame(frame) => self.frame(frame, at),
                    Arrival::Control(control) => self.control(&control, at),
                }
            } else if self.frames.is_abandoned() && self.frames.is_empty() {
                break;
            } else {
                self.wait();
            }
            if self.events.is_abandoned() {
                break;
            }
        }
        self.take_losses();
        let end_ns = match self.pace {
            // The same file ends at the same time, however fast it was played.
            Pace::ByStamp => self.view.t_ns,
            Pace::ByDevice => self.now_ns().max(self.view.t_ns),
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
        let lost = self.losses.frames.swap(0, Ordering::Relaxed);
        if lost > 0 {
            self.input(&Input::Lost { frames: lost }, None);
            self.view.lost_frames += lost;
        }
    }

    fn take_commands(&mut self) {
        while let Ok(control) = self.commands.pop() {
            let t_ns = self.now_ns().max(self.view.t_ns);
            let input = match control {
                Command::Profile(profile) => Input::Profile { t_ns, profile },
                Command::Pause => Input::Pause { t_ns },
                Command::Rezero => Input::Rezero { t_ns },
            };
            self.input(&input, None);
            self.publish();
        }
    }

    /// A gamepad's state: it has no image, and is no frame to be counted.
    fn control(&mut self, control: &Control, at: Instant) {
        self.silent = false;
        self.first_ns.get_or_insert(control.t_ns);
        self.last_frame = Some((control.t_ns, at));
        self.view.t_ns = control.t_ns;
        let taken = now();
        self.longest_silence = GAMEPAD_SILENCE;
        self.input(&Input::Control(*control), Some(at));
        // There is nothing to place.
        self.times.note(at, taken, taken);
        self.publish();
    }

    fn frame(&mut self, frame: Frame, at: Instant) {
        if self.silent {
            self.silent = false;
            tracing::warn!("the board sends again");
        }
        self.first_ns.get_or_insert(frame.t_ns);
        self.last_frame = Some((frame.t_ns, at));
        self.view.t_ns = frame.t_ns;
        self.view.frames += 1;
        self.view.signals.volts.clone_from(&frame.volts);
        let taken = now();
        let mut placed = taken;
        self.input_watched(&Input::Frame(frame), Some(at), &mut || placed = now());
        self.times.note(at, taken, placed);
        self.rate(at);
        self.publish();
        let retaken = self.engine.references_retaken();
        if retaken > self.retaken_told {
            self.retaken_told = retaken;
            tracing::warn!("the reference was taken anew: a hand lay on the pad, or has left it");
        }
        if self.view.frames == REFERENCE_FRAMES as u64 {
            let muted = self.engine.muted_channels();
            if !muted.is_empty() {
                tracing::warn!("dead or loose at the start, left out: channels {muted:?}");
            }
        }
        self.tell_electrodes();
        self.rebuild();
    }

    /// Says which electrodes were lost, and which are back.
    fn tell_electrodes(&mut self) {
        let lost = self.engine.lost_electrodes();
        if lost == self.view.lost_electrodes {
            return;
        }
        for electrode in lost
            .iter()
            .filter(|e| !self.view.lost_electrodes.contains(e))
        {
            tracing::warn!(
                "electrode {electrode} is loose, shorted or noisy: play goes on without it"
            );
        }
        for electrode in self
            .view
            .lost_electrodes
            .iter()
            .filter(|e| !lost.contains(e))
        {
            tracing::warn!("electrode {electrode} is back");
        }
        self.view.lost_electrodes = lost;
    }

    /// Asks for the matrix that the engine wants, and feeds the one that was built.
    fn rebuild(&mut self) {
        let Some(rebuilder) = &mut self.rebuilder else {
            return;
        };
        if let Some(deviations) = self.engine.wanted() {
            rebuilder.wish(deviations);
        }
        if let Some(sensing) = rebuilder.take() {
            self.input(&Input::Matrix(sensing), None);
        }
    }

    /// Feeds every tick that is due by a time, with its own time.
    fn tick_until(&mut self, t_ns: Nanos) {
        while let Some(due_ns) = self.engine.next_due().filter(|due| *due <= t_ns) {
            self.input(&Input::Tick { due_ns }, None);
        }
    }

    /// Sleeps until the next tick is due or a frame is there, and feeds that tick.
    fn wait(&mut self) {
        self.rebuild();
        let nap = match self.engine.next_due() {
            Some(due) => Duration::from_nanos(due.saturating_sub(self.now_ns())).min(NAP),
            None => NAP,
        };
        if !nap.is_zero() {
            std::thread::park_timeout(nap);
        }
        // What came before the board went is played first.
        let gone = self.losses.gone.load(Ordering::Acquire);
        if self.frames.is_empty() {
            self.tick_until(self.now_ns());
            if gone {
                self.losses.gone.store(false, Ordering::Relaxed);
                self.fall_silent();
            }
            self.watch();
        }
    }

    /// Lets go of everything while a board is silent: a key must not stick because a cable is half out.
    fn watch(&mut self) {
        let quiet = self
            .last_frame
            .is_some_and(|(_, at)| at.elapsed() > self.longest_silence);
        if self.pace == Pace::ByDevice && quiet && !self.silent {
            self.fall_silent();
            tracing::warn!(
                "the board has been silent for {} ms: all keys are up",
                self.longest_silence.as_millis()
            );
        }
    }

    fn fall_silent(&mut self) {
        if !self.silent {
            self.silent = true;
            let t_ns = self.now_ns();
            self.input(&Input::End { t_ns }, None);
            self.publish();
        }
    }

    /// The source's time now, by the clock since the last frame.
    fn now_ns(&self) -> Nanos {
        self.last_frame
            .map_or(0, |(t_ns, at)| t_ns + nanos(at.elapsed()))
    }

    fn input(&mut self, input: &Input, frame_at: Option<Instant>) {
        self.input_watched(input, frame_at, &mut || {});
    }

    /// Feeds an input; what is given is called when its touches are known.
    fn input_watched(
        &mut self,
        input: &Input,
        frame_at: Option<Instant>,
        placed: &mut dyn FnMut(),
    ) {
        self.engine.input_watched(input, &mut self.fresh, placed);
        let made = now();
        // A frame's events are due as it comes; a tick's at its time, by the clock since the last frame.
        let due_at = match (input, self.last_frame) {
            (Input::Tick { due_ns }, Some((t_ns, at))) => {
                at + Duration::from_nanos(due_ns.saturating_sub(t_ns))
            }
            _ => frame_at.unwrap_or(made),
        };
        let step = Step {
            input,
            touches: self.engine.touches().down,
            events: &self.fresh,
        };
        for listener in &mut self.listeners {
            listener.step(&step);
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
            while let Err(PushError::Full(back)) = self.events.push(due) {
                if self.events.is_abandoned() {
                    return;
                }
                due = back;
                self.output.unpark();
                std::thread::park_timeout(Duration::from_millis(1));
            }
        }
        self.output.unpark();
    }

    /// From the first frame to the last, by the source's own time.
    fn frames_per_s(&self) -> f64 {
        match (self.first_ns, self.last_frame) {
            (Some(first), Some((last, _))) if last > first => {
                self.view.frames.saturating_sub(1) as f64 / ((last - first) as f64 * 1e-9)
            }
            _ => 0.0,
        }
    }

    fn rate(&mut self, at: Instant) {
        let (start, frames) = *self.second.get_or_insert((at, self.view.frames));
        let elapsed = at.duration_since(start);
        if elapsed >= Duration::from_secs(1) {
            self.view.frames_per_s = (self.view.frames - frames) as f64 / elapsed.as_secs_f64();
            let emitted = *self.emitted.read();
            self.view.stages = self.times.stages(&emitted);
            self.view.latency_us = self.times.frame_to_events_ns.value_at_quantile(0.5) / 1000;
            self.second = Some((at, self.view.frames));
        }
    }

    fn publish(&mut self) {
        let emitted = *self.emitted.read();
        let state = self.engine.touches();
        let detector = self.engine.detector();
        if self.view.frames.is_multiple_of(SLOW_SIGNALS) && detector.is_ready() {
            let [reference, noise] = detector.at_rest();
            self.view.signals.reference = reference;
            self.view.signals.noise = noise;
        }
        let slot = self.views.input_buffer_mut();
        slot.signals.volts.clone_from(&self.view.signals.volts);
        slot.signals
            .reference
            .clone_from(&self.view.signals.reference);
        slot.signals.noise.clone_from(&self.view.signals.noise);
        if detector.is_ready() {
            let (changes, explained) = detector.changes();
            slot.signals.changes.clear();
            slot.signals.changes.extend_from_slice(changes);
            slot.signals.explained.clear();
            slot.signals.explained.extend_from_slice(explained);
        }
        slot.events_so_far = self.view.events_so_far;
        slot.t_ns = self.view.t_ns;
        slot.profile = Arc::clone(self.engine.profile());
        slot.paused = self.engine.is_paused();
        slot.image.values.clone_from(&state.image.values);
        slot.touches.clear();
        slot.touches.extend_from_slice(state.down);
        slot.held.clear();
        slot.held.extend(self.engine.held());
        slot.events.clone_from(&self.view.events);
        slot.frames = self.view.frames;
        slot.lost_frames = self.view.lost_frames;
        slot.lost_electrodes.clone_from(&self.view.lost_electrodes);
        slot.frames_per_s = self.view.frames_per_s;
        slot.latency_us = self.view.latency_us;
        slot.stages = self.view.stages;
        slot.late_events = emitted.late;
        slot.rumble = emitted.rumble;
        self.views.publish();
        self.wake.wake();
    }
}
