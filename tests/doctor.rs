//! Provokes every fault that `gelpad doctor` reports: on real systems where possible (a kernel without the module, a user
//! without permission, a display without XTEST, ...), else in a folder that stands for a machine.
//!
//! A test that needs a missing program or virtual machine is ignored, with the reason as its kind; with
//! `GELPAD_TEST_ALL=1` it fails.

#[path = "game/process.rs"]
#[allow(dead_code)]
mod process;
#[path = "game/tools.rs"]
#[allow(dead_code)]
mod tools;

#[path = "guest/host.rs"]
mod host;

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, ExitCode};
use std::time::Duration;

use anyhow::{Context as _, Result, ensure};
use gelpad::doctor::linux::{Machine, run_checks};
use gelpad::doctor::{BoardAccess, CheckLine, CheckStatus};
use libtest_mimic::{Arguments, Trial};

use host::{Guest, Said, trial};
use process::Process;

const GELPAD: &str = env!("CARGO_BIN_EXE_gelpad");
const PATIENCE: Duration = Duration::from_secs(30);

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let xvfb = || {
        tools::program("Xvfb")
            .map(drop)
            .ok_or("not installed: Xvfb".to_owned())
    };
    let weston = tools::program("weston").map(drop);
    let trials: Vec<Trial> = vec![
        trial("no display", Ok(()), no_display),
        trial("a display that does not answer", Ok(()), silent_display),
        trial("a display without XTEST", xvfb(), || {
            on_xvfb(&["-extension", "XTEST"], |said| {
                wrong(said, "X11", "lacks XTEST", "without `-extension XTEST`")
            })
        }),
        trial("a display that accepts keys", xvfb(), || {
            on_xvfb(&[], |said| {
                ok(
                    said,
                    "X11",
                    "accepts keys (XTEST); delay to a program: median",
                )?;
                ensure!(said.code == 0, "exit code {}", said.code);
                Ok(())
            })
        }),
        trial(
            "a Wayland desktop without the protocol",
            weston.ok_or("not installed: weston".to_owned()),
            under_weston,
        ),
        trial("no module", Guest::needs(), no_module),
        trial("no permission", Guest::needs(), no_permission),
        trial("the rule is installed", Guest::needs(), install),
        trial("a test gamepad is read back", Guest::needs(), read_back),
        trial("a port in use, a slow adapter", Ok(()), board),
        trial("a machine without anything", Ok(()), nothing),
    ];
    libtest_mimic::run(&arguments, trials).exit_code()
}

/// Runs `gelpad doctor` without a desktop except for these environment variables.
fn doctor(variables: &[(&str, &str)]) -> Result<Said> {
    let mut command = Command::new(GELPAD);
    for name in ["DISPLAY", "WAYLAND_DISPLAY", "XDG_SESSION_TYPE"] {
        command.env_remove(name);
    }
    Said::by(command.arg("doctor").envs(variables.iter().copied()))
}

/// The line about a subject: status, finding, and fix if there is one.
fn line<'a>(said: &'a Said, subject: &str) -> Result<(&'a str, &'a str, Option<&'a str>)> {
    let mut lines = said.out.lines().peekable();
    while let Some(line) = lines.next() {
        let Some((word, rest)) = line.trim_start().split_once(' ') else {
            continue;
        };
        if let Some(found) = rest.trim_start().strip_prefix(subject) {
            let fix = lines
                .peek()
                .and_then(|next| next.trim_start().strip_prefix("-> "));
            return Ok((word, found.trim_start(), fix));
        }
    }
    anyhow::bail!("no line about {subject}:\n{}", said.out)
}

fn wrong(said: &Said, subject: &str, words: &str, fix: &str) -> Result<()> {
    let line = line(said, subject)?;
    ensure!(
        line.0 == "wrong" && line.1.contains(words) && line.2.is_some_and(|own| own.contains(fix)),
        "should be wrong: {line:?}"
    );
    Ok(())
}

fn ok(said: &Said, subject: &str, words: &str) -> Result<()> {
    let line = line(said, subject)?;
    ensure!(line.0 == "ok" && line.1.contains(words), "not ok: {line:?}");
    Ok(())
}

