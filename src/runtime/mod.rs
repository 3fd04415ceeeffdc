//! Threads, clocks, wiring: plays a source through the engine into a device.
//!
//! ```text
//! source thread ─frames─▶ engine thread ─events─▶ output thread
//!                               └─views─▶ whoever shows them
//! ```
//! Queues are bounded. The engine takes every frame; one that finds the queue full is counted and told as lost.
//! Shut-down runs from the source on: its thread ends, the engine releases all, the output is flushed. A thread that
//! panics drops its ends of the queues, and the next in line shuts down as if the source had ended; whatever is still
//! down is released when the device is dropped.

mod rebuild;

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{Builder, JoinHandle, Thread};
use std::time::{Duration, Instant};

use hdrhistogram::Histogram;
use rtrb::{Consumer, Producer, PushError, RingBuffer};

use crate::eit::REFERENCE_FRAMES;
use crate::engine::{Engine, Input};
use crate::output::{Device, Held, OutputError};
use crate::profile::Profile;
use crate::source::{Pace, Reading, Source, SourceError};
use crate::touch::SensingBuilder;
use crate::types::{Event, Frame, Image, Nanos, Output, Touch};
use rebuild::Rebuilder;

/// Frames that may wait for the engine: a quarter of a second at 1000 frames/s.
const FRAME_QUEUE: usize = 256;
/// Events that may wait for the device.
const EVENT_QUEUE: usize = 1024;
/// Wishes of the player that may wait for the engine.
const CONTROL_QUEUE: usize = 16;
/// Longest sleep of any thread: what a shut-down waits for at most.
const NAP: Duration = Duration::from_millis(20);
/// A board that sends no frame for this long is silent: its keys come up until it speaks again.
const SILENCE: Duration = Duration::from_millis(500);
/// Longest wait for the threads to end when nobody asks how it went.
const LAST_WAIT: Duration = Duration::from_secs(2);
/// The first reasons for skipping are told, then every hundredth.
const TOLD_SKIPS: u64 = 3;
/// Events that a view keeps for its log.
const VIEW_EVENTS: usize = 64;

/// What a player may ask for meanwhile.
#[derive(Clone, Debug)]
pub enum Control {
    /// Another profile.
    Profile(Arc<Profile>),
    /// Pause, or go on.
    Pause,
}

/// What a view needs of one moment; views drop to the newest.
#[derive(Clone, Debug)]
pub struct View {
    /// The newest frame's time.
    pub t_ns: Nanos,
    /// The profile in force.
    pub profile: Arc<Profile>,
    /// Whether the player has paused.
    pub paused: bool,
    /// Its image.
    pub image: Image,
    /// Touches that are down.
    pub touches: Vec<Touch>,
    /// Outputs that are down.
    pub held: Vec<Output>,
    /// The last events, oldest first.
    pub events: VecDeque<Event>,
    /// Frames so far.
    pub frames: u64,
    /// Frames that were lost or garbled.
    pub lost_frames: u64,
    /// Electrodes that are left out.
    pub lost_electrodes: Vec<usize>,
    /// Frames a second, over the last second or so.
    pub frames_per_s: f64,
    /// From a frame's arrival to its events, median so far, us.
    pub latency_us: u64,
}

/// What was played, when it is over.
#[derive(Debug)]
pub struct Summary {
    /// Frames that the engine took.
    pub frames: u64,
    /// Frames that were lost before it.
    pub lost_frames: u64,
    /// Things that came from the source and were no frames.
    pub skipped: u64,
    /// Presses sent.
    pub presses: u64,
    /// From a frame's arrival to its events, ns.
    pub frame_to_events_ns: Histogram<u64>,
    /// From a frame's arrival to the moment at which the device has taken its events, ns.
    pub frame_to_device_ns: Histogram<u64>,
    /// Why the source ended, if not by itself.
    pub source_error: Option<SourceError>,
    /// Why the device failed, if it did.
    pub output_error: Option<OutputError>,
    /// The thread that panicked, if one did.
    pub panicked: Option<&'static str>,
}

/// A game being played.
pub struct Running {
    stop: Arc<AtomicBool>,
    controls: Producer<Control>,
    views: triple_buffer::Output<View>,
    threads: Option<Threads>,
}

struct Threads {
    source: JoinHandle<SourceReport>,
    engine: JoinHandle<EngineReport>,
    output: JoinHandle<OutputReport>,
}

struct Arrived {
    frame: Frame,
    at: Instant,
}

