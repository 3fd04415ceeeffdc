//! What `gelpad play` plays with, of its arguments or of the recording that it plays, and who listens: a recorder, TUIO.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};

use super::args::{PlayArgs, SourceArg};
use super::exit::Ending;
use super::play::say;
use super::{replay, resolve};
use crate::output::Tuio;
use crate::pad::{DEFAULT_PAD, Pad};
use crate::profile::{Checked, DEFAULT_PROFILE};
use crate::runtime::{self, Listener, Recorder};
use crate::tape::Kit;
use crate::touch::Correction;

/// What an engine is made of before its pad is solved.
pub(super) struct PlayedWith {
    pub pad: Pad,
    pub pad_toml: String,
    pub checked: Checked,
    /// The profile's name or path; none for one out of a recording.
    pub argument: Option<String>,
    pub correction: Option<Correction>,
}

impl PlayedWith {
    pub(super) fn of(args: &PlayArgs) -> anyhow::Result<Self> {
        let recorded = match &args.source {
            SourceArg::Replay(file) if replay::is_recording(file)? => Some(replay::open(file)?.1),
            _ => None,
        };
        let (pad, pad_toml) = match (&args.pad, &recorded) {
            (None, Some(kit)) => (kit.pad.clone(), kit.pad_toml.clone()),
            (argument, _) => {
                let argument = argument.as_deref().unwrap_or(DEFAULT_PAD);
                (resolve::pad(argument)?, resolve::pad_text(argument)?.toml)
            }
        };
        let own = match (&args.profile, recorded.as_ref()) {
            (None, Some(kit)) => Some(match args.user.as_deref() {
                None => kit.profile.as_ref().clone(),
                user => resolve::with_user(&kit.profile, user)?.as_ref().clone(),
            }),
            _ => None,
        };
        let (checked, argument) = match own {
            Some(profile) => {
                let checked = Checked {
                    profile,
                    warnings: Vec::new(),
                    texts: Vec::new(),
                };
                (checked, None)
            }
            None => {
                let argument = args.profile.as_deref().unwrap_or(DEFAULT_PROFILE);
                let checked = resolve::checked(argument, args.user.as_deref())?;
                (checked, Some(argument.to_owned()))
            }
        };
        let correction = match (&args.calibration, recorded, &args.pad) {
            (None, Some(kit), None) => kit.correction,
            (file, ..) => resolve::correction(file.as_deref(), &pad)?,
        };
        Ok(Self {
            pad,
            pad_toml,
            checked,
            argument,
            correction,
        })
    }
}

/// Who is told of every step while one plays.
#[derive(Default)]
pub(super) struct Asides {
    pub listeners: Vec<Box<dyn Listener>>,
    pub recorder: Option<Recording>,
}

impl Asides {
    pub(super) fn start(args: &PlayArgs, kit: &Kit) -> anyhow::Result<Self> {
        let mut asides = Self::default();
        if let Some(address) = &args.tuio {
            let tuio = Tuio::connect(address, kit.pad.outline.size_mm())?;
            let listener = runtime::send_touches(tuio).context("no thread to send touches on")?;
            asides.listeners.push(listener);
        }
        if let Some(path) = &args.record {
            if let SourceArg::Replay(file) = &args.source
                && is_same(file, path)
            {
                bail!(
                    "{}: this is the recording that is played\n  help: record to another file",
                    path.display()
                );
            }
            let (listener, recorder) = runtime::record(path, &kit.to_setup())?;
            asides.listeners.push(listener);
            asides.recorder = Some(Recording {
                path: path.clone(),
                recorder,
            });
        }
        Ok(asides)
    }
}

/// A recording under way, and where it goes.
pub(super) struct Recording {
    path: PathBuf,
    recorder: Recorder,
}

impl Recording {
    /// Waits until it is packed, and says how it went.
    pub(super) fn conclude(self) -> Ending {
        let report = self.recorder.join();
        let path = self.path.display();
        let kilobytes = std::fs::metadata(&self.path).map_or(0, |file| file.len() / 1000);
        let frames = report.frames;
        match &report.error {
            Some(why) => say(&format!(
                "{path}: {why}: {frames} frames are recorded, {} inputs after them are not",
                report.left_out
            )),
            None if report.left_out > 0 => say(&format!(
                "{path}: {frames} frames are recorded, {} inputs are missing: the disk was too slow",
                report.left_out
            )),
            None => say(&format!(
                "{path}: {frames} frames are recorded, {kilobytes} kB"
            )),
        }
        if report.error.is_some() || report.left_out > 0 {
            Ending::LostData
        } else {
            Ending::Done
        }
    }
}

fn is_same(one: &Path, other: &Path) -> bool {
    match (one.canonicalize(), other.canonicalize()) {
        (Ok(one), Ok(other)) => one == other,
        _ => false,
    }
}
