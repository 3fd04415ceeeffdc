//! Finds which way round a pad is wired, from three guided presses.
//!
//! Turning or mirroring the electrodes of a square pad changes no reading at rest and no reciprocity. A board that is
//! plugged in a quarter turn off looks healthy and shows every touch in the wrong place. Three presses at places that every
//! turn and mirror maps elsewhere decide it.

mod guided;
mod pad_text;
mod solver;

pub use guided::{GuidedPressRecorder, Progress};
pub use pad_text::{NumberingTextError, with_numbering};
pub use solver::{Orientation, OrientationError, OrientationSolver, shown_places};
