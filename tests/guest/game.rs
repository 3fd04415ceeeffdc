//! fceux plays the game of `tests/game` with gelpad's pad, and with nothing else.
//!
//! The test's switch box controls gelpad, whose pad controls the game. The test releases a switch when it has
//! seen the game take it for enough frames, however slow the guest is.

#![cfg_attr(
    not(feature = "gilrs"),
    allow(dead_code, reason = "who plays in the guest needs gilrs")
)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use anyhow::{Context as _, Result, ensure};

use crate::host::{Guest, needs_gilrs};
use crate::tools::Tools;

/// Lengths of alternately short and long presses, frames of the game.
const SHORT_FRAMES: usize = 3;
const LONG_FRAMES: usize = 60;
const PRESSES: usize = 6;
/// Frames until the highest jump has ended.
const REST_FRAMES: usize = 60;
/// Frames until the game has drawn itself and its rate is known.
const WARM_UP_FRAMES: usize = 90;
/// A guest on a busy machine needs long to start an emulator.
const PATIENCE: Duration = Duration::from_secs(150);

pub fn needs() -> Result<(), String> {
    needs_gilrs()?;
    Tools::find().map_err(|error| error.to_string()).map(drop)
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("guest-game")
}

/// On the host: builds the game and runs the guest.
pub fn play() -> Result<()> {
    let tools = Tools::find()?;
    let folder = folder();
    fs::create_dir_all(&folder)?;
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/game");
    let run = |command: &mut Command| -> Result<()> {
        let status = command.status().context("an assembler")?;
        ensure!(status.success(), "{command:?}: {status}");
        Ok(())
    };
    let (object, game) = (folder.join("jump.o"), folder.join("jump.nes"));
    run(Command::new(&tools.ca65)
        .arg(sources.join("jump.s"))
        .arg("-o")
        .arg(&object))?;
    run(Command::new(&tools.ld65)
        .arg("-C")
        .arg(sources.join("nrom.cfg"))
        .args([&object, Path::new("-o"), &game]))?;
    warm_up(&folder)?;
    Guest {
        timeout_s: 500,
        ..Guest::default()
    }
    .inside("game")
}

/// Solves the pad's tables on the host, because the guest is slow.
fn warm_up(folder: &Path) -> Result<()> {
    let script = folder.join("nothing.txt");
    fs::write(&script, "t:50 down 1 50 50\nt:100 up 1\nt:110 end\n")?;
    let output = Command::new(env!("CARGO_BIN_EXE_gelpad"))
        .args(["play", "--headless", "--output", "trace", "--source"])
        .arg(format!("simulated:{}", script.display()))
        .output()?;
    ensure!(output.status.success(), "gelpad: {}", output.status);
    Ok(())
}

#[cfg(not(feature = "gilrs"))]
pub fn inside() -> Result<()> {
    anyhow::bail!("built without the feature gilrs")
}

#[cfg(feature = "gilrs")]
pub use of_gilrs::inside;

#[cfg(feature = "gilrs")]
mod of_gilrs {
    use super::*;
    use crate::as_evdev;
    use crate::log::{Frame, Log, Press};
    use crate::process::Process;
    use crate::source::{Gelpad, SwitchBox};

    /// The only gamepad plays. fceux reads it between two drawings of its window, which on the guest's one
    /// slow processor may be half a second apart: so the window is small and has priority.
    const SETTINGS: &str = "\
SDL.Input.0 = GamePad.0
SDL.Input.GamePad.0.DeviceType = Joystick
SDL.Sound = 0
SDL.XScale = 1
SDL.YScale = 1
SDL.LastXRes = 256
SDL.LastYRes = 240
SDL.WinSizeX = 256
SDL.WinSizeY = 240
SDL.SetSchedParam = 1
SDL.EmuSchedNice = 5
SDL.GuiSchedNice = -5
";
    const PROFILE: &str = r#"
schema = 1
name = "by-switches"

[[binding]]
from = "pad:a"
output = "pad:a"

[[binding]]
from = "pad:b"
output = "pad:right"
"#;
    /// The first two switches.
    const JUMP: u16 = 0;
    const RIGHT: u16 = 1;

