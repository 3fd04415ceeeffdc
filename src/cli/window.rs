//! `gelpad` without a command: the window, or where there is none the level in the terminal.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context as _;
use clap::Parser as _;

use super::args::{Arguments, Command, PlayArgs};
use super::changes::Changes;
use super::exit::{self, Ending};
use super::outputs::{self, Takes};
use super::played_with::{Asides, PlayedWith, Recording};
use super::{calibrate, gamepads, play, replay, resolve};
use crate::calibrate::recommend::{Recommendation, Trial, recommend};
use crate::calibrate::{Press, Presses, correction};
use crate::engine::{Engine, Input};
use crate::gui::desk::{Choice, Desk, From, Started, To, Watch};
use crate::gui::hush::Hushed;
use crate::gui::record::tape::Tape;
use crate::gui::{self, Opening, Tab};
use crate::output::Device;
use crate::pad::{Pad, SHIPPED_PADS};
use crate::profile::{Checked, Profile, SHIPPED_PROFILES, SHIPPED_USERS, Source};
use crate::runtime::{self, Running};
use crate::source::{LiveSource, Noise, Reading, open_file};
use crate::tape::Played;
use crate::types::{Faulty, PointMm};

/// Noise of the simulated pad, dB, and its seed.
const NOISE: (f64, u64) = (60.0, 1);

/// Opens the window; where that cannot be, says why in a line and plays the level in the terminal.
pub(super) fn open() -> anyhow::Result<Ending> {
    if !has_display() {
        tracing::warn!(
            "no window: there is no display (DISPLAY, WAYLAND_DISPLAY); the level plays here"
        );
        return play::level();
    }
    let signals = play::Signals::listen()?;
    let signals = Arc::new(signals);
    let heard = Arc::clone(&signals);
    let opened = gui::open(Opening {
        desk: Arc::new(OwnDesk),
        choice: Choice::default(),
        tab: Tab::Play,
        interrupted: Box::new(move || heard.received().is_some()),
    });
    match opened {
        Ok(()) => Ok(match signals.received() {
            Some(signal) => Ending::Signal(signal),
            None => Ending::Done,
        }),
        Err(error) => {
            tracing::warn!("{error}; the level plays here");
            drop(signals);
            play::level()
        }
    }
}

/// Whether a window can be hoped for: macOS and Windows always have a display.
fn has_display() -> bool {
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    cfg!(not(target_os = "linux"))
        || is_set("DISPLAY")
        || is_set("WAYLAND_DISPLAY")
        || is_set("WAYLAND_SOCKET")
}

/// Starts games for the window as `gelpad play` would.
struct OwnDesk;

impl Desk for OwnDesk {
    fn start(&self, choice: &Choice) -> Result<Started, String> {
        start(choice).map_err(|error| match error.downcast_ref::<Faulty>() {
            Some(faulty) => first_words(faulty),
            None => format!("{error:#}"),
        })
    }

    fn profiles(&self) -> Vec<String> {
        let shipped = SHIPPED_PROFILES.iter().map(|p| p.name.to_owned());
        shipped.chain(own_files("profiles")).collect()
    }

    fn pads(&self) -> Vec<String> {
        let shipped = SHIPPED_PADS.iter().map(|p| p.name.to_owned());
        shipped.chain(own_files("pads")).collect()
    }

    fn users(&self) -> Vec<String> {
        let shipped = SHIPPED_USERS.iter().map(|p| p.name.to_owned());
        shipped.chain(own_files("users")).collect()
    }

    fn ports(&self) -> Vec<String> {
        let ports = serialport::available_ports().unwrap_or_default();
        let mut names: Vec<String> = ports.into_iter().map(|port| port.port_name).collect();
        names.sort();
        names
    }

    fn profile_text(&self, name: &str) -> Result<String, String> {
        resolve::profile_text(name)
            .map(|text| text.toml)
            .map_err(|error| format!("{error:#}"))
    }

    fn check(&self, profile: Source, user: Option<&str>) -> Result<Checked, Faulty> {
        resolve::checked_text(profile, user)
    }

