//! What an engine is made of, as things and as a recording's attachments.

use std::sync::Arc;

use super::input::{read_texts, texts_of};
use crate::eit::ResponseTable;
use crate::engine::Engine;
use crate::pad::Pad;
use crate::profile::Profile;
use crate::session::Setup;
use crate::touch::{Correction, CorrectionData, Sensing};
use crate::types::Faulty;

/// What an engine is made of.
#[derive(Clone, Debug)]
pub struct Kit {
    /// The pad.
    pub pad: Pad,
    /// Its text.
    pub pad_toml: String,
    /// The profile at the start.
    pub profile: Arc<Profile>,
    /// What a calibration has shown.
    pub correction: Option<Correction>,
    /// Matrix and weights at the start.
    pub sensing: Arc<Sensing>,
    /// The table of responses, if touches are located by one.
    pub table: Option<Arc<ResponseTable>>,
}

/// Why a recording's attachments make no engine.
#[derive(Debug, thiserror::Error)]
#[error("the recording's {part}: {why}")]
pub struct KitError {
    /// Which of them.
    pub part: &'static str,
    /// What is wrong with it.
    pub why: String,
}

impl Kit {
    /// What goes before the messages of a recording.
    #[must_use]
    pub fn to_setup(&self) -> Setup {
        let json = |correction: &Correction| serde_json::to_vec(correction.data()).ok();
        Setup {
            pad: self.pad_toml.clone(),
            profile: texts_of(&self.profile, 0),
            calibration: self.correction.as_ref().and_then(json),
            sensing: self.sensing.to_bytes(),
            responses: self.table.as_ref().map(|table| table.to_bytes()),
        }
    }

    /// From what stands before the messages of a recording.
    ///
    /// # Errors
    /// A part that is damaged, or does not fit the others.
    pub fn of_setup(setup: &Setup) -> Result<Self, KitError> {
        let wrong = |part, why: String| KitError { part, why };
        let first = |faulty: &Faulty| match faulty.faults.first() {
            Some(fault) => fault.message.clone(),
            None => "there is no text".to_owned(),
        };
        let pad =
            Pad::from_toml("pad", &setup.pad).map_err(|faulty| wrong("pad", first(&faulty)))?;
        let table = setup
            .responses
            .as_deref()
            .map(ResponseTable::from_bytes)
            .transpose();
        let table = table
            .map_err(|error| wrong("table of responses", error.to_string()))?
            .map(Arc::new);
        let sensing = Sensing::from_bytes(&setup.sensing, table.as_ref(), &pad.outline);
        let sensing = sensing.map_err(|error| wrong("matrix", error.to_string()))?;
        if sensing.channels() != pad.channels() {
            let (has, wants) = (sensing.channels(), pad.channels());
            return Err(wrong(
                "matrix",
                format!("it is for {has} voltages a frame, the pad has {wants}"),
            ));
        }
        let correction = setup.calibration.as_deref().map(|json| {
            let data: CorrectionData =
                serde_json::from_slice(json).map_err(|error| error.to_string())?;
            let correction = Correction::new(data).map_err(|error| error.to_string())?;
            if correction.channels() == pad.channels() {
                Ok(correction)
            } else {
                Err("it is another pad's".to_owned())
            }
        });
        let profile = read_texts(&setup.profile).read();
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

    /// An engine at its start.
    #[must_use]
    pub fn engine(&self) -> Engine {
        let (sensing, profile) = (Arc::clone(&self.sensing), Arc::clone(&self.profile));
        Engine::new(&self.pad, sensing, profile).corrected(self.correction.clone())
    }
}