    pub fn inside() -> Result<()> {
        let tools = Tools::find()?;
        let home = PathBuf::from("/tmp/home");
        fs::create_dir_all(home.join(".fceux"))?;
        fs::write(home.join(".fceux/fceux.cfg"), SETTINGS)?;
        let (_server, display) = server(&tools, &home)?;
        let mut switches = SwitchBox::plug_in()?;
        // Without gelpad the game sees nothing of the switches: they are not a gamepad.
        let mut game = Game::start(&tools, &home, &display, "without.csv")?;
        game.run_for(WARM_UP_FRAMES)?;
        for (switch, is_down) in [(JUMP, true), (JUMP, false), (RIGHT, true), (RIGHT, false)] {
            switches.set(switch, is_down)?;
            game.run_for(10)?;
        }
        let presses = game
            .log()?
            .presses(|frame| frame.a || frame.left || frame.right);
        ensure!(
            presses.is_empty(),
            "the game sees presses without gelpad: {presses:?}"
        );
        drop(game);

        let mut gelpad = Gelpad::start(PROFILE, &["--output", "gamepad"])?;
        gelpad.says("gamepad: ")?;
        // gelpad plays as soon as a press arrives.
        switches.set(JUMP, true)?;
        let mut pad = as_evdev::wait_for_pad()?;
        while as_evdev::report(&mut pad)? != [(1, 0x130, 1)] {}
        switches.set(JUMP, false)?;
        let mut game = Game::start(&tools, &home, &display, "with.csv")?;
        game.run_for(WARM_UP_FRAMES)?;
        let before = game.last_frame()?;
        for index in 0..PRESSES {
            game.hold(&mut switches, JUMP, asked(index), |frame| frame.a)?;
        }
        let jumps = game.log()?.skip(before).presses(|frame| frame.a);
        println!("frames asked  frames of A  height px");
        for (index, jump) in jumps.iter().enumerate() {
            println!(
                "{:12}  {:11}  {:9}",
                asked(index),
                jump.frames,
                jump.height_px
            );
        }
        judge(&jumps)?;
        let before = game.last_frame()?;
        game.hold(&mut switches, RIGHT, LONG_FRAMES, |frame| frame.right)?;
        let walks = game.log()?.skip(before).presses(|frame| frame.right);
        ensure!(
            walks.len() == 1 && walks[0].way_px > 0,
            "the d-pad walked {walks:?}"
        );
        Ok(())
    }

    fn asked(index: usize) -> usize {
        [SHORT_FRAMES, LONG_FRAMES][index % 2]
    }

    fn judge(jumps: &[Press]) -> Result<()> {
        ensure!(
            jumps.len() == PRESSES,
            "{PRESSES} presses became {}",
            jumps.len()
        );
        let of = |asked_for: usize, what: fn(&Press) -> usize| {
            let pairs = jumps.iter().enumerate();
            pairs
                .filter(move |(index, _)| asked(*index) == asked_for)
                .map(move |(_, jump)| what(jump))
        };
        ensure!(
            of(SHORT_FRAMES, |jump| jump.frames).max() < of(LONG_FRAMES, |jump| jump.frames).min(),
            "a short press holds A as long as a long one"
        );
        ensure!(
            of(SHORT_FRAMES, |jump| jump.height_px.into()).max()
                < of(LONG_FRAMES, |jump| jump.height_px.into()).min(),
            "a short press jumps as high as a long one"
        );
        Ok(())
    }

    /// fceux with the game.
    struct Game {
        fceux: Process,
        log: PathBuf,
    }

    impl Game {
        fn start(tools: &Tools, home: &Path, display: &str, log: &str) -> Result<Self> {
            let log = home.join(log);
            let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/game/log.lua");
            let mut fceux = Command::new(&tools.fceux);
            fceux
                .env("HOME", home)
                .env("DISPLAY", display)
                .env("QT_QPA_PLATFORM", "xcb")
                .env("GELPAD_GAME_LOG", &log)
                .args(["--sound", "0", "--loadlua"])
                .arg(script)
                .arg(folder().join("jump.nes"));
            let fceux = Process::start("fceux", &mut fceux, home)?;
            Ok(Self { fceux, log })
        }

        fn log(&self) -> Result<Log> {
            // The log exists once the game runs.
            Log::parse(&fs::read_to_string(&self.log).unwrap_or_default())
        }

        /// Index of the newest frame. A press starts from a frame without it: the very next one may have it.
        fn last_frame(&self) -> Result<usize> {
            Ok(self.log()?.frames().len().saturating_sub(1))
        }

        /// Waits until the game has run for this many frames.
        fn run_for(&mut self, frames: usize) -> Result<()> {
            let until = self.log()?.frames().len() + frames;
            self.wait_for(|log| log.frames().len() >= until)
        }

        /// Holds a switch until the game has seen it for this many frames, then waits until the jump has
        /// ended.
        fn hold(
            &mut self,
            switches: &mut SwitchBox,
            switch: u16,
            frames: usize,
            held: impl Fn(&Frame) -> bool,
        ) -> Result<()> {
            let before = self.log()?.frames().len();
            let held = |log: &Log| {
                let fresh = &log.frames()[before..];
                fresh.iter().filter(|frame| held(frame)).count()
            };
            switches.set(switch, true)?;
            self.wait_for(|log| held(log) >= frames)?;
            switches.set(switch, false)?;
            self.run_for(REST_FRAMES)
        }

        fn wait_for(&mut self, is_so: impl Fn(&Log) -> bool) -> Result<()> {
            let log = self.log.clone();
            self.fceux.wait_for("frame of the game", PATIENCE, || {
                let text = fs::read_to_string(&log).unwrap_or_default();
                Ok(is_so(&Log::parse(&text)?).then_some(()))
            })
        }
    }

    fn server(tools: &Tools, home: &Path) -> Result<(Process, String)> {
        let answer = home.join("display");
        let mut xvfb = Command::new(&tools.xvfb);
        xvfb.args(["-displayfd", "1", "-nolisten", "tcp", "-noreset"])
            .args(["-screen", "0", "320x300x16"]);
        let mut server = Process::start_answering("Xvfb", &mut xvfb, home, &answer)?;
        let number = server.wait_for("display number", PATIENCE, || {
            let text = fs::read_to_string(&answer).context("the display's number")?;
            Ok(text.strip_suffix('\n').map(str::to_owned))
        })?;
        Ok((server, format!(":{number}")))
    }
}
