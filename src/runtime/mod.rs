//! Threads, clocks, wiring: plays a source through the engine into a device.
//!
//! ```text
//! source thread ─frames─▶ engine thread ─events─▶ output thread
//!                               └─views─▶ whoever shows them
//! ```
//! Events carry the time at which they are due; the output's thread sends them then (`schedule.rs`).
//! Queues are bounded. The engine takes every frame; one that finds the queue full is counted and told as lost.
//! Shut-down runs from the source on: its thread ends, the engine releases all, the output is flushed. A thread that
//! panics drops its ends of the queues, and the next in line shuts down as if the source had ended; whatever is still
//! down is released when the device is dropped.

mod emit;
mod feed;
mod latency;
mod listen;
mod rebuild;
mod record;
mod schedule;
mod steps;
mod touches;
mod wake;

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use hdrhistogram::Histogram;
use rtrb::{Producer, RingBuffer};

use crate::engine::Engine;
use crate::output::{Device, OutputError};
use crate::profile::Profile;
use crate::source::{Source, SourceError};
use crate::touch::SensingBuilder;
use crate::types::{Control, Event, Frame, Image, Nanos, Output, Touch};
use emit::output_thread;
use feed::source_thread;
use latency::EngineTimes;
pub use latency::{Emitted, Spread, Stages};
use rebuild::Rebuilder;
use steps::EngineThread;
use wake::Wake;

pub use listen::{Listener, Step};
pub use record::{RecordError, RecordReport, Recorder, record};
pub use touches::send_touches;

/// Frames that may wait for the engine: a quarter of a second at 1000 frames/s.
const FRAME_QUEUE: usize = 256;
/// Events that may wait for the device.
const EVENT_QUEUE: usize = 1024;
/// Wishes of the player that may wait for the engine.
const COMMAND_QUEUE: usize = 16;
/// Longest sleep of any thread: what a shut-down waits for at most.
const NAP: Duration = Duration::from_millis(20);
/// Longest wait for the threads to end when nobody asks how it went.
const LAST_WAIT: Duration = Duration::from_secs(2);

/// What a player may ask for meanwhile.
#[derive(Clone, Debug)]
pub enum Command {
    /// Another profile.
    Profile(Arc<Profile>),
    /// Pause, or go on.
    Pause,
    /// The pad counts as untouched as it is.
    Rezero,
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
    /// Events so far: tells which of the last ones are new.
    pub events_so_far: u64,
    /// What the newest frame measured, for those who build pads.
    pub signals: Signals,
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
    /// How long each stage takes, so far.
    pub stages: Stages,
    /// Events that went out late, so far.
    pub late_events: u64,
    /// How hard a game shakes the pad: the strong motor and the weak one, 0..1.
    pub rumble: [f32; 2],
}

/// What a frame measured, channel by channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Signals {
    /// The voltages as they came.
    pub volts: Vec<f32>,
    /// Their relative change against the untouched pad; empty before there is one.
    pub changes: Vec<f32>,
    /// How much of that the touches explain; the rest is the fit's residual.
    pub explained: Vec<f32>,
    /// The untouched pad's voltages, as of the last half second.
    pub reference: Vec<f32>,
    /// Deviation of each reading from frame to frame, relative; infinite for a channel that is left out.
    pub noise: Vec<f32>,
}

/// What was played, when it is over.
#[derive(Debug)]
pub struct Summary {
    /// Frames that the engine took.
    pub frames: u64,
    /// Frames a second, from the first to the last.
    pub frames_per_s: f64,
    /// Frames that were lost before it.
    pub lost_frames: u64,
    /// Things that came from the source and were no frames.
    pub skipped: u64,
    /// Presses sent.
    pub presses: u64,
    /// Events sent.
    pub events: u64,
    /// Those of them that went out late: more than a quarter of a game's frame after they were due.
    pub late_events: u64,
    /// The latest of them, after it was due.
    pub latest: Duration,
    /// How long each stage took.
    pub stages: Stages,
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
    commands: Producer<Command>,
    views: triple_buffer::Output<View>,
    wake: Arc<Wake>,
    threads: Option<Threads>,
}

struct Threads {
    source: JoinHandle<SourceReport>,
    engine: JoinHandle<EngineReport>,
    output: JoinHandle<OutputReport>,
}

struct Arrived {
    what: Arrival,
    at: Instant,
}

/// What a source gives.
enum Arrival {
    Frame(Frame),
    Control(Control),
}

impl Arrival {
    fn t_ns(&self) -> Nanos {
        match self {
            Self::Frame(frame) => frame.t_ns,
            Self::Control(control) => control.t_ns,
        }
    }
}

/// What the source tells the engine beside frames.
#[derive(Default)]
struct Losses {
    /// Frames that were lost since the engine last looked.
    frames: AtomicU64,
    /// The board went away behind the frames that are queued.
    gone: AtomicBool,
}

#[derive(Default)]
struct SourceReport {
    skipped: u64,
    error: Option<SourceError>,
}

struct EngineReport {
    frames: u64,
    frames_per_s: f64,
    lost_frames: u64,
    times: EngineTimes,
}

