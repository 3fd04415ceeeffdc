//! `gelpad` without a command: the window, or where there is none the level in the terminal.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Parser as _;

use super::args::{Arguments, Command, PlayArgs};
use super::changes::Changes;
use super::exit::{self, Ending};
use super::{play, resolve};
use crate::gui::desk::{Choice, Desk, From, Started, To, Watch};
use crate::gui::hush::Hushed;
use crate::gui::{self, Opening, Tab};
use crate::output::Device;
use crate::pad::SHIPPED_PADS;
use crate::profile::{Checked, SHIPPED_PROFILES, SHIPPED_USERS, Source};
use crate::runtime::{self, Running};
use crate::source::{self, LiveSource, Noise};
use crate::types::{Faulty, Output};

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
    match Arguments::try_parse_from(words)?.command {
        Some(Command::Play(args)) => Ok(args),
        _ => anyhow::bail!("a bug in gelpad: `play` is not understood"),
    }
}

fn start(choice: &Choice) -> anyhow::Result<Started> {
    let args = arguments(choice)?;
    let pad = resolve::pad(&args.pad)?;
    let checked = resolve::checked(&args.profile, args.user.as_deref())?;
    let profile = Arc::new(checked.profile.clone());
    let correction = resolve::correction(args.calibration.as_deref(), &pad)?;
    let method = resolve::method(args.method, &profile, &pad);
    let made = play::engine(&pad, profile.clone(), method, correction)?;
    let (source, hand): (Box<dyn source::Source>, _) = match choice.from {
        From::Hand => {
            let (source, hand) = LiveSource::new(&pad, Noise::new(NOISE.0, NOISE.1))?;
            (Box::new(source), Some(hand))
        }
        _ => (play::source(&args, &pad)?, None),
    };
    let device: Box<dyn Device> = match choice.to {
        To::Nothing => play::silent(),
        To::Auto => play::desktop(&profile)?,
    };
    let takes = play::Takes::of(device.as_ref());
    if let Some(lacking) = takes.lacking(&profile) {
        anyhow::bail!("{lacking}");
    }
    let is_keyboard =
        choice.to == To::Auto && "key:a".parse::<Output>().is_ok_and(|key| device.takes(key));
    let output = match choice.to {
        To::Nothing => "nothing".to_owned(),
        To::Auto => device.name().to_owned(),
    };
    let (device, hush): (Box<dyn Device>, _) = if is_keyboard {
        let (hushed, hush) = Hushed::new(device);
        (Box::new(hushed), Some(hush))
    } else {
        (device, None)
    };
    let changes = Changes::new(
        &args.profile,
        args.user.as_deref(),
        &checked,
        None,
        Box::new(move |profile| takes.lacking(profile)),
    );
    let (engine, builder) = made;
    let running = runtime::start(engine, builder, source, device)?;
    Ok(Started {
        running,
        hand,
        pad,
        output,
        hush,
        watch: Box::new(Watcher(changes)),
        warnings: checked.warnings.iter().map(first_words).collect(),
    })
}

struct Watcher(Changes);

impl Watch for Watcher {
    fn look(&mut self, running: &mut Running, say: &mut dyn FnMut(String)) {
        self.0
            .look(running, &mut |text| say(play::in_one_line(text)));
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
