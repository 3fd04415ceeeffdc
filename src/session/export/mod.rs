//! A session in the words of other programs: what its events were to an emulator or a kernel, and its frames as CSV.

pub mod csv;
pub mod evemu;
pub mod fm2;
