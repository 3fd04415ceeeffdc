//! Every named key under sway, as wev reports it: its keycode, and how long it was down. No stuck key when
//! gelpad is killed or stopped. Under weston, which has no virtual keyboard, a clear error.
//!
//! Both compositors run without a screen and not as root (sway refuses that). Needs the Debian packages sway,
//! wev and weston, and for root setpriv; if one is missing, the trials are ignored with the reason as their
//! kind; with `GELPAD_TEST_ALL=1` they fail.

#![allow(
    clippy::disallowed_methods,
    reason = "deadlines of a test read the clock"
)]

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use gelpad::types::Key;
use libtest_mimic::{Arguments, Failed, Trial};
use rustix::process::{Pid, Signal, kill_process};

#[path = "kills/adversary.rs"]
mod adversary;

use crate::adversary::{Random, processes_with};

/// Longest wait for each step, for a busy machine.
const PATIENCE: Duration = Duration::from_mins(1);
/// Longest time until the keys of a stopped gelpad are up; its watcher waits two seconds.
const RELEASED: Duration = Duration::from_secs(4);
/// How long each key is held, and the pause after it, ms.
const HELD_MS: u32 = 40;
const PAUSE_MS: u32 = 20;
/// Even on a busy machine a press is held for two frames of a game, less the rounding to milliseconds.
const LEAST_MS: u32 = 33;
/// The id of Debian's user `nobody`, which root changes to.
const NOBODY: u32 = 65534;

fn main() -> ExitCode {
    let mut arguments = Arguments::from_args();
    arguments.test_threads = Some(1);
    let trials = vec![
        trial("every_key", &["sway", "wev"], every_key),
        trial("killed_and_stopped", &["sway", "wev"], killed_and_stopped),
        trial("endings_of_an_adversary", &["sway", "wev"], endings),
        trial(
            "a_compositor_without_the_protocol",
            &["weston"],
            without_protocol,
        ),
    ];
    libtest_mimic::run(&arguments, trials).exit_code()
}

fn trial(name: &str, needed: &[&'static str], run: fn(&Home) -> Result<()>) -> Trial {
    let all = std::env::var_os("GELPAD_TEST_ALL").is_some_and(|value| value == "1");
    let also = is_root().then_some("setpriv");
    let missing: Vec<&str> = needed
        .iter()
        .copied()
        .chain(also)
        .filter(|name| !is_there(name))
        .collect();
    if missing.is_empty() {
        return Trial::test(name, move || {
            Home::new()
                .and_then(|home| run(&home))
                .map_err(|error| Failed::from(format!("{error:#}")))
        });
    }
    let reason = format!("not installed: {}", missing.join(", "));
    let message = reason.clone();
    Trial::test(name, move || Err(Failed::from(message)))
        .with_kind(reason)
        .with_ignored_flag(!all)
}

fn is_there(program: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).any(|folder| folder.join(program).is_file())
}

fn is_root() -> bool {
    rustix::process::getuid().is_root()
}

/// The home of a user without privileges: runtime folder, settings, logs.
struct Home {
    folder: tempfile::TempDir,
}

