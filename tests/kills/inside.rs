//! Threads that panic or hang, in a gelpad that is built from its parts here.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context as _, Result, ensure};
use gelpad::engine::Engine;
use gelpad::output::{OutputDevice, OutputError};
use gelpad::pad::{DEFAULT_PAD, Pad, shipped_pad};
use gelpad::platform::linux::x11::X11;
use gelpad::platform::watch::WatchedDevice;
use gelpad::profile::{DEFAULT_PROFILE, Profile, shipped_profile};
use gelpad::runtime::{self, RunningGame};
use gelpad::source::{
    Noise, Script, SimulatedSource, Source, SourceError, SourcePace, SourceReading,
};
use gelpad::touch::SensingBuilder;
use gelpad::types::{Event, Method, Output};

use crate::gelpad::one_hold;
use crate::{PATIENCE, RELEASED, STOPPED, Stage};

/// Number of frames until the fault: the key is down by then.
const FRAMES: usize = 60;

/// A source that panics in the middle of a press.
struct Panicking {
    source: SimulatedSource,
    left: usize,
}

impl Source for Panicking {
    fn read(&mut self) -> Result<SourceReading, SourceError> {
        assert!(self.left > 0, "a bug in the source");
        self.left -= 1;
        self.source.read()
    }

    fn pace(&self) -> SourcePace {
        self.source.pace()
    }
}

/// A fault of a device in its idle call.
enum Fault {
    Panics,
    Hangs(Duration),
}

/// A display with a fault once a key is down.
struct FaultyDisplay {
    device: WatchedDevice<X11>,
    fault: Option<Fault>,
    idle_since_press: Option<usize>,
}

impl OutputDevice for FaultyDisplay {
    fn name(&self) -> &str {
        self.device.name()
    }

    fn supports(&self, output: Output) -> bool {
        self.device.supports(output)
    }

    fn send(&mut self, event: &Event) -> Result<(), OutputError> {
        self.idle_since_press = Some(0);
        self.device.send(event)
    }

    fn flush(&mut self) -> Result<(), OutputError> {
        self.device.flush()
    }

    fn idle(&mut self) -> Result<(), OutputError> {
        if let Some(idle) = &mut self.idle_since_press {
            *idle += 1;
            if *idle == FRAMES / 4 {
                match self.fault.take() {
                    Some(Fault::Panics) => panic!("a bug in the output"),
                    Some(Fault::Hangs(span)) => std::thread::sleep(span),
                    None => {}
                }
            }
        }
        self.device.idle()
    }
}

fn display(stage: &Stage) -> Result<WatchedDevice<X11>> {
    let x11 = X11::connect_to(&stage.display.name)?;
    Ok(WatchedDevice::new(
        x11,
        PathBuf::from(env!("CARGO_BIN_EXE_gelpad")),
    ))
}

fn source() -> Result<(Pad, SimulatedSource)> {
    let shipped = shipped_pad(DEFAULT_PAD).context("the pad")?;
    let pad = Pad::from_toml(DEFAULT_PAD, shipped.toml)?;
    let script = Script::parse("hold", &one_hold())?;
    let source = SimulatedSource::new(&pad, &script, Noise::new(60.0, 1))?;
    Ok((pad, source))
}

fn start(pad: &Pad, source: Box<dyn Source>, device: Box<dyn OutputDevice>) -> Result<RunningGame> {
    let shipped = shipped_profile(DEFAULT_PROFILE).context("the profile")?;
    let profile = Profile::from_toml(DEFAULT_PROFILE, shipped.toml)?;
    let builder = SensingBuilder::new(pad, Method::default())?;
    let engine = Engine::new(pad, Arc::new(builder.build_initial()?), Arc::new(profile));
    Ok(runtime::start(engine, builder, source, device)?)
}

pub fn panic_of_the_source(stage: &Stage) -> Result<()> {
    let (pad, source) = source()?;
    let source = Panicking {
        source,
        left: FRAMES,
    };
    let running = start(&pad, Box::new(source), Box::new(display(stage)?))?;
    stage.display.wait(true, PATIENCE)?;
    stage.display.wait(false, RELEASED)?;
    let panicked = running.join().panicked;
    ensure!(panicked == Some("source"), "panicked: {panicked:?}");
    Ok(())
}

pub fn panic_of_the_output(stage: &Stage) -> Result<()> {
    let (pad, source) = source()?;
    let device = FaultyDisplay {
        device: display(stage)?,
        fault: Some(Fault::Panics),
        idle_since_press: None,
    };
    let running = start(&pad, Box::new(source), Box::new(device))?;
    stage.display.wait(true, PATIENCE)?;
    stage.display.wait(false, RELEASED)?;
    let panicked = running.join().panicked;
    ensure!(panicked == Some("output"), "panicked: {panicked:?}");
    Ok(())
}

/// The beats come from the output's thread: if it hangs, the watcher releases the keys.
pub fn an_output_that_hangs(stage: &Stage) -> Result<()> {
    let (pad, source) = source()?;
    let device = FaultyDisplay {
        device: display(stage)?,
        fault: Some(Fault::Hangs(STOPPED + STOPPED)),
        idle_since_press: None,
    };
    let running = start(&pad, Box::new(source), Box::new(device))?;
    stage.display.wait(true, PATIENCE)?;
    let took = stage.display.wait(false, STOPPED + RELEASED)?;
    let back = stage.display.wait(true, STOPPED + RELEASED)?;
    eprintln!("\nhanging: up after {took:.1?}, down again {back:.1?} later");
    running.stop();
    stage.display.wait(false, RELEASED)?;
    let summary = running.join();
    ensure!(summary.panicked.is_none() && summary.output_error.is_none());
    Ok(())
}
