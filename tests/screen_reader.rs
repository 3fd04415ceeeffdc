//! The window as a screen reader walks it over the accessibility bus (AT-SPI): names, roles, order, focus and actions of every view, and
//! what the pad says while it is pressed. `tests/gui/names.rs` checks the same tree, with every step of the setup, before it is sent.
//!
//! Needs the Debian packages xvfb, xdotool, dbus-daemon, at-spi2-core, gir1.2-atspi-2.0 and python3-gi; if one is missing, the trial is
//! ignored with the reason as its kind; with `GELPAD_TEST_ALL=1` it fails.
#![cfg(all(feature = "gui", target_os = "linux"))]

use std::path::Path;
use std::process::{Command, ExitCode};

use libtest_mimic::{Arguments, Failed, Trial};

const RUN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/screen_reader/run.sh");

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let missing = missing();
    let is_required = std::env::var_os("GELPAD_TEST_ALL").is_some_and(|value| value == "1");
    let name = "a_screen_reader_walks_every_view";
    let trial = match missing {
        Some(missing) if !is_required => Trial::test(name, || Ok(()))
            .with_kind(missing)
            .with_ignored_flag(true),
        _ => Trial::test(name, walk),
    };
    libtest_mimic::run(&arguments, vec![trial]).exit_code()
}

/// What is not installed, if anything.
fn missing() -> Option<String> {
    let runs = |program: &str, arguments: &[&str]| {
        let output = Command::new(program).args(arguments).output();
        output.is_ok_and(|output| output.status.success())
    };
    let found = [
        ("xvfb", runs("sh", &["-c", "command -v Xvfb"])),
        ("xdotool", runs("xdotool", &["--version"])),
        ("dbus-daemon", runs("dbus-run-session", &["--version"])),
        (
            "at-spi2-core",
            Path::new("/usr/libexec/at-spi-bus-launcher").exists(),
        ),
        (
            "gir1.2-atspi-2.0 or python3-gi",
            runs(
                "/usr/bin/python3",
                &["-c", "import gi; gi.require_version('Atspi', '2.0')"],
            ),
        ),
    ];
    let missing = found.iter().find(|(_, is_installed)| !is_installed);
    missing.map(|(package, _)| format!("not installed: {package}"))
}

fn walk() -> Result<(), Failed> {
    let output = Command::new("bash")
        .args([RUN, env!("CARGO_BIN_EXE_gelpad")])
        .output()
        .map_err(|error| format!("{RUN}: {error}"))?;
    let said = format!(
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    eprintln!("\n{}", String::from_utf8_lossy(&output.stdout));
    if !output.status.success() {
        return Err(said.into());
    }
    Ok(())
}