    fn own_folder(&self) -> Option<PathBuf> {
        resolve::own_folder()
    }

    fn tape(&self, file: &Path, choice: &Choice) -> Result<Tape, String> {
        tape(file, choice).map_err(|error| format!("{error:#}"))
    }

    fn places(&self, pad: &Pad, count: usize) -> Vec<PointMm> {
        calibrate::places(pad, count)
    }

    fn calibrate(&self, pad: &Pad, presses: Vec<Press>) -> Result<(PathBuf, String), String> {
        learn(pad, presses).map_err(|error| format!("{error:#}"))
    }

    fn recommend(
        &self,
        trials: &[Trial],
        choice: &Choice,
        pad_mm: [f64; 2],
    ) -> Result<Recommendation, String> {
        let text = resolve::profile_text(&choice.profile).map_err(|error| format!("{error:#}"))?;
        let profile = Source::from(text);
        let find = resolve::bases_of(&profile.name);
        recommend(trials, &profile, &find, pad_mm).map_err(|error| error.to_string())
    }

    fn pad_text(&self, name: &str) -> Result<String, String> {
        resolve::pad_text(name)
            .map(|text| text.toml)
            .map_err(|error| format!("{error:#}"))
    }
}

/// The player's own texts of a kind, as paths.
fn own_files(kind: &str) -> Vec<String> {
    let Some(folder) = resolve::own_folder() else {
        return Vec::new();
    };
    let Ok(entries) = std::fs::read_dir(folder.join(kind)) else {
        return Vec::new();
    };
    let mut files: Vec<String> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .map(|path| path.display().to_string())
        .collect();
    files.sort();
    files
}

/// What `gelpad play` would be told.
fn arguments(choice: &Choice) -> anyhow::Result<PlayArgs> {
    let source = match &choice.from {
        From::Hand | From::Level => "simulated".to_owned(),
        From::Serial(port) => format!("serial:{port}"),
        From::Replay(file) => format!("replay:{}", file.display()),
    };
    let output = match choice.to {
        To::Nothing => "trace",
        To::Auto => "auto",
    };
    let mut words = vec![
        "gelpad".to_owned(),
        "play".to_owned(),
        choice.profile.clone(),
        format!("--pad={}", choice.pad),
        format!("--source={source}"),
        format!("--output={output}"),
    ];
    if let Some(user) = &choice.user {
        words.push(format!("--user={user}"));
    }
    if let Some(file) = &choice.calibration {
        words.push(format!("--calibration={}", file.display()));
    }
    if let Some(file) = &choice.record {
        words.push(format!("--record={}", file.display()));
    }
    match Arguments::try_parse_from(words)?.command {
        Some(Command::Play(args)) => Ok(args),
        _ => anyhow::bail!("a bug in gelpad: `play` is not understood"),
    }
}

fn start(choice: &Choice) -> anyhow::Result<Started> {
    let args = arguments(choice)?;
    let PlayedWith {
        pad,
        pad_toml,
        checked,
        argument,
        correction,
    } = PlayedWith::of(&args)?;
    let profile = Arc::new(checked.profile.clone());
    let method = resolve::method(args.method, &profile, &pad);
    let (builder, kit) = play::kit(pad, pad_toml, Arc::clone(&profile), method, correction)?;
    let (source, hand): (gamepads::Opened, _) = match choice.from {
        From::Hand => {
            let (source, hand) = LiveSource::new(&kit.pad, Noise::new(NOISE.0, NOISE.1))?;
            (Box::new(|_| Box::new(source)), Some(hand))
        }
        _ => (play::source(&args, &kit.pad)?, None),
    };
    let device = match choice.to {
        To::Nothing => outputs::trace(true),
        // The player has asked for it: the simulated pad may type too.
        To::Auto => outputs::best(true).device,
    };
    let source = source(device.is_gamepad());
    let takes = Takes::of(device.as_ref());
    if let Some(lacking) = takes.lacking(&profile) {
        anyhow::bail!("{lacking}");
    }
    let output = match choice.to {
        To::Nothing => "nothing".to_owned(),
        To::Auto => device.name().to_owned(),
    };
    let (device, hush): (Box<dyn Device>, _) = match choice.to {
        To::Nothing => (device, None),
        To::Auto => {
            let (hushed, hush) = Hushed::new(device);
            (Box::new(hushed), Some(hush))
        }
    };
    let changes = argument.map(|argument| {
        let refuse = Box::new(move |profile: &Profile| takes.lacking(profile));
        Changes::new(&argument, args.user.as_deref(), &checked, None, refuse)
    });
    let Asides {
        listeners,
        recorder,
    } = Asides::start(&args, &kit)?;
    let running = runtime::start_with(kit.engine(), builder, source, device, listeners)?;
    Ok(Started {
        running,
        hand,
        pad: kit.pad,
        output,
        hush,
        watch: Box::new(Watcher { changes, recorder }),
        warnings: checked.warnings.iter().map(first_words).collect(),
    })
}

