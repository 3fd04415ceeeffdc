//! No key stays down when gelpad ends: killed, stopped, hanging, panicking, at the end of the source, at a
//! change of profile.
//!
//! The real binary plays into the test's own X server (Xvfb), and another client reads the keys.
//! `GELPAD_KILLS` sets the number of kills (default: a small sample); `scripts/kill-a-thousand.sh` does the
//! full count. The kernel's devices are tested in a virtual machine. If Xvfb or the machine is missing, the
//! trials are ignored with the reason as their kind; with `GELPAD_TEST_ALL=1` they fail.

#![allow(
    clippy::disallowed_methods,
    reason = "how long a key stays down is measured by the clock"
)]

#[path = "kills/adversary.rs"]
mod adversary;
#[path = "kills/display.rs"]
mod display;
#[path = "kills/endings.rs"]
mod endings;
#[path = "kills/gelpad.rs"]
mod gelpad;
#[path = "kills/guest.rs"]
mod guest;
#[path = "kills/inside.rs"]
mod inside;
#[path = "game/process.rs"]
#[allow(dead_code, reason = "the game test starts more")]
mod process;
#[path = "game/server.rs"]
mod server;
#[path = "kills/signals.rs"]
mod signals;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use libtest_mimic::{Arguments, Failed, Trial};
use rustix::process::{Pid, Signal, kill_process};

use crate::adversary::Random;
use crate::display::Display;
use crate::gelpad::{Gelpad, one_hold, presses, watcher_processes, watchers};
use crate::process::Process;
use crate::server::{PATIENCE, start_server};

/// Number of kills without `GELPAD_KILLS`.
const SAMPLE: usize = 8;
/// Longest time until all keys are up after a kill.
const RELEASED: Duration = Duration::from_secs(10);
/// A parent that is silent for this long counts as stopped (`src/platform/watch`).
const STOPPED: Duration = Duration::from_secs(2);
/// The X keycode of the left shift key, which no profile here uses.
const OTHER_KEY: u8 = 50;

/// A display and a folder.
pub struct Stage {
    display: Display,
    server: Process,
    folder: tempfile::TempDir,
}

fn main() -> ExitCode {
    if std::env::args().nth(1).as_deref() == Some("--inside-the-guest") {
        return match guest::inside() {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                eprintln!("{error:#}");
                ExitCode::FAILURE
            }
        };
    }
    // A backtrace is resolved before the stack unwinds, which takes a second or two with debug information.
    std::panic::set_hook(Box::new(|info| eprintln!("{info}")));
    let mut arguments = Arguments::from_args();
    // Most trials only wait, each on a display of its own.
    arguments.test_threads = Some(4);
    let trials = vec![
        needing(guest::missing(), "killed_in_the_guest", guest::killed),
        trial("killed", killed),
        trial("aborted", aborted),
        trial("stopped", stopped),
        trial("a_watcher_that_is_killed", without_watcher),
        trial(
            "signals_of_a_terminal_do_not_end_the_watcher",
            ignores_signals,
        ),
        trial("end_of_the_source", end_of_the_source),
        trial("profile_switch", profile_switch),
        trial("endings_of_an_adversary", endings::endings),
        trial("each_signal", signals::each_signal),
        trial("closed_pipes", signals::closed_pipes),
        trial("a_scope_of_a_watcher", signals::scope_of_a_watcher),
        trial("a_killed_terminal", signals::killed_emulator),
        trial("a_killed_shell", signals::killed_shell),
        trial_with("a_killed_tmux", signals::no_tmux(), signals::killed_tmux),
        trial("a_display_that_is_killed", killed_display),
        trial("another_gelpad_keeps_its_keys", keys_of_another_gelpad),
        trial("keys_of_another_keyboard_stay_down", keys_of_others),
        trial("panic_of_the_source", inside::panic_of_the_source),
        trial("panic_of_the_output", inside::panic_of_the_output),
        trial("an_output_that_hangs", inside::an_output_that_hangs),
    ];
    libtest_mimic::run(&arguments, trials).exit_code()
}

