//! Finite elements in three dimensions on grids of hexahedra ("bricks"): electric current and large elastic deformation.
//!
//! Invariant: results do not depend on the number of threads. Sums run brick by brick, and each system is factorised on
//! one thread.

pub mod bricks;
pub mod current;
pub mod elastic;
mod newton;
mod order;
mod rubber;
mod system;

pub use bricks::{Bricks, Lines, growing_lines};
pub use current::{Contact, CurrentModel, Transfer};
pub use elastic::{Constraint, Elastic, ElasticError};
pub use rubber::{Gradient, Rubber};
pub use system::Size;
