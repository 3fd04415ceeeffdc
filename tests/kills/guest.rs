//! Endings on a real kernel, which releases the devices of a process that is gone: in a virtual machine
//! (`scripts/run-in-guest.sh`). gelpad has no watchers there, since nothing outlives it.
//!
//! `GELPAD_GUEST_ENDINGS` sets how many are drawn.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use rustix::process::Signal;

use crate::adversary::Random;
use crate::endings::storm_profile;
use crate::gelpad::{Gelpad, presses};
use crate::signals::{FATAL, HANDLED};
use crate::{PATIENCE, RELEASED, STOPPED, summary};

const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scripts/run-in-guest.sh");
/// Number of endings without `GELPAD_GUEST_ENDINGS`: each kind once; the guest is slow.
const SAMPLE: usize = KINDS.len();
/// Time limit per ending in the guest, s: a start takes it some seconds.
const LIMIT_S: usize = 60;

/// A kind of ending.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// A signal that gelpad can react to.
    Signal,
    /// A signal that ends the process.
    Crash,
    /// Stopped, and killed some time later.
    Stopped,
    /// Ends while its profile is saved over and over.
    InAStormOfReloads,
}

const KINDS: [Kind; 4] = [
    Kind::Signal,
    Kind::Crash,
    Kind::Stopped,
    Kind::InAStormOfReloads,
];

/// Why no guest can run here, if so.
pub fn missing() -> Option<String> {
    let output = Command::new(SCRIPT).arg("--prepare").output();
    match output {
        Ok(output) if output.status.success() => None,
        Ok(output) => {
            let said = String::from_utf8_lossy(&output.stderr);
            Some(said.lines().last().unwrap_or("no guest").to_owned())
        }
        Err(error) => Some(format!("{SCRIPT}: {error}")),
    }
}

/// Runs [`inside`] there.
pub fn killed() -> Result<()> {
    let limit = ((count() + 3) * LIMIT_S).to_string();
    let output = Command::new(SCRIPT)
        .args(["--timeout", &limit])
        .arg(std::env::current_exe()?)
        .arg("--inside-the-guest")
        // What it says is seen while it runs.
        .stdout(std::io::stderr())
        .stderr(Stdio::piped())
        .spawn()
        .and_then(Child::wait_with_output)
        .context(SCRIPT)?;
    let said = String::from_utf8_lossy(&output.stderr);
    ensure!(
        output.status.success(),
        "{}: {}",
        output.status,
        said.trim_end()
    );
    Ok(())
}

fn count() -> usize {
    let endings = std::env::var("GELPAD_GUEST_ENDINGS").ok();
    let endings = endings.and_then(|text| text.parse().ok());
    endings.unwrap_or(SAMPLE)
}

/// Ends gelpad while keys are held on the kernel's keyboard; measures how long until they are up.
pub fn inside() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let mut times = Vec::new();
    for round in 0..count() {
        let kind = KINDS[round % KINDS.len()];
        let took = end_once(folder.path(), kind, round as u64);
        times.push(took.with_context(|| {
            let said = std::fs::read_to_string(folder.path().join("gelpad.said"));
            format!("ending {round}, {kind:?}: {}", said.unwrap_or_default())
        })?);
        if times.len().is_multiple_of(100) {
            println!("in the guest: {} endings", times.len());
        }
    }
    println!("in the guest: {}", summary(&mut times));
    Ok(())
}

fn end_once(folder: &Path, kind: Kind, seed: u64) -> Result<Duration> {
    let mut random = Random(seed);
    let storm = folder.join("storm.toml");
    std::fs::write(&storm, storm_profile(0))?;
    let profile = match kind {
        Kind::InAStormOfReloads => storm.display().to_string(),
        _ => "super-mario".to_owned(),
    };
    let mut gelpad = Gelpad::play_on_small_pad(folder, &presses(&mut random), &profile)?;
    let keyboard = wait(|| {
        let mut devices = evdev::enumerate().map(|(_, device)| device);
        Ok(devices.find(|device| device.name() == Some("gelpad keyboard")))
    })?;
    let is_down = || Ok(keyboard.get_key_state()?.iter().next().map(|_| ()));
    wait(is_down)?;
    std::thread::sleep(Duration::from_millis(random.below(400).into()));
    wait(is_down)?;
    let pick = |random: &mut Random, signals: &[Signal]| {
        signals[random.below(signals.len() as u32) as usize]
    };
    match kind {
        Kind::Signal => gelpad.signal(pick(&mut random, &HANDLED))?,
        Kind::Crash => gelpad.signal(pick(&mut random, &FATAL))?,
        Kind::Stopped => {
            gelpad.signal(Signal::STOP)?;
            let pause_ms = random.below(2 * STOPPED.as_millis() as u32);
            std::thread::sleep(Duration::from_millis(pause_ms.into()));
            gelpad.signal(Signal::KILL)?;
        }
        Kind::InAStormOfReloads => {
            for version in 1..10 {
                std::fs::write(&storm, storm_profile(version))?;
                std::thread::sleep(Duration::from_millis(random.below(60).into()));
            }
            gelpad.signal(pick(&mut random, &[Signal::TERM, Signal::KILL]))?;
        }
    }
    let start = Instant::now();
    // A device that is gone holds nothing; until then its keys are read.
    while keyboard
        .get_key_state()
        .is_ok_and(|keys| keys.iter().next().is_some())
    {
        ensure!(start.elapsed() < RELEASED, "a key is down still");
    }
    let took = start.elapsed();
    gelpad.ended(PATIENCE)?;
    let mut left = evdev::enumerate().map(|(_, device)| device);
    let left = left.find(|device| device.name().is_some_and(|name| name.starts_with("gelpad")));
    ensure!(left.is_none(), "a device is left");
    Ok(took)
}

fn wait<T>(mut look: impl FnMut() -> Result<Option<T>>) -> Result<T> {
    let start = Instant::now();
    loop {
        if let Some(found) = look()? {
            return Ok(found);
        }
        if start.elapsed() > PATIENCE {
            bail!("nothing within {PATIENCE:?}");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}
