//! The guest, as seen from the host.

use std::process::Command;
use std::sync::OnceLock;

use anyhow::{Context, Result, ensure};
use libtest_mimic::{Failed, Trial};

use crate::tools::all_required;

/// This is not a missing program: the default build has no gilrs.
const WITHOUT_GILRS: &str = "built without the feature gilrs";
const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scripts/run-in-guest.sh");

/// Settings of a guest.
#[derive(Clone, Copy, Debug)]
pub struct Guest {
    /// Whether udev runs in it.
    pub udev: bool,
    /// A module that is not loaded.
    pub without: Option<&'static str>,
    /// Time limit, s.
    pub timeout_s: u32,
}

impl Default for Guest {
    fn default() -> Self {
        Self {
            udev: false,
            without: None,
            timeout_s: 300,
        }
    }
}

impl Guest {
    /// Why no guest can run here, if so; checked once.
    pub fn needs() -> Result<(), String> {
        static NEEDS: OnceLock<Result<(), String>> = OnceLock::new();
        NEEDS
            .get_or_init(|| {
                let output = Command::new(SCRIPT)
                    .arg("--prepare")
                    .output()
                    .map_err(|error| format!("{SCRIPT}: {error}"))?;
                if output.status.success() {
                    return Ok(());
                }
                let said = String::from_utf8_lossy(&output.stderr);
                Err(said.lines().last().unwrap_or("no guest").to_owned())
            })
            .clone()
    }

    /// Runs a part of this program in the guest; fails unless it was successful.
    #[allow(dead_code)]
    pub fn inside(self, part: &str) -> Result<()> {
        let own = std::env::current_exe().context("which program is this?")?;
        let said = self.run(&[own.to_str().context("an odd path")?, "--inside", part])?;
        let Said { code, out, err } = &said;
        println!("{out}");
        let last = err.lines().last().unwrap_or_default();
        ensure!(*code == 0, "exit code {code}: {last}\n{out}\n{err}");
        Ok(())
    }

    /// Runs a command in the guest.
    pub fn run(self, command: &[&str]) -> Result<Said> {
        let mut run = Command::new(SCRIPT);
        if self.udev {
            run.arg("--udev");
        } else {
            // Without udev gilrs searches the devices itself.
            run.env("GILRS_DISABLE_UDEV", "1");
        }
        if let Some(module) = self.without {
            run.args(["--without", module]);
        }
        run.args(["--timeout", &self.timeout_s.to_string()]);
        Said::by(run.args(command))
    }
}

/// Exit code and output of a program.
#[derive(Clone, Debug)]
pub struct Said {
    pub code: i32,
    pub out: String,
    pub err: String,
}

impl Said {
    /// Runs a program to its end.
    pub fn by(command: &mut Command) -> Result<Self> {
        let output = command
            .output()
            .with_context(|| format!("{:?}", command.get_program()))?;
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim_end().to_owned();
        Ok(Self {
            code: output.status.code().context("killed")?,
            out: text(&output.stdout),
            err: text(&output.stderr),
        })
    }
}

/// Requirements of the trials with gilrs.
#[allow(dead_code)]
pub fn needs_gilrs() -> Result<(), String> {
    if cfg!(feature = "gilrs") {
        Guest::needs()
    } else {
        Err(WITHOUT_GILRS.to_owned())
    }
}

/// A trial, or an ignored one if something for it is missing.
pub fn trial(
    name: &str,
    needs: Result<(), String>,
    run: impl FnOnce() -> Result<()> + Send + 'static,
) -> Trial {
    match needs {
        Ok(()) => Trial::test(name, || {
            run().map_err(|error| Failed::from(format!("{error:#}")))
        }),
        Err(missing) => {
            let required = all_required() && missing != WITHOUT_GILRS;
            let reason = missing.clone();
            Trial::test(name, move || Err(Failed::from(missing)))
                .with_kind(reason)
                .with_ignored_flag(!required)
        }
    }
}
