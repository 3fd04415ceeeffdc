//! The protocol study: in which order a board should read its drives, and which readings it can leave out.
//!
//! Both questions are answered by Fisher information. For random fingers, every reading tells something about place, size and
//! strength; a press is placed as soon as the drives that were read since it began tell enough (`order`), and readings that tell
//! what others tell too can be left out (`fewest`). The cases solve the fields under the fingers; the search is part of the report.

mod fewest;
mod information;
mod order;
mod report;
mod texts;

use serde::{Deserialize, Serialize};

use super::accuracy::draws::Draws;
use super::accuracy::specimen::Specimen;
use super::job::Study;
use super::report::Report;
use super::{Press, StudyError};
use crate::pad::Pad;
use information::{Knowledge, PressInformation};

/// Fingers of a case, and number of cases in full and in quick studies.
const FINGERS: usize = 10;
const CASES: (usize, usize) = (10, 2);

/// Settings of the study, stored in `study.json`. The same settings give the same files.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProtocolSettings {
    /// Version of gelpad.
    pub version: String,
    /// The pad as named on the command line.
    pub pad: String,
    /// Its TOML text.
    pub pad_toml: String,
    /// Noise, proportional to each reading, dB.
    pub snr_db: f64,
    /// Mean error of place that the fewest readings keep, mm.
    pub keep_mm: f64,
    /// Fewer fingers.
    pub quick: bool,
    /// Seed of the fingers.
    pub seed: u64,
}

/// The study with valid settings.
#[derive(Clone, Debug)]
pub struct ProtocolStudy {
    settings: ProtocolSettings,
    /// The pad's text without an order of drives, and the pad that it describes.
    text: String,
    pad: Pad,
    cases: Vec<FingerCase>,
}

/// Some random fingers; the number of the case determines them.
#[derive(Clone, Copy, Debug)]
pub struct FingerCase {
    stream: u64,
}

/// What the readings of the pad tell about the fingers of a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProtocolOutcome(Vec<PressInformation>);

impl ProtocolStudy {
    /// Validates the settings.
    ///
    /// # Errors
    /// An invalid pad; a noise or an accuracy that is not a positive number.
    pub fn new(settings: ProtocolSettings) -> Result<Self, StudyError> {
        // Reports a mistake at its place in the user's text.
        super::parse_pad(&settings.pad, &settings.pad_toml)?;
        let text = texts::without_order(&settings.pad_toml)?;
        let pad = super::parse_pad(&settings.pad, &text)?;
        if !(settings.keep_mm > 0.0 && settings.keep_mm.is_finite()) {
            return Err(StudyError::refused(format!(
                "--keep {} is not an error of place: give millimetres above zero",
                settings.keep_mm
            )));
        }
        if !settings.snr_db.is_finite() {
            return Err(StudyError::refused("--snr needs a number of dB, as in 60"));
        }
        let cases = if settings.quick { CASES.1 } else { CASES.0 };
        Ok(Self {
            settings,
            text,
            pad,
            cases: (0..cases as u64)
                .map(|stream| FingerCase { stream })
                .collect(),
        })
    }

    /// The settings.
    #[must_use]
    pub fn settings(&self) -> &ProtocolSettings {
        &self.settings
    }

    /// What is known about a finger before it touches.
    fn prior(&self) -> Knowledge {
        Knowledge::of_any_finger(self.pad.outline.size_mm())
    }
}

impl Study for ProtocolStudy {
    type Case = FingerCase;
    type Outcome = ProtocolOutcome;

    fn cases(&self) -> &[FingerCase] {
        &self.cases
    }

    fn id(case: &FingerCase) -> String {
        format!("fingers-{:02}", case.stream)
    }

    fn solve(&self, case: &FingerCase) -> Result<ProtocolOutcome, StudyError> {
        let mut draws = Draws::new(&self.pad, self.settings.seed, case.stream);
        let specimen = Specimen::ideal(&self.pad)?;
        let fingers: Vec<Press> = (0..FINGERS)
            .map(|_| Ok(draws.presses(1)?[0]))
            .collect::<Result<_, StudyError>>()?;
        let informations = fingers.into_iter().map(|finger| {
            let (volts, slopes) = specimen.pressed(&self.pad, &[finger])?;
            Ok(PressInformation::new(
                &specimen.rest,
                &volts,
                &slopes,
                self.settings.snr_db,
            ))
        });
        Ok(ProtocolOutcome(
            informations.collect::<Result<_, StudyError>>()?,
        ))
    }

    fn report(&self, outcomes: &[ProtocolOutcome]) -> Result<Report, StudyError> {
        let fingers: Vec<PressInformation> = outcomes
            .iter()
            .flat_map(|outcome| outcome.0.iter().cloned())
            .collect();
        self.build_report(&fingers)
    }
}
