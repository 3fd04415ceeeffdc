//! Pad, profile and calibration of a game: from the request, or from the recording that it plays.

use super::pads::{PadText, load_pad};
use super::profiles::{load_profile, with_user};
use super::recording::{is_recording, open_recording};
use super::request::{PlayRequest, SourceChoice};
use super::texts::own_or_given_profile;
use super::{AppError, calibration};
use crate::profile::Checked;
use crate::touch::Correction;

/// Everything an engine is made of, before its pad is solved.
pub(super) struct PlayConfig {
    pub pad: PadText,
    pub checked: Checked,
    /// Name or path of the profile; none for one from a recording, which no file can change.
    pub argument: Option<String>,
    pub correction: Option<Correction>,
}

impl PlayConfig {
    pub(super) fn load(request: &PlayRequest) -> Result<Self, AppError> {
        let recorded = match &request.source {
            SourceChoice::Replay(file)
                if (request.recorded_pad || request.recorded_profile) && is_recording(file)? =>
            {
                Some(open_recording(file)?.1)
            }
            _ => None,
        };
        let with_pad = recorded.as_ref().filter(|_| request.recorded_pad);
        let pad = match with_pad {
            Some(config) => PadText {
                pad: config.pad.clone(),
                toml: config.pad_toml.clone(),
            },
            None => load_pad(&request.pad)?,
        };
        let user = request.user.as_deref();
        let with_profile = recorded.as_ref().filter(|_| request.recorded_profile);
        let (checked, argument) = match with_profile {
            Some(config) => {
                let profile = match user {
                    None => config.profile.as_ref().clone(),
                    user => with_user(&config.profile, user)?,
                };
                let checked = Checked {
                    profile,
                    warnings: Vec::new(),
                    texts: Vec::new(),
                };
                (checked, None)
            }
            None => {
                let argument = own_or_given_profile(&request.profile);
                (load_profile(&argument, user)?, Some(argument))
            }
        };
        let correction = match (&request.calibration, with_pad) {
            (Some(file), _) => Some(calibration::load(file, &pad.pad)?),
            (None, Some(config)) => config.correction.clone(),
            (None, None) => None,
        };
        Ok(Self {
            pad,
            checked,
            argument,
            correction,
        })
    }
}
