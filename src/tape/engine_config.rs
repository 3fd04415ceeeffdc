//! The configuration of an engine, and its form as the attachments of a recording.

use std::sync::Arc;

use super::input::{profile_texts, texts_from_message};
use crate::eit::ResponseTable;
use crate::engine::Engine;
use crate::pad::Pad;
use crate::profile::Profile;
use crate::session::Setup;
use crate::touch::{Correction, CorrectionData, Sensing};
use crate::types::SourceErrors;

/// Everything that an engine is built from.
#[derive(Clone, Debug)]
pub struct EngineConfig {
    /// The pad.
    pub pad: Pad,
    /// Its text.
    pub pad_toml: String,
    /// The profile at the start.
    pub profile: Arc<Profile>,
    /// The correction of places by a calibration.
    pub correction: Option<Correction>,
    /// Matrix and weights at the start.
    pub sensing: Arc<Sensing>,
    /// The response table, if touches are located with one.
    pub table: Option<Arc<ResponseTable>>,
}

/// Why no engine can be built from the attachments of a recording.
#[derive(Debug, thiserror::Error)]
#[error("the recording's {part}: {why}")]
pub struct EngineConfigError {
    /// The attachment.
    pub part: &'static str,
    /// The reason.
    pub why: String,
}

impl EngineConfigError {
    /// Whether the part follows from the recording's pad, so that a copy can contain it again.
    #[must_use]
    pub fn is_solved_again(&self) -> bool {
        matches!(self.part, "matrix" | "response table")
    }
}

impl EngineConfig {
    /// The attachments of a recording.
    #[must_use]
    pub fn to_setup(&self) -> Setup {
        let json = |correction: &Correction| serde_json::to_vec(correction.data()).ok();
        Setup {
            pad: self.pad_toml.clone(),
            profile: profile_texts(&self.profile, 0),
            calibration: self.correction.as_ref().and_then(json),
            sensing: self.sensing.to_bytes(),
            responses: self.table.as_ref().map(|table| table.to_bytes()),
            slim: None,
        }
    }

    /// From the attachments of a recording.
    ///
    /// # Errors
    /// An attachment that is damaged or does not fit the others.
    pub fn from_setup(setup: &Setup) -> Result<Self, EngineConfigError> {
        let wrong = |part, why: String| EngineConfigError { part, why };
        let first = |faulty: &SourceErrors| match faulty.diagnostics.first() {
            Some(fault) => fault.message.clone(),
            None => "the text is missing".to_owned(),
        };
        if setup.slim.is_some() && setup.sensing.is_empty() {
            let why = "named, but not contained: a slim recording".to_owned();
            return Err(wrong("matrix", why));
        }
        let pad =
            Pad::from_toml("pad", &setup.pad).map_err(|faulty| wrong("pad", first(&faulty)))?;
        let table = setup
            .responses
            .as_deref()
            .map(|bytes| ResponseTable::from_bytes(bytes, &pad))
            .transpose();
        let table = table
            .map_err(|error| wrong("response table", error.to_string()))?
            .map(Arc::new);
        let sensing = Sensing::from_bytes(&setup.sensing, table.as_ref(), &pad);
        let sensing = sensing.map_err(|error| wrong("matrix", error.to_string()))?;
        if sensing.channels() != pad.channels() {
            let (has, wants) = (sensing.channels(), pad.channels());
            return Err(wrong(
                "matrix",
                format!("made for {has} channels, but the pad has {wants}"),
            ));
        }
        let correction = setup.calibration.as_deref().map(|json| {
            let data: CorrectionData =
                serde_json::from_slice(json).map_err(|error| error.to_string())?;
            let correction = Correction::new(data).map_err(|error| error.to_string())?;
            if correction.channels() == pad.channels() {
                Ok(correction)
            } else {
                Err("made for another pad".to_owned())
            }
        });
        let profile = texts_from_message(&setup.profile).read();
        Ok(Self {
            profile: Arc::new(
                profile
                    .map_err(|faulty| wrong("profile", first(&faulty)))?
                    .profile,
            ),
            correction: correction
                .transpose()
                .map_err(|why| wrong("calibration", why))?,
            sensing: Arc::new(sensing),
            pad_toml: setup.pad.clone(),
            pad,
            table,
        })
    }

    /// A new engine.
    #[must_use]
    pub fn engine(&self) -> Engine {
        let (sensing, profile) = (Arc::clone(&self.sensing), Arc::clone(&self.profile));
        Engine::new(&self.pad, sensing, profile).with_correction(self.correction.clone())
    }
}
