//! Every fault that the doctor names, provoked: with the real thing where it can be had (a kernel without the module, a
//! user without permission, a display without XTEST, ...), else with a folder that stands for a machine.
//!
//! What needs a program or a guest that is missing is ignored, and its kind says why; with `GELPAD_TEST_ALL=1` it fails.

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
use gelpad::doctor::{Boards, Line, Machine, State, examine};
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
        trial("a display that takes keys", xvfb(), || {
            on_xvfb(&[], |said| {
                ok(said, "X11", "takes keys (XTEST); press to reader: median")?;
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
        trial("a port that is held, an adapter that waits", Ok(()), board),
        trial("a machine without anything", Ok(()), nothing),
    ];
    libtest_mimic::run(&arguments, trials).exit_code()
}

/// The doctor, here, without a desktop but for what is set.
fn doctor(settings: &[(&str, &str)]) -> Result<Said> {
    let mut command = Command::new(GELPAD);
    for name in ["DISPLAY", "WAYLAND_DISPLAY", "XDG_SESSION_TYPE"] {
        command.env_remove(name);
    }
    Said::by(command.arg("doctor").envs(settings.iter().copied()))
}

/// The line about something: its word, what was found, and what mends it, if anything does.
fn line<'a>(said: &'a Said, subject: &str) -> Result<(&'a str, &'a str, Option<&'a str>)> {
    let mut lines = said.out.lines().peekable();
    while let Some(line) = lines.next() {
        let Some((word, rest)) = line.trim_start().split_once(' ') else {
            continue;
        };
        if let Some(found) = rest.trim_start().strip_prefix(subject) {
            let mend = lines
                .peek()
                .and_then(|next| next.trim_start().strip_prefix("-> "));
            return Ok((word, found.trim_start(), mend));
        }
    }
    anyhow::bail!("no line about {subject}:\n{}", said.out)
}

fn wrong(said: &Said, subject: &str, words: &str, mend: &str) -> Result<()> {
    let line = line(said, subject)?;
    ensure!(
        line.0 == "wrong" && line.1.contains(words) && line.2.is_some_and(|own| own.contains(mend)),
        "not wrong as it should be: {line:?}"
    );
    Ok(())
}

fn ok(said: &Said, subject: &str, words: &str) -> Result<()> {
    let line = line(said, subject)?;
    ensure!(line.0 == "ok" && line.1.contains(words), "not ok: {line:?}");
    Ok(())
}

/// Without a desktop and without the kernel's devices nothing plays, and that is said.
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
    let mend = "from a terminal of the desktop";
    wrong(&said, "X11", "the display :9999 does not answer", mend)?;
    wrong(&said, "Wayland", "/nowhere/wayland-1 does not answer", mend)
}

fn on_xvfb(arguments: &[&str], judge: impl Fn(&Said) -> Result<()>) -> Result<()> {
    let folder = tempfile::tempdir()?;
    let answer = folder.path().join("display");
    let mut xvfb = Command::new(tools::program("Xvfb").context("no Xvfb")?);
    xvfb.args(["-displayfd", "1", "-nolisten", "tcp"])
        .args(arguments);
    let mut server = Process::start_answering("Xvfb", &mut xvfb, folder.path(), &answer)?
        .with_grace(Duration::ZERO);
    let number = server.wait_for("display number", PATIENCE, || {
        Ok(fs::read_to_string(&answer)?
            .strip_suffix('\n')
            .map(str::to_owned))
    })?;
    judge(&doctor(&[("DISPLAY", &format!(":{number}"))])?)
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
        "lets no program press keys",
        "--install-rule",
    )
}

/// The module is there and not loaded; the command that is named mends it.
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
    wrong(&said, "/dev/uinput", "not there", "see the kernel module")?;
    ensure!(said.code == 1, "exit code {}", said.code);
    let mended = guest.run(&["sh", "-c", &format!("modprobe uinput && {GELPAD} doctor")])?;
    ok(&mended, "kernel module", "uinput is loaded")?;
    ensure!(
        mended.code == 0,
        "exit code {}\n{}",
        mended.code,
        mended.out
    );
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
        "not yours to write (root:root 600)",
        "--install-rule",
    )?;
    let (word, found, _) = line(&said, "test gamepad")?;
    ensure!(word == "note" && found.contains("not tried"), "{found}");
    let (word, _, mend) = line(&said, "group dialout")?;
    let mend = mend.unwrap_or_default();
    ensure!(
        word == "note" && mend.contains("usermod -aG dialout nobody"),
        "{mend}"
    );
    ensure!(said.code == 1, "exit code {}", said.code);
    // What is named asks for root, and says what it would have done.
    let install = [&NOBODY[..], &[GELPAD, "doctor", "--install-rule"]].concat();
    let said = Guest::default().run(&install)?;
    ensure!(
        said.code == 1 && said.err.contains("only root may"),
        "{}",
        said.err
    );
    ensure!(said.out.contains("70-gelpad.rules"), "{}", said.out);
    Ok(())
}

/// The rule is written where udev reads it, and udev then does what it says.
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
    ok(&said, "/dev/uinput", "yours to write")?;
    ok(&said, "test gamepad", "read back; write to read: median")?;
    if cfg!(feature = "gilrs") {
        ok(
            &said,
            "seen by a game",
            "15 buttons, 2 sticks and 2 triggers (gilrs)",
        )?;
    }
    ensure!(said.code == 0, "exit code {}", said.code);
    Ok(())
}

/// A board's port that brltty holds, by an adapter of FTDI; ModemManager runs.
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
    let report = examine(&Machine::under(folder.path(), &[]));
    let about = |subject: &str| -> Result<Line> {
        let mut lines = report.sections.iter().flat_map(|section| &section.lines);
        let line = lines.find(|line| line.subject.starts_with(subject));
        line.cloned()
            .with_context(|| format!("nothing about {subject}"))
    };
    let port = about("/dev/ttyUSB0")?;
    ensure!(
        port.state == State::Wrong
            && port.found.ends_with("held by brltty (process 812)")
            && port.mend.as_deref() == Some("sudo apt remove brltty"),
        "{port:?}"
    );
    let grabber = about("ModemManager")?;
    ensure!(grabber.state == State::Note, "{grabber:?}");
    let adapter = about("ttyUSB0 (FTDI)")?;
    ensure!(
        adapter.state == State::Wrong && adapter.found.contains("16 ms"),
        "{adapter:?}"
    );
    ensure!(
        about("/dev/ttyS0").is_err(),
        "a port of the mainboard is no board"
    );
    ensure!(report.boards == Boards::Unreadable && !report.plays());
    Ok(())
}

/// A folder with nothing in it is a machine that cannot play, and no reason to panic.
fn nothing() -> Result<()> {
    let folder = tempfile::tempdir()?;
    let report = examine(&Machine::under(folder.path(), &[]));
    ensure!(!report.plays() && report.outputs.is_empty());
    let lines = report.sections.iter().flat_map(|section| &section.lines);
    for line in lines.filter(|line| line.state == State::Wrong) {
        ensure!(line.mend.is_some(), "wrong, and nothing mends it: {line:?}");
    }
    Ok(())
}
