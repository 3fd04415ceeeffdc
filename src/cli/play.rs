//! `gelpad play`, and the level that plays without arguments.

use std::io::IsTerminal as _;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::Context as _;
use hdrhistogram::Histogram;
use signal_hook::consts::{SIGINT, SIGTERM};

use super::args::{OutputArg, PlayArgs, SourceArg};
use super::exit::Ending;
use super::live::{LiveView, Title};
use super::resolve;
use crate::engine::Engine;
use crate::output::{Device, Keyboard, OutputError, Trace};
use crate::pad::{DEFAULT_PAD, Pad};
use crate::profile::{DEFAULT_PROFILE, Profile};
use crate::runtime::{self, Running, Summary};
use crate::source::serial::SerialSource;
use crate::source::{FramesCsv, LEVEL_SCRIPT, Noise, Script, SimulatedSource, Source};
use crate::types::Method;

/// How often signals are looked at, and the live view drawn.
const LOOK: Duration = Duration::from_millis(33);
/// Noise of the level, dB, and its seed.
const LEVEL_NOISE: (f64, u64) = (60.0, 1);

/// The main job without arguments: the level on the simulated pad; nothing reaches the desktop.
pub(super) fn level() -> anyhow::Result<Ending> {
    let pad = resolve::pad(DEFAULT_PAD)?;
    let profile = resolve::profile(DEFAULT_PROFILE)?;
    let script = Script::parse("level", LEVEL_SCRIPT)?;
    let noise = Noise::new(LEVEL_NOISE.0, LEVEL_NOISE.1);
    let source = SimulatedSource::new(&pad, &script, noise)?;
    let live = std::io::stdout().is_terminal();
    let device: Box<dyn Device> = if live {
        Box::new(Trace::new(std::io::sink()))
    } else {
        Box::new(Trace::new(std::io::stdout()))
    };
    let title = Title {
        source: "simulated pad, the level".to_owned(),
        output: "nothing leaves this terminal".to_owned(),
    };
    run(
        &pad,
        profile,
        Method::default(),
        Box::new(source),
        device,
        live.then_some(title),
    )
}

/// `gelpad play`.
pub(super) fn play(args: &PlayArgs) -> anyhow::Result<Ending> {
    let pad = resolve::pad(&args.pad)?;
    let profile = resolve::profile(&args.profile)?;
    let live = !args.headless && std::io::stdout().is_terminal();
    let source = source(args, &pad)?;
    let device = device(args.output, live)?;
    let title = Title {
        source: match &args.source {
            SourceArg::Simulated(None) => "simulated pad, the level".to_owned(),
            SourceArg::Simulated(Some(script)) => format!("simulated pad, {}", script.display()),
            SourceArg::Serial(port) => port.clone(),
            SourceArg::Replay(file) => file.display().to_string(),
        },
        output: device.name().to_owned(),
    };
    let method = resolve::method(args.method, &profile, &pad);
    run(&pad, profile, method, source, device, live.then_some(title))
}

fn source(args: &PlayArgs, pad: &Pad) -> anyhow::Result<Box<dyn Source>> {
    Ok(match &args.source {
        SourceArg::Simulated(script) => {
            let script = match script {
                Some(path) => Script::parse(&path.display().to_string(), &resolve::read(path)?)?,
                None => Script::parse("level", LEVEL_SCRIPT)?,
            };
            let noise = Noise::new(args.snr, args.seed);
            Box::new(SimulatedSource::new(pad, &script, noise)?)
        }
        SourceArg::Serial(port) => Box::new(SerialSource::open(port, pad.channels())?),
        SourceArg::Replay(file) => Box::new(FramesCsv::open(Path::new(file), pad.channels())?),
    })
}

fn device(output: OutputArg, live: bool) -> anyhow::Result<Box<dyn Device>> {
    let trace = || -> Box<dyn Device> {
        if live {
            Box::new(Trace::new(std::io::sink()))
        } else {
            Box::new(Trace::new(std::io::stdout()))
        }
    };
    Ok(match output {
        OutputArg::Trace => trace(),
        OutputArg::Keyboard => Box::new(Keyboard::connect()?),
        OutputArg::Auto => match Keyboard::connect() {
            Ok(keyboard) => Box::new(keyboard),
            Err(error) => {
                eprintln!("output: trace ({error})");
                trace()
            }
        },
    })
}

