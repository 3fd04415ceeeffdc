//! A desk without engines: texts from a folder of the test, games that do not start.

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use gelpad::calibrate::Press;
use gelpad::calibrate::recommend::{Recommendation, Trial, recommend};
use gelpad::gui::desk::{Choice, Desk, Started};
use gelpad::gui::record::tape::Tape;
use gelpad::pad::{Pad, SHIPPED_PADS, shipped_pad};
use gelpad::profile::{
    self, Checked, SHIPPED_PROFILES, SHIPPED_USERS, Source, find_shipped, shipped_profile,
};
use gelpad::types::{Faulty, PointMm};

/// Why no game starts here.
pub const NO_START: &str = "no port /dev/ttyTEST: plug the board in";

pub struct TestDesk {
    pub folder: tempfile::TempDir,
    pub ports: Mutex<Vec<String>>,
    /// What was to be started.
    pub started: Mutex<Vec<Choice>>,
    /// Presses that were to be learned from.
    pub calibrated: Mutex<usize>,
    pub tape: Mutex<Option<Tape>>,
}

impl TestDesk {
    pub fn new() -> Self {
        Self {
            folder: tempfile::tempdir().expect("a folder"),
            ports: Mutex::new(Vec::new()),
            started: Mutex::new(Vec::new()),
            calibrated: Mutex::new(0),
            tape: Mutex::new(None),
        }
    }

    /// A shipped profile as a file of the player's own.
    pub fn own_profile(&self, name: &str) -> PathBuf {
        let path = self.folder.path().join("mine.toml");
        let text = shipped_profile(name).expect("shipped").toml;
        std::fs::write(&path, text).expect("written");
        path
    }

    /// The last game that was to be started.
    pub fn last(&self) -> Option<Choice> {
        self.started.lock().expect("no panic").last().cloned()
    }
}

impl Desk for TestDesk {
    fn start(&self, choice: &Choice) -> Result<Started, String> {
        self.started.lock().expect("no panic").push(choice.clone());
        Err(NO_START.to_owned())
    }

    fn profiles(&self) -> Vec<String> {
        SHIPPED_PROFILES.iter().map(|p| p.name.to_owned()).collect()
    }

    fn pads(&self) -> Vec<String> {
        SHIPPED_PADS.iter().map(|p| p.name.to_owned()).collect()
    }

    fn users(&self) -> Vec<String> {
        SHIPPED_USERS.iter().map(|p| p.name.to_owned()).collect()
    }

    fn ports(&self) -> Vec<String> {
        self.ports.lock().expect("no panic").clone()
    }

    fn profile_text(&self, name: &str) -> Result<String, String> {
        match shipped_profile(name) {
            Some(shipped) => Ok(shipped.toml.to_owned()),
            None => std::fs::read_to_string(name).map_err(|error| format!("{name}: {error}")),
        }
    }

    fn check(&self, profile: Source, _: Option<&str>) -> Result<Checked, Faulty> {
        profile::read(profile, None, &find_shipped)
    }

    fn pad_text(&self, name: &str) -> Result<String, String> {
        shipped_pad(name)
            .map(|pad| pad.toml.to_owned())
            .ok_or_else(|| format!("no pad is named {name}"))
    }

    fn tape(&self, file: &Path, _: &Choice) -> Result<Tape, String> {
        let tape = self.tape.lock().expect("no panic").take();
        tape.ok_or_else(|| format!("{}: this is no recording", file.display()))
    }

    fn places(&self, _: &Pad, count: usize) -> Vec<PointMm> {
        (0..count).map(|i| [10.0 + 3.0 * i as f64, 50.0]).collect()
    }

    fn calibrate(&self, _: &Pad, presses: Vec<Press>) -> Result<(PathBuf, String), String> {
        *self.calibrated.lock().expect("no panic") = presses.len();
        Ok((
            self.folder.path().join("pad.calibration.json"),
            "touches were off by 3.0 mm, now by 1.0 mm".to_owned(),
        ))
    }

    fn recommend(
        &self,
        trials: &[Trial],
        choice: &Choice,
        pad_mm: [f64; 2],
    ) -> Result<Recommendation, String> {
        let profile = Source {
            name: choice.profile.clone(),
            toml: self.profile_text(&choice.profile)?,
        };
        recommend(trials, &profile, &find_shipped, pad_mm).map_err(|error| error.to_string())
    }

    fn own_folder(&self) -> Option<PathBuf> {
        Some(self.folder.path().to_owned())
    }
}
