//! The services of the window on this computer.

use std::path::{Path, PathBuf};
use std::sync::mpsc;

use super::calibration;
use super::folders::{own_folder, own_texts, recordings_folder};
use super::identify::{FoundFromPresses, PadIdentifier, begin_identifying};
use super::load_timeline::load_timeline;
use super::places::calibration_places;
use super::play::{FirstUse, Game, PreparedGame};
use super::profiles::{bases_of, check_text};
use super::recording::ActiveRecording;
use super::reload::{ProfileReload, ReloadNotice};
use super::services::{
    AppServices, OpenError, OutputChoice, PlayRequest, StartError, Started, Watch,
};
use super::table_solver::TableSolver;
use super::texts::{pad_text, profile_text, user_text};
use super::timeline::RecordingTimeline;
use super::{AppError, first_fault};
use crate::calibrate::recommend::{PressTrial, Recommendation, recommend};
use crate::calibrate::{GuidedReadings, Press, Presses, calibration_file_name, fit_correction};
use crate::files::FileError;
use crate::pad::{Pad, SHIPPED_PADS};
use crate::profile::{Checked, SHIPPED_PROFILES, SHIPPED_USERS, Source};
use crate::runtime::RunningGame;
use crate::types::{PointMm, SourceErrors};

/// Starts games as `gelpad play` does.
#[derive(Debug, Default)]
pub struct LocalServices {
    tables: TableSolver,
}

impl AppServices for LocalServices {
    fn start(&self, request: &PlayRequest) -> Result<Started, StartError> {
        start(request, &self.tables).map_err(|error| StartError {
            reason: error.one_line(),
            is_output: matches!(error, AppError::Output(_)),
        })
    }

    fn profiles(&self) -> Vec<String> {
        with_own_texts(SHIPPED_PROFILES.iter().map(|p| p.name), "profiles")
    }

    fn pads(&self) -> Vec<String> {
        with_own_texts(SHIPPED_PADS.iter().map(|p| p.name), "pads")
    }

    fn users(&self) -> Vec<String> {
        with_own_texts(SHIPPED_USERS.iter().map(|p| p.name), "users")
    }

    fn ports(&self) -> Vec<String> {
        let ports = crate::platform::ports::all();
        let mut names: Vec<String> = ports.into_iter().map(|port| port.port_name).collect();
        names.sort();
        names
    }

    fn profile_text(&self, name: &str) -> Result<String, String> {
        text_or_line(profile_text(name))
    }

    fn check_profile(&self, profile: Source, user: Option<&str>) -> Result<Checked, SourceErrors> {
        check_text(profile, user)
    }

    fn user_text(&self, name: &str) -> Result<String, String> {
        text_or_line(user_text(name))
    }

    fn pad_text(&self, name: &str) -> Result<String, String> {
        text_or_line(pad_text(name))
    }

    fn load_timeline(
        &self,
        file: &Path,
        request: &PlayRequest,
    ) -> Result<RecordingTimeline, OpenError> {
        load_timeline(file, request, &log_solving).map_err(open_error)
    }

    fn calibration_places(&self, pad: &Pad, count: usize) -> Vec<PointMm> {
        calibration_places(pad, count)
    }

    fn calibrate(&self, pad: &Pad, presses: Vec<Press>) -> Result<(PathBuf, String), String> {
        learn(pad, presses).map_err(|error| error.to_string())
    }

    fn begin_identifying(
        &self,
        request: &PlayRequest,
        readings: GuidedReadings,
    ) -> mpsc::Receiver<FoundFromPresses> {
        begin_identifying(request.pad.clone(), readings)
    }

    fn recommend(
        &self,
        trials: &[PressTrial],
        request: &PlayRequest,
        pad_mm: [f64; 2],
    ) -> Result<Recommendation, String> {
        let profile = profile_text(&request.profile).map_err(|error| error.to_string())?;
        let find = bases_of(&profile.name);
        recommend(trials, &profile, &find, pad_mm).map_err(|error| error.to_string())
    }

    fn own_folder(&self) -> Option<PathBuf> {
        own_folder()
    }

    fn recordings_folder(&self) -> Option<PathBuf> {
        recordings_folder()
    }
}

/// The user's own files, then shipped names.
fn with_own_texts(shipped: impl Iterator<Item = &'static str>, kind: &str) -> Vec<String> {
    let own = own_texts(kind).into_iter();
    own.chain(shipped.map(str::to_owned)).collect()
}

fn text_or_line(text: Result<Source, AppError>) -> Result<String, String> {
    text.map(|text| text.toml)
        .map_err(|error| error.to_string())
}