struct OutputReport {
    presses: u64,
    events: u64,
    late: u64,
    latest: Duration,
    device_ns: Histogram<u64>,
    frame_to_device_ns: Histogram<u64>,
    error: Option<OutputError>,
}

impl Default for OutputReport {
    fn default() -> Self {
        Self {
            presses: 0,
            events: 0,
            late: 0,
            latest: Duration::ZERO,
            device_ns: new_histogram(),
            frame_to_device_ns: new_histogram(),
            error: None,
        }
    }
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
    start_with(engine, builder, source, device, Vec::new())
}

/// The same, and listeners are told of every step of the engine.
///
/// # Errors
/// As [`start`].
pub fn start_with(
    engine: Engine,
    builder: SensingBuilder,
    source: Box<dyn Source>,
    device: Box<dyn Device>,
    listeners: Vec<Box<dyn Listener>>,
) -> std::io::Result<Running> {
    let stop = Arc::new(AtomicBool::new(false));
    let losses = Arc::new(Losses::default());
    let (frames_in, frames_out) = RingBuffer::new(FRAME_QUEUE);
    let (events_in, events_out) = RingBuffer::new(EVENT_QUEUE);
    let (commands_in, commands_out) = RingBuffer::new(COMMAND_QUEUE);
    let blank = View::blank(Arc::clone(engine.profile()), engine.touches().image.clone());
    let pace = source.pace();
    let wake = Arc::new(Wake::default());
    let waking = Arc::clone(&wake);
    let (views_in, views) = triple_buffer::triple_buffer(&blank);
    let (told, emitted) = triple_buffer::triple_buffer(&Emitted::default());
    let output = Builder::new()
        .name("output".to_owned())
        .spawn(move || output_thread(device, events_out, told))?;
    let to_output = output.thread().clone();
    let engine_losses = Arc::clone(&losses);
    let engine = Builder::new().name("engine".to_owned()).spawn(move || {
        // Without a thread to build on, play goes on as it is.
        let rebuilder = Rebuilder::start(builder, std::thread::current());
        EngineThread {
            engine,
            rebuilder: rebuilder.ok(),
            frames: frames_out,
            commands: commands_out,
            losses: engine_losses,
            events: events_in,
            output: to_output,
            views: views_in,
            wake: waking,
            view: blank,
            listeners,
            fresh: Vec::new(),
            times: EngineTimes::new(),
            emitted,
            pace,
            longest_silence: steps::SILENCE,
            silent: false,
            retaken_told: 0,
            first_ns: None,
            last_frame: None,
            second: None,
        }
        .run()
    })?;
    let to_engine = engine.thread().clone();
    let stopping = Arc::clone(&stop);
    let source = Builder::new()
        .name("source".to_owned())
        .spawn(move || source_thread(source, frames_in, &to_engine, &stopping, &losses))?;
    Ok(Running {
        stop,
        commands: commands_in,
        views,
        wake,
        threads: Some(Threads {
            source,
            engine,
            output,
        }),
    })
}

impl View {
    /// Before the first frame.
    #[must_use]
    pub fn blank(profile: Arc<Profile>, image: Image) -> Self {
        Self {
            t_ns: 0,
            profile,
            paused: false,
            image,
            touches: Vec::new(),
            held: Vec::new(),
            events: VecDeque::new(),
            events_so_far: 0,
            signals: Signals::default(),
            frames: 0,
            lost_frames: 0,
            lost_electrodes: Vec::new(),
            frames_per_s: 0.0,
            latency_us: 0,
            stages: Stages::default(),
            late_events: 0,
            rumble: [0.0; 2],
        }
    }
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
    pub fn ask(&mut self, command: Command) -> bool {
        let taken = self.commands.push(command).is_ok();
        if let Some(threads) = &self.threads {
            threads.engine.thread().unpark();
        }
        taken
    }

    /// Wakes a thread whenever there is a newer view: it need not ask again and again. The first thread stays the one.
    pub fn wake(&self, thread: std::thread::Thread) {
        self.wake.who(thread);
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
                frames_per_s: 0.0,
                lost_frames: 0,
                times: EngineTimes::new(),
            }
        });
        let output = threads.output.join().unwrap_or_else(|_| {
            panicked = Some("output");
            OutputReport::default()
        });
        let emitted = Emitted {
            device: Spread::of(&output.device_ns),
            frame_to_device: Spread::of(&output.frame_to_device_ns),
            ..Emitted::default()
        };
        Summary {
            frames: engine.frames,
            frames_per_s: engine.frames_per_s,
            lost_frames: engine.lost_frames,
            skipped: source.skipped,
            presses: output.presses,
            events: output.events,
            late_events: output.late,
            latest: output.latest,
            stages: engine.times.stages(&emitted),
            frame_to_events_ns: engine.times.frame_to_events_ns,
            frame_to_device_ns: output.frame_to_device_ns,
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

/// Nanoseconds up to an hour, two digits: small enough to be looked through while events wait.
fn new_histogram() -> Histogram<u64> {
    Histogram::new_with_bounds(1, 3_600_000_000_000, 2).expect("constant bounds")
}

#[allow(clippy::disallowed_methods, reason = "the one clock of play")]
fn now() -> Instant {
    Instant::now()
}

fn nanos(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}
