//! Requests of the views to the application, and the names to choose from.

use std::path::PathBuf;

use super::playing::Playing;
use super::tab::Tab;
use crate::app::services::{AppServices, OutputChoice, PlayRequest};

/// What a view requests of the application.
#[derive(Clone, Debug, PartialEq, Eq)]
#[allow(
    clippy::large_enum_variant,
    reason = "a few a session, never stored in bulk"
)]
pub enum UiAction {
    /// Start this game instead.
    Play(PlayRequest),
    /// Pause or resume the game.
    Pause,
    /// Show a view.
    Show(Tab),
    /// Open or close the pad-only window.
    PadWindow,
    /// Open or close the overlay of regions and touches.
    Overlay,
    /// Start or stop recording.
    Record,
    /// Hide the message for the player.
    Dismiss,
}

/// The running game and the services of the application.
#[derive(Clone, Copy)]
pub(super) struct GameContext<'a> {
    pub playing: &'a Playing,
    pub services: &'a dyn AppServices,
}

/// Names to choose from.
#[derive(Clone, Debug, Default)]
pub struct Names {
    /// Profiles.
    pub profiles: Vec<String>,
    /// Pads.
    pub pads: Vec<String>,
    /// Personal settings.
    pub users: Vec<String>,
    /// Serial ports.
    pub ports: Vec<String>,
    /// Calibrations of the pad that is played.
    pub calibrations: Vec<PathBuf>,
}

impl Names {
    /// What can be chosen now.
    pub fn find(services: &dyn AppServices, pad: &str) -> Self {
        Self {
            profiles: services.profiles(),
            pads: services.pads(),
            users: services.users(),
            ports: services.ports(),
            calibrations: services.calibrations(pad),
        }
    }
}

/// An output in a word or two.
pub(super) fn output_words(output: OutputChoice) -> &'static str {
    match output {
        OutputChoice::Nothing => "nothing",
        OutputChoice::Keyboard => "keyboard",
        OutputChoice::Gamepad => "gamepad",
        OutputChoice::Auto | OutputChoice::Trace => "your game",
    }
}

/// The last part of a path, without `.toml`.
pub fn file_name(argument: &str) -> String {
    let last = argument.rsplit(['/', '\\']).next().unwrap_or(argument);
    last.strip_suffix(".toml").unwrap_or(last).to_owned()
}
