//! Services for tests: profiles from a temporary folder, games that never start.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, mpsc};

use gelpad::app::services::{
    AppServices, BoardLine, FoundFromPresses, OpenError, OutputChoice, PlayRequest, SavedPart,
    SourceChoice, StartError, Started, Watch,
};
use gelpad::app::timeline::RecordingTimeline;
use gelpad::calibrate::recommend::{PressTrial, Recommendation, RecommendedSettings, TrialScorer};
use gelpad::calibrate::{GuidedReadings, Press};
use gelpad::engine::Engine;
use gelpad::output::Trace;
use gelpad::pad::{Pad, SHIPPED_PADS, shipped_pad};
use gelpad::profile::{
    self, Checked, SHIPPED_PROFILES, SHIPPED_USERS, Source, find_shipped, shipped_profile,
};
use gelpad::runtime::{self, RunningGame};
use gelpad::source::serial::SerialSource;
use gelpad::source::{SourceError, SourcePace, SourceReading};
use gelpad::touch::SensingBuilder;
use gelpad::types::{Method, PointMm, SourceErrors};

/// Why no game starts.
pub const NO_START: &str = "no port /dev/ttyTEST: plug the board in";

/// Why an output does not open.
pub const NO_OUTPUT: &str = "no display and no /dev/uinput";

pub struct TestServices {
    pub folder: tempfile::TempDir,
    pub ports: Mutex<Vec<String>>,
    /// Games that were requested.
    pub started: Mutex<Vec<PlayRequest>>,
    /// Number of presses of the last calibration.
    pub calibrated: Mutex<usize>,
    /// Why nothing can be learned from presses, if so.
    pub calibration_error: Mutex<Option<String>>,
    pub tape: Mutex<Option<RecordingTimeline>>,
    /// Games start and read this board.
    pub board: Mutex<Option<TestBoard>>,
    /// The output that cannot be opened.
    pub broken_output: Mutex<Option<OutputChoice>>,
    /// Whether there is room for what can be read of a damaged recording: at the second try.
    can_save: Mutex<bool>,
    /// What the recommended settings make of the presses.
    pub found: Mutex<Found>,
    /// Folders that were shown.
    pub shown_folders: Mutex<Vec<PathBuf>>,
}

/// What recommended settings make of presses.
#[derive(Clone, Copy)]
pub enum Found {
    /// The same as before.
    Same,
    /// Some are wrong, before and after.
    NoHelp,
    /// All wrong.
    Worse,
    /// A few more are wrong, but no unintended ones come.
    FewerUnintended,
}

/// A board of a game that starts.
#[derive(Clone, Copy)]
pub enum TestBoard {
    /// Sends nothing.
    Silent,
}

/// Name and text of a shipped pad, or of a file.
fn pad_text(name: &str) -> Result<String, String> {
    match shipped_pad(name) {
        Some(pad) => Ok(pad.toml.to_owned()),
        None => std::fs::read_to_string(name).map_err(|_| format!("no pad called `{name}`")),
    }
}

/// A game that reads the port of the request.
fn play_port(port: &str, request: &PlayRequest) -> Result<Started, String> {
    let pad = Pad::from_toml(&request.pad, &pad_text(&request.pad)?).expect("sound");
    let BoardLine { format, baud } = request.board;
    let source = SerialSource::open(port, baud, &pad, format).map_err(|error| error.to_string())?;
    Ok(start_game(pad, Box::new(source)))
}

impl gelpad::source::Source for TestBoard {
    fn pace(&self) -> SourcePace {
        SourcePace::ByDevice
    }

    fn read(&mut self) -> Result<SourceReading, SourceError> {
        std::thread::sleep(std::time::Duration::from_millis(10));
        match self {
            Self::Silent => Ok(SourceReading::Idle),
        }
    }
}

/// Does nothing for a game.
struct NoWatch;

impl Watch for NoWatch {
    fn poll(&mut self, _: &mut RunningGame, _: &mut dyn FnMut(Option<String>)) {}
}

/// A game that reads a board.
fn start_game(pad: Pad, source: Box<dyn gelpad::source::Source>) -> Started {
    let profile = gelpad::gui::still::profile();
    let builder = SensingBuilder::new(&pad, Method::default()).expect("solvable");
    let sensing = std::sync::Arc::new(builder.build_initial().expect("a matrix"));
    let engine = Engine::new(&pad, sensing, profile);
    let device = Box::new(Trace::new(std::io::sink()));
    let running = runtime::start(engine, builder, source, device).expect("threads");
    Started {
        running,
        hand: None,
        pad,
        output: "nothing".to_owned(),
        keys_blocked: None,
        watch: Box::new(NoWatch),
        warnings: Vec::new(),
        table: None,
    }
}

impl TestServices {
    pub fn new() -> Self {
        Self {
            folder: tempfile::tempdir().expect("a folder"),
            ports: Mutex::new(Vec::new()),
            started: Mutex::new(Vec::new()),
            calibrated: Mutex::new(0),
            calibration_error: Mutex::new(None),
            tape: Mutex::new(None),
            board: Mutex::new(None),
            broken_output: Mutex::new(None),
            found: Mutex::new(Found::Same),
            shown_folders: Mutex::new(Vec::new()),
            can_save: Mutex::new(false),
        }
    }

