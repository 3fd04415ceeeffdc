//! What the window asks of whoever starts games: it names what is wanted and gets a running game, a text, or a sentence that
//! says what is wrong. The command line gives it, so that both resolve names and files in the same way; tests give their own.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::record::tape::Tape;
use crate::calibrate::Press;
use crate::calibrate::recommend::{Recommendation, Trial};
use crate::pad::Pad;
use crate::profile::{Checked, Source};
use crate::runtime::Running;
use crate::source::Hand;
use crate::types::{Faulty, PointMm};

/// Where frames come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum From {
    /// The simulated pad, pressed in the window.
    Hand,
    /// The simulated pad, pressed by the level's script.
    Level,
    /// A board.
    Serial(String),
    /// A recording, or frames as CSV.
    Replay(PathBuf),
}

/// Where events go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum To {
    /// Nowhere: a try-out.
    Nothing,
    /// Whatever this desktop has.
    Auto,
}

/// What is to be played.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Choice {
    /// A shipped pad, or a file.
    pub pad: String,
    /// A shipped profile, or a file.
    pub profile: String,
    /// One person's settings.
    pub user: Option<String>,
    /// Where frames come from.
    pub from: From,
    /// Where events go.
    pub to: To,
    /// What a calibration saved.
    pub calibration: Option<PathBuf>,
    /// Where the recording goes, if one is made.
    pub record: Option<PathBuf>,
}

impl Default for Choice {
    fn default() -> Self {
        Self {
            pad: crate::pad::DEFAULT_PAD.to_owned(),
            profile: crate::profile::DEFAULT_PROFILE.to_owned(),
            user: None,
            from: From::Hand,
            to: To::Nothing,
            calibration: None,
            record: None,
        }
    }
}

impl Choice {
    /// Where frames come from, in words.
    #[must_use]
    pub fn source_words(&self) -> String {
        match &self.from {
            From::Hand => "simulated pad, your mouse".to_owned(),
            From::Level => "simulated pad, the level".to_owned(),
            From::Serial(port) => port.clone(),
            From::Replay(file) => match file.file_name() {
                Some(name) => name.to_string_lossy().into_owned(),
                None => file.display().to_string(),
            },
        }
    }
}

/// What looks after a game while it runs: saved profiles go live.
pub trait Watch: Send {
    /// Looks once; says what the player should know.
    fn look(&mut self, running: &mut Running, say: &mut dyn FnMut(String));

    /// The game is over and its threads are joined: packs what was recorded.
    fn end(&mut self) {}
}

/// A game that has been started.
pub struct Started {
    /// The threads.
    pub running: Running,
    /// What presses the simulated pad, if it is that.
    pub hand: Option<Hand>,
    /// The pad.
    pub pad: Pad,
    /// A word for the device that events go to.
    pub output: String,
    /// Set while no key may be sent: the window has the focus, and would get it.
    pub hush: Option<Arc<AtomicBool>>,
    /// What looks after it.
    pub watch: Box<dyn Watch>,
    /// What is odd about the profile.
    pub warnings: Vec<String>,
}

/// Who starts games and finds texts.
pub trait Desk: Send + Sync {
    /// Starts a game; may take seconds, so it is called on a thread of its own.
    ///
    /// # Errors
    /// Why not, and what to do, for the player.
    fn start(&self, choice: &Choice) -> Result<Started, String>;

    /// Names of profiles: the shipped ones, then the player's own files.
    fn profiles(&self) -> Vec<String>;

    /// Names of pads.
    fn pads(&self) -> Vec<String>;

    /// Names of people whose settings are known.
    fn users(&self) -> Vec<String>;

    /// Serial ports where a board may be.
    fn ports(&self) -> Vec<String>;

    /// The text of a profile.
    ///
    /// # Errors
    /// Why it cannot be read.
    fn profile_text(&self, name: &str) -> Result<String, String>;

    /// Whether a text can be played, with the bases and the person that it needs.
    ///
    /// # Errors
    /// Everything that is wrong, each at its place.
    fn check(&self, profile: Source, user: Option<&str>) -> Result<Checked, Faulty>;

    /// The text of a pad.
    ///
    /// # Errors
    /// Why it cannot be read.
    fn pad_text(&self, name: &str) -> Result<String, String>;

    /// Reads a recording, or frames as CSV for what is played now; may take seconds.
    ///
    /// # Errors
    /// Why it cannot be read.
    fn tape(&self, file: &Path, choice: &Choice) -> Result<Tape, String>;

    /// Places to press for a calibration, spread over a pad, mm.
    fn places(&self, pad: &Pad, count: usize) -> Vec<PointMm>;

    /// Learns from presses and saves what was learned; where, and how good it is in words.
    ///
    /// # Errors
    /// Why nothing can be learned, or not saved.
    fn calibrate(&self, pad: &Pad, presses: Vec<Press>) -> Result<(PathBuf, String), String>;

    /// Recommends settings for who made the presses.
    ///
    /// # Errors
    /// Why nothing is recommended.
    fn recommend(
        &self,
        trials: &[Trial],
        choice: &Choice,
        pad_mm: [f64; 2],
    ) -> Result<Recommendation, String>;

    /// Where the player's own profiles and people lie.
    fn own_folder(&self) -> Option<PathBuf>;
}
