//! `gelpad accuracy`: what a pad's sensing can do.

use std::fs;
use std::io::Write as _;

use anyhow::Context as _;

use super::args::AccuracyArgs;
use super::exit::Ending;
use super::{progress, resolve};
use crate::study::accuracy::{Accuracy, Settings};
use crate::study::job;

pub(super) fn run(args: &AccuracyArgs) -> anyhow::Result<Ending> {
    let pad = resolve::pad(&args.pad)?;
    let method = args.method.or(pad.method).unwrap_or_default();
    // A folder that cannot be made is told before a minute of solving, not after.
    fs::create_dir_all(&args.out).with_context(|| args.out.display().to_string())?;
    let sensing = resolve::sensing(&pad, method)?;
    let settings = Settings {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        pad_argument: args.pad.clone(),
        method,
        snr_db: args.snr.clone(),
        seed: args.seed,
        quick: args.quick,
        pad,
    };
    let study = Accuracy::new(settings, sensing)?;
    let bar = progress::bar();
    let outcomes = job::side_by_side(
        study.cases(),
        |case| study.solve(case),
        progress::tell(&bar),
    )?;
    bar.finish_and_clear();
    let findings = study.findings(&outcomes);
    let report = study.report(&findings)?;
    job::write_whole(&args.out, "accuracy.json", findings.json()?.as_bytes())?;
    report.write(&args.out)?;
    write!(std::io::stderr().lock(), "{}", findings.summary())?;
    let report = args.out.join("report.html");
    writeln!(std::io::stdout().lock(), "{}", report.display())?;
    Ok(Ending::Done)
}
