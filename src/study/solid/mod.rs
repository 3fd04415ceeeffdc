//! Solids in three dimensions: bricks, the order in which their unknowns are eliminated, current and large elastic deformation.
//!
//! Invariant: everything here is the same on every machine and with any number of threads: sums run brick by brick, and each
//! system is factorised on one thread.

pub mod bricks;
pub mod current;
pub mod elastic;
mod newton;
mod order;
mod rubber;
mod system;

pub use bricks::{Bricks, Lines, growing_lines};
pub use current::{Contact, CurrentModel, Transfer};
pub use elastic::{Elastic, ElasticError, Prescribed};
pub use rubber::{Gradient, Rubber};
pub use system::Size;
