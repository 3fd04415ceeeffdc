//! Sessions to record: through the runtime with every kind of input, or straight into a file.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread;
use std::time::Duration;

use anyhow::{Context, Result, ensure};
use gelpad::cache;
use gelpad::eit::Press;
use gelpad::engine::{Engine, Input};
use gelpad::output::Trace;
use gelpad::pad::{DEFAULT_PAD, Pad, Pair, shipped_pad};
use gelpad::profile::{Profile, shipped_profile};
use gelpad::runtime::{self, EngineStep, ExistingFile, PlayCommand, StepListener};
use gelpad::source::{Noise, SimulatedPad, Source, SourceError, SourcePace, SourceReading};
use gelpad::tape::{EngineConfig, SessionWriter};
use gelpad::touch::SensingBuilder;
use gelpad::types::{Frame, Method, Nanos};

const FRAME_NS: Nanos = 10_000_000;
/// Where super-mario's regions `jump` and `left` lie, mm.
const JUMP: [f64; 2] = [80.0, 50.0];
const LEFT: [f64; 2] = [13.0, 57.0];
/// The electrode that comes loose, and the frame in which it does.
const LOOSE: usize = 5;
const LOOSE_FROM: u64 = 500;
const FRAMES: u64 = 900;
/// The engine stops at this frame until the source is `STALL_FRAMES` ahead: more than its queue holds.
const STALL_AT: u64 = 250;
const STALL_FRAMES: u64 = 320;

pub fn pad() -> Pad {
    let shipped = shipped_pad(DEFAULT_PAD).expect("shipped");
    Pad::from_toml(shipped.name, shipped.toml).expect("sound")
}

pub fn profile(name: &str) -> Arc<Profile> {
    let shipped = shipped_profile(name).expect("shipped");
    Arc::new(Profile::from_toml(name, shipped.toml).expect("sound"))
}

pub fn builder() -> &'static SensingBuilder {
    static BUILDER: OnceLock<SensingBuilder> = OnceLock::new();
    BUILDER.get_or_init(|| {
        cache::sensing_builder(&pad(), Method::default(), |_, _| ()).expect("solvable")
    })
}

pub fn config() -> EngineConfig {
    let sensing = Arc::new(builder().build_initial().expect("a matrix"));
    EngineConfig {
        table: sensing
            .locator_model
            .as_ref()
            .map(|l| Arc::clone(l.table())),
        pad: pad(),
        pad_toml: shipped_pad(DEFAULT_PAD).expect("shipped").toml.to_owned(),
        profile: profile("super-mario"),
        correction: None,
        sensing,
    }
}

/// Voltages of the pad at rest, with one finger and with two.
pub fn states() -> &'static [Vec<f64>; 3] {
    static STATES: OnceLock<[Vec<f64>; 3]> = OnceLock::new();
    STATES.get_or_init(|| {
        let pad = SimulatedPad::new(&pad()).expect("solvable");
        let finger = |centre_mm| Press {
            centre_mm,
            radius_mm: 7.0,
            rise: 1.2,
        };
        let (jump, left) = (finger(JUMP), finger(LEFT));
        [vec![], vec![jump], vec![jump, left]].map(|fingers| pad.volts(&fingers).expect("solvable"))
    })
}

/// The frames of a session: rest, then presses, some with a second finger.
pub struct Frames {
    noise: Noise,
    next: u64,
}

impl Frames {
    pub fn new(seed: u64) -> Self {
        Self {
            noise: Noise::new(60.0, seed),
            next: 0,
        }
    }
}

impl Iterator for Frames {
    type Item = Frame;

    fn next(&mut self) -> Option<Frame> {
        let t_ns = self.next * FRAME_NS;
        let state = match self.next {
            ..60 => 0,
            next => match (next / 20 % 4, next / 200 % 2) {
                (0 | 2, _) => 0,
                (_, 0) => 1,
                _ => 2,
            },
        };
        self.next += 1;
        Some(Frame {
            t_ns,
            volts: self.noise.read(&states()[state]),
        })
    }
}

/// A board that sends frames at a fixed rate, and loses an electrode.
struct Board {
    frames: Frames,
    uses_loose: Vec<bool>,
    sent: Arc<AtomicU64>,
}

impl Source for Board {
    fn pace(&self) -> SourcePace {
        SourcePace::ByDevice
    }