    /// A copy of a shipped profile in the folder.
    pub fn copy_profile(&self, name: &str) -> PathBuf {
        let path = self.folder.path().join("mine.toml");
        let text = shipped_profile(name).expect("shipped").toml;
        std::fs::write(&path, text).expect("written");
        path
    }

    /// The last game that was requested.
    pub fn last_request(&self) -> Option<PlayRequest> {
        self.started.lock().expect("no panic").last().cloned()
    }
}

impl AppServices for TestServices {
    fn start(&self, request: &PlayRequest) -> Result<Started, StartError> {
        self.started.lock().expect("no panic").push(request.clone());
        if *self.broken_output.lock().expect("no panic") == Some(request.output) {
            return Err(StartError {
                reason: NO_OUTPUT.to_owned(),
                is_output: true,
            });
        }
        let board = *self.board.lock().expect("no panic");
        match (&request.source, board) {
            (_, Some(board)) => Ok(start_game(gelpad::gui::still::pad(), Box::new(board))),
            (SourceChoice::Serial(port), None) if Path::new(port).exists() => {
                play_port(port, request).map_err(StartError::of_game)
            }
            _ => Err(StartError::of_game(NO_START)),
        }
    }

    fn show_folder(&self, folder: &Path) -> Result<(), String> {
        let mut shown = self.shown_folders.lock().expect("no panic");
        shown.push(folder.to_owned());
        Ok(())
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

    fn check_profile(&self, profile: Source, _: Option<&str>) -> Result<Checked, SourceErrors> {
        profile::read(profile, None, &find_shipped)
    }

    fn pad_text(&self, name: &str) -> Result<String, String> {
        pad_text(name)
    }

    fn load_timeline(&self, file: &Path, _: &PlayRequest) -> Result<RecordingTimeline, OpenError> {
        let tape = self.tape.lock().expect("no panic").take();
        tape.ok_or_else(|| OpenError {
            reason: format!("{}: this is not a recording", file.display()),
            is_damaged: file.file_stem().is_some_and(|stem| stem == "damaged"),
        })
    }

    fn save_readable_part(&self, recording: &Path) -> Result<SavedPart, String> {
        let mut can_save = self.can_save.lock().expect("no panic");
        if !std::mem::replace(&mut *can_save, true) {
            return Err("no room on the disk".to_owned());
        }
        *self.tape.lock().expect("no panic") = Some(crate::record::timeline());
        Ok(SavedPart {
            path: recording.with_file_name("damaged-saved.mcap"),
            summary: "Saved 121 frames; one place could not be read".to_owned(),
            has_frames: true,
        })
    }

    fn calibration_places(&self, _: &Pad, count: usize) -> Vec<PointMm> {
        (0..count)
            .map(|i| [10.0 + 3.0 * i as f64, 30.0 + 20.0 * (i % 3) as f64])
            .collect()
    }

    fn calibrate(&self, _: &Pad, presses: Vec<Press>) -> Result<(PathBuf, String), String> {
        if let Some(why) = self.calibration_error.lock().expect("no panic").clone() {
            return Err(why);
        }
        *self.calibrated.lock().expect("no panic") = presses.len();
        Ok((
            self.folder.path().join("pad.calibration.json"),
            "touches were off by 3.0 mm, now by 1.0 mm".to_owned(),
        ))
    }

    fn begin_identifying(
        &self,
        _: &PlayRequest,
        readings: GuidedReadings,
    ) -> mpsc::Receiver<FoundFromPresses> {
        let (found_in, found) = mpsc::sync_channel(1);
        let path = self.folder.path().join("pad-found.toml");
        let untouched = match readings.untouched.len() {
            0..5 => "few",
            _ => "some",
        };
        let summary = format!(
            "{} presses and {untouched} untouched frames",
            readings.presses.len()
        );
        found_in.send(Ok((path, summary))).expect("awaited");
        found
    }

    fn recommend(
        &self,
        trials: &[PressTrial],
        request: &PlayRequest,
        pad_mm: [f64; 2],
    ) -> Result<Recommendation, String> {
        let profile = Source {
            name: request.profile.clone(),
            toml: self.profile_text(&request.profile)?,
        };
        // The search takes long and is tested elsewhere: recommend the profile itself.
        let judge = TrialScorer::new(&profile, &find_shipped, pad_mm);
        let of = |overlay: Option<&RecommendedSettings>| {
            judge.score(trials, overlay).map_err(|e| e.to_string())
        };
        let plain = judge.profile(None).map_err(|faulty| faulty.to_string())?;
        let overlay = RecommendedSettings::from_profile(&plain);
        let (mut before, mut after) = (of(None)?, of(Some(&overlay))?);
        match *self.found.lock().expect("no panic") {
            Found::Same => {}
            Found::NoHelp => {
                before.right -= 4;
                after = before;
            }
            Found::Worse => after.right = 0,
            Found::FewerUnintended => {
                before.wrong += 6;
                after.right -= 4;
            }
        }
        Ok(Recommendation {
            before,
            after,
            overlay,
        })
    }

    fn own_folder(&self) -> Option<PathBuf> {
        Some(self.folder.path().to_owned())
    }
}