fn trial(name: &str, run: fn(&Stage) -> Result<()>) -> Trial {
    trial_with(name, None, run)
}

/// A trial that may need more than a display.
fn trial_with(name: &str, missing: Option<String>, run: fn(&Stage) -> Result<()>) -> Trial {
    let xvfb = xvfb();
    let no_xvfb = xvfb.is_none().then(|| "not installed: Xvfb".to_owned());
    let missing = missing.or(no_xvfb);
    needing(missing, name, move || {
        on_stage(&xvfb.context("no Xvfb")?, run)
    })
}

/// A trial, or an ignored one if something for it is missing.
fn needing(
    missing: Option<String>,
    name: &str,
    run: impl FnOnce() -> Result<()> + Send + 'static,
) -> Trial {
    let all = std::env::var_os("GELPAD_TEST_ALL").is_some_and(|value| value == "1");
    match missing {
        None => Trial::test(name, || {
            run().map_err(|error| Failed::from(format!("{error:#}")))
        }),
        Some(reason) => {
            let message = reason.clone();
            Trial::test(name, move || Err(Failed::from(message)))
                .with_kind(reason)
                .with_ignored_flag(!all)
        }
    }
}

fn xvfb() -> Option<PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let mut files = std::env::split_paths(&path).map(|folder| folder.join("Xvfb"));
    files.find(|file| file.is_file())
}

fn on_stage(xvfb: &Path, run: fn(&Stage) -> Result<()>) -> Result<()> {
    let folder = tempfile::tempdir()?;
    let (server, name) = start_server(xvfb, folder.path())?;
    let stage = Stage {
        display: Display::open(&name.to_string_lossy())?,
        server,
        folder,
    };
    let keymap = stage.display.keymap()?;
    run(&stage).with_context(|| stage.said())?;
    ensure!(
        stage.display.keymap()? == keymap,
        "the keymap is another than before"
    );
    stage.no_watcher_is_left()
}

impl Stage {
    fn play(&self, script: &str) -> Result<Gelpad> {
        Gelpad::play(
            self.folder.path(),
            &self.display.name,
            script,
            "super-mario",
        )
    }

    fn said(&self) -> String {
        let said = std::fs::read(self.folder.path().join("gelpad.said")).unwrap_or_default();
        format!("gelpad said: {}", String::from_utf8_lossy(&said))
    }