/// Without a desktop and without kernel devices nothing works, and the report says so.
fn no_display() -> Result<()> {
    let said = doctor(&[])?;
    let (word, found, _) = line(&said, "session")?;
    ensure!(
        word == "note" && found.contains("neither DISPLAY nor WAYLAND_DISPLAY"),
        "{found}"
    );
    for subject in ["X11", "Wayland"] {
        let (word, found, _) = line(&said, subject)?;
        ensure!(word == "note" && found.contains("is not set"), "{found}");
    }
    if Path::new("/dev/uinput").exists() {
        return Ok(());
    }
    ensure!(said.code == 1, "exit code {}", said.code);
    ensure!(
        said.err.contains("play would not work here"),
        "{}",
        said.err
    );
    Ok(())
}

fn silent_display() -> Result<()> {
    let said = doctor(&[
        ("DISPLAY", ":9999"),
        ("WAYLAND_DISPLAY", "/nowhere/wayland-1"),
    ])?;
    let fix = "from a terminal of the desktop";
    wrong(&said, "X11", "display :9999 does not answer", fix)?;
    wrong(&said, "Wayland", "/nowhere/wayland-1 does not answer", fix)
}

fn on_xvfb(arguments: &[&str], check: impl Fn(&Said) -> Result<()>) -> Result<()> {
    let folder = tempfile::tempdir()?;
    let answer = folder.path().join("display");
    let mut xvfb = Command::new(tools::program("Xvfb").context("no Xvfb")?);
    xvfb.args(["-displayfd", "1", "-nolisten", "tcp", "-noreset"])
        .args(arguments);
    let mut server = Process::start_answering("Xvfb", &mut xvfb, folder.path(), &answer)?
        .with_grace(Duration::ZERO);
    let number = server.wait_for("display number", PATIENCE, || {
        Ok(fs::read_to_string(&answer)?
            .strip_suffix('\n')
            .map(str::to_owned))
    })?;
    check(&doctor(&[("DISPLAY", &format!(":{number}"))])?)
}

fn under_weston() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let runtime = folder.path().to_str().context("a path")?;
    let mut weston = Command::new(tools::program("weston").context("no weston")?);
    weston.env("XDG_RUNTIME_DIR", runtime).args([
        "--backend=headless-backend.so",
        "--socket=wayland-7",
        "--idle-time=0",
    ]);
    let mut weston = Process::start("weston", &mut weston, folder.path())?;
    let socket = folder.path().join("wayland-7");
    weston.wait_for("socket", PATIENCE, || Ok(socket.exists().then_some(())))?;
    let said = doctor(&[
        ("WAYLAND_DISPLAY", "wayland-7"),
        ("XDG_RUNTIME_DIR", runtime),
    ])?;
    wrong(
        &said,
        "Wayland",
        "does not let programs press keys",
        "--install-rule",
    )
}

/// The module exists and is not loaded; the reported command fixes it.
fn no_module() -> Result<()> {
    let guest = Guest {
        without: Some("uinput"),
        ..Guest::default()
    };
    let said = guest.run(&[GELPAD, "doctor"])?;
    wrong(
        &said,
        "kernel module",
        "uinput is not loaded",
        "sudo modprobe uinput",
    )?;
    wrong(
        &said,
        "/dev/uinput",
        "missing",
        "fix the kernel module first",
    )?;
    ensure!(said.code == 1, "exit code {}", said.code);
    let fixed = guest.run(&["sh", "-c", &format!("modprobe uinput && {GELPAD} doctor")])?;
    ok(&fixed, "kernel module", "uinput is loaded")?;
    ensure!(fixed.code == 0, "exit code {}\n{}", fixed.code, fixed.out);
    Ok(())
}

const NOBODY: [&str; 4] = [
    "setpriv",
    "--reuid=nobody",
    "--regid=nogroup",
    "--clear-groups",
];

fn no_permission() -> Result<()> {
    let said = Guest::default().run(&[&NOBODY[..], &[GELPAD, "doctor"]].concat())?;
    wrong(
        &said,
        "/dev/uinput",
        "no write permission (root:root 600)",
        "--install-rule",
    )?;
    let (word, found, _) = line(&said, "test gamepad")?;
    ensure!(word == "note" && found.contains("skipped"), "{found}");
    let (word, _, fix) = line(&said, "group dialout")?;
    let fix = fix.unwrap_or_default();
    ensure!(
        word == "note" && fix.contains("usermod -aG dialout nobody"),
        "{fix}"
    );
    ensure!(said.code == 1, "exit code {}", said.code);
    // The installation needs root, and prints what it would write.
    let install = [&NOBODY[..], &[GELPAD, "doctor", "--install-rule"]].concat();
    let said = Guest::default().run(&install)?;
    ensure!(
        said.code == 1 && said.err.contains("only root can"),
        "{}",
        said.err
    );
    ensure!(said.out.contains("70-gelpad.rules"), "{}", said.out);
    Ok(())
}