impl Home {
    fn new() -> Result<Self> {
        let folder = tempfile::tempdir()?;
        if is_root() {
            std::os::unix::fs::chown(folder.path(), Some(NOBODY), Some(NOBODY))?;
        }
        let home = Self { folder };
        // The solved tables of the pad are copied: this user cannot read the tests' folder.
        let ours = home.path("cache");
        fs::create_dir(&ours)?;
        let solved = gelpad::cache::folder().into_iter();
        for file in solved.flat_map(|folder| files(&folder).collect::<Vec<_>>()) {
            if let (true, Some(name)) = (file.is_file(), file.file_name()) {
                fs::copy(&file, ours.join(name))?;
            }
        }
        if is_root() {
            for made in [ours.clone()].into_iter().chain(files(&ours)) {
                std::os::unix::fs::chown(made, Some(NOBODY), Some(NOBODY))?;
            }
        }
        Ok(home)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Starts a program as that user; its messages go to `NAME.said`.
    fn start(&self, name: &str, arguments: &[&str], display: Option<&str>) -> Result<Program> {
        let mut command = if is_root() {
            let user = NOBODY.to_string();
            let mut command = Command::new("setpriv");
            command.args(["--reuid", &user, "--regid", &user, "--clear-groups", name]);
            command
        } else {
            Command::new(name)
        };
        let short = Path::new(name)
            .file_name()
            .context("a name")?
            .to_string_lossy();
        let said = self.path(&format!("{short}.said"));
        let file = File::create(&said)?;
        let child = command
            .args(arguments)
            .env("HOME", self.folder.path())
            .env("XDG_RUNTIME_DIR", self.folder.path())
            .env(gelpad::cache::FOLDER_VARIABLE, self.path("cache"))
            .env("WAYLAND_DISPLAY", display.unwrap_or_default())
            .env("WLR_BACKENDS", "headless")
            .env("WLR_RENDERER", "pixman")
            .env("WLR_LIBINPUT_NO_DEVICES", "1")
            .env_remove("DISPLAY")
            .env_remove("XDG_CONFIG_HOME")
            .stdin(Stdio::null())
            .stdout(file.try_clone()?)
            .stderr(file)
            .spawn()
            .with_context(|| format!("{name} does not start"))?;
        Ok(Program { child, said })
    }

    /// A compositor and the name of its display.
    fn compositor(&self, name: &str, arguments: &[&str]) -> Result<(Program, String)> {
        let program = self.start(name, arguments, None)?;
        let display = wait(|| {
            let names = fs::read_dir(self.folder.path())
                .into_iter()
                .flatten()
                .flatten();
            let mut names = names.map(|entry| entry.file_name().to_string_lossy().into_owned());
            Ok(names.find(|name| name.starts_with("wayland-") && !name.ends_with(".lock")))
        })
        .with_context(|| program.said())?;
        Ok((program, display))
    }

    /// sway, and wev in its only window.
    fn sway(&self) -> Result<(Program, Program, String)> {
        let settings = self.path("sway.conf");
        fs::write(&settings, "")?;
        let settings = settings.display().to_string();
        let (sway, display) = self.compositor("sway", &["-c", &settings])?;
        let wev = self.start("stdbuf", &["-oL", "wev"], Some(&display))?;
        wait(|| Ok(wev.said().contains("xdg_toplevel] configure").then_some(())))
            .with_context(|| wev.said())?;
        Ok((sway, wev, display))
    }

    fn gelpad(&self, display: &str, profile: &str, script: &str) -> Result<Program> {
        let (profile_file, script_file) = (self.path("keys.toml"), self.path("touches.txt"));
        fs::write(&profile_file, profile)?;
        fs::write(&script_file, script)?;
        let profile = profile_file.display().to_string();
        let source = format!("simulated:{}", script_file.display());
        let arguments = [
            "play",
            &profile,
            "--source",
            &source,
            "--output",
            "keyboard",
            "--headless",
        ];
        self.start(env!("CARGO_BIN_EXE_gelpad"), &arguments, Some(display))
    }
}

fn files(folder: &Path) -> impl Iterator<Item = PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| entry.path())
}

/// A running program; dropping it kills it.
struct Program {
    child: Child,
    said: PathBuf,
}

impl Program {
    fn said(&self) -> String {
        String::from_utf8_lossy(&fs::read(&self.said).unwrap_or_default()).into_owned()
    }

    fn signal(&self, signal: Signal) -> Result<()> {
        Ok(kill_process(Pid::from_child(&self.child), signal)?)
    }