    fn no_watcher_is_left(&self) -> Result<()> {
        let start = Instant::now();
        loop {
            let left = watcher_processes(&self.display.name, &["watch", "guard"]);
            if left.is_empty() {
                return Ok(());
            }
            ensure!(start.elapsed() < RELEASED, "watchers are left: {left:?}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

fn killed(stage: &Stage) -> Result<()> {
    let kills = std::env::var("GELPAD_KILLS").ok();
    let kills = kills.and_then(|text| text.parse().ok()).unwrap_or(SAMPLE);
    let mut times = Vec::new();
    for round in 0..kills {
        times.push(
            kill_once(stage, round as u64, Signal::KILL)
                .with_context(|| format!("kill {round}"))?,
        );
    }
    eprintln!("\n{}", summary(&mut times));
    Ok(())
}

/// Statistics of how long keys stayed down, for people.
fn summary(times: &mut [Duration]) -> String {
    times.sort();
    let at = |part: f64| {
        let index = (times.len().saturating_sub(1) as f64 * part).round() as usize;
        times
            .get(index)
            .map_or(0.0, |time| time.as_secs_f64() * 1e3)
    };
    format!(
        "{} kills with keys held; all up after {:.1} ms (p50), {:.1} ms (p99), {:.1} ms at the latest",
        times.len(),
        at(0.5),
        at(0.99),
        at(1.0)
    )
}

fn aborted(stage: &Stage) -> Result<()> {
    kill_once(stage, 99, Signal::ABORT).map(drop)
}

/// Kills gelpad at a random moment when a key is down; returns how long until none is.
fn kill_once(stage: &Stage, seed: u64, signal: Signal) -> Result<Duration> {
    let mut random = Random(seed);
    let mut gelpad = stage.play(&presses(&mut random))?;
    stage.display.wait(true, PATIENCE)?;
    std::thread::sleep(Duration::from_micros(random.below(400_000).into()));
    stage.display.wait(true, PATIENCE)?;
    gelpad.signal(signal)?;
    let took = stage.display.wait(false, RELEASED)?;
    gelpad.ended(PATIENCE)?;
    // No key goes down after that.
    std::thread::sleep(Duration::from_millis(60));
    let down = stage.display.down()?;
    ensure!(down.is_empty(), "down after all were up: {down:?}");
    Ok(took)
}

fn stopped(stage: &Stage) -> Result<()> {
    let mut gelpad = stage.play(&one_hold())?;
    stage.display.wait(true, PATIENCE)?;
    // A short stop has no effect.
    gelpad.signal(Signal::STOP)?;
    std::thread::sleep(STOPPED / 4);
    ensure!(!stage.display.down()?.is_empty(), "released too soon");
    gelpad.signal(Signal::CONT)?;
    std::thread::sleep(STOPPED / 4);
    gelpad.signal(Signal::STOP)?;
    let took = stage.display.wait(false, STOPPED + RELEASED)?;
    ensure!(took > STOPPED / 2, "released after {took:?} already");
    gelpad.signal(Signal::CONT)?;
    let back = stage.display.wait(true, RELEASED)?;
    eprintln!("\nstopped: up after {took:.1?}; down again {back:.1?} after it went on");
    gelpad.signal(Signal::TERM)?;
    stage.display.wait(false, RELEASED)?;
    let code = gelpad.ended(PATIENCE)?.code();
    ensure!(code == Some(143), "exit code {code:?}");
    Ok(())
}

fn without_watcher(stage: &Stage) -> Result<()> {
    let gelpad = stage.play(&one_hold())?;
    stage.display.wait(true, PATIENCE)?;
    let first = watchers(&stage.display.name);
    let [watcher] = first[..] else {
        anyhow::bail!("watchers: {first:?}");
    };
    kill_process(Pid::from_raw(watcher).context("a process")?, Signal::KILL)?;
    let start = Instant::now();
    let has_another = || {
        watchers(&stage.display.name)
            .iter()
            .any(|pid| *pid != watcher)
    };
    while !has_another() {
        ensure!(start.elapsed() < PATIENCE, "no other watcher was started");
        std::thread::sleep(Duration::from_millis(50));
    }
    // The watcher must be ready before its parent ends.
    std::thread::sleep(Duration::from_millis(500));
    ensure!(!stage.display.down()?.is_empty(), "the key came up");
    gelpad.signal(Signal::KILL)?;
    stage.display.wait(false, RELEASED).map(drop)
}

fn ignores_signals(stage: &Stage) -> Result<()> {
    let gelpad = stage.play(&one_hold())?;
    stage.display.wait(true, PATIENCE)?;
    let first = watchers(&stage.display.name);
    for pid in &first {
        for signal in [Signal::INT, Signal::TERM, Signal::HUP, Signal::QUIT] {
            kill_process(Pid::from_raw(*pid).context("a process")?, signal)?;
        }
    }
    std::thread::sleep(Duration::from_millis(200));
    ensure!(
        watchers(&stage.display.name) == first,
        "the watcher has ended"
    );
    gelpad.signal(Signal::KILL)?;
    stage.display.wait(false, RELEASED).map(drop)
}

fn end_of_the_source(stage: &Stage) -> Result<()> {
    let mut gelpad = stage.play("t:200 down 1 80 50\nt:700 end\n")?;
    stage.display.wait(true, PATIENCE)?;
    stage.display.wait(false, RELEASED)?;
    let code = gelpad.ended(PATIENCE)?.code();
    ensure!(code == Some(0), "exit code {code:?}");
    Ok(())
}

fn profile_switch(stage: &Stage) -> Result<()> {
    let file = stage.folder.path().join("mine.toml");
    let text = |key: &str| {
        format!(
            "schema = 1\nname = \"mine\"\n[[region]]\nname = \"all\"\nx = 0\ny = 0\nw = 1\nh = 1\n\
             [[binding]]\nregion = \"all\"\noutput = \"key:{key}\"\n"
        )
    };
    std::fs::write(&file, text("f"))?;
    let name = stage.display.name.as_str();
    let profile = file.display().to_string();
    let mut gelpad = Gelpad::play(stage.folder.path(), name, &one_hold(), &profile)?;
    stage.display.wait(true, PATIENCE)?;
    std::fs::write(&file, text("g"))?;
    // The change waits a second for the finger to lift, then releases what is held.
    stage.display.wait(false, RELEASED + RELEASED)?;
    gelpad.signal(Signal::TERM)?;
    gelpad.ended(PATIENCE).map(drop)
}

/// The watcher releases only gelpad's keys: those of a real keyboard stay down.
fn keys_of_others(stage: &Stage) -> Result<()> {
    stage.display.press(OTHER_KEY, true)?;
    let mut gelpad = stage.play(&one_hold())?;
    let start = Instant::now();
    while stage.display.down()?.len() < 2 {
        ensure!(start.elapsed() < PATIENCE, "gelpad holds no key");
        std::thread::sleep(Duration::from_millis(5));
    }
    gelpad.signal(Signal::KILL)?;
    gelpad.ended(PATIENCE)?;
    let start = Instant::now();
    while stage.display.down()? != [OTHER_KEY] {
        let down = stage.display.down()?;
        ensure!(start.elapsed() < RELEASED, "after the kill: {down:?}");
        std::thread::sleep(Duration::from_millis(5));
    }
    // It does not come up later either.
    std::thread::sleep(RELEASED / 4);
    let down = stage.display.down()?;
    ensure!(down == [OTHER_KEY], "half a second later: {down:?}");
    stage.display.press(OTHER_KEY, false)
}

/// A display that is gone is noticed without an event, and ends the game with an error.
fn killed_display(stage: &Stage) -> Result<()> {
    let folder = stage.folder.path().join("other");
    std::fs::create_dir(&folder)?;
    let (mut server, name) = start_server(&xvfb().context("no Xvfb")?, &folder)?;
    let display = Display::open(&name.to_string_lossy())?;
    let mut gelpad = Gelpad::play(&folder, &display.name, &one_hold(), "super-mario")?;
    display.wait(true, PATIENCE)?;
    server.signal(Signal::KILL)?;
    let start = Instant::now();
    let code = gelpad.ended(PATIENCE)?.code();
    eprintln!(
        "\nthe display was killed: ended after {:.1?}",
        start.elapsed()
    );
    ensure!(code == Some(1), "exit code {code:?}");
    ensure!(server.end_within(PATIENCE)?.is_some());
    Ok(())
}

/// The end of one gelpad leaves down what another one holds.
fn keys_of_another_gelpad(stage: &Stage) -> Result<()> {
    let mut first = stage.play(&one_hold())?;
    stage.display.wait(true, PATIENCE)?;
    let held = stage.display.down()?;
    let folder = stage.folder.path().join("other");
    std::fs::create_dir(&folder)?;
    let runtime = stage.folder.path();
    let mut second = Gelpad::play_in(
        runtime,
        &folder,
        &stage.display.name,
        &one_hold(),
        "super-mario",
    )?;
    // Both hold the same key when the watchers of the second have noted it.
    let holders = || {
        let files = std::fs::read_dir(runtime.join("gelpad/held"))
            .into_iter()
            .flatten()
            .flatten();
        let texts = files.map(|file| std::fs::read_to_string(file.path()).unwrap_or_default());
        texts.filter(|text| text.contains("key:")).count()
    };
    let start = Instant::now();
    while holders() < 4 {
        ensure!(
            start.elapsed() < PATIENCE,
            "{} watchers hold keys",
            holders()
        );
        std::thread::sleep(Duration::from_millis(5));
    }
    second.signal(Signal::KILL)?;
    second.ended(PATIENCE)?;
    std::thread::sleep(RELEASED / 2);
    ensure!(
        stage.display.down()? == held,
        "the first gelpad's key came up"
    );
    first.signal(Signal::KILL)?;
    first.ended(PATIENCE)?;
    stage.display.wait(false, RELEASED).map(drop)
}
