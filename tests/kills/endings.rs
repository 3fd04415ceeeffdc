//! Endings that an adversary would choose, drawn at random: displays that stall, watchers that die too, stops, signals,
//! reloads. After each of them no key is down.
//!
//! `GELPAD_ENDINGS` sets how many are drawn (default: each kind once), `GELPAD_SEED` the first draw; `scripts/adversary.sh`
//! does the full count.

use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, ensure};
use rustix::process::{Pid, Signal, kill_process};

use crate::adversary::Random;
use crate::gelpad::{Gelpad, watcher_processes};
use crate::server::PATIENCE;
use crate::signals::{FATAL, HANDLED};
use crate::{RELEASED, STOPPED, Stage};

/// Longest time until all keys are up, on a busy computer.
const UP: Duration = Duration::from_secs(10);
/// A display stalls for up to this long, ms: longer than gelpad waits for it.
const LONGEST_STALL_MS: u32 = 3500;

/// A kind of ending.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// A signal that gelpad can react to.
    Signal,
    /// A signal that ends the process.
    Crash,
    /// Killed together with one of its watchers.
    WithOneWatcher,
    /// Killed shortly after one of its watchers.
    AfterAWatcher,
    /// Killed while one of its watchers is stopped.
    BesideAStoppedWatcher,
    /// Ends by a signal while the display stalls.
    InAStall,
    /// The finger lifts and gelpad is killed while the display stalls.
    LiftedInAStall,
    /// Stopped, and killed before or after the watchers have noticed.
    Stopped,
    /// Ends while its profile is saved over and over.
    InAStormOfReloads,
    /// Killed with both watchers; the next gelpad releases the keys.
    WithEverything,
}

const KINDS: [Kind; 10] = [
    Kind::Signal,
    Kind::Crash,
    Kind::WithOneWatcher,
    Kind::AfterAWatcher,
    Kind::BesideAStoppedWatcher,
    Kind::InAStall,
    Kind::LiftedInAStall,
    Kind::Stopped,
    Kind::InAStormOfReloads,
    Kind::WithEverything,
];

pub fn endings(stage: &Stage) -> Result<()> {
    let number = |name: &str| std::env::var(name).ok().and_then(|text| text.parse().ok());
    let count = number("GELPAD_ENDINGS").unwrap_or(KINDS.len());
    let seed = number("GELPAD_SEED").unwrap_or(1) as u64;
    let mut stuck = Vec::new();
    for round in 0..count {
        let mut random = Random(seed.wrapping_mul(1_000_003) + round as u64);
        let kind = match count <= KINDS.len() {
            true => KINDS[round % KINDS.len()],
            false => KINDS[random.below(KINDS.len() as u32) as usize],
        };
        if let Err(error) = one(stage, kind, &mut random) {
            eprintln!("ending {round}, {kind:?}: {error:#}");
            stuck.push(format!("{kind:?}"));
            stage.release_all()?;
        }
    }
    eprintln!(
        "\n{count} endings, {} with a key stuck: {stuck:?}",
        stuck.len()
    );
    ensure!(stuck.is_empty(), "a key stays down after {stuck:?}");
    Ok(())
}

