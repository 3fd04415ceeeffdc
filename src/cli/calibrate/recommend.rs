//! `gelpad calibrate --recommend NAME`: asks for presses, then writes the settings under which most presses give the
//! intended output.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::bail;

use super::source::open;
use crate::app::pads::load_pad;
use crate::app::profiles::check_text;
use crate::app::services::SourceChoice;
use crate::app::texts::{is_path, profile_text};
use crate::calibrate::recommend::{
    FEWEST_TRIALS, PressSession, PressTrial, RecommendError, Recommendation, recommend,
};
use crate::cli::args::CalibrateArgs;
use crate::cli::exit::{self, Ending};
use crate::cli::map::Map;
use crate::cli::message::say;
use crate::cli::progress::{Spinner, solve_pad};
use crate::files;
use crate::pad::Pad;
use crate::profile::{Profile, Source, find_shipped};
use crate::source::{self, SourceReading};
use crate::touch::Detector;
use crate::types::Touch;

/// Characters across the map.
const MAP_COLUMNS: usize = 40;

pub(super) fn run(
    args: &CalibrateArgs,
    name: &str,
    choice: &SourceChoice,
) -> anyhow::Result<Ending> {
    let path = match &args.output {
        Some(path) => path.clone(),
        None if is_path(name) => PathBuf::from(name),
        None => PathBuf::from("users").join(format!("{name}.toml")),
    };
    if path.exists() {
        bail!(
            "{} exists: it would be overwritten\n  help: choose another name, or move the file",
            path.display()
        );
    }
    let pad = load_pad(&args.pad)?.pad;
    let text = profile_text(&args.profile)?;
    let checked = check_text(text.clone(), None)?;
    checked.warnings.iter().for_each(exit::warn);
    let method = args.method.or(pad.method).unwrap_or_default();
    let sensing = solve_pad(&pad, method)?.build_initial()?;
    let detector = Detector::for_pad(Arc::new(sensing), &pad.protocol);
    let mut source = open(args, &pad, choice, &[])?;
    let trials = ask(
        &pad,
        &checked.profile,
        detector,
        source.as_mut(),
        args.points,
    )?;
    let recommended = search(&trials, &text, &pad)?;
    if let Some(folder) = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty())
    {
        std::fs::create_dir_all(folder)?;
    }
    let toml = recommended.toml();
    files::write(&path, toml.as_bytes())?;
    let (before, after) = (recommended.before, recommended.after);
    say(&toml);
    say(&format!(
        "{} of {} presses come out as meant with these settings, {} without\nsaved: {}\nuse it: gelpad play {} --user {name}",
        after.right,
        after.requested,
        before.right,
        path.display(),
        args.profile,
    ));
    Ok(match trials.len() == args.points {
        true => Ending::Done,
        false => Ending::LostData,
    })
}

/// Searches the settings under which most presses give the intended output.
fn search(trials: &[PressTrial], profile: &Source, pad: &Pad) -> anyhow::Result<Recommendation> {
    let spinner = Spinner::new();
    spinner.show("trying settings on your presses");
    match recommend(trials, profile, &find_shipped, pad.outline.size_mm()) {
        Ok(recommended) => Ok(recommended),
        Err(RecommendError::Profile(errors)) => Err(errors.into()),
        Err(error) => Err(error.into()),
    }
}

/// Asks for presses until all are recorded or the source ends.
fn ask(
    pad: &Pad,
    profile: &Profile,
    mut detector: Detector,
    source: &mut dyn source::Source,
    count: usize,
) -> anyhow::Result<Vec<PressTrial>> {
    let mut session = PressSession::new(PressSession::default_requests(profile, count));
    if session.request_count() < FEWEST_TRIALS {
        bail!(
            "at least {FEWEST_TRIALS} presses are needed, in regions with a plain press binding: give --points {FEWEST_TRIALS} or more, or another --profile"
        );
    }
    say(
        "do not touch the pad for a moment, then press as asked, in your usual way; the next press is asked for two seconds after you let go",
    );
    show(pad, profile, &session);
    let mut changed: Vec<Touch> = Vec::new();
    while session.current_request().is_some() {
        match source.read()? {
            SourceReading::Frame(frame) => {
                changed.clear();
                detector.process_frame(&frame, &mut changed);
                if session.take_frame(frame.t_ns, &changed) {
                    show(pad, profile, &session);
                }
            }
            SourceReading::Skipped { reason, .. } => {
                tracing::warn!("skipped an unreadable frame: {reason}")
            }
            // Boards are read frame by frame here.
            SourceReading::Part(_)
            | SourceReading::Control(_)
            | SourceReading::Disconnected { .. }
            | SourceReading::Idle => {}
            SourceReading::End => break,
        }
    }
    Ok(session.finish())
}

fn show(pad: &Pad, profile: &Profile, session: &PressSession) {
    let Some((number, asked)) = session.current_request() else {
        return;
    };
    let pad_mm = pad.outline.size_mm();
    let mut map = Map::new(pad_mm, MAP_COLUMNS).regions(profile);
    if let Some(wanted) = profile.regions.iter().find(|one| one.name == asked.region) {
        let place = wanted.placed(pad_mm, &profile.settings.area).centre_mm();
        map = map.marked(place, '✕');
    }
    // Rings the terminal's bell: the player looks at the pad.
    say(&format!(
        "\u{7}{}\n{} of {}: {asked} (✕)",
        map.framed(),
        number + 1,
        session.request_count()
    ));
}
