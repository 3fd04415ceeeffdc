//! Calibration from presses at known places.
//!
//! [`Regression`] learns places from voltages alone, for any protocol, outline and unit. `correction` learns
//! how far a pad's model is off, as data that the engine applies. All choices are made by leave-one-out or
//! cross-validation; nothing is random.

mod blend;
mod component_maps;
mod correct;
mod csv_rows;
mod curve;
mod error;
mod features;
mod file_name;
mod guided_readings;
mod learned_pad;
mod maps;
mod next_places;
pub mod orientation;
mod press_recorder;
mod presses;
mod process;
pub mod recommend;
mod region;
mod regression;
mod superposed;
mod touch_rows;
mod untouched_level;

pub use correct::{FittedCorrection, fit_correction};
pub use curve::{LearningCurve, learning_curve};
pub use error::{CalibrateError, FEWEST_PRESSES, PlaceErrors, PressesError};
pub use file_name::{calibration_file_name, free_file_name};
pub use guided_readings::GuidedReadings;
pub use learned_pad::{LearnedErrors, learn_maps, learned_errors};
pub use next_places::{NextPlace, next_places, places_between};
pub use press_recorder::{MEAN_FRAMES, PressRecorder, RecordedPress, Touching};
pub use presses::{ModelPrediction, Press, Presses, presses_csv};
pub use regression::Regression;
pub use superposed::{MOST_PLACES, SuperposedMaps};
pub use touch_rows::{TouchRow, TouchRows};
pub use untouched_level::UntouchedLevel;
