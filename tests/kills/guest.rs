//! Kills on a real kernel, which releases its devices itself: in a virtual machine
//! (`scripts/run-in-guest.sh`).

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use rustix::process::Signal;

use crate::gelpad::{Gelpad, Random, presses};
use crate::{PATIENCE, RELEASED, summary};

const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scripts/run-in-guest.sh");
/// Number of kills without `GELPAD_GUEST_KILLS`; the guest is slow.
const SAMPLE: usize = 2;
/// Time limit per kill in the guest, s: a start takes it some seconds.
const LIMIT_S: usize = 60;

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
        .output()
        .context(SCRIPT)?;
    let said = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim_end().to_owned();
    eprintln!("\n{}", said(&output.stdout));
    ensure!(
        output.status.success(),
        "{}: {}",
        output.status,
        said(&output.stderr)
    );
    Ok(())
}

fn count() -> usize {
    let kills = std::env::var("GELPAD_GUEST_KILLS").ok();
    kills.and_then(|text| text.parse().ok()).unwrap_or(SAMPLE)
}

/// Kills gelpad while keys are held on the kernel's keyboard; measures how long until the device is gone.
pub fn inside() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let mut times = Vec::new();
    for round in 0..count() {
        times
            .push(kill_once(folder.path(), round as u64).with_context(|| format!("kill {round}"))?);
    }
    println!("in the guest: {}", summary(&mut times));
    Ok(())
}

fn kill_once(folder: &Path, seed: u64) -> Result<Duration> {
    let mut random = Random(seed);
    let mut gelpad = Gelpad::play_by("gamepad", folder, "", &presses(&mut random), "super-mario")?;
    let keyboard = wait(|| {
        let mut devices = evdev::enumerate().map(|(_, device)| device);
        Ok(devices.find(|device| device.name() == Some("gelpad keyboard")))
    })?;
    let is_down = || Ok(keyboard.get_key_state()?.iter().next().map(|_| ()));
    wait(is_down)?;
    std::thread::sleep(Duration::from_millis(random.below(400).into()));
    wait(is_down)?;
    gelpad.signal(Signal::KILL)?;
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
