//! A gelpad process that plays into a display, to be killed.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use rustix::process::{Pid, Signal, kill_process};

use crate::adversary::{Random, processes_with};

/// Places of the regions left, right, jump and run of super-mario, mm.
const PLACES: [(u32, u32); 4] = [(13, 57), (37, 57), (80, 50), (75, 9)];

/// A running gelpad; dropping it kills it.
pub struct Gelpad {
    pub child: Child,
}

impl Gelpad {
    /// Plays a script with a profile into the display's keyboard.
    pub fn play(folder: &Path, display: &str, script: &str, profile: &str) -> Result<Self> {
        Self::play_in(folder, folder, display, script, profile)
    }

    /// The same with another runtime folder, which several share.
    pub fn play_in(
        runtime: &Path,
        folder: &Path,
        display: &str,
        script: &str,
        profile: &str,
    ) -> Result<Self> {
        let mut command = play_command(folder, "keyboard", script, profile)?;
        command
            .env("DISPLAY", display)
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("XAUTHORITY")
            .env("XDG_RUNTIME_DIR", runtime);
        Self::start(&mut command)
    }

    /// Plays a script on a small pad into the kernel's devices.
    pub fn play_on_small_pad(folder: &Path, script: &str, profile: &str) -> Result<Self> {
        let pad = folder.join("small-pad.toml");
        fs::write(&pad, include_str!("small-pad.toml")).context("the pad")?;
        let mut command = play_command(folder, "gamepad", script, profile)?;
        // A checkout under /tmp is read-only in a guest: the pad would be solved at each start.
        command.env("GELPAD_CACHE", folder.join("cache"));
        Self::start(command.arg("--pad").arg(pad))
    }

    fn start(command: &mut Command) -> Result<Self> {
        let child = command.spawn().context("gelpad does not start")?;
        Ok(Self { child })
    }

    pub fn signal(&self, signal: Signal) -> Result<()> {
        Ok(kill_process(Pid::from_child(&self.child), signal)?)
    }

    pub fn ended(&mut self, patience: Duration) -> Result<ExitStatus> {
        let start = Instant::now();
        while start.elapsed() < patience {
            if let Some(status) = self.child.try_wait()? {
                return Ok(status);
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        bail!("gelpad has not ended after {patience:?}")
    }
}

impl Drop for Gelpad {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// One finger that holds `jump` from 200 ms on.
pub fn one_hold() -> String {
    "t:200 down 1 80 50\nt:600000 end\n".to_owned()
}

/// Two fingers with short and long presses at different places, for a minute.
pub fn presses(random: &mut Random) -> String {
    let mut events = Vec::new();
    for (finger, places) in [&PLACES[..2], &PLACES[2..]].iter().enumerate() {
        let mut t_ms = 150 + random.below(50);
        while t_ms < 60_000 {
            let (x, y) = places[random.below(2) as usize];
            events.push((t_ms, format!("down {finger} {x} {y}")));
            t_ms += 40 + random.below(300);
            events.push((t_ms, format!("up {finger}")));
            t_ms += 40 + random.below(100);
        }
    }
    events.sort();
    let mut script = String::new();
    for (t_ms, event) in events {
        // Writing to a String cannot fail.
        let _ = writeln!(script, "t:{t_ms} {event}");
    }
    script
}

/// `gelpad play` without a window; what it says goes to `gelpad.said`.
fn play_command(folder: &Path, output: &str, script: &str, profile: &str) -> Result<Command> {
    let file = folder.join("touches.txt");
    fs::write(&file, script).context("the script")?;
    let mut command = Command::new(env!("CARGO_BIN_EXE_gelpad"));
    command
        .args(["play", profile, "--source"])
        .arg(format!("simulated:{}", file.display()))
        .args(["--output", output, "--headless"])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(fs::File::create(folder.join("gelpad.said"))?);
    Ok(command)
}

/// Process ids of the first watcher of each gelpad on a display.
pub fn watchers(display: &str) -> Vec<i32> {
    watcher_processes(display, &["watch"])
}

/// Process ids of the watchers with certain names on a display.
pub fn watcher_processes(display: &str, names: &[&str]) -> Vec<i32> {
    processes_with(&format!("DISPLAY={display}"), names)
}
