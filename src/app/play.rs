//! Games: everything opened first, then started.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::focus_gate::FocusGate;
use super::identify::{Identification, PadIdentifier};
use super::listeners::{Listeners, check_recording};
use super::outputs::{self, OutputAbilities};
use super::pads::{
    PadText, choose_method, config_with_builder, engine_config, sensing_by_image, start_workers,
};
use super::play_config::PlayConfig;
use super::process_match::ProfileMatcher;
use super::recording::ActiveRecording;
use super::reload::ProfileReload;
use super::request::{OutputChoice, PlayRequest, SourceChoice};
use super::source::open_requested;
use super::table_solver::{TableInProgress, TableSolver, TableStart};
use super::{AppError, Progress};
use crate::output::OutputDevice;
use crate::pad::Pad;
use crate::profile::Profile;
use crate::runtime::{self, RunningGame};
use crate::source::serial::serial_number;
use crate::source::{LiveFingers, Source};
use crate::tape::EngineConfig;
use crate::touch::{Correction, SensingBuilder};
use crate::types::{Method, SourceErrors};

/// A game whose source and output are open; nothing plays yet.
pub(crate) struct PreparedGame {
    /// Name of the output.
    pub output: String,
    /// For [`OutputChoice::Auto`]: which output was chosen, and why no better one.
    pub output_note: Option<String>,
    /// Warnings about the profile.
    pub warnings: Vec<SourceErrors>,
    config: EngineConfig,
    builder: SensingBuilder,
    source: Box<dyn Source>,
    hand: Option<LiveFingers>,
    device: Box<dyn OutputDevice>,
    keys_blocked: Option<Arc<AtomicBool>>,
    reload: Option<ProfileReload>,
    listeners: Listeners,
    table: Option<Arc<TableInProgress>>,
    identifier: Option<PadIdentifier>,
}