/// Plays until the source ends or a signal comes; shows it if a title is given.
fn run(
    pad: &Pad,
    profile: Arc<Profile>,
    method: Method,
    source: Box<dyn Source>,
    device: Box<dyn Device>,
    title: Option<Title>,
) -> anyhow::Result<Ending> {
    let signals = Signals::listen()?;
    let matrix = resolve::reconstruction(pad, method)?;
    let engine = Engine::new(pad, matrix, Arc::clone(&profile));
    let mut view = match title {
        Some(title) => Some(LiveView::open(title, pad, profile)?),
        None => None,
    };
    let mut running = runtime::start(engine, source, device).context("no thread to play on")?;
    let signal = watch(&mut running, &signals, view.as_mut());
    running.stop();
    let summary = running.join();
    drop(view);
    conclude(summary, signal)
}

/// Draws and waits; returns the signal that ended it, if one did.
fn watch(running: &mut Running, signals: &Signals, mut view: Option<&mut LiveView>) -> Option<i32> {
    while !running.is_finished() {
        if let Some(signal) = signals.received() {
            return Some(signal);
        }
        match view.as_deref_mut() {
            // Keys of a raw terminal: Ctrl-C arrives as a key there, and q and Esc end it too.
            Some(view) => {
                if view.draw_and_wait(running.view(), LOOK) {
                    return Some(SIGINT);
                }
            }
            None => std::thread::sleep(LOOK),
        }
    }
    signals.received()
}

/// Says how it went, and how it ended.
fn conclude(summary: Summary, signal: Option<i32>) -> anyhow::Result<Ending> {
    eprintln!("{}", told(&summary));
    if let Some(thread) = summary.panicked {
        anyhow::bail!("a bug in gelpad ended its {thread} thread; all keys are up");
    }
    match summary.output_error {
        Some(OutputError::Closed) => return Ok(Ending::Done),
        Some(error) => return Err(error.into()),
        None => {}
    }
    if let Some(error) = summary.source_error {
        return Err(error.into());
    }
    Ok(match signal {
        Some(signal) => Ending::Signal(signal),
        None if summary.lost_frames > 0 => Ending::LostData,
        None => Ending::Done,
    })
}

fn told(summary: &Summary) -> String {
    let mut text = format!("{} frames, {} presses", summary.frames, summary.presses);
    if summary.lost_frames > 0 {
        text.push_str(&format!(
            ", {} frames lost ({} of them garbled)",
            summary.lost_frames, summary.skipped
        ));
    }
    let times = |histogram: &Histogram<u64>| {
        let us = |quantile| histogram.value_at_quantile(quantile) as f64 / 1000.0;
        format!("median {:.0} us, p99 {:.0} us", us(0.5), us(0.99))
    };
    if summary.frames > 0 {
        text.push_str(&format!(
            "\nframe to events: {}",
            times(&summary.frame_to_events_ns)
        ));
    }
    if summary.presses > 0 {
        text.push_str(&format!(
            "\nframe to device: {}",
            times(&summary.frame_to_device_ns)
        ));
    }
    text
}

/// Ctrl-C and SIGTERM as flags.
struct Signals {
    interrupt: Arc<AtomicBool>,
    terminate: Arc<AtomicBool>,
}

impl Signals {
    fn listen() -> anyhow::Result<Self> {
        let flag = |signal| -> std::io::Result<Arc<AtomicBool>> {
            let flag = Arc::new(AtomicBool::new(false));
            signal_hook::flag::register(signal, Arc::clone(&flag))?;
            Ok(flag)
        };
        Ok(Self {
            interrupt: flag(SIGINT).context("Ctrl-C cannot be caught")?,
            terminate: flag(SIGTERM).context("SIGTERM cannot be caught")?,
        })
    }

    fn received(&self) -> Option<i32> {
        if self.interrupt.load(Ordering::Relaxed) {
            Some(SIGINT)
        } else if self.terminate.load(Ordering::Relaxed) {
            Some(SIGTERM)
        } else {
            None
        }
    }
}