    fn code(&mut self) -> Result<Option<i32>> {
        let status = wait(|| Ok(self.child.try_wait()?))?;
        Ok(status.code())
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn wait<T>(mut look: impl FnMut() -> Result<Option<T>>) -> Result<T> {
    let start = Instant::now();
    loop {
        if let Some(found) = look()? {
            return Ok(found);
        }
        ensure!(start.elapsed() < PATIENCE, "nothing within {PATIENCE:?}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// A key event of a client: XKB keycode, whether the key went down, and the time, ms.
type KeyEvent = (u32, bool, u32);

/// The key events in wev's log, each once: wev binds the keyboard more than once.
fn key_events(wev: &str) -> Vec<KeyEvent> {
    let mut serials = BTreeSet::new();
    let lines = wev.lines();
    let lines = lines.filter(|line| line.contains("wl_keyboard] key:"));
    lines
        .filter_map(|line| {
            let number = |name: &str| {
                let after = line.split_once(name)?.1.trim_start();
                let end = after
                    .find(|c: char| !c.is_ascii_digit())
                    .unwrap_or(after.len());
                after[..end].parse().ok()
            };
            let serial: u32 = number("serial:")?;
            if !serials.insert(serial) {
                return None;
            }
            Some((
                number("; key:")?,
                line.contains("(pressed)"),
                number("time:")?,
            ))
        })
        .collect()
}

fn profile(binding: &str) -> String {
    format!(
        "schema = 1\nname = \"keys\"\n[[region]]\nname = \"all\"\nx = 0\ny = 0\nw = 1\nh = 1\n\
         [[binding]]\nregion = \"all\"\n{binding}\n"
    )
}

fn every_key(home: &Home) -> Result<()> {
    let (_sway, wev, display) = home.sway()?;
    let keys: Vec<Key> = Key::all().collect();
    let steps: Vec<String> = keys
        .iter()
        .map(|key| {
            format!("\"press key:{key}\", \"wait {HELD_MS}\", \"release key:{key}\", \"wait {PAUSE_MS}\"")
        })
        .collect();
    let profile = profile(&format!("mode = \"macro\"\nmacro = [{}]", steps.join(", ")));
    let length_ms = (HELD_MS + PAUSE_MS) * keys.len() as u32 + 1000;
    let script = format!("t:300 down 1 50 50\nt:400 up 1\nt:{length_ms} end\n");
    let mut gelpad = home.gelpad(&display, &profile, &script)?;
    let code = gelpad.code()?;
    ensure!(code == Some(0), "exit code {code:?}: {}", gelpad.said());
    let seen = wait(|| {
        let seen = key_events(&wev.said());
        Ok((seen.len() >= 2 * keys.len()).then_some(seen))
    })
    .with_context(|| {
        format!(
            "{} changes of keys were seen",
            key_events(&wev.said()).len()
        )
    })?;
    let mut worst_ms = 0;
    for key in &keys {
        let code = u32::from(key.evdev_code()) + 8;
        let mut of_key = seen.iter().filter(|(known, ..)| *known == code);
        let (Some((_, true, from_ms)), Some((_, false, to_ms)), None) =
            (of_key.next(), of_key.next(), of_key.next())
        else {
            anyhow::bail!("{key} was not seen once, down and up again, as {code}");
        };
        let held_ms = to_ms - from_ms;
        ensure!(held_ms >= LEAST_MS, "{key} was held for {held_ms} ms");
        worst_ms = worst_ms.max(held_ms.abs_diff(HELD_MS));
    }
    ensure!(
        seen.len() == 2 * keys.len(),
        "{} changes too many",
        seen.len() - 2 * keys.len()
    );
    let pressed = seen.iter().filter(|(_, is_down, _)| *is_down);
    let pressed = pressed.map(|(code, ..)| *code);
    let order = keys.iter().map(|key| u32::from(key.evdev_code()) + 8);
    ensure!(pressed.eq(order), "they came in another order");
    eprintln!(
        "\n{} keys, each held for {HELD_MS} ms: at worst {worst_ms} ms off",
        keys.len()
    );
    Ok(())
}

fn killed_and_stopped(home: &Home) -> Result<()> {
    let (_sway, wev, display) = home.sway()?;
    let profile = profile("output = \"key:f\"");
    let script = "t:300 down 1 50 50\nt:600000 end\n";
    let last = || {
        key_events(&wev.said())
            .last()
            .map(|(_, is_down, _)| *is_down)
    };
    let until = |is_down: bool| {
        let start = Instant::now();
        wait(|| Ok((last() == Some(is_down)).then_some(())))?;
        Ok::<_, anyhow::Error>(start.elapsed())
    };
    let gelpad = home.gelpad(&display, &profile, script)?;
    until(true)?;
    gelpad.signal(Signal::STOP)?;
    let took = until(false)?;
    ensure!(took < RELEASED, "released after {took:?}");
    gelpad.signal(Signal::CONT)?;
    let back = until(true)?;
    gelpad.signal(Signal::KILL)?;
    let killed = until(false)?;
    ensure!(killed < RELEASED, "released after {killed:?}");
    eprintln!(
        "\nstopped: up after {took:.1?}, down again {back:.1?} after it went on; killed: up after {killed:.1?}"
    );
    Ok(())
}

/// Endings that an adversary would choose; `GELPAD_ENDINGS` sets their number, `GELPAD_SEED` the draws.
fn endings(home: &Home) -> Result<()> {
    let count = std::env::var("GELPAD_ENDINGS").ok();
    let count: usize = count.and_then(|text| text.parse().ok()).unwrap_or(8);
    let (sway, wev, display) = home.sway()?;
    let profile = profile("output = \"key:f\"");
    let script = "t:300 down 1 50 50\nt:600000 end\n";
    // Displays of other sessions have the same name.
    let own = format!("XDG_RUNTIME_DIR={}", home.folder.path().display());
    let watchers = || processes_with(&own, &["watch", "guard"]);
    let kill = |pid: i32| -> Result<()> {
        // It may be gone already.
        let _ = Pid::from_raw(pid).map(|pid| kill_process(pid, Signal::KILL));
        Ok(())
    };
    let any_down = || {
        let mut down = BTreeSet::new();
        for (code, is_down, _) in key_events(&wev.said()) {
            match is_down {
                true => down.insert(code),
                false => down.remove(&code),
            };
        }
        !down.is_empty()
    };
    let until = |is_down| wait(|| Ok((any_down() == is_down).then_some(())));
    let seed = std::env::var("GELPAD_SEED").ok();
    let mut random = Random(seed.and_then(|text| text.parse().ok()).unwrap_or(1));
    let pause = |random: &mut Random, most_ms| Duration::from_millis(random.below(most_ms).into());
    for round in 0..count {
        let mut gelpad = home.gelpad(&display, &profile, script)?;
        until(true).with_context(|| format!("ending {round}: the press"))?;
        match round % 8 {
            0 => gelpad.signal(Signal::KILL)?,
            1 => gelpad.signal(Signal::TERM)?,
            2 => gelpad.signal(Signal::SEGV)?,
            3 => {
                gelpad.signal(Signal::STOP)?;
                std::thread::sleep(pause(&mut random, 2 * 1000));
                gelpad.signal(Signal::KILL)?;
            }
            4 => {
                // The compositor stalls while gelpad ends.
                sway.signal(Signal::STOP)?;
                gelpad.signal(Signal::TERM)?;
                std::thread::sleep(pause(&mut random, 3500));
                sway.signal(Signal::CONT)?;
            }
            5 => {
                // A watcher dies before gelpad, ...
                let watcher = watchers().into_iter().nth(random.below(2) as usize);
                kill(watcher.context("a watcher")?)?;
                std::thread::sleep(pause(&mut random, 1000));
                gelpad.signal(Signal::KILL)?;
            }
            6 => {
                // ... or all of them with it.
                watchers().into_iter().try_for_each(kill)?;
                gelpad.signal(Signal::KILL)?;
            }
            _ => {
                // Its profile is saved over and over.
                for version in 0..10 {
                    let key = ["g", "h", "f"][version % 3];
                    let text = profile.replace("key:f", &format!("key:{key}"));
                    fs::write(home.path("keys.toml"), text)?;
                    std::thread::sleep(pause(&mut random, 60));
                }
                gelpad.signal(Signal::TERM)?;
            }
        }
        gelpad.code().with_context(|| format!("ending {round}"))?;
        until(false).with_context(|| format!("ending {round}: a key is stuck"))?;
        std::thread::sleep(Duration::from_millis(100));
        ensure!(!any_down(), "ending {round}: a key is down again");
    }
    eprintln!("\n{count} endings on Wayland, no key stuck");
    Ok(())
}

fn without_protocol(home: &Home) -> Result<()> {
    let (_weston, display) = home.compositor("weston", &["--backend=headless-backend.so"])?;
    let mut gelpad = home.gelpad(
        &display,
        &profile("output = \"key:f\""),
        "t:300 down 1 50 50\nt:600 end\n",
    )?;
    let code = gelpad.code()?;
    let said = gelpad.said();
    ensure!(code == Some(1), "exit code {code:?}: {said}");
    ensure!(
        said.contains("has no virtual keyboard (protocol zwp_virtual_keyboard_v1")
            && said.contains("--output gamepad"),
        "{said}"
    );
    Ok(())
}
