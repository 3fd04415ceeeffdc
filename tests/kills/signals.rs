//! Every signal, a reader that goes away, and every way to lose a terminal, while a key is held: the key comes up, and the exit
//! status says what ended gelpad.
//!
//! `GELPAD_SIGNALS` sets how many trials of each there are (default: one); `scripts/adversary.sh` does 30.

use std::fs::{File, Permissions};
use std::io::Read as _;
use std::os::unix::fs::PermissionsExt as _;
use std::os::unix::process::ExitStatusExt as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, ensure};
use rustix::process::{Pid, Signal, kill_process};

use crate::gelpad::{Gelpad, one_hold, watcher_processes};
use crate::server::PATIENCE;
use crate::{RELEASED, Stage};

/// Signals that gelpad ends by, with 128 and their number.
pub const HANDLED: [Signal; 5] = [
    Signal::INT,
    Signal::TERM,
    Signal::HUP,
    Signal::QUIT,
    Signal::XCPU,
];
/// Signals that end it wherever it is.
pub const FATAL: [Signal; 7] = [
    Signal::KILL,
    Signal::ABORT,
    Signal::SEGV,
    Signal::BUS,
    Signal::FPE,
    Signal::ILL,
    Signal::SYS,
];
/// Where a shell writes the exit status of gelpad in a terminal.
const STATUS: &str = "status";

fn trials() -> usize {
    let text = std::env::var("GELPAD_SIGNALS").ok();
    text.and_then(|text| text.parse().ok()).unwrap_or(1)
}

/// Repeats a trial and reports how many held.
fn repeat(name: &str, one: impl Fn() -> Result<()>) -> Result<()> {
    let mut failures = Vec::new();
    for _ in 0..trials() {
        if let Err(error) = one() {
            failures.push(format!("{error:#}"));
        }
    }
    eprintln!("{name}: {} trials, {} failed", trials(), failures.len());
    ensure!(failures.is_empty(), "{name}: {failures:?}");
    Ok(())
}

pub fn each_signal(stage: &Stage) -> Result<()> {
    for signal in HANDLED {
        repeat(&format!("{signal:?}"), || {
            let status = ended_by(stage, signal)?;
            let expected = Some(128 + signal.as_raw());
            ensure!(status.code() == expected, "{status}");
            Ok(())
        })?;
    }
    for signal in FATAL {
        repeat(&format!("{signal:?}"), || {
            let status = ended_by(stage, signal)?;
            ensure!(status.signal() == Some(signal.as_raw()), "{status}");
            Ok(())
        })?;
    }
    Ok(())
}

fn ended_by(stage: &Stage, signal: Signal) -> Result<std::process::ExitStatus> {
    let mut gelpad = stage.play(&one_hold())?;
    stage.display.wait(true, PATIENCE)?;
    gelpad.signal(signal)?;
    let status = gelpad.ended(PATIENCE)?;
    stage.display.wait(false, RELEASED)?;
    Ok(status)
}

/// Pipes whose reader is gone, and the signal of such a pipe, do not end play; the next TERM does.
pub fn closed_pipes(stage: &Stage) -> Result<()> {
    repeat("PIPE", || {
        let mut child = command(stage)?
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()?;
        stage.display.wait(true, PATIENCE)?;
        drop((child.stdout.take(), child.stderr.take()));
        kill_process(Pid::from_child(&child), Signal::PIPE)?;
        std::thread::sleep(Duration::from_millis(100));
        ensure!(!stage.display.down()?.is_empty(), "the key came up");
        let mut gelpad = Gelpad { child };
        gelpad.signal(Signal::TERM)?;
        let status = gelpad.ended(PATIENCE)?;
        ensure!(status.code() == Some(143), "{status}");
        stage.display.wait(false, RELEASED).map(drop)
    })
}

/// The second watcher asks for a scope where there is a systemd, and works although the answer never comes.
pub fn scope_of_a_watcher(stage: &Stage) -> Result<()> {
    let folder = stage.folder.path();
    let asked = folder.join("asked");
    std::fs::create_dir_all(folder.join("systemd/private"))?;
    let tool = folder.join("busctl");
    let script = format!(
        "#!/bin/sh\necho \"$*\" >{}\nexec sleep 5\n",
        asked.display()
    );
    std::fs::write(&tool, script)?;
    std::fs::set_permissions(&tool, Permissions::from_mode(0o700))?;
    let path = std::env::var("PATH")?;
    let child = command(stage)?
        .env("PATH", format!("{}:{path}", folder.display()))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()?;
    let mut gelpad = Gelpad { child };
    stage.display.wait(true, PATIENCE)?;
    let guards = watcher_processes(&stage.display.name, &["guard"]);
    let guard = guards.first().context("no second watcher")?;
    let start = Instant::now();
    let text = loop {
        match std::fs::read_to_string(&asked) {
            Ok(text) if text.ends_with('\n') => break text,
            _ => ensure!(start.elapsed() < PATIENCE, "nothing was asked"),
        }
        std::thread::sleep(Duration::from_millis(10));
    };
    let wanted = format!("gelpad-guard-{guard}.scope fail 1 PIDs au 1 {guard} 0");
    ensure!(text.trim().ends_with(&wanted), "asked for {text}");
    kill_process(Pid::from_raw(*guard).context("a process")?, Signal::KILL)?;
    gelpad.signal(Signal::KILL)?;
    gelpad.ended(PATIENCE)?;
    stage.display.wait(false, RELEASED).map(drop)
}

