//! `gelpad study`: which pad to build.

use std::io::Write as _;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::args::{StudyArgs, StudyCommand};
use super::exit::Ending;
use super::progress::{bar, tell};
use super::resolve;
use crate::study::job::{self, Folder, Shard};
use crate::study::phantoms::{self, Phantoms};
use crate::study::width::{self, Width};

/// Any study: what `study.json` holds.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Settings {
    Width(width::Settings),
    Phantoms(phantoms::Settings),
}

pub(super) fn run(command: &StudyCommand) -> anyhow::Result<Ending> {
    match command {
        StudyCommand::Width {
            common,
            vary,
            rank,
            quick,
        } => {
            let (pad, pad_toml) = pad(common)?;
            let study = Width::new(width::Settings {
                version: version(),
                pad,
                pad_toml,
                vary: vary.clone(),
                rank: (*rank).into(),
                quick: *quick,
                seed: common.seed,
            })?;
            solve_width(&study, common)
        }
        StudyCommand::Phantoms { common, quick: _ } => {
            let (pad, pad_toml) = pad(common)?;
            let study = Phantoms::new(phantoms::Settings {
                version: version(),
                pad,
                pad_toml,
                seed: common.seed,
            })?;
            solve_phantoms(&study, common)
        }
        StudyCommand::Merge { folders, out } => merge(folders, out),
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

fn solve_width(study: &Width, common: &StudyArgs) -> anyhow::Result<Ending> {
    let folder = Folder::open(&common.out, &Settings::Width(study.settings().clone()))?;
    let bar = bar();
    job::run(
        &folder,
        study.cases(),
        common.shard,
        Width::id,
        |case| study.solve(case),
        tell(&bar),
    )?;
    bar.finish_and_clear();
    if common.shard == Shard::ALL {
        write_width(study, &folder)?;
    }
    finish(&folder, common.shard)
}

fn write_width(study: &Width, folder: &Folder) -> anyhow::Result<()> {
    let outcomes: Vec<width::Outcome> = job::results(folder, study.cases(), Width::id)?;
    Ok(study.report(&outcomes)?.write(folder.path())?)
}

fn solve_phantoms(study: &Phantoms, common: &StudyArgs) -> anyhow::Result<Ending> {
    let folder = Folder::open(&common.out, &Settings::Phantoms(study.settings().clone()))?;
    let bar = bar();
    let cases = phantoms::phantoms();
    job::run(
        &folder,
        &cases,
        common.shard,
        Phantoms::id,
        |case| study.solve(case),
        tell(&bar),
    )?;
    bar.finish_and_clear();
    if common.shard == Shard::ALL {
        write_phantoms(study, &folder)?;
    }
    finish(&folder, common.shard)
}

fn write_phantoms(study: &Phantoms, folder: &Folder) -> anyhow::Result<()> {
    let outcomes: Vec<phantoms::Outcome> =
        job::results(folder, &phantoms::phantoms(), Phantoms::id)?;
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
        Settings::Width(settings) => write_width(&Width::new(settings)?, &folder)?,
        Settings::Phantoms(settings) => write_phantoms(&Phantoms::new(settings)?, &folder)?,
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