fn one(stage: &Stage, kind: Kind, random: &mut Random) -> Result<()> {
    let profile = stage.folder.path().join("storm.toml");
    std::fs::write(&profile, storm_profile(0))?;
    let name = match kind {
        Kind::InAStormOfReloads => profile.display().to_string(),
        _ => "super-mario".to_owned(),
    };
    let lift_ms = 1200 + random.below(400);
    let script = match kind {
        Kind::LiftedInAStall => {
            format!("t:200 down 1 80 50\nt:{lift_ms} up 1\nt:600000 end\n")
        }
        _ => crate::gelpad::one_hold(),
    };
    let display = stage.display.name.as_str();
    let mut gelpad = Gelpad::play(stage.folder.path(), display, &script, &name)?;
    stage.display.wait(true, PATIENCE)?;
    let held = Instant::now();
    let pause = |random: &mut Random, ms| {
        std::thread::sleep(Duration::from_millis(random.below(ms).into()));
    };
    match kind {
        Kind::Signal => {
            pause(random, 300);
            let signal = HANDLED[random.below(HANDLED.len() as u32) as usize];
            gelpad.signal(signal)?;
            stage.all_up()?;
            let code = gelpad.ended(PATIENCE)?.code();
            let expected = Some(128 + signal.as_raw());
            ensure!(code == expected, "{signal:?}: exit code {code:?}");
        }
        Kind::Crash => {
            pause(random, 300);
            gelpad.signal(FATAL[random.below(FATAL.len() as u32) as usize])?;
        }
        Kind::WithOneWatcher => {
            pause(random, 300);
            let watcher = stage.one_watcher(random)?;
            let both = [watcher, Pid::from_child(&gelpad.child)];
            let first = random.below(2) as usize;
            kill_process(both[first], Signal::KILL)?;
            kill_process(both[1 - first], Signal::KILL)?;
        }
        Kind::AfterAWatcher => {
            kill_process(stage.one_watcher(random)?, Signal::KILL)?;
            pause(random, 1000);
            gelpad.signal(Signal::KILL)?;
        }
        Kind::BesideAStoppedWatcher => {
            let watcher = stage.one_watcher(random)?;
            kill_process(watcher, Signal::STOP)?;
            pause(random, 2000);
            gelpad.signal(Signal::KILL)?;
            let up = stage.all_up();
            // It may have been replaced and killed.
            let _ = kill_process(watcher, Signal::CONT);
            up?;
        }
        Kind::InAStall => {
            stage.server.signal(Signal::STOP)?;
            let signals = [Signal::TERM, Signal::INT, Signal::KILL];
            pause(random, 300);
            gelpad.signal(signals[random.below(3) as usize])?;
            pause(random, LONGEST_STALL_MS);
            stage.server.signal(Signal::CONT)?;
        }
        Kind::LiftedInAStall => {
            let lift = Duration::from_millis((lift_ms - 200).into());
            std::thread::sleep(lift.saturating_sub(held.elapsed() + Duration::from_millis(100)));
            stage.server.signal(Signal::STOP)?;
            std::thread::sleep(Duration::from_millis(400));
            gelpad.signal(Signal::KILL)?;
            pause(random, 1000);
            stage.server.signal(Signal::CONT)?;
        }
        Kind::Stopped => {
            gelpad.signal(Signal::STOP)?;
            pause(random, 2 * STOPPED.as_millis() as u32);
            gelpad.signal(Signal::KILL)?;
        }
        Kind::InAStormOfReloads => {
            for version in 1..10 {
                std::fs::write(&profile, storm_profile(version))?;
                pause(random, 60);
            }
            let signals = [Signal::TERM, Signal::KILL];
            gelpad.signal(signals[random.below(2) as usize])?;
        }
        Kind::WithEverything => {
            pause(random, 300);
            let mut all: Vec<Pid> = stage.watchers();
            all.push(Pid::from_child(&gelpad.child));
            for process in all {
                kill_process(process, Signal::KILL)?;
            }
            gelpad.ended(PATIENCE)?;
            let script = "t:200 down 1 5 95\nt:600000 end\n";
            let folder = stage.folder.path();
            let mut next = Gelpad::play(folder, display, script, "super-mario")?;
            stage.all_up()?;
            next.signal(Signal::TERM)?;
            next.ended(PATIENCE)?;
        }
    }
    gelpad.ended(PATIENCE)?;
    stage.all_up()
}

/// A profile that presses another key in each version.
pub fn storm_profile(version: usize) -> String {
    let key = ["f", "g", "h"][version % 3];
    format!(
        "schema = 1\nname = \"storm\"\n[[region]]\nname = \"all\"\nx = 0\ny = 0\nw = 1\nh = 1\n\
         [[binding]]\nregion = \"all\"\noutput = \"key:{key}\"\n"
    )
}

impl Stage {
    /// Waits until all keys are up and stay up.
    fn all_up(&self) -> Result<()> {
        self.display.wait(false, UP)?;
        std::thread::sleep(Duration::from_millis(100));
        let down = self.display.down()?;
        ensure!(down.is_empty(), "down after all were up: {down:?}");
        Ok(())
    }

    fn watchers(&self) -> Vec<Pid> {
        let pids = watcher_processes(&self.display.name, &["watch", "guard"]);
        pids.into_iter().filter_map(Pid::from_raw).collect()
    }

    fn one_watcher(&self, random: &mut Random) -> Result<Pid> {
        let watchers = self.watchers();
        ensure!(watchers.len() >= 2, "watchers: {watchers:?}");
        let index = random.below(watchers.len() as u32) as usize;
        watchers.get(index).copied().context("a watcher")
    }

    /// Releases every key, so that the next ending starts from none.
    fn release_all(&self) -> Result<()> {
        for code in self.display.down()? {
            self.display.press(code, false)?;
        }
        self.display.wait(false, RELEASED).map(drop)
    }
}