/// The terminal's program is killed, as an emulator or a connection by ssh would be.
pub fn killed_emulator(stage: &Stage) -> Result<()> {
    repeat("terminal killed", || {
        let mut terminal = in_terminal(stage)?;
        stage.display.wait(true, PATIENCE)?;
        terminal.kill()?;
        terminal.wait()?;
        hung_up(stage)
    })
}

/// The shell that started gelpad is killed; the terminal stays.
pub fn killed_shell(stage: &Stage) -> Result<()> {
    repeat("shell killed", || {
        let mut terminal = in_terminal(stage)?;
        stage.display.wait(true, PATIENCE)?;
        let gelpad = playing(stage)?;
        kill_process(parent_of(gelpad)?, Signal::KILL)?;
        let released = stage.display.wait(false, RELEASED);
        terminal.kill()?;
        terminal.wait()?;
        released.map(drop)
    })
}

/// The server of tmux ends.
pub fn killed_tmux(stage: &Stage) -> Result<()> {
    repeat("tmux killed", || {
        let socket = stage.folder.path().join("tmux");
        let tmux = || {
            let mut tmux = Command::new("tmux");
            tmux.arg("-S").arg(&socket).args(["-f", "/dev/null"]);
            in_environment(stage, tmux)
        };
        let shell = shell_line(stage)?;
        let started = tmux()
            .args(["new-session", "-d", "sh", "-c", &shell])
            .status()?;
        ensure!(started.success(), "tmux: {started}");
        stage.display.wait(true, PATIENCE)?;
        ensure!(tmux().arg("kill-server").status()?.success(), "not ended");
        hung_up(stage)
    })
}

pub fn no_tmux() -> Option<String> {
    let found = Command::new("tmux").arg("-V").output();
    found.is_err().then(|| "not installed: tmux".to_owned())
}

/// Waits until the key is up and the shell has noted that gelpad ended by a hangup.
fn hung_up(stage: &Stage) -> Result<()> {
    stage.display.wait(false, RELEASED)?;
    let file = stage.folder.path().join(STATUS);
    let start = Instant::now();
    loop {
        let mut status = String::new();
        if let Ok(mut file) = File::open(&file) {
            file.read_to_string(&mut status)?;
        }
        if !status.trim().is_empty() {
            ensure!(status.trim() == "129", "exit status {status}");
            return Ok(());
        }
        ensure!(start.elapsed() < PATIENCE, "gelpad has not ended");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// gelpad in a shell on a terminal of its own.
fn in_terminal(stage: &Stage) -> Result<Child> {
    let mut script = Command::new("script");
    script
        .args(["--quiet", "--return", "--command"])
        .arg(shell_line(stage)?)
        .arg("/dev/null")
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    in_environment(stage, script)
        .env("SHELL", "/bin/sh")
        .spawn()
        .context("script")
}

/// A line for a shell that outlives the hangup and notes the exit status of gelpad.
fn shell_line(stage: &Stage) -> Result<String> {
    let folder = stage.folder.path();
    let status = folder.join(STATUS);
    if status.exists() {
        std::fs::remove_file(&status)?;
    }
    let words: Vec<String> = std::iter::once(env!("CARGO_BIN_EXE_gelpad").to_owned())
        .chain(arguments(folder)?)
        .collect();
    let (command, status) = (words.join(" "), status.display().to_string());
    Ok(format!("trap : HUP; {command}; echo $? >{status}"))
}

fn arguments(folder: &Path) -> Result<Vec<String>> {
    let file = folder.join("touches.txt");
    std::fs::write(&file, one_hold())?;
    let source = format!("simulated:{}", file.display());
    let words = ["play", "--source", &source, "--output", "keyboard"];
    Ok(words.map(str::to_owned).to_vec())
}

fn command(stage: &Stage) -> Result<Command> {
    let mut gelpad = Command::new(env!("CARGO_BIN_EXE_gelpad"));
    gelpad
        .args(arguments(stage.folder.path())?)
        .stdin(Stdio::null());
    Ok(in_environment(stage, gelpad))
}

fn in_environment(stage: &Stage, mut command: Command) -> Command {
    command
        .env("DISPLAY", &stage.display.name)
        .env("XDG_RUNTIME_DIR", stage.folder.path())
        .env("TERM", "xterm")
        .env_remove("TMUX")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("XAUTHORITY");
    command
}

/// The process that plays on the display.
fn playing(stage: &Stage) -> Result<i32> {
    let pids = watcher_processes(&stage.display.name, &["play"]);
    pids.first().copied().context("no gelpad plays")
}

fn parent_of(pid: i32) -> Result<Pid> {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat"))?;
    // After the name in brackets: state, parent.
    let (_, rest) = stat.rsplit_once(')').context("a name")?;
    let parent = rest.split_whitespace().nth(1).context("a parent")?;
    Pid::from_raw(parent.parse()?).context("a process")
}
