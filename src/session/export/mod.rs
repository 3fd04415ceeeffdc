//! A session in the formats of other programs: an emulator's movie, kernel events, frames as CSV.

pub mod csv;
pub mod evemu;
pub mod fm2;
