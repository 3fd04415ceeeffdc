//! What the window needs from the rest of the program: games, texts, calibrations. Tests implement it with a fake.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc;

use super::gamepads;
pub use super::gamepads::GamepadCheck;
pub use super::identify::FoundFromPresses;
pub use super::port_report::PortDiagnosis;
use super::port_report::diagnose;
pub use super::recovery::SavedPart;
use super::recovery::save_readable_part;
pub use super::request::{
    BoardLine, NoiseLevel, OutputChoice, PlayRequest, SourceChoice, WindowArguments,
};
pub use super::table_solver::TableInProgress;
use super::timeline::RecordingTimeline;
use crate::calibrate::recommend::{PressTrial, Recommendation};
use crate::calibrate::{GuidedReadings, Press};
use crate::pad::Pad;
use crate::profile::{Checked, Source};
use crate::runtime::RunningGame;
use crate::source::LiveFingers;
use crate::types::{PointMm, SourceErrors};

/// Follows a running game: loads saved profiles, finishes the recording.
pub trait Watch: Send {
    /// Checks once for changes; `say` receives a line for the player, or none when the last one no longer holds.
    fn poll(&mut self, running: &mut RunningGame, say: &mut dyn FnMut(Option<String>));

    /// Finishes the recording after the threads of the game have ended.
    fn finish(&mut self) {}
}

/// A game that has been started.
pub struct Started {
    /// The threads.
    pub running: RunningGame,
    /// Presses the simulated pad, with [`SourceChoice::Simulated`].
    pub hand: Option<LiveFingers>,
    /// The pad.
    pub pad: Pad,
    /// Name of the output.
    pub output: String,
    /// While set, no key is sent: the window has the focus and would receive it.
    pub keys_blocked: Option<Arc<AtomicBool>>,
    /// Loads saved profiles and finishes the recording.
    pub watch: Box<dyn Watch>,
    /// Warnings about the profile.
    pub warnings: Vec<String>,
    /// The pad's response table, while it is being solved: the game finds touches in images until it is sent
    /// [`crate::runtime::PlayCommand::Table`].
    pub table: Option<Arc<TableInProgress>>,
}

/// Why a game does not start.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StartError {
    /// The reason and what to do, for the player.
    pub reason: String,
    /// Whether it is the output that cannot be opened: another one may help.
    pub is_output: bool,
}

impl StartError {
    /// The output is not the reason.
    #[must_use]
    pub fn of_game(reason: impl Into<String>) -> Self {
        Self {
            reason: reason.into(),
            is_output: false,
        }
    }
}

/// Why a recording is not shown.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OpenError {
    /// The reason, for the player.
    pub reason: String,
    /// Whether the recording is damaged, so that [`AppServices::save_readable_part`] may help.
    pub is_damaged: bool,
}

/// Starts games and finds texts.
pub trait AppServices: Send + Sync {
    /// Starts a game. Takes seconds for a new pad: call it on a thread.
    ///
    /// # Errors
    /// The reason and what to do, for the player.
    fn start(&self, request: &PlayRequest) -> Result<Started, StartError>;

    /// Profiles: paths of the player's own files, then shipped names.
    fn profiles(&self) -> Vec<String>;

    /// Pads: paths of the player's own files, then shipped names.
    fn pads(&self) -> Vec<String>;

    /// Users: paths of the player's own files, then shipped names.
    fn users(&self) -> Vec<String>;

    /// The player's own calibrations of a pad, by its name.
    fn calibrations(&self, pad: &str) -> Vec<PathBuf> {
        let folder = self.own_folder().map(|folder| folder.join("calibrations"));
        let entries = folder.and_then(|folder| std::fs::read_dir(folder).ok());
        let paths = entries.into_iter().flatten().flatten();
        let mut files: Vec<PathBuf> = paths
            .map(|entry| entry.path())
            .filter(|path| is_calibration_of(path, pad))
            .collect();
        files.sort();
        files
    }

    /// Names of the serial ports.
    fn ports(&self) -> Vec<String>;

    /// Listens to a port for 10 s at most: call it on a thread, while no game reads the port.
    ///
    /// # Errors
    /// The port cannot be opened, or it disappears.
    fn diagnose_port(&self, port: &str, board: BoardLine) -> Result<PortDiagnosis, String> {
        diagnose(port, board).map_err(|error| error.to_string())
    }

