//! `gelpad study`: which pad to build.

use std::io::Write as _;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::args::{StudyArgs, StudyCommand};
use super::exit::Ending;
use super::progress::{bar, tell};
use super::resolve;
use crate::study::job::{self, Folder, Shard, Study};
use crate::study::phantoms::{self, Phantoms};
use crate::study::thickness::{self, Thickness};
use crate::study::width::{self, Width};

/// Any study: what `study.json` holds.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Settings {
    Width(width::Settings),
    Phantoms(phantoms::Settings),
    Thickness(Box<thickness::Settings>),
}

pub(super) fn run(command: &StudyCommand) -> anyhow::Result<Ending> {
    let (common, settings) = match command {
        StudyCommand::Merge { folders, out } => return merge(folders, out),
        StudyCommand::Width {
            common,
            vary,
            rank,
            quick,
        } => {
            let (pad, pad_toml) = pad(common)?;
            let settings = width::Settings {
                version: version(),
                pad,
                pad_toml,
                vary: vary.clone(),
                rank: (*rank).into(),
                quick: *quick,
                seed: common.seed,
            };
            (common, Settings::Width(settings))
        }
        StudyCommand::Phantoms { common, quick: _ } => {
            let (pad, pad_toml) = pad(common)?;
            let settings = phantoms::Settings {
                version: version(),
                pad,
                pad_toml,
                seed: common.seed,
            };
            (common, Settings::Phantoms(settings))
        }
        StudyCommand::Thickness {
            common,
            parameters,
            quick,
        } => {
            let (pad, pad_toml) = pad(common)?;
            let settings = thickness::Settings {
                version: version(),
                pad,
                pad_toml,
                quick: *quick,
                parameters: parameters.into(),
            };
            (common, Settings::Thickness(Box::new(settings)))
        }
    };
    let (out, shard) = (&common.out, common.shard);
    match &settings {
        Settings::Width(of) => solve(&Width::new(of.clone())?, &settings, out, shard),
        Settings::Phantoms(of) => solve(&Phantoms::new(of.clone())?, &settings, out, shard),
        Settings::Thickness(of) => {
            let study = Thickness::new((**of).clone())?;
            foretell(&study)?;
            solve(&study, &settings, out, shard)
        }
    }
}

fn version() -> String {
    env!("CARGO_PKG_VERSION").to_owned()
}

fn pad(common: &StudyArgs) -> anyhow::Result<(String, String)> {
    let text = resolve::pad_text(&common.pad)?;
    // Read once for its own messages, with the place of a mistake.
    resolve::pad(&common.pad)?;
    Ok((text.name, text.toml))
}

/// Says what a study of thickness takes, before it starts.
fn foretell(study: &Thickness) -> anyhow::Result<()> {
    let workers = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let foretold = study.foretell(workers)?;
    let mut stderr = std::io::stderr().lock();
    writeln!(
        stderr,
        "{} cases of up to {} unknowns: about {:.1} GiB for {workers} at a time, and about {} minutes",
        study.cases().len(),
        foretold.unknowns,
        foretold.bytes / f64::from(1 << 30),
        (foretold.seconds / 60.0).ceil()
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
    let bar = bar();
    job::run(&folder, study, shard, tell(&bar))?;
    bar.finish_and_clear();
    if shard == Shard::ALL {
        write(study, &folder)?;
    }
    finish(&folder, shard)
}

fn write<S: Study>(study: &S, folder: &Folder) -> anyhow::Result<()> {
    let outcomes = job::outcomes(folder, study)?;
    Ok(study.report(&outcomes)?.write(folder.path())?)
}

fn merge(folders: &[std::path::PathBuf], out: &Path) -> anyhow::Result<Ending> {
    let Some(first) = folders.first() else {
        anyhow::bail!("nothing to merge: name the folders of the shards");
    };
    let text = Folder::settings_text(first)?;
    let settings: Settings = serde_json::from_str(&text)
        .map_err(|error| anyhow::anyhow!("{}/study.json: {error}", first.display()))?;
    let folder = Folder::open(out, &settings)?;
    for other in folders {
        folder.take_over(other)?;
    }
    match settings {
        Settings::Width(of) => write(&Width::new(of)?, &folder)?,
        Settings::Phantoms(of) => write(&Phantoms::new(of)?, &folder)?,
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
            "{}: shard {}/{} done; join all with: gelpad study merge DIR... --out DIR",
            folder.path().display(),
            shard.index,
            shard.count
        )?;
    }
    Ok(Ending::Done)
}
