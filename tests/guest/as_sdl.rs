//! The pad as read by SDL2, which most games use. The reader is written in C (`sdl.c`).

use std::io::{BufRead as _, BufReader, Lines};
use std::path::PathBuf;
use std::process::{Child, ChildStdout, Command, Stdio};

use anyhow::{Context as _, Result, bail, ensure};
use gelpad::platform::linux::uinput::Uinput;

use crate::host::Guest;
use crate::pad::{cases, send};

const SOURCE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/guest/sdl.c");
/// The library as games load it; its headers are not needed.
const LIBRARY: &str = "libSDL2-2.0.so.0";

pub fn needs() -> Result<(), String> {
    Guest::needs()?;
    build().map_err(|error| format!("{error:#}"))
}

fn reader() -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("sdl-reader")
}

pub fn build() -> Result<()> {
    let output = Command::new("cc")
        .args(["-O1", "-Wall", "-o"])
        .arg(reader())
        .args([SOURCE, &format!("-l:{LIBRARY}")])
        .output()
        .context("no C compiler `cc`")?;
    let said = String::from_utf8_lossy(&output.stderr);
    ensure!(
        output.status.success(),
        "not installed: {LIBRARY} ({})",
        said.lines().last().unwrap_or_default()
    );
    Ok(())
}

/// In the guest: acts on the pad and compares the reader's output.
pub fn read() -> Result<()> {
    let mut pad = Uinput::create()?;
    let mut reader = Reader::start()?;
    let name = reader.line()?;
    // Which of the two depends on the library's list of pads.
    ensure!(
        ["Xbox 360 Controller", "X360 Controller"].contains(&name.as_str()),
        "SDL2 takes the pad for a {name}"
    );
    for case in cases() {
        send(&mut pad, case.action)?;
        let (what, value) = case.sdl;
        let (line, expected) = (reader.line()?, format!("{what} {value}"));
        ensure!(
            line == expected,
            "{:?} came as {line} instead of {expected}",
            case.action
        );
    }
    drop(pad);
    let last = reader.line()?;
    ensure!(
        last == "gone",
        "the pad is unplugged, and SDL2 says: {last}"
    );
    println!("SDL2: {name}, {} changes", cases().len());
    Ok(())
}

struct Reader {
    child: Child,
    lines: Lines<BufReader<ChildStdout>>,
}

impl Reader {
    fn start() -> Result<Self> {
        let mut child = Command::new(reader())
            .stdout(Stdio::piped())
            .spawn()
            .context("the reader does not start")?;
        let stdout = child.stdout.take().context("the reader has no output")?;
        Ok(Self {
            child,
            lines: BufReader::new(stdout).lines(),
        })
    }

    fn line(&mut self) -> Result<String> {
        match self.lines.next() {
            Some(line) => Ok(line?),
            None => bail!("the reader ended"),
        }
    }
}

impl Drop for Reader {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
