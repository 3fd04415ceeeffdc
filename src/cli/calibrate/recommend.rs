//! `gelpad calibrate --recommend NAME`: asks for presses, then writes the settings under which most presses give the
//! intended output.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::bail;

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
use crate::platform::signals::Signals;
use crate::profile::{Profile, Source, find_shipped};
use crate::source::{self, SkipLog, SourceReading};
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
    let mut source = args.press_source(choice).open(&pad, &[])?;
    // Minutes of work: the presses are used, also after Ctrl-C.
    let signals = Signals::listen()?;
    let session = PressSession::new(PressSession::default_requests(
        &checked.profile,
        args.points,
    ));
    let asked = ask(
        session,
        (&pad, &checked.profile),
        detector,
        source.as_mut(),
        &|| signals.received(),
    )?;
    let trials = &asked.trials;
    if let Some(signal) = asked.interrupted_by {
        if trials.len() < FEWEST_TRIALS {
            say(&format!(
                "nothing is saved: {} presses were made, but at least {FEWEST_TRIALS} are needed",
                trials.len()
            ));
            return Ok(Ending::Signal(signal));
        }
        say(&format!(
            "stopped after {} presses, which are used; Ctrl-C again ends without them",
            trials.len()
        ));
    }
    let recommended = search(trials, &text, &pad)?;
    if recommended.is_worse() {
        say(&kept_text(&recommended));
    } else {
        save(
            &recommended,
            &path,
            &format!("gelpad play {} --user {name}", args.profile),
        )?;
    }
    Ok(match asked.interrupted_by {
        Some(signal) => Ending::Signal(signal),
        None if trials.len() == args.points => Ending::Done,
        None => Ending::LostData,
    })
}

/// Why nothing is saved, although settings were found.
fn kept_text(found: &Recommendation) -> String {
    let (before, after) = (&found.before, &found.after);
    format!(
        "{} of {} presses come out as meant with the profile as it is ({} unintended), {} with the best settings found ({} unintended)\nthey would be worse: nothing is saved, keep what you have",
        before.right, before.requested, before.wrong, after.right, after.wrong
    )
}

/// Writes the settings, and prints them with what they bring.
fn save(found: &Recommendation, path: &Path, usage: &str) -> anyhow::Result<()> {
    if let Some(folder) = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty())
    {
        std::fs::create_dir_all(folder)?;
    }
    let toml = found.toml();
    files::write(path, toml.as_bytes())?;
    let (before, after) = (found.before, found.after);
    say(&toml);
    say(&format!(
        "{} of {} presses come out as meant with these settings ({} unintended), {} without ({} unintended)\nsaved: {}\nuse it: {usage}",
        after.right,
        after.requested,
        after.wrong,
        before.right,
        before.wrong,
        path.display(),
    ));
    Ok(())
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

/// The presses that were made.
struct Asked {
    trials: Vec<PressTrial>,
    /// The signal that ended the requests, such as Ctrl-C.
    interrupted_by: Option<i32>,
}

/// Asks for presses until all are recorded, the source ends or a signal comes.
fn ask(
    mut session: PressSession,
    (pad, profile): (&Pad, &Profile),
    mut detector: Detector,
    source: &mut dyn source::Source,
    interrupted: &dyn Fn() -> Option<i32>,
) -> anyhow::Result<Asked> {
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
    let mut log = SkipLog::default();
    let mut interrupted_by = None;
    while session.current_request().is_some() {
        interrupted_by = interrupted();
        if interrupted_by.is_some() {
            break;
        }
        match source.read()? {
            SourceReading::Frame(frame) => {
                log.frame();
                changed.clear();
                detector.process_frame(&frame, &mut changed);
                if session.take_frame(frame.t_ns, &changed) {
                    show(pad, profile, &session);
                }
            }
            SourceReading::Skipped { reason, .. } => log.skip(reason)?,
            SourceReading::Disconnected { reason } => tracing::warn!("{reason}"),
            // Boards are read frame by frame here.
            SourceReading::Part(_) | SourceReading::Control(_) | SourceReading::Idle => {}
            SourceReading::End => break,
        }
    }
    Ok(Asked {
        trials: session.finish(),
        interrupted_by,
    })
}

fn show(pad: &Pad, profile: &Profile, session: &PressSession) {
    let Some((number, asked)) = session.current_request() else {
        return;
    };
    let pad_mm = pad.outline.size_mm();
    let mut map = Map::new(pad_mm, MAP_COLUMNS).with_regions(profile);
    if let Some(wanted) = profile.regions.iter().find(|one| one.name == asked.region) {
        let place = wanted.placed(pad_mm, &profile.settings.area).centre_mm();
        map = map.with_mark(place, '✕');
    }
    // Rings the terminal's bell: the player looks at the pad.
    say(&format!(
        "\u{7}{}\n{} of {}: {asked} (✕)",
        map.framed(),
        number + 1,
        session.request_count()
    ));
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;
    use crate::eit::Reconstruction;
    use crate::source::{SourceError, SourcePace};
    use crate::types::{Frame, Method};

    /// Sends the same readings again and again, or nothing that can be read.
    struct Board {
        volts: Option<Vec<f32>>,
        reads: u64,
    }

    impl source::Source for Board {
        fn pace(&self) -> SourcePace {
            SourcePace::ByDevice
        }

        fn read(&mut self) -> Result<SourceReading, SourceError> {
            self.reads += 1;
            Ok(match &self.volts {
                Some(volts) => SourceReading::Frame(Frame {
                    t_ns: self.reads * 10_000_000,
                    volts: volts.clone(),
                }),
                None => SourceReading::Skipped {
                    reason: "no digits".to_owned(),
                    frames: 1,
                },
            })
        }
    }

    /// Asks for presses on a board until `interrupted`.
    fn asked(board: &mut Board, interrupted: &dyn Fn() -> Option<i32>) -> anyhow::Result<Asked> {
        let pad = load_pad("openeit-lattice").expect("shipped").pad;
        let text = profile_text("super-mario-classified").expect("shipped");
        let profile = check_text(text, None).expect("sound").profile;
        let matrix = Reconstruction::from_pad(&pad, Method::default()).expect("a matrix");
        if let Some(volts) = &mut board.volts {
            volts.resize(pad.channels(), 0.5);
        }
        let session = PressSession::new(PressSession::default_requests(&profile, 20));
        let detector = Detector::new(Arc::new(matrix));
        ask(session, (&pad, &profile), detector, board, interrupted)
    }

    #[test]
    fn a_board_that_sends_no_frame_ends_the_requests() {
        let mut board = Board {
            volts: None,
            reads: 0,
        };
        let error = asked(&mut board, &|| None).err().expect("no frame");
        assert!(error.to_string().contains("no digits"), "{error}");
    }

    #[test]
    fn a_signal_ends_the_requests_and_keeps_the_presses() {
        let mut board = Board {
            volts: Some(Vec::new()),
            reads: 0,
        };
        let calls = Cell::new(0);
        let after_30 = || {
            calls.set(calls.get() + 1);
            (calls.get() > 30).then_some(2)
        };
        let asked = asked(&mut board, &after_30).expect("asked");
        assert_eq!(asked.interrupted_by, Some(2));
        assert_eq!((board.reads, asked.trials.len()), (30, 0));
    }
}
