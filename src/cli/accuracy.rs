//! `gelpad accuracy`: estimates how accurately a pad locates touches.

use std::fs;
use std::io::Write as _;

use anyhow::{Context as _, ensure};

use super::args::AccuracyArgs;
use super::exit::Ending;
use super::progress::{case_bar, case_progress, solve_pad};
use crate::app::pads::load_drawn_pad;
use crate::study::accuracy::identified::IdentifyExtent;
use crate::study::accuracy::real::{Condition, Extent, TABLE_HEADER, conditions, own_conditions};
use crate::study::accuracy::scan::ScanExtent;
use crate::study::accuracy::{Accuracy, AccuracySettings};
use crate::study::job;

pub(super) fn run(args: &AccuracyArgs) -> anyhow::Result<Ending> {
    let pad = load_drawn_pad(&args.pad)?.pad;
    let method = args.method.or(pad.method).unwrap_or_default();
    let conditions = args.real.then(|| chosen_conditions(args)).transpose()?;
    // Reports a folder that cannot be created before a minute of solving, not after.
    fs::create_dir_all(&args.out).with_context(|| args.out.display().to_string())?;
    let sensing = solve_pad(&pad, method)?;
    let settings = AccuracySettings {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        pad_argument: args.pad.clone(),
        method,
        snr_db: args.snr.clone(),
        seed: args.seed,
        quick: args.quick,
        as_drawn: args.as_drawn,
        pad,
    };
    let study = Accuracy::new(settings, sensing)?;
    let bar = case_bar();
    if args.scan {
        let extent = if args.quick {
            ScanExtent::QUICK
        } else {
            ScanExtent::FULL
        };
        let findings = study.play_scans(extent, case_progress(&bar))?;
        bar.finish_and_clear();
        job::write_whole(&args.out, "scan.json", findings.json()?.as_bytes())?;
        write!(std::io::stdout().lock(), "{}", findings.table())?;
        return Ok(Ending::Done);
    }
    if args.identify {
        let extent = if args.quick {
            IdentifyExtent::QUICK
        } else {
            IdentifyExtent::FULL
        };
        let findings = study.locate_on_built_pads(extent, case_progress(&bar))?;
        bar.finish_and_clear();
        job::write_whole(&args.out, "identified.json", findings.json()?.as_bytes())?;
        job::write_whole(&args.out, "found-and-true.png", &findings.figure()?.png)?;
        write!(std::io::stdout().lock(), "{}", findings.table())?;
        return Ok(Ending::Done);
    }
    if let Some(conditions) = conditions {
        return play_conditions(args, &study, &conditions);
    }
    let outcomes =
        job::solve_in_parallel(study.cases(), |case| study.solve(case), case_progress(&bar))?;
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

/// The conditions of `--real`, one's own or the shipped ones: those whose names contain `--only`.
fn chosen_conditions(args: &AccuracyArgs) -> anyhow::Result<Vec<Condition>> {
    let mut chosen = if args.disturb.is_empty() {
        conditions()
    } else {
        own_conditions(&args.disturb, args.snr[0])
    };
    let names: Vec<&str> = chosen.iter().map(|condition| condition.name).collect();
    chosen.retain(|condition| condition.name.contains(&args.only));
    ensure!(
        !chosen.is_empty(),
        "no condition's name contains `{}`; the conditions are:\n  {}",
        args.only,
        names.join("\n  ")
    );
    Ok(chosen)
}

/// `--real`: each row is printed and stored as soon as it is played, since all of them take more than ten minutes.
fn play_conditions(
    args: &AccuracyArgs,
    study: &Accuracy,
    conditions: &[Condition],
) -> anyhow::Result<Ending> {
    let extent = if args.quick {
        Extent::QUICK
    } else {
        Extent::FULL
    };
    let bar = case_bar();
    let progress = case_progress(&bar);
    progress(0, conditions.len());
    bar.suspend(|| writeln!(std::io::stdout().lock(), "{TABLE_HEADER}"))?;
    study.play_conditions(conditions, extent, |findings| -> anyhow::Result<()> {
        job::write_whole(&args.out, "real.json", findings.json()?.as_bytes())?;
        if let Some(row) = findings.conditions.last() {
            bar.suspend(|| writeln!(std::io::stdout().lock(), "{row}"))?;
        }
        progress(findings.conditions.len(), conditions.len());
        Ok(())
    })?;
    bar.finish_and_clear();
    Ok(Ending::Done)
}