/// Runs what was recorded through its own engine.
fn tape(file: &Path, choice: &Choice) -> anyhow::Result<Tape> {
    if replay::is_recording(file)? {
        let (mut player, kit) = replay::open(file)?;
        let mut tape = Tape::new(kit.pad.clone(), kit.engine());
        while let Some(played) = player.next()? {
            if let Played::Input(input) = played
                && !tape.take(&input)
            {
                break;
            }
        }
        return Ok(tape);
    }
    let args = arguments(choice)?;
    let pad = resolve::pad(&choice.pad)?;
    let mut frames = open_file(file, &pad)?;
    let profile = resolve::profile(&choice.profile, choice.user.as_deref())?;
    let correction = resolve::correction(args.calibration.as_deref(), &pad)?;
    let builder = resolve::sensing(&pad, resolve::method(args.method, &profile, &pad))?;
    let engine = Engine::new(&pad, Arc::new(builder.first()?), profile).corrected(correction);
    let mut tape = Tape::new(pad, engine);
    loop {
        match frames.read()? {
            Reading::Frame(frame) => {
                if !tape.take(&Input::Frame(frame)) {
                    return Ok(tape);
                }
            }
            Reading::End => return Ok(tape),
            Reading::Control(_)
            | Reading::Skipped { .. }
            | Reading::Gone { .. }
            | Reading::Idle => {}
        }
    }
}

/// Learns a calibration and saves it in the player's own folder.
fn learn(pad: &Pad, presses: Vec<Press>) -> anyhow::Result<(PathBuf, String)> {
    let presses = Presses::new("the presses", presses)?;
    let fitted = correction(&presses, pad.outline.size_mm())?;
    let folder =
        resolve::own_folder().context("there is no folder for settings of your own: set HOME")?;
    let folder = folder.join("calibrations");
    std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    let path = folder.join(format!("{}.calibration.json", pad.name));
    calibrate::save(&path, pad, &fitted.correction, fitted.lone.mean_mm)?;
    let told = format!(
        "touches were off by {:.1} mm, now by {:.1} mm (mean, each press left out in turn)",
        fitted.model.mean_mm, fitted.lone.mean_mm
    );
    Ok((path, told))
}

/// Looks after a game of the window.
struct Watcher {
    changes: Option<Changes>,
    recorder: Option<Recording>,
}

impl Watch for Watcher {
    fn look(&mut self, running: &mut Running, say: &mut dyn FnMut(String)) {
        if let Some(changes) = &mut self.changes {
            changes.look(running, &mut |text| say(play::in_one_line(text)));
        }
    }

    fn end(&mut self) {
        if let Some(recorder) = self.recorder.take() {
            recorder.conclude();
        }
    }
}
/// The first fault of a text, with its place.
fn first_words(faulty: &Faulty) -> String {
    match faulty.faults.first() {
        Some(fault) => {
            let (line, column) = faulty.line_column(fault.span.start);
            format!("{}:{line}:{column}: {}", faulty.name, fault.message)
        }
        None => exit::drawn(faulty, miette::Severity::Error),
    }
}
