//! The stage: its own X server, and on it the emulator with the game.

use std::env;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread;
use std::time::Duration;

use anyhow::{Context, Result};
use tempfile::TempDir;

use crate::log::Log;
use crate::process::Process;
use crate::script::Script;
use crate::server::{PATIENCE, start_server};
use crate::tools::Tools;

const GAME: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/game/jump.s");
const LINKER_CONFIG: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/game/nrom.cfg");
const LOG_SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/game/log.lua");

/// The game continues after gelpad until the last jump has ended.
const JUMP_END_WAIT: Duration = Duration::from_secs(1);
/// Time for the window to start: on a new machine it solves the pad's response table first.
#[cfg(feature = "gui")]
const WINDOW_STARTS: Duration = Duration::from_secs(6);
/// In the window of 1280 x 800 points: the button that sends keys to the game, and the one that opens the
/// pad's own window.
#[cfg(feature = "gui")]
const SEND: (&str, &str) = ("853", "33");
#[cfg(feature = "gui")]
const PAD_WINDOW: (&str, &str) = ("1130", "181");
/// In the pad's own window: the jump region.
#[cfg(feature = "gui")]
const PAD_JUMP: (&str, &str) = ("239", "168");
/// Number of frames before play starts: the game draws itself in three.
const WARM_UP_FRAMES: usize = 60;

/// Fields are dropped in this order: emulator, server, folder.
#[derive(Debug)]
pub struct Stage {
    emulator: Process,
    _server: Process,
    display: OsString,
    log: PathBuf,
    folder: TempDir,
}

impl Stage {
    /// Returns when the game runs and has the keyboard focus.
    pub fn start(tools: &Tools) -> Result<Self> {
        let folder = tempfile::tempdir().context("cannot create a folder for the test")?;
        let game = assemble(tools, folder.path())?;
        let (server, display) = start_server(&tools.xvfb, folder.path())?;
        let log = folder.path().join("log.csv");
        let emulator = start_emulator(tools, folder.path(), &display, &game, &log)?;
        let mut stage = Self {
            emulator,
            _server: server,
            display,
            log,
            folder,
        };
        stage.wait_for_game()?;
        stage.focus(tools)?;
        Ok(stage)
    }

    /// Lets gelpad play the script; returns the log of that time.
    pub fn play(&mut self, profile: &str, script: &Script) -> Result<Log> {
        let file = self.folder.path().join("touches.txt");
        fs::write(&file, script.to_string()).context("cannot write the touch script")?;
        let mut source = OsString::from("simulated:");
        source.push(&file);
        let seen = read_log(&self.log)?.frames().len();

        let gelpad = Process::start(
            "gelpad",
            command(gelpad(), self.folder.path(), &self.display)
                .args(["play", profile, "--source"])
                .arg(source)
                .args(["--output", "keyboard", "--headless", "--seed", "1"]),
            self.folder.path(),
        )?;
        gelpad.succeed(Duration::from_millis(script.end_ms().into()) + PATIENCE)?;

        thread::sleep(JUMP_END_WAIT);
        Ok(read_log(&self.log)?.skip(seen))
    }

    /// Presses the jump region of the window's small pad with the mouse while the emulator has the keyboard
    /// focus; returns the log of that time.
    #[cfg(feature = "gui")]
    pub fn play_in_window(&mut self, tools: &Tools, presses_ms: &[u32]) -> Result<Log> {
        let mut gelpad = Process::start(
            "gelpad",
            command(gelpad(), self.folder.path(), &self.display)
                .env("XDG_CONFIG_HOME", self.folder.path())
                .env("LIBGL_ALWAYS_SOFTWARE", "1")
                .env_remove("WAYLAND_DISPLAY"),
            self.folder.path(),
        )?;
        let search = ["search", "--sync", "--onlyvisible", "--name"];
        let window = ["^gelpad$", "windowmove", "0", "0"];
        self.xdotool(tools, &[&search[..], &window].concat())?;
        thread::sleep(WINDOW_STARTS);
        for (x, y) in [SEND, PAD_WINDOW] {
            self.xdotool(tools, &["mousemove", x, y, "click", "1"])?;
            thread::sleep(JUMP_END_WAIT);
        }
        self.xdotool(tools, &[&search[..], &["^gelpad pad$"]].concat())?;
        self.focus(tools)?;
        thread::sleep(JUMP_END_WAIT);
        let seen = read_log(&self.log)?.frames().len();
        let jump = [
            "^gelpad pad$",
            "mousemove",
            "--window",
            "%1",
            PAD_JUMP.0,
            PAD_JUMP.1,
        ];
        self.xdotool(tools, &[&search[..], &jump].concat())?;
        for press_ms in presses_ms {
            self.xdotool(tools, &["mousedown", "1"])?;
            thread::sleep(Duration::from_millis((*press_ms).into()));
            self.xdotool(tools, &["mouseup", "1"])?;
            thread::sleep(JUMP_END_WAIT);
        }
        thread::sleep(JUMP_END_WAIT);
        gelpad.wait_for("the end of the presses", PATIENCE, || Ok(Some(())))?;
        Ok(read_log(&self.log)?.skip(seen))
    }

