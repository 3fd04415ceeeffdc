//! The guest, from outside.

use std::process::Command;
use std::sync::OnceLock;

use anyhow::{Context, Result, ensure};
use libtest_mimic::{Failed, Trial};

use crate::tools::all_required;

/// Nothing is missing then: the default build has no gilrs.
const WITHOUT_GILRS: &str = "built without the feature gilrs";
const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scripts/run-in-guest.sh");

/// How a guest is to be.
#[derive(Clone, Copy, Debug, Default)]
pub struct Guest {
    /// udev runs in it.
    pub udev: bool,
}

impl Guest {
    /// What keeps a guest from running here, if anything does: asked once.
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

    /// Runs a part of this program in it.
    pub fn inside(self, part: &str) -> Result<()> {
        let own = std::env::current_exe().context("which program is this?")?;
        self.run(&[own.to_str().context("an odd path")?, "--inside", part])
    }

    /// Runs a command in it; its exit code must be 0.
    pub fn run(self, command: &[&str]) -> Result<()> {
        let mut run = Command::new(SCRIPT);
        if self.udev {
            run.arg("--udev");
        } else {
            // Without it gilrs looks for devices by itself.
            run.env("GILRS_DISABLE_UDEV", "1");
        }
        run.args(["--share", env!("CARGO_TARGET_TMPDIR")]);
        let output = run.args(command).output().context(SCRIPT)?;
        let said = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim_end().to_owned();
        let (out, err) = (said(&output.stdout), said(&output.stderr));
        println!("{out}");
        ensure!(output.status.success(), "{}\n{out}\n{err}", output.status);
        Ok(())
    }
}

/// What the trials about gilrs need.
pub fn needs_gilrs() -> Result<(), String> {
    if cfg!(feature = "gilrs") {
        Guest::needs()
    } else {
        Err(WITHOUT_GILRS.to_owned())
    }
}

/// A trial, or an ignored one where something for it is missing.
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