/// What happens while the pad has no solved response table, the first time it is used.
pub(crate) enum FirstUse<'a> {
    /// The game starts when it is solved, which takes seconds.
    Wait(Progress<'a>),
    /// The game starts at once and finds touches in images; the table arrives later. A game that is recorded waits: its
    /// recording contains the table from the start.
    PlayAtOnce(&'a TableSolver),
}

/// A game that plays.
pub(crate) struct Game {
    /// Its threads.
    pub running: RunningGame,
    /// The pad.
    pub pad: Pad,
    /// Name of the output.
    pub output: String,
    /// Presses the simulated pad, with [`SourceChoice::Simulated`].
    pub hand: Option<LiveFingers>,
    /// While set, no key is sent.
    pub keys_blocked: Option<Arc<AtomicBool>>,
    /// Loads the profile again when its files change.
    pub reload: Option<ProfileReload>,
    /// The recording that is being made.
    pub recording: Option<ActiveRecording>,
    /// Warnings about the profile.
    pub warnings: Vec<SourceErrors>,
    /// The response table, if it is still being solved.
    pub table: Option<Arc<TableInProgress>>,
    /// Identifies the pad on a board.
    pub identifier: Option<PadIdentifier>,
}

/// Builder of matrices, the engine's configuration, and a table that is not ready yet.
type EngineSetUp = ((SensingBuilder, EngineConfig), Option<Arc<TableInProgress>>);

impl PreparedGame {
    /// Opens everything that a request names.
    pub(crate) fn prepare(
        request: &PlayRequest,
        first_use: &FirstUse<'_>,
    ) -> Result<Self, AppError> {
        check_recording(request)?;
        let PlayConfig {
            pad,
            checked,
            argument,
            correction,
        } = PlayConfig::load(request)?;
        let (identification, pad) = start_of_identification(request, pad);
        let profile = Arc::new(checked.profile);
        check_gamepad_profile(request, &profile)?;
        let (source, hand) = open_requested(request, &pad.pad)?;
        let chosen = outputs::open(request.output, request.trace_on_stdout)?;
        let source = source(chosen.device.is_gamepad());
        let abilities = OutputAbilities::from_device(chosen.device.as_ref());
        if let Some(missing) = abilities.missing_for(&profile) {
            return Err(AppError::Unsuitable(missing));
        }
        let reload = start_reload(request, argument, &profile, abilities)?;
        let method = choose_method(request.method, &profile, &pad.pad);
        let is_recorded = request.record.is_some();
        let ((builder, config), table) =
            set_up_engine(first_use, is_recorded, (pad, profile, correction), method)?;
        let mut listeners = Listeners::start(request, &config, method)?;
        let mut identifier = None;
        if let Some(identification) = identification {
            let started = identification.start(method, table.clone());
            let (listener, started) = started.map_err(AppError::Thread)?;
            listeners.listeners.push(listener);
            identifier = Some(started);
        }
        Ok(Self {
            output: match request.output {
                OutputChoice::Nothing => "nothing".to_owned(),
                _ => chosen.device.name().to_owned(),
            },
            output_note: chosen.note,
            warnings: checked.warnings,
            config,
            builder,
            source,
            hand,
            device: chosen.device,
            keys_blocked: None,
            reload,
            listeners,
            table,
            identifier,
        })
    }

    /// The pad.
    pub(crate) fn pad(&self) -> &Pad {
        &self.config.pad
    }

    /// Adds a gate that holds keys back while a window has the focus.
    pub(crate) fn with_focus_gate(mut self) -> Self {
        let (gate, keys_blocked) = FocusGate::new(self.device);
        self.device = Box::new(gate);
        self.keys_blocked = Some(keys_blocked);
        self
    }

    /// Starts the threads.
    pub(crate) fn start(self) -> Result<Game, AppError> {
        let Listeners {
            listeners,
            recording,
        } = self.listeners;
        let engine = self.config.engine();
        let running = runtime::start_with_listeners(
            engine,
            self.builder,
            self.source,
            self.device,
            listeners,
        )
        .map_err(AppError::Thread)?;
        Ok(Game {
            running,
            pad: self.config.pad,
            output: self.output,
            hand: self.hand,
            keys_blocked: self.keys_blocked,
            reload: self.reload,
            recording,
            warnings: self.warnings,
            table: self.table,
            identifier: self.identifier,
        })
    }
}

/// Watches the profile's files, unless the profile is no file.
fn start_reload(
    request: &PlayRequest,
    argument: Option<String>,
    profile: &Profile,
    abilities: OutputAbilities,
) -> Result<Option<ProfileReload>, AppError> {
    let Some(argument) = argument else {
        return Ok(None);
    };
    let matcher = request
        .match_programs
        .then(|| ProfileMatcher::new(&argument));
    let user = request.user.clone();
    let reload = ProfileReload::start(argument, user, profile, matcher, abilities);
    reload.map(Some).map_err(AppError::Thread)
}

/// What an engine starts from, and the table that is still being solved: a recording waits for it, since its events must not depend on
/// when it is ready.
fn set_up_engine(
    first_use: &FirstUse<'_>,
    is_recorded: bool,
    (pad, profile, correction): (PadText, Arc<Profile>, Option<Correction>),
    method: Method,
) -> Result<EngineSetUp, AppError> {
    match first_use {
        FirstUse::PlayAtOnce(solver) if !is_recorded => {
            let (builder, table) = begin_at_once(solver, &pad.pad, method)?;
            let config = config_with_builder(pad, profile, correction, builder)?;
            Ok((config, table))
        }
        FirstUse::PlayAtOnce(solver) => {
            solver.wait(&pad.pad);
            let config = engine_config(pad, profile, method, correction, &|_, _| ())?;
            Ok((config, None))
        }
        FirstUse::Wait(progress) => {
            let config = engine_config(pad, profile, method, correction, progress)?;
            Ok((config, None))
        }
    }
}

/// Sensing with the response table if it was solved before, else by images until it is.
fn begin_at_once(
    solver: &TableSolver,
    pad: &Pad,
    method: Method,
) -> Result<(SensingBuilder, Option<Arc<TableInProgress>>), AppError> {
    start_workers()?;
    let (start, builder) = rayon::join(|| solver.start(pad), || sensing_by_image(pad, method));
    Ok(match start.map_err(AppError::Thread)? {
        TableStart::Ready(table) => (builder?.with_table(table), None),
        TableStart::Solving(table) => (builder?, Some(table)),
    })
}

/// How the pad of a board is identified, and the pad to start with. A pad that was found or learned by a command, one with a calibration,
/// which was learned with it, and one to be played as drawn stay as they are.
fn start_of_identification(
    request: &PlayRequest,
    pad: PadText,
) -> (Option<Identification>, PadText) {
    let SourceChoice::Serial(port) = &request.source else {
        return (None, pad);
    };
    let is_known = !pad.pad.deviations.is_none() || pad.pad.learned.is_some();
    if request.as_drawn || request.calibration.is_some() || is_known {
        return (None, pad);
    }
    let serial = serial_number(port);
    let board = serial.as_deref().unwrap_or(port);
    let (identification, start) = Identification::new(pad, board, serial.is_some());
    let identification = match request.record {
        Some(_) => identification.for_next_start(),
        None => identification,
    };
    (Some(identification), start)
}

/// Only bindings with `from` are played by a gamepad.
fn check_gamepad_profile(request: &PlayRequest, profile: &Profile) -> Result<(), AppError> {
    if request.source == SourceChoice::Gamepad && profile.parts.is_empty() {
        return Err(AppError::Unsuitable(format!(
            "a gamepad cannot play the profile {}: none of its bindings has a `from`\n  help: write `from = \"pad:a\"` in a binding, or try the profile super-mario-gamepad",
            profile.name
        )));
    }
    Ok(())
}
