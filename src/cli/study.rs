//! `gelpad study`: studies of pad designs.

use std::io::Write as _;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::args::{StudyArgs, StudyCommand};
use super::exit::Ending;
use super::progress::{case_bar, case_progress};
use crate::app::pads::{PadText, load_drawn_pad};
use crate::study::job::{self, Folder, Shard, Study};
use crate::study::phantoms::{self, Phantoms};
use crate::study::protocol::{self, ProtocolStudy};
use crate::study::thickness::{self, Thickness};
use crate::study::width::{self, Width};

/// Settings of a study, as `study.json` stores them.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Settings {
    Width(width::WidthSettings),
    Phantoms(phantoms::PhantomSettings),
    Thickness(Box<thickness::ThicknessSettings>),
    Protocol(protocol::ProtocolSettings),
}

pub(super) fn run(command: &StudyCommand) -> anyhow::Result<Ending> {
    let (common, settings) = match command {
        StudyCommand::Merge { folders, out } => return merge(folders, out),
        StudyCommand::Width { common, .. }
        | StudyCommand::Phantoms { common, .. }
        | StudyCommand::Thickness { common, .. }
        | StudyCommand::Protocol { common, .. } => (common, settings(command, common)?),
    };
    let (out, shard) = (&common.out, common.shard);
    match &settings {
        Settings::Width(of) => solve(&Width::new(of.clone())?, &settings, out, shard),
        Settings::Phantoms(of) => solve(&Phantoms::new(of.clone())?, &settings, out, shard),
        Settings::Protocol(of) => solve(&ProtocolStudy::new(of.clone())?, &settings, out, shard),
        Settings::Thickness(of) => {
            let study = Thickness::new((**of).clone())?;
            print_estimate(&study)?;
            solve(&study, &settings, out, shard)
        }
    }
}

/// The settings of a study that is to be solved.
fn settings(command: &StudyCommand, common: &StudyArgs) -> anyhow::Result<Settings> {
    let (pad, pad_toml) = pad(common)?;
    let version = env!("CARGO_PKG_VERSION").to_owned();
    Ok(match command {
        StudyCommand::Width {
            vary,
            rank,
            quick,
            seed,
            ..
        } => Settings::Width(width::WidthSettings {
            version,
            pad,
            pad_toml,
            vary: vary.clone(),
            rank: (*rank).into(),
            quick: *quick,
            seed: *seed,
        }),
        StudyCommand::Phantoms { quick, seed, .. } => {
            Settings::Phantoms(phantoms::PhantomSettings {
                version,
                pad,
                pad_toml,
                quick: *quick,
                seed: *seed,
            })
        }
        StudyCommand::Thickness {
            parameters, quick, ..
        } => Settings::Thickness(Box::new(thickness::ThicknessSettings {
            version,
            pad,
            pad_toml,
            quick: *quick,
            parameters: parameters.into(),
        })),
        StudyCommand::Protocol {
            snr,
            keep,
            quick,
            seed,
            ..
        } => Settings::Protocol(protocol::ProtocolSettings {
            version,
            pad,
            pad_toml,
            snr_db: *snr,
            keep_mm: *keep,
            quick: *quick,
            seed: *seed,
        }),
        StudyCommand::Merge { .. } => anyhow::bail!("a merge has the settings of its shards"),
    })
}

fn pad(common: &StudyArgs) -> anyhow::Result<(String, String)> {
    // Parsed here as well to report mistakes with their places.
    let PadText { toml, .. } = load_drawn_pad(&common.pad)?;
    Ok((common.pad.clone(), toml))
}

/// Prints the estimated memory and run time of a thickness study.
fn print_estimate(study: &Thickness) -> anyhow::Result<()> {
    let workers = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let estimate = study.estimate(workers)?;
    let time = match estimate.seconds {
        seconds if seconds < 60.0 => "less than a minute".to_owned(),
        seconds => format!("about {:.0} minutes", (seconds / 60.0).ceil()),
    };
    let mut stderr = std::io::stderr().lock();
    writeln!(
        stderr,
        "{} cases of up to {} unknowns: about {:.1} GiB for {workers} in parallel, {time}",
        study.cases().len(),
        estimate.unknowns,
        estimate.bytes / f64::from(1 << 30),
    )?;
    Ok(())
}

fn solve<S: Study>(
    study: &S,
    settings: &Settings,
    out: &Path,
    shard: Shard,
) -> anyhow::Result<Ending> {
    let folder = Folder::open(out, settings)?;
    let bar = case_bar();
    job::run_shard(&folder, study, shard, case_progress(&bar))?;
    bar.finish_and_clear();
    if shard == Shard::ALL {
        write(study, &folder)?;
    }
    finish(&folder, shard)
}

fn write<S: Study>(study: &S, folder: &Folder) -> anyhow::Result<()> {
    let outcomes = job::load_results(folder, study)?;
    Ok(study.report(&outcomes)?.write(folder.path())?)
}

fn merge(folders: &[std::path::PathBuf], out: &Path) -> anyhow::Result<Ending> {
    let Some(first) = folders.first() else {
        anyhow::bail!("nothing to merge: give the folders of the shards");
    };
    let text = Folder::settings_text(first)?;
    let settings: Settings = serde_json::from_str(&text)
        .map_err(|error| anyhow::anyhow!("{}/study.json: {error}", first.display()))?;
    // Before anything is written.
    for other in folders {
        Folder::check_settings(other, &text)?;
    }
    let folder = Folder::open(out, &settings)?;
    for other in folders {
        folder.copy_results_from(other)?;
    }
    match settings {
        Settings::Width(of) => write(&Width::new(of)?, &folder)?,
        Settings::Phantoms(of) => write(&Phantoms::new(of)?, &folder)?,
        Settings::Protocol(of) => write(&ProtocolStudy::new(of)?, &folder)?,
        Settings::Thickness(of) => write(&Thickness::new(*of)?, &folder)?,
    }
    finish(&folder, Shard::ALL)
}

fn finish(folder: &Folder, shard: Shard) -> anyhow::Result<Ending> {
    let mut stdout = std::io::stdout().lock();
    if shard == Shard::ALL {
        writeln!(stdout, "{}", folder.path().join("report.html").display())?;
    } else {
        writeln!(
            stdout,
            "{}: shard {}/{} done; merge all with: gelpad study merge DIR... --out DIR",
            folder.path().display(),
            shard.index,
            shard.count
        )?;
    }
    Ok(Ending::Done)
}
