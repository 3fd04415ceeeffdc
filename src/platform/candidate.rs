//! An output that may open.

use crate::output::{OutputDevice, OutputError};

/// An output that may open.
#[derive(Clone, Copy)]
pub struct Candidate {
    /// Its name in the explanation why it was not chosen.
    pub name: &'static str,
    /// Opens it.
    pub open: fn() -> Result<Box<dyn OutputDevice>, OutputError>,
}
