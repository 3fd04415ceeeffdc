//! Completes the setup of a damaged recording: what cannot be read is solved again or replaced, with a warning.

use std::sync::Arc;

use super::pads::{PadText, choose_method, engine_config, load_pad};
use super::profiles::load_profile;
use super::recording::complete_slim;
use super::{AppError, Progress};
use crate::pad::{DEFAULT_PAD, Pad};
use crate::profile::DEFAULT_PROFILE;
use crate::session::{Message, ProfileTexts, Restore, Setup, SetupParts};
use crate::tape::{EngineConfig, ReplayCheck, profile_texts, texts_from_message};
use crate::touch::{Correction, CorrectionData};

/// Restores a recording.
pub(crate) struct Restorer<'a> {
    progress: Progress<'a>,
    /// The pad that was named for a recording whose own cannot be read.
    named_pad: Option<&'a str>,
    check: Option<ReplayCheck>,
    /// What was solved again or replaced, for people.
    pub(crate) replaced: Vec<String>,
    /// Whether a pad was named but not used.
    pub(crate) is_pad_ignored: bool,
}

impl<'a> Restorer<'a> {
    /// `pad` names the pad of a recording whose own cannot be read: by default [`DEFAULT_PAD`].
    pub(crate) fn new(progress: Progress<'a>, pad: Option<&'a str>) -> Self {
        Self {
            progress,
            named_pad: pad,
            check: None,
            replaced: Vec::new(),
            is_pad_ignored: false,
        }
    }

    fn complete(&mut self, parts: SetupParts) -> Result<Setup, AppError> {
        let pad = self.read_pad(&parts)?;
        let profile = self.read_profile(&parts)?;
        if parts.slim.is_some() && parts.sensing.is_none() {
            return Ok(Setup {
                pad: pad.toml,
                profile,
                calibration: parts.calibration,
                sensing: Vec::new(),
                responses: None,
                slim: parts.slim,
            });
        }
        if let Some(sensing) = parts.sensing {
            let setup = Setup {
                pad: pad.toml.clone(),
                profile: profile.clone(),
                calibration: parts.calibration.clone(),
                sensing,
                responses: parts.responses,
                slim: None,
            };
            if EngineConfig::from_setup(&setup).is_ok() {
                return Ok(setup);
            }
        }
        self.replaced.push(
            "the matrix or the response table cannot be read: solved again from the pad; the last bits of touches, and with \
             them events, may differ from what was played"
                .to_owned(),
        );
        let checked = load_profile(DEFAULT_PROFILE, None)?.profile;
        let method = choose_method(None, &checked, &pad.pad);
        let correction = parts.calibration.as_deref().and_then(|json| {
            let data: CorrectionData = serde_json::from_slice(json).ok()?;
            Correction::new(data).ok()
        });
        let (_, config) = engine_config(pad, Arc::new(checked), method, correction, self.progress)?;
        Ok(Setup {
            profile,
            ..config.to_setup()
        })
    }

    /// The pad of the recording, or the one that is named or assumed.
    fn read_pad(&mut self, parts: &SetupParts) -> Result<PadText, AppError> {
        match parts.pad.as_deref().map(|toml| Pad::from_toml("pad", toml)) {
            Some(Ok(pad)) => {
                self.is_pad_ignored = self.named_pad.is_some();
                Ok(PadText {
                    pad,
                    toml: parts.pad.clone().unwrap_or_default(),
                })
            }
            _ => {
                let pad = self.named_pad.unwrap_or(DEFAULT_PAD);
                let note = format!(
                    "the pad cannot be read: {pad} is assumed (`gelpad recover --pad` names another)"
                );
                self.replaced.push(note);
                Ok(load_pad(pad)?)
            }
        }
    }

    /// The profile of the recording, or the default one.
    fn read_profile(&mut self, parts: &SetupParts) -> Result<ProfileTexts, AppError> {
        match &parts.profile {
            Some(texts) if texts_from_message(texts).read().is_ok() => Ok(texts.clone()),
            _ => {
                let note = format!(
                    "the profile cannot be read: {DEFAULT_PROFILE} is assumed (`gelpad replay --profile` plays another)"
                );
                self.replaced.push(note);
                Ok(profile_texts(
                    &load_profile(DEFAULT_PROFILE, None)?.profile,
                    0,
                ))
            }
        }
    }
}

impl Restore for Restorer<'_> {
    fn setup(&mut self, parts: SetupParts) -> Result<Setup, String> {
        let setup = self.complete(parts).map_err(|error| error.to_string())?;
        let completed = complete_slim(&setup).map_err(|error| error.to_string())?;
        let check = ReplayCheck::new(completed.as_ref().unwrap_or(&setup));
        let check = check.map_err(|error| error.to_string())?;
        self.check = Some(check);
        Ok(setup)
    }

    fn check(&mut self, message: &Message, matrix: Option<&[u8]>) -> Result<(), String> {
        match &mut self.check {
            Some(check) => check
                .accept(message, matrix)
                .map_err(|error| error.to_string()),
            None => Ok(()),
        }
    }
}