/// The rule is written where udev reads it, and udev applies it.
fn install() -> Result<()> {
    let guest = Guest {
        udev: true,
        ..Guest::default()
    };
    let commands = format!(
        "{GELPAD} doctor --install-rule && udevadm settle && udevadm info /dev/uinput && {GELPAD} doctor"
    );
    let said = guest.run(&["sh", "-c", &commands])?;
    ensure!(
        said.code == 0,
        "exit code {}\n{}\n{}",
        said.code,
        said.out,
        said.err
    );
    ensure!(
        said.out
            .contains("This writes /etc/udev/rules.d/70-gelpad.rules"),
        "{}",
        said.out
    );
    ensure!(
        said.out.contains(":uaccess:"),
        "udev did not tag it:\n{}",
        said.out
    );
    ok(&said, "udev rule", "/etc/udev/rules.d/70-gelpad.rules")
}

fn read_back() -> Result<()> {
    let said = Guest::default().run(&[GELPAD, "doctor"])?;
    println!("{}", said.out);
    ok(&said, "/dev/uinput", "writable")?;
    ok(&said, "test gamepad", "read back; write to read: median")?;
    if cfg!(feature = "gilrs") {
        ok(
            &said,
            "seen by games",
            "15 buttons, 2 sticks and 2 triggers (gilrs)",
        )?;
    }
    ensure!(said.code == 0, "exit code {}", said.code);
    Ok(())
}

/// The port of a board behind an FTDI adapter, in use by brltty; ModemManager runs.
fn board() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let write = |path: &str, text: &str| -> Result<()> {
        let path = folder.path().join(path);
        fs::create_dir_all(path.parent().context("a folder")?)?;
        Ok(fs::write(path, text)?)
    };
    write("sys/class/tty/ttyUSB0/dev", "188:0\n")?;
    write("sys/class/tty/ttyS0/dev", "4:64\n")?;
    write("dev/ttyUSB0", "")?;
    write("sys/bus/usb-serial/devices/ttyUSB0/latency_timer", "16\n")?;
    write("proc/812/comm", "brltty\n")?;
    write("proc/4711/comm", "ModemManager\n")?;
    fs::create_dir_all(folder.path().join("proc/812/fd"))?;
    symlink("/dev/ttyUSB0", folder.path().join("proc/812/fd/3"))?;
    let report = run_checks(&Machine::at_root(folder.path(), &[]));
    let about = |subject: &str| -> Result<CheckLine> {
        let mut lines = report.sections.iter().flat_map(|section| &section.lines);
        let line = lines.find(|line| line.subject.starts_with(subject));
        line.cloned()
            .with_context(|| format!("nothing about {subject}"))
    };
    let port = about("/dev/ttyUSB0")?;
    ensure!(
        port.state == CheckStatus::Wrong
            && port.found.ends_with("in use by brltty (process 812)")
            && port.fix.as_deref() == Some("sudo apt remove brltty"),
        "{port:?}"
    );
    let grabber = about("ModemManager")?;
    ensure!(grabber.state == CheckStatus::Note, "{grabber:?}");
    let adapter = about("ttyUSB0 (FTDI)")?;
    ensure!(
        adapter.state == CheckStatus::Wrong && adapter.found.contains("16 ms"),
        "{adapter:?}"
    );
    ensure!(
        about("/dev/ttyS0").is_err(),
        "a port of the mainboard is not a board"
    );
    ensure!(report.boards == BoardAccess::Unreadable && !report.can_play());
    Ok(())
}

/// On an empty machine nothing works, and nothing panics.
fn nothing() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let report = run_checks(&Machine::at_root(folder.path(), &[]));
    ensure!(!report.can_play() && report.outputs.is_empty());
    let lines = report.sections.iter().flat_map(|section| &section.lines);
    for line in lines.filter(|line| line.state == CheckStatus::Wrong) {
        ensure!(line.fix.is_some(), "wrong without a fix: {line:?}");
    }
    Ok(())
}
