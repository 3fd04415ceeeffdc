//! Threads, clocks and wiring: plays a source through the engine into a device.
//!
//! ```text
//! source thread ─frames─▶ engine thread ─events─▶ output thread
//!                               └─views─▶ window or terminal
//! ```
//! Every event carries its due time, at which the output thread sends it (`schedule.rs`). All queues are bounded. The
//! engine takes every frame; a board's frame that finds the queue full is counted and reported as lost.
//!
//! Shut-down starts at the source: its thread ends, the engine releases all outputs, the output is flushed. A thread
//! that panics drops its ends of the queues, so the next one shuts down as if the source had ended. Whatever is still
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
mod view;
mod wake;

use std::io;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use hdrhistogram::Histogram;
use rtrb::{Producer, RingBuffer};

use crate::eit::ResponseTable;
use crate::engine::Engine;
use crate::output::{OutputDevice, OutputError};
use crate::profile::Profile;
use crate::source::{Source, SourceError};
use crate::touch::SensingBuilder;
use crate::types::{Control, Frame, Nanos, Part};
use emit::output_thread;
use feed::source_thread;
use latency::EngineTimes;
pub use latency::{LatencySummary, OutputStatistics, StageLatencies};
use steps::{EngineQueues, EngineThread};
use wake::ViewWaker;

use crate::platform::priority;
pub use crate::platform::priority::lower as lower_priority;
use crate::platform::timer::FineTimer;
pub use listen::{EngineStep, StepListener};
pub use record::{
    ExistingFile, RecordError, RecordReport, Recorder, check_recording, start_recording,
};
pub use touches::send_touches;
pub use view::{Signals, View};

/// Frames that may wait for the engine: a quarter of a second at 1000 frames/s.
const FRAME_QUEUE: usize = 256;
/// Events that may wait for the device.
const EVENT_QUEUE: usize = 1024;
/// Commands that may wait for the engine.
const COMMAND_QUEUE: usize = 16;
/// Longest sleep of the threads that a shut-down waits for, and so its longest delay.
const NAP: Duration = Duration::from_millis(20);
/// Longest wait for the threads when [`RunningGame`] is dropped without [`RunningGame::join`].
const LAST_WAIT: Duration = Duration::from_secs(2);

/// What the player can do during play.
#[derive(Clone, Debug)]
pub enum PlayCommand {
    /// Change to this profile.
    Profile(Arc<Profile>),
    /// Pause or continue.
    Pause,
    /// Take the reference again: the pad counts as untouched.
    Rezero,
    /// Locate touches with this response table of the pad as soon as nothing is pressed. For games that are not recorded: a
    /// recording contains its table from the start.
    Table(Arc<ResponseTable>),
    /// Locate touches with this pad as soon as nothing is pressed: the same drawing as before, as identified from its readings. Not
    /// for games that are recorded either.
    Pad(Box<SensingBuilder>),
}

/// Counts and times of a session that has ended.
#[derive(Debug)]
pub struct SessionSummary {
    /// Frames that the engine took.
    pub frames: u64,
    /// Frames a second, from the first to the last.
    pub frames_per_s: f64,
    /// Frames that were lost before they reached the engine.
    pub lost_frames: u64,
    /// Garbled frames and other input that the source skipped.
    pub skipped: u64,
    /// Frames that repeat the one before bit for bit.
    pub repeated: u64,
    /// Presses sent.
    pub presses: u64,
    /// Events sent.
    pub events: u64,
    /// Events sent more than 4 ms (a quarter of a game's frame) after they were due.
    pub late_events: u64,
    /// The longest time by which an event was sent after it was due.
    pub longest_delay: Duration,
    /// Latency of each stage.
    pub stages: StageLatencies,
    /// From a frame's arrival to its events, ns.
    pub frame_to_events_ns: Histogram<u64>,
    /// From a frame's arrival until the device has taken its events, ns.
    pub frame_to_device_ns: Histogram<u64>,
    /// The error that ended the source.
    pub source_error: Option<SourceError>,
    /// The error that ended the output.
    pub output_error: Option<OutputError>,
    /// The thread that panicked.
    pub panicked: Option<&'static str>,
}

/// A game being played.
pub struct RunningGame {
    stop: Arc<AtomicBool>,
    status: Arc<SourceStatus>,
    commands: Producer<PlayCommand>,
    views: triple_buffer::Output<View>,
    waker: Arc<ViewWaker>,
    threads: Option<Threads>,
}

struct Threads {
    source: JoinHandle<SourceReport>,
    engine: JoinHandle<EngineReport>,
    output: JoinHandle<OutputReport>,
}

/// A reading of the source and when it arrived.
struct Arrival {
    input: SourceInput,
    at: Instant,
}

enum SourceInput {
    Frame(Frame),
    Part(Part),
    Control(Control),
}

impl SourceInput {
    fn t_ns(&self) -> Nanos {
        match self {
            Self::Frame(frame) => frame.t_ns,
            Self::Part(part) => part.t_ns,
            Self::Control(control) => control.t_ns,
        }
    }
}

/// What the source reports to the engine besides its readings.
#[derive(Default)]
struct SourceStatus {
    /// Frames that were lost since the engine last looked.
    lost_frames: AtomicU64,
    /// The board is disconnected; the frames that are queued came before.
    is_disconnected: AtomicBool,
    /// Why the last input was skipped. The engine does not read it.
    skip_reason: Mutex<Option<String>>,
}

#[derive(Default)]
struct SourceReport {
    skipped: u64,
    repeated: u64,
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
    longest_delay: Duration,
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
            longest_delay: Duration::ZERO,
            device_ns: new_histogram(),
            frame_to_device_ns: new_histogram(),
            error: None,
        }
    }
}

