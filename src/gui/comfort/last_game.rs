//! The game that was played last, so that the window opens with it again. Kept in `window.toml` under `[last]`.
//!
//! Invariant: the output is kept, but nothing is sent to it before a click of this session.

use std::path::PathBuf;

use toml_edit::{Item, Table, value};

use crate::app::services::{OutputChoice, PlayRequest, SourceChoice};

/// What is kept of the last game.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LastGame {
    profile: String,
    pad: String,
    user: Option<String>,
    calibration: Option<PathBuf>,
    source: Option<SourceChoice>,
    /// Whether the profile followed the running game.
    match_programs: bool,
    /// Whether its keys were sent to a game.
    pub was_sent: bool,
    /// The output that was chosen last, other than a trial.
    pub output: Option<OutputChoice>,
}

/// The outputs that are kept, with their words in the file.
const OUTPUTS: [(OutputChoice, &str); 3] = [
    (OutputChoice::Auto, "auto"),
    (OutputChoice::Keyboard, "keyboard"),
    (OutputChoice::Gamepad, "gamepad"),
];

impl LastGame {
    /// The parts of a game that are kept.
    #[must_use]
    pub fn from_request(request: &PlayRequest) -> Self {
        let is_kept = matches!(
            request.source,
            SourceChoice::Simulated | SourceChoice::Serial(_) | SourceChoice::Gamepad
        );
        Self {
            profile: request.profile.clone(),
            pad: request.pad.clone(),
            user: request.user.clone(),
            calibration: request.calibration.clone(),
            source: is_kept.then(|| request.source.clone()),
            match_programs: request.match_programs,
            was_sent: request.output != OutputChoice::Nothing,
            output: kept_output(request.output),
        }
    }

    /// The same game as a trial.
    #[must_use]
    pub fn to_request(&self) -> PlayRequest {
        let default = PlayRequest::default();
        let or = |text: &str, default: String| match text.is_empty() {
            true => default,
            false => text.to_owned(),
        };
        PlayRequest {
            profile: or(&self.profile, default.profile.clone()),
            pad: or(&self.pad, default.pad.clone()),
            user: self.user.clone(),
            calibration: self.calibration.clone(),
            source: self.source.clone().unwrap_or(SourceChoice::Simulated),
            match_programs: self.match_programs,
            ..default
        }
    }

    /// Reads `[last]`; what is missing or unknown keeps its default.
    pub(super) fn read(table: &Item) -> Self {
        let text = |key: &str| {
            let text = table.get(key).and_then(Item::as_str);
            text.filter(|text| !text.is_empty()).map(str::to_owned)
        };
        let source = text("source");
        Self {
            profile: text("profile").unwrap_or_default(),
            pad: text("pad").unwrap_or_default(),
            user: text("person"),
            calibration: text("calibration").map(PathBuf::from),
            source: match source.as_deref().and_then(|source| source.split_once(':')) {
                Some(("serial", port)) => Some(SourceChoice::Serial(port.to_owned())),
                _ => match source.as_deref() {
                    Some("gamepad") => Some(SourceChoice::Gamepad),
                    Some("simulated") => Some(SourceChoice::Simulated),
                    _ => None,
                },
            },
            match_programs: table
                .get("by_game")
                .and_then(Item::as_bool)
                .unwrap_or(false),
            was_sent: table.get("sent").and_then(Item::as_bool).unwrap_or(false),
            output: text("output").and_then(|word| {
                let mut outputs = OUTPUTS.iter();
                outputs.find(|one| one.1 == word).map(|one| one.0)
            }),
        }
    }

    pub(super) fn to_table(&self) -> Table {
        let mut table = Table::new();
        table["profile"] = value(&self.profile);
        table["pad"] = value(&self.pad);
        let source = match &self.source {
            Some(SourceChoice::Serial(port)) => format!("serial:{port}"),
            Some(SourceChoice::Gamepad) => "gamepad".to_owned(),
            _ => "simulated".to_owned(),
        };
        table["source"] = value(source);
        if let Some(user) = &self.user {
            table["person"] = value(user);
        }
        if let Some(file) = self.calibration.as_ref().and_then(|file| file.to_str()) {
            table["calibration"] = value(file);
        }
        table["by_game"] = value(self.match_programs);
        table["sent"] = value(self.was_sent);
        if let Some((_, word)) = OUTPUTS.iter().find(|one| Some(one.0) == self.output) {
            table["output"] = value(*word);
        }
        table
    }
}

/// The output to keep; none for a trial.
pub(in crate::gui) fn kept_output(output: OutputChoice) -> Option<OutputChoice> {
    OUTPUTS.iter().map(|one| one.0).find(|kept| *kept == output)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_game_is_read_back_as_a_trial() {
        let played = PlayRequest {
            match_programs: true,
            profile: "/home/anna/my-super-mario.toml".to_owned(),
            pad: "openeit-lattice".to_owned(),
            user: Some("tremor".to_owned()),
            calibration: Some(PathBuf::from("/home/anna/pad.calibration.json")),
            source: SourceChoice::Serial("/dev/ttyACM0".to_owned()),
            output: OutputChoice::Gamepad,
            ..PlayRequest::default()
        };
        let kept = LastGame::from_request(&played);
        let read = LastGame::read(&Item::Table(kept.to_table()));
        assert_eq!(read, kept);
        assert!(read.was_sent);
        assert_eq!(read.output, Some(OutputChoice::Gamepad));
        let trial = PlayRequest {
            output: OutputChoice::Nothing,
            ..played
        };
        assert_eq!(read.to_request(), trial);
    }

    #[test]
    fn without_a_last_game_the_default_is_played() {
        let none = LastGame::read(&Item::None);
        assert_eq!(none.to_request(), PlayRequest::default());
    }

    #[test]
    fn a_recording_that_was_played_is_not_played_again() {
        let request = PlayRequest {
            source: SourceChoice::Replay(PathBuf::from("a.mcap")),
            ..PlayRequest::default()
        };
        let again = LastGame::from_request(&request).to_request();
        assert_eq!(again.source, SourceChoice::Simulated);
    }
}