struct Due {
    event: Event,
    /// Arrival of the frame that caused it; none for a tick.
    frame_at: Option<Instant>,
}

#[derive(Default)]
struct SourceReport {
    skipped: u64,
    error: Option<SourceError>,
}

struct EngineReport {
    frames: u64,
    lost_frames: u64,
    latency: Histogram<u64>,
}

struct OutputReport {
    presses: u64,
    latency: Histogram<u64>,
    error: Option<OutputError>,
}

/// Starts to play. The builder makes another matrix when an electrode is lost.
///
/// # Errors
/// The system gives no thread.
pub fn start(
    engine: Engine,
    builder: SensingBuilder,
    source: Box<dyn Source>,
    device: Box<dyn Device>,
) -> std::io::Result<Running> {
    let stop = Arc::new(AtomicBool::new(false));
    let lost = Arc::new(AtomicU64::new(0));
    let (frames_in, frames_out) = RingBuffer::new(FRAME_QUEUE);
    let (events_in, events_out) = RingBuffer::new(EVENT_QUEUE);
    let (controls_in, controls_out) = RingBuffer::new(CONTROL_QUEUE);
    let blank = View {
        t_ns: 0,
        profile: Arc::clone(engine.profile()),
        paused: false,
        image: engine.touches().image.clone(),
        touches: Vec::new(),
        held: Vec::new(),
        events: VecDeque::new(),
        frames: 0,
        lost_frames: 0,
        lost_electrodes: Vec::new(),
        frames_per_s: 0.0,
        latency_us: 0,
    };
    let pace = source.pace();
    let (views_in, views) = triple_buffer::triple_buffer(&blank);
    let output = Builder::new()
        .name("output".to_owned())
        .spawn(move || output_thread(device, events_out))?;
    let to_output = output.thread().clone();
    let lost_frames = Arc::clone(&lost);
    let engine = Builder::new().name("engine".to_owned()).spawn(move || {
        // Without a thread to build on, play goes on as it is.
        let rebuilder = Rebuilder::start(builder, std::thread::current());
        EngineThread {
            engine,
            rebuilder: rebuilder.ok(),
            frames: frames_out,
            controls: controls_out,
            lost: lost_frames,
            events: events_in,
            output: to_output,
            views: views_in,
            view: blank,
            fresh: Vec::new(),
            latency: new_histogram(),
            pace,
            silent: false,
            retaken_told: 0,
            last_frame: None,
            second: None,
        }
        .run()
    })?;
    let to_engine = engine.thread().clone();
    let stopping = Arc::clone(&stop);
    let source = Builder::new()
        .name("source".to_owned())
        .spawn(move || source_thread(source, frames_in, &to_engine, &stopping, &lost))?;
    Ok(Running {
        stop,
        controls: controls_in,
        views,
        threads: Some(Threads {
            source,
            engine,
            output,
        }),
    })
}

impl Running {
    /// Whether everything has ended.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        self.threads
            .as_ref()
            .is_none_or(|threads| threads.output.is_finished())
    }

    /// Asks the source to end; the rest follows.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(threads) = &self.threads {
            threads.source.thread().unpark();
        }
    }

    /// Asks for something; whether there was room for the wish.
    pub fn ask(&mut self, control: Control) -> bool {
        let taken = self.controls.push(control).is_ok();
        if let Some(threads) = &self.threads {
            threads.engine.thread().unpark();
        }
        taken
    }

    /// The newest view.
    pub fn view(&mut self) -> &View {
        self.views.read()
    }

    /// Waits for the end.
    #[must_use]
    pub fn join(mut self) -> Summary {
        let threads = self.threads.take().expect("taken here only");
        let mut panicked = None;
        let source = threads.source.join().unwrap_or_else(|_| {
            panicked = Some("source");
            SourceReport::default()
        });
        let engine = threads.engine.join().unwrap_or_else(|_| {
            panicked = Some("engine");
            EngineReport {
                frames: 0,
                lost_frames: 0,
                latency: new_histogram(),
            }
        });
        let output = threads.output.join().unwrap_or_else(|_| {
            panicked = Some("output");
            OutputReport {
                presses: 0,
                latency: new_histogram(),
                error: None,
            }
        });
        Summary {
            frames: engine.frames,
            lost_frames: engine.lost_frames,
            skipped: source.skipped,
            presses: output.presses,
            frame_to_events_ns: engine.latency,
            frame_to_device_ns: output.latency,
            source_error: source.error,
            output_error: output.error,
            panicked,
        }
    }
}