    #[cfg(feature = "gui")]
    fn xdotool(&self, tools: &Tools, words: &[&str]) -> Result<()> {
        let mut xdotool = command(&tools.xdotool, self.folder.path(), &self.display);
        Process::start("xdotool", xdotool.args(words), self.folder.path())?.succeed(PATIENCE)
    }

    /// The last lines of the emulator's messages.
    pub fn emulator_messages(&self) -> String {
        self.emulator.to_string()
    }

    fn wait_for_game(&mut self) -> Result<()> {
        let log = &self.log;
        self.emulator.wait_for("frame of the game", PATIENCE, || {
            Ok((read_log(log)?.frames().len() > WARM_UP_FRAMES).then_some(()))
        })
    }

    /// Without a window manager no window gets the keyboard focus automatically.
    fn focus(&self, tools: &Tools) -> Result<()> {
        let mut xdotool = command(&tools.xdotool, self.folder.path(), &self.display);
        xdotool.args(["search", "--sync", "--onlyvisible", "--class", "fceux"]);
        xdotool.args(["windowfocus", "--sync"]);
        Process::start("xdotool", &mut xdotool, self.folder.path())?
            .succeed(PATIENCE)
            .context("cannot give the emulator the keyboard")
    }
}

/// The binary under test; `GELPAD_BIN` replaces it.
fn gelpad() -> OsString {
    env::var_os("GELPAD_BIN").unwrap_or_else(|| env!("CARGO_BIN_EXE_gelpad").into())
}

fn assemble(tools: &Tools, folder: &Path) -> Result<PathBuf> {
    let (object, game) = (folder.join("jump.o"), folder.join("jump.nes"));
    let mut ca65 = Command::new(&tools.ca65);
    ca65.arg(GAME).arg("-o").arg(&object);
    Process::start("ca65", &mut ca65, folder)?.succeed(PATIENCE)?;
    let mut ld65 = Command::new(&tools.ld65);
    ld65.arg("-C")
        .arg(LINKER_CONFIG)
        .arg(&object)
        .arg("-o")
        .arg(&game);
    Process::start("ld65", &mut ld65, folder)?.succeed(PATIENCE)?;
    Ok(game)
}

fn start_emulator(
    tools: &Tools,
    folder: &Path,
    display: &OsStr,
    game: &Path,
    log: &Path,
) -> Result<Process> {
    let mut fceux = command(&tools.fceux, folder, display);
    fceux
        .env("QT_QPA_PLATFORM", "xcb")
        .env("GELPAD_GAME_LOG", log)
        .args(["--no-config", "1", "--sound", "0"])
        .args(["--loadlua", LOG_SCRIPT])
        .arg(game);
    Process::start("fceux", &mut fceux, folder)
}

/// A command on the stage's display, without user settings.
fn command(program: impl AsRef<OsStr>, home: &Path, display: &OsStr) -> Command {
    let mut command = Command::new(program);
    command
        .env("DISPLAY", display)
        .env("HOME", home)
        .env("XDG_RUNTIME_DIR", home)
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("XAUTHORITY")
        .env_remove("XDG_CONFIG_HOME")
        .env_remove("XDG_DATA_HOME");
    command
}

/// Empty while there is no log.
fn read_log(file: &Path) -> Result<Log> {
    let text = match fs::read_to_string(file) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
        text => text.with_context(|| format!("cannot read {}", file.display()))?,
    };
    Log::parse(&text)
}
