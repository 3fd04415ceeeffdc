//! Touches from the voltages: how many, where, how large, how strong.
//!
//! An image is a linear, blurred view of a frame. Here, a touch is a place, radius and strength whose response the table
//! predicts, and the touches of a frame are those that explain it best. The fit starts from the last frame's touches;
//! their residual is searched for a new touch, which counts if it explains far more than noise and model error can.
//!
//! Invariant: the same frames give the same touches, bit for bit.

mod beside;
mod deformation;
mod deformed;
mod fit;
mod gains;
mod held;
mod located_pad;
mod locator;
mod metric;
mod model;
mod motion;
mod new_touches;
mod odd;
mod pair_or_odd;
mod place_held;
mod recent;
mod responses;
mod sign;
mod sizes;
mod taken_back;
mod templates;

pub(super) use located_pad::LocatedPad;
pub use locator::{FitQuality, Locator};
pub use model::LocatorModel;
pub(super) use sign::Onset;