    /// What stands between gelpad and a virtual gamepad or gamepads as a source, each with its fix.
    fn gamepad_checks(&self) -> Vec<GamepadCheck> {
        gamepads::checks()
    }

    /// The text of a profile.
    ///
    /// # Errors
    /// Why it cannot be read.
    fn profile_text(&self, name: &str) -> Result<String, String>;

    /// Checks a profile text with its bases and a user's settings.
    ///
    /// # Errors
    /// All mistakes, each with its place.
    fn check_profile(&self, profile: Source, user: Option<&str>) -> Result<Checked, SourceErrors>;

    /// The text of a user's settings.
    ///
    /// # Errors
    /// Why it cannot be read.
    fn user_text(&self, name: &str) -> Result<String, String> {
        match crate::profile::shipped_user(name) {
            Some(user) => Ok(user.toml.to_owned()),
            None => std::fs::read_to_string(name).map_err(|error| format!("{name}: {error}")),
        }
    }

    /// The text of a pad.
    ///
    /// # Errors
    /// Why it cannot be read.
    fn pad_text(&self, name: &str) -> Result<String, String>;

    /// Reads a recording, or frames as CSV for the pad and profile of the request; may take seconds.
    ///
    /// # Errors
    /// Why it cannot be read.
    fn load_timeline(
        &self,
        file: &Path,
        request: &PlayRequest,
    ) -> Result<RecordingTimeline, OpenError>;

    /// Saves what can be read of a damaged recording beside it, under a new name. May take seconds.
    ///
    /// # Errors
    /// Too little can be read, or the copy cannot be written: the reason and what to do, for the player.
    fn save_readable_part(&self, recording: &Path) -> Result<SavedPart, String> {
        let saved = save_readable_part(recording, &|_, _| ());
        saved.map_err(|error| error.to_string())
    }

    /// Places for guided presses, spread over a pad, mm.
    fn calibration_places(&self, pad: &Pad, count: usize) -> Vec<PointMm>;

    /// Learns a calibration from presses and saves it; returns the file and a sentence about its error.
    ///
    /// # Errors
    /// Why nothing can be learned or saved.
    fn calibrate(&self, pad: &Pad, presses: Vec<Press>) -> Result<(PathBuf, String), String>;

    /// Begins to find how the pad of a request differs from its drawing, from guided presses; what is found is saved as a pad of the
    /// player's own. Takes seconds.
    fn begin_identifying(
        &self,
        request: &PlayRequest,
        readings: GuidedReadings,
    ) -> mpsc::Receiver<FoundFromPresses>;

    /// Recommends settings from guided presses.
    ///
    /// # Errors
    /// Why nothing is recommended.
    fn recommend(
        &self,
        trials: &[PressTrial],
        request: &PlayRequest,
        pad_mm: [f64; 2],
    ) -> Result<Recommendation, String>;

    /// The folder of the player's own profiles and users.
    fn own_folder(&self) -> Option<PathBuf>;

    /// Shows a folder in the desktop's file manager.
    ///
    /// # Errors
    /// There is no file manager: the reason, for the player.
    fn show_folder(&self, folder: &Path) -> Result<(), String> {
        let shown = open::that_detached(folder);
        shown.map_err(|error| format!("no file manager opens {}: {error}", folder.display()))
    }

    /// The folder of recordings, which are data and no settings.
    fn recordings_folder(&self) -> Option<PathBuf> {
        self.own_folder().map(|folder| folder.join("recordings"))
    }
}

/// Whether a file is named as [`crate::calibrate::calibration_file_name`] names the calibrations of a pad.
fn is_calibration_of(path: &Path, pad: &str) -> bool {
    let name = path.file_name().and_then(|name| name.to_str());
    let stem = name.and_then(|name| name.strip_suffix(".calibration.json"));
    let number = stem.and_then(|stem| stem.strip_prefix(pad));
    number.is_some_and(|rest| {
        rest.is_empty()
            || rest
                .strip_prefix('-')
                .is_some_and(|n| n.parse::<u32>().is_ok())
    })
}