/// Whoever shows the game may panic: the keys come up before the program ends.
impl Drop for Running {
    fn drop(&mut self) {
        self.stop();
        let start = now();
        while !self.is_finished() && start.elapsed() < LAST_WAIT {
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

/// Nanoseconds up to an hour, three digits.
fn new_histogram() -> Histogram<u64> {
    Histogram::new_with_bounds(1, 3_600_000_000_000, 3).expect("constant bounds")
}

#[allow(clippy::disallowed_methods, reason = "the one clock of play")]
fn now() -> Instant {
    Instant::now()
}

fn nanos(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

fn source_thread(
    mut source: Box<dyn Source>,
    mut frames: Producer<Arrived>,
    engine: &Thread,
    stop: &AtomicBool,
    lost: &AtomicU64,
) -> SourceReport {
    let mut report = SourceReport::default();
    let mut first: Option<(Instant, Nanos)> = None;
    while !stop.load(Ordering::Relaxed) && !frames.is_abandoned() {
        match source.read() {
            Ok(Reading::Frame(frame)) => {
                if source.pace() == Pace::ByStamp {
                    let (start, t0) = *first.get_or_insert_with(|| (now(), frame.t_ns));
                    sleep_until(start + Duration::from_nanos(frame.t_ns - t0), stop);
                }
                if stop.load(Ordering::Relaxed) {
                    break;
                }
                let full = match frames.push(Arrived { frame, at: now() }) {
                    Ok(()) => None,
                    Err(PushError::Full(back)) => Some(back),
                };
                engine.unpark();
                match (full, source.pace()) {
                    (None, _) => {}
                    // A board goes on sending: its frame is lost, and said to be.
                    (Some(_), Pace::ByDevice) => {
                        lost.fetch_add(1, Ordering::Relaxed);
                    }
                    (Some(back), Pace::ByStamp) => wait_for_room(&mut frames, back, engine, stop),
                }
            }
            Ok(Reading::Skipped { reason }) => {
                report.skipped += 1;
                lost.fetch_add(1, Ordering::Relaxed);
                if report.skipped <= TOLD_SKIPS || report.skipped.is_multiple_of(100) {
                    let skipped = report.skipped;
                    tracing::warn!("skipped what is no frame ({skipped} so far): {reason}");
                }
                engine.unpark();
            }
            Ok(Reading::Idle) => {}
            Ok(Reading::End) => break,
            Err(error) => {
                report.error = Some(error);
                break;
            }
        }
    }
    drop(frames);
    engine.unpark();
    report
}

/// A file's frames are never lost: it waits until the engine has caught up.
fn wait_for_room(
    frames: &mut Producer<Arrived>,
    frame: Arrived,
    engine: &Thread,
    stop: &AtomicBool,
) {
    let mut waiting = frame;
    while !stop.load(Ordering::Relaxed) && !frames.is_abandoned() {
        match frames.push(waiting) {
            Ok(()) => break,
            Err(PushError::Full(back)) => waiting = back,
        }
        engine.unpark();
        std::thread::park_timeout(Duration::from_millis(1));
    }
    engine.unpark();
}

/// Sleeps, but wakes to stop.
fn sleep_until(due: Instant, stop: &AtomicBool) {
    while !stop.load(Ordering::Relaxed) {
        let left = due.saturating_duration_since(now());
        if left.is_zero() {
            return;
        }
        std::thread::park_timeout(left.min(NAP));
    }
}

struct EngineThread {
    engine: Engine,
    rebuilder: Option<Rebuilder>,
    frames: Consumer<Arrived>,
    controls: Consumer<Control>,
    lost: Arc<AtomicU64>,
    events: Producer<Due>,
    output: Thread,
    views: triple_buffer::Input<View>,
    view: View,
    fresh: Vec<Event>,
    latency: Histogram<u64>,
    pace: Pace,
    /// Whether the board is silent, and its keys up.
    silent: bool,
    /// References that were taken anew and told.
    retaken_told: u64,
    /// Time and arrival of the last frame: how the source's time runs against the clock's.
    last_frame: Option<(Nanos, Instant)>,
    /// When the current second of the frame rate began, and the frames until then.
    second: Option<(Instant, u64)>,
}

impl EngineThread {
    fn run(mut self) -> EngineReport {
        loop {
            self.take_losses();
            self.take_controls();
            if let Ok(arrived) = self.frames.pop() {
                self.frame(arrived);
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
            lost_frames: self.engine.lost_frames(),
            latency: self.latency,
        }
    }

    fn take_losses(&mut self) {
        let lost = self.lost.swap(0, Ordering::Relaxed);
        if lost > 0 {
            self.input(&Input::Lost { frames: lost }, None);
            self.view.lost_frames += lost;
        }
    }

    fn take_controls(&mut self) {
        while let Ok(control) = self.controls.pop() {
            let t_ns = self.now_ns().max(self.view.t_ns);
            let input = match control {
                Control::Profile(profile) => Input::Profile { t_ns, profile },
                Control::Pause => Input::Pause { t_ns },
            };
            self.input(&input, None);
            self.publish();
        }
    }

    fn frame(&mut self, arrived: Arrived) {
        let Arrived { frame, at } = arrived;
        if self.silent {
            self.silent = false;
            tracing::warn!("the board sends again");
        }
        self.last_frame = Some((frame.t_ns, at));
        self.view.t_ns = frame.t_ns;
        self.view.frames += 1;
        self.input(&Input::Frame(frame), Some(at));
        let took = nanos(at.elapsed());
        self.latency.saturating_record(took);
        self.rate(at);
        self.publish();
        let retaken = self.engine.references_retaken();
        if retaken > self.retaken_told {
            self.retaken_told = retaken;
            tracing::warn!("the pad was touched while its reference was taken: taken anew");
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
        if self.frames.is_empty() {
            self.tick_until(self.now_ns());
            self.watch();
        }
    }

    /// Lets go of everything while a board is silent: a key must not stick because a cable is half out.
    fn watch(&mut self) {
        let quiet = self
            .last_frame
            .is_some_and(|(_, at)| at.elapsed() > SILENCE);
        if self.pace == Pace::ByDevice && quiet && !self.silent {
            self.silent = true;
            let t_ns = self.now_ns();
            self.input(&Input::End { t_ns }, None);
            self.publish();
            tracing::warn!(
                "the board has been silent for {} ms: all keys are up",
                SILENCE.as_millis()
            );
        }
    }

    /// The source's time now, by the clock since the last frame.
    fn now_ns(&self) -> Nanos {
        self.last_frame
            .map_or(0, |(t_ns, at)| t_ns + nanos(at.elapsed()))
    }

    fn input(&mut self, input: &Input, frame_at: Option<Instant>) {
        self.engine.input(input, &mut self.fresh);
        for event in self.fresh.drain(..) {
            if self.view.events.len() == VIEW_EVENTS {
                self.view.events.pop_front();
            }
            self.view.events.push_back(event);
            let mut due = Due { event, frame_at };
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

    fn rate(&mut self, at: Instant) {
        let (start, frames) = *self.second.get_or_insert((at, self.view.frames));
        let elapsed = at.duration_since(start);
        if elapsed >= Duration::from_secs(1) {
            self.view.frames_per_s = (self.view.frames - frames) as f64 / elapsed.as_secs_f64();
            self.view.latency_us = self.latency.value_at_quantile(0.5) / 1000;
            self.second = Some((at, self.view.frames));
        }
    }

    fn publish(&mut self) {
        let state = self.engine.touches();
        let slot = self.views.input_buffer_mut();
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
        self.views.publish();
    }
}

fn output_thread(device: Box<dyn Device>, mut events: Consumer<Due>) -> OutputReport {
    let mut held = Held::new(device);
    let mut report = OutputReport {
        presses: 0,
        latency: new_histogram(),
        error: None,
    };
    loop {
        match events.pop() {
            Ok(due) => {
                if let Err(error) = carry_out(&mut held, &due, &mut report) {
                    report.error = Some(error);
                    break;
                }
            }
            Err(_) if events.is_abandoned() && events.is_empty() => break,
            Err(_) => {
                if let Err(error) = held.flush() {
                    report.error = Some(error);
                    break;
                }
                std::thread::park_timeout(NAP);
            }
        }
    }
    report
}

fn carry_out(held: &mut Held, due: &Due, report: &mut OutputReport) -> Result<(), OutputError> {
    held.send(&due.event)?;
    if let Some(at) = due.frame_at {
        report.latency.saturating_record(nanos(at.elapsed()));
    }
    if matches!(due.event.action, crate::types::Action::Press(_)) {
        report.presses += 1;
    }
    Ok(())
}
