//! `gelpad calibrate --recommend NAME`: asks for presses, and writes the settings under which most come out as meant.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::bail;

use super::{Spinner, file, say};
use crate::calibrate::recommend::{
    Asked, FEWEST_TRIALS, Length, RecommendError, Session, Trial, recommend,
};
use crate::cli::args::{CalibrateArgs, SourceArg};
use crate::cli::exit::Ending;
use crate::cli::map::Map;
use crate::cli::resolve;
use crate::pad::Pad;
use crate::profile::{Profile, find_shipped};
use crate::source::{Reading, Source};
use crate::touch::Detector;
use crate::types::Touch;

/// Characters across the map.
const MAP_COLUMNS: usize = 40;

pub(super) fn run(args: &CalibrateArgs, name: &str, source: &SourceArg) -> anyhow::Result<Ending> {
    let path = match &args.output {
        Some(path) => path.clone(),
        None if resolve::is_path(name) => PathBuf::from(name),
        None => PathBuf::from("users").join(format!("{name}.toml")),
    };
    if path.exists() {
        bail!(
            "{} exists: it would be overwritten\n  help: take another name, or move it away",
            path.display()
        );
    }
    let pad = resolve::pad(&args.pad)?;
    let text: crate::profile::Source = resolve::profile_text(&args.profile)?.into();
    let profile = resolve::profile(&args.profile, None)?;
    let method = args.method.or(pad.method).unwrap_or_default();
    let sensing = resolve::sensing(&pad, method)?.first()?;
    let detector = Detector::of_pad(Arc::new(sensing), &pad.protocol);
    let mut source = super::open(args, &pad, source, &[])?;
    let trials = ask(&pad, &profile, detector, source.as_mut(), args.points)?;
    let complete = trials.len() == args.points;
    let spinner = Spinner::new();
    spinner.say("trying settings on your presses");
    let pad_mm = pad.outline.size_mm();
    let recommended = match recommend(&trials, &text, &find_shipped, pad_mm) {
        Ok(recommended) => recommended,
        Err(RecommendError::Profile(faulty)) => return Err(faulty.into()),
        Err(error) => return Err(error.into()),
    };
    drop(spinner);
    if let Some(folder) = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty())
    {
        std::fs::create_dir_all(folder)?;
    }
    let toml = recommended.toml();
    file::write(&path, &toml)?;
    let (before, after) = (recommended.before, recommended.after);
    say(&toml);
    say(&format!(
        "{} of {} presses come out as meant with these settings, {} without\nsaved: {}\nuse it: gelpad play {} --user {name}",
        after.right,
        after.asked,
        before.right,
        path.display(),
        args.profile,
    ));
    Ok(if complete {
        Ending::Done
    } else {
        Ending::LostData
    })
}

/// Asks for presses until all are done or the source ends.
fn ask(
    pad: &Pad,
    profile: &Profile,
    mut detector: Detector,
    source: &mut dyn Source,
    count: usize,
) -> anyhow::Result<Vec<Trial>> {
    let mut session = Session::new(Session::usual(profile, count));
    if session.count() < FEWEST_TRIALS {
        bail!(
            "at least {FEWEST_TRIALS} presses are needed, of regions that a plain press is bound to: give --points {FEWEST_TRIALS} or more, or another --profile"
        );
    }
    say(
        "leave the pad alone for a moment, then do as you are asked, as you usually do; the next is asked two seconds after you let go",
    );
    show(pad, profile, &session);
    let mut changed: Vec<Touch> = Vec::new();
    while session.asked().is_some() {
        match source.read()? {
            Reading::Frame(frame) => {
                changed.clear();
                detector.frame(&frame, &mut changed);
                if session.frame(frame.t_ns, &changed) {
                    show(pad, profile, &session);
                }
            }
            Reading::Skipped { reason, .. } => tracing::warn!("skipped what is no frame: {reason}"),
            Reading::Control(_) | Reading::Gone { .. } | Reading::Idle => {}
            Reading::End => break,
        }
    }
    Ok(session.finish())
}

fn show(pad: &Pad, profile: &Profile, session: &Session) {
    let Some((number, Asked { region, length })) = session.asked() else {
        return;
    };
    let how = match length {
        Length::Short => "press it shortly",
        Length::Long => "press it and hold, for a long press",
        Length::Twice => "press it twice, shortly",
    };
    let pad_mm = pad.outline.size_mm();
    let mut map = Map::new(pad_mm, MAP_COLUMNS).regions(profile);
    if let Some(wanted) = profile.regions.iter().find(|one| one.name == *region) {
        let place = wanted.placed(pad_mm, &profile.settings.area).centre_mm();
        map = map.marked(place, '✕');
    }
    // The terminal's bell: eyes are on the pad.
    say(&format!(
        "\u{7}{}\n{} of {}: {region} ✕: {how}",
        map.framed(),
        number + 1,
        session.count()
    ));
}