/// Of a damaged recording, the window offers itself what the help in further lines names.
fn open_error(error: AppError) -> OpenError {
    let mut reason = error.to_string();
    let is_damaged = error.is_damaged_recording();
    if is_damaged && let Some(end) = reason.find('\n') {
        reason.truncate(end);
    }
    OpenError { reason, is_damaged }
}

fn log_solving(done: usize, rows: usize) {
    if done == 1 {
        tracing::warn!("solving the touches of this pad ({rows} rows), once: takes seconds");
    }
}

fn start(request: &PlayRequest, tables: &TableSolver) -> Result<Started, AppError> {
    let prepared = PreparedGame::prepare(request, &FirstUse::PlayAtOnce(tables))?;
    let prepared = match request.output {
        OutputChoice::Nothing => prepared,
        _ => prepared.with_focus_gate(),
    };
    let Game {
        running,
        pad,
        output,
        hand,
        keys_blocked,
        reload,
        recording,
        warnings,
        table,
        identifier,
    } = prepared.start()?;
    Ok(Started {
        running,
        hand,
        pad,
        output,
        keys_blocked,
        watch: Box::new(GameWatch {
            reload,
            recording,
            identifier,
        }),
        warnings: warnings.iter().map(first_fault).collect(),
        table,
    })
}

/// Learns a calibration and saves it in the player's own folder.
fn learn(pad: &Pad, presses: Vec<Press>) -> Result<(PathBuf, String), AppError> {
    let presses = Presses::new("the presses", presses)?;
    let fitted = fit_correction(&presses, pad.outline.size_mm())?.checked()?;
    let folder = own_folder().ok_or_else(|| {
        AppError::Unsuitable("there is no folder for your own settings: set HOME".to_owned())
    })?;
    let folder = folder.join("calibrations");
    std::fs::create_dir_all(&folder).map_err(|error| FileError::new(&folder, error))?;
    let name = calibration_file_name(&pad.name, |name| folder.join(name).exists());
    let path = folder.join(name);
    calibration::save(&path, pad, &fitted.correction, fitted.lone.mean_mm)?;
    let summary = format!(
        "mean error of a touch: {:.1} mm before, {:.1} mm with the calibration (leave-one-out)",
        fitted.model.mean_mm, fitted.lone.mean_mm
    );
    Ok((path, summary))
}

/// The line for a reload. One that worked needs none: the window shows the profile that is played.
fn line_of(notice: &ReloadNotice) -> Option<String> {
    match notice {
        ReloadNotice::Playing { .. } => None,
        _ => Some(notice.to_string()),
    }
}

/// Follows a game of the window.
struct GameWatch {
    reload: Option<ProfileReload>,
    recording: Option<ActiveRecording>,
    identifier: Option<PadIdentifier>,
}

impl Watch for GameWatch {
    fn poll(&mut self, running: &mut RunningGame, say: &mut dyn FnMut(Option<String>)) {
        if let Some(reload) = &mut self.reload {
            reload.poll(running, &mut |notice| say(line_of(&notice)));
        }
        if let Some(identifier) = &mut self.identifier {
            identifier.poll(running, &mut |notice| say(Some(notice)));
        }
    }

    fn finish(&mut self) {
        match self.recording.take().map(ActiveRecording::finish) {
            Some((summary, true)) => tracing::info!("{summary}"),
            Some((summary, false)) => tracing::warn!("{summary}"),
            None => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_damaged_recording_the_first_line_is_told() {
        let folder = tempfile::tempdir().expect("a folder");
        let open = |bytes: &[u8]| {
            let file = folder.path().join("session.mcap");
            std::fs::write(&file, bytes).expect("written");
            let opened = LocalServices::default().load_timeline(&file, &PlayRequest::default());
            opened.err().expect("cannot be shown")
        };
        let whole = include_bytes!("../../tests/data/recordings/version-1.mcap");
        let cut = open(&whole[..whole.len() * 9 / 10]);
        assert!(cut.is_damaged && !cut.reason.contains('\n'), "{cut:?}");
        let foreign = open(b"\x89MCAP0\r\n");
        assert!(!foreign.is_damaged, "{foreign:?}");
    }

    #[test]
    fn a_reload_that_worked_takes_the_last_line_back() {
        let played = ReloadNotice::Playing {
            profile: "super-mario".to_owned(),
            after_ms: 3.0,
        };
        assert_eq!(line_of(&played), None);
        let refused = ReloadNotice::Unsupported("no mouse".to_owned());
        assert!(line_of(&refused).is_some_and(|line| line.contains("no mouse")));
    }
}