/// Starts to play. `builder` makes another matrix when an electrode is lost.
///
/// # Errors
/// The system cannot start a thread.
pub fn start(
    engine: Engine,
    builder: SensingBuilder,
    source: Box<dyn Source>,
    device: Box<dyn OutputDevice>,
) -> io::Result<RunningGame> {
    start_with_listeners(engine, builder, source, device, Vec::new())
}

/// The same, with listeners to every step of the engine.
///
/// # Errors
/// As [`start`].
pub fn start_with_listeners(
    mut engine: Engine,
    builder: SensingBuilder,
    source: Box<dyn Source>,
    device: Box<dyn OutputDevice>,
    listeners: Vec<Box<dyn StepListener>>,
) -> io::Result<RunningGame> {
    let stop = Arc::new(AtomicBool::new(false));
    let status = Arc::new(SourceStatus::default());
    let waker = Arc::new(ViewWaker::default());
    let profile = Arc::clone(engine.profile());
    let blank = View::blank(profile, engine.image().clone());
    let (frames_in, frames) = RingBuffer::new(FRAME_QUEUE);
    let (events, events_out) = RingBuffer::new(EVENT_QUEUE);
    let (commands_in, commands) = RingBuffer::new(COMMAND_QUEUE);
    let (views, views_out) = triple_buffer::triple_buffer(&blank);
    let (emitted_in, emitted) = triple_buffer::triple_buffer(&OutputStatistics::default());
    let output = spawn("output", move || {
        priority::raise();
        let _fine_sleeps = FineTimer::request();
        output_thread(device, events_out, emitted_in)
    })?;
    let queues = EngineQueues {
        frames,
        commands,
        status: Arc::clone(&status),
        events,
        output: output.thread().clone(),
        emitted,
        views,
        waker: Arc::clone(&waker),
    };
    let pace = source.pace();
    let engine = spawn("engine", move || {
        priority::raise();
        EngineThread::new(engine, builder, pace, queues, blank, listeners).run()
    })?;
    let to_engine = engine.thread().clone();
    let stopping = Arc::clone(&stop);
    let of_source = Arc::clone(&status);
    let source = spawn("source", move || {
        priority::raise();
        source_thread(source, frames_in, &to_engine, &stopping, &of_source)
    })?;
    Ok(RunningGame {
        stop,
        status,
        commands: commands_in,
        views: views_out,
        waker,
        threads: Some(Threads {
            source,
            engine,
            output,
        }),
    })
}

fn spawn<T: Send + 'static>(
    name: &str,
    run: impl FnOnce() -> T + Send + 'static,
) -> io::Result<JoinHandle<T>> {
    Builder::new().name(name.to_owned()).spawn(run)
}

impl RunningGame {
    /// Whether all threads have ended.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        self.threads
            .as_ref()
            .is_none_or(|threads| threads.output.is_finished())
    }

    /// Stops the source; the other threads end after it.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(threads) = &self.threads {
            threads.source.thread().unpark();
        }
    }

    /// Sends a command; returns whether the queue had room for it.
    pub fn send_command(&mut self, command: PlayCommand) -> bool {
        let was_sent = self.commands.push(command).is_ok();
        if let Some(threads) = &self.threads {
            threads.engine.thread().unpark();
        }
        was_sent
    }

    /// Wakes this thread at every new view, so that it need not poll. `changes` is incremented before it is woken for a touch
    /// that comes or goes, an event, a pause or another profile. Only the first call has an effect.
    pub fn wake_on_view(&self, thread: std::thread::Thread, changes: Arc<AtomicU64>) {
        self.waker.set_listener(thread, changes);
    }

    /// Why the source skipped what the board sent last, if it did: another number of values than the pad's, say.
    #[must_use]
    pub fn skip_reason(&self) -> Option<String> {
        self.status.skip_reason.lock().ok()?.clone()
    }

    /// The newest view.
    pub fn view(&mut self) -> &View {
        self.views.read()
    }

    /// Stops the game and waits until all threads have ended, for a limited time: a display or a pipe that is not read may
    /// hold up the output. `None`: it still does; what is down must be released by others (kernel, watcher).
    #[must_use]
    pub fn end_within(mut self, limit: Duration) -> Option<SessionSummary> {
        self.stop();
        let start = now();
        while !self.is_finished() {
            if start.elapsed() >= limit {
                self.threads = None;
                return None;
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        Some(self.join())
    }

    /// Waits until all threads have ended.
    #[must_use]
    pub fn join(mut self) -> SessionSummary {
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
        let emitted = OutputStatistics {
            device: LatencySummary::from_times(&output.device_ns),
            frame_to_device: LatencySummary::from_times(&output.frame_to_device_ns),
            ..OutputStatistics::default()
        };
        SessionSummary {
            frames: engine.frames,
            frames_per_s: engine.frames_per_s,
            lost_frames: engine.lost_frames,
            skipped: source.skipped,
            repeated: source.repeated,
            presses: output.presses,
            events: output.events,
            late_events: output.late,
            longest_delay: output.longest_delay,
            stages: engine.times.stages(&emitted),
            frame_to_events_ns: engine.times.frame_to_events_ns,
            frame_to_device_ns: output.frame_to_device_ns,
            source_error: source.error,
            output_error: output.error,
            panicked,
        }
    }
}

/// If the thread that shows the game panics, this releases the keys before the program ends.
impl Drop for RunningGame {
    fn drop(&mut self) {
        self.stop();
        let start = now();
        while !self.is_finished() && start.elapsed() < LAST_WAIT {
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

/// A histogram of times up to an hour, ns, with two significant digits: small, so that percentiles are fast.
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
