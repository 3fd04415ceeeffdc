//! Sparse images: argmin 1/2 |A x - dv|2 + lambda |x|1, optionally with x >= 0.
//!
//! A is the Jacobian with columns scaled to unit norm, so that lambda weighs every pixel alike. lambda is a share of
//! max |A' dv|, above which the answer is zero, and never below what noise alone would reach.
//!
//! `model` holds what depends on the pad only, `solver` finds the answer of a frame. Both use f64 throughout, with every
//! sum in the order of the source: the same frames give the same bits.

mod model;
mod solver;

pub use model::{ITERATIONS, L1Model};
pub use solver::{L1State, Quality};