    fn read(&mut self) -> Result<SourceReading, SourceError> {
        let sent = self.sent.load(Ordering::SeqCst);
        if sent == FRAMES {
            return Ok(SourceReading::End);
        }
        thread::sleep(Duration::from_millis(2));
        let mut frame = self.frames.next().expect("endless");
        if sent >= LOOSE_FROM {
            for (channel, volt) in frame.volts.iter_mut().enumerate() {
                if self.uses_loose[channel] {
                    let wild = (sent * 7919 + channel as u64 * 104_729) % 1000;
                    *volt *= wild as f32 / 500.0;
                }
            }
        }
        self.sent.store(sent + 1, Ordering::SeqCst);
        Ok(SourceReading::Frame(frame))
    }
}

/// Stops the engine once, until the source is far ahead.
struct Stall {
    frames: u64,
    sent: Arc<AtomicU64>,
}

impl StepListener for Stall {
    fn on_step(&mut self, step: &EngineStep<'_>) {
        if !matches!(step.input, Input::Frame(_)) {
            return;
        }
        self.frames += 1;
        if self.frames == STALL_AT {
            let until = self.sent.load(Ordering::SeqCst) + STALL_FRAMES;
            while self.sent.load(Ordering::SeqCst) < until.min(FRAMES) {
                thread::sleep(Duration::from_millis(1));
            }
        }
    }
}

/// Records a session through the runtime: a stall, a lost electrode, another profile, a rezero and a pause.
pub fn eventful(path: &Path) -> Result<()> {
    let config = config();
    let (recording, recorder) =
        runtime::start_recording(path, &config.to_setup(), ExistingFile::Replace)?;
    let sent = Arc::new(AtomicU64::new(0));
    let loose = |pair: &Pair| pair.0 == LOOSE || pair.1 == LOOSE;
    let channels = config.pad.protocol.channels.iter();
    let uses_loose = channels
        .map(|channel| loose(&channel.drive) || loose(&channel.measure))
        .collect();
    let board = Board {
        frames: Frames::new(1),
        uses_loose,
        sent: Arc::clone(&sent),
    };
    let stall = Stall {
        frames: 0,
        sent: Arc::clone(&sent),
    };
    let device = Box::new(Trace::new(std::io::sink()));
    let listeners: Vec<Box<dyn StepListener>> = vec![recording, Box::new(stall)];
    let mut running = runtime::start_with_listeners(
        config.engine(),
        builder().clone(),
        Box::new(board),
        device,
        listeners,
    )?;
    let mut wishes = [
        (150, PlayCommand::Profile(profile("super-mario-classified"))),
        (180, PlayCommand::Rezero),
        (220, PlayCommand::Pause),
        (230, PlayCommand::Pause),
    ]
    .into_iter()
    .peekable();
    while !running.is_finished() {
        let frames = running.view().frames;
        while let Some((_, wish)) = wishes.next_if(|(from, _)| *from <= frames) {
            ensure!(running.send_command(wish), "no room for a wish");
        }
        thread::sleep(Duration::from_millis(2));
    }
    let summary = running.join();
    let report = recorder.join();
    ensure!(
        report.error.is_none() && report.omitted_steps == 0,
        "{report:?}"
    );
    ensure!(
        report.frames == summary.frames && summary.lost_frames > 0,
        "{report:?} of {summary:?}"
    );
    Ok(())
}

/// Records `frames` frames straight into a file; packed, or as a killed session leaves it.
pub fn straight(path: &Path, frames: usize, packed: bool) -> Result<()> {
    let config = config();
    let setup = config.to_setup();
    let file = BufWriter::new(File::create(path).context("a file")?);
    let mut writer = if packed {
        SessionWriter::packed(file, &setup)?
    } else {
        SessionWriter::live(file, &setup)?
    };
    let mut engine = config.engine();
    let mut last_ns = 0;
    for frame in Frames::new(3).take(frames) {
        last_ns = frame.t_ns;
        step(&mut engine, &Input::Frame(frame), &mut writer)?;
        if let Some(deviations) = engine.wanted() {
            let sensing = Arc::new(builder().build(deviations)?);
            step(&mut engine, &Input::Matrix(sensing), &mut writer)?;
        }
    }
    step(&mut engine, &Input::End { t_ns: last_ns }, &mut writer)?;
    if packed {
        writer.finish()?;
    } else {
        writer.flush()?;
        // As after a kill: nothing more is written.
        std::mem::forget(writer);
    }
    Ok(())
}

pub fn step(
    engine: &mut Engine,
    input: &Input,
    writer: &mut SessionWriter<BufWriter<File>>,
) -> Result<()> {
    let mut events = Vec::new();
    engine.input(input, &mut events);
    writer.write_step(input, engine.touches_down(), &events)?;
    Ok(())
}
