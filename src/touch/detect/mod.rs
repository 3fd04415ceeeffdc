//! One frame to touches: reference, image, contacts, tracking, and what to do with a frame that cannot be right.
//!
//! If the pad has a response table, contacts are located in the voltages; the image is for display and for palms and
//! forearms, which no finger explains. Without a table, contacts come from the image.
//!
//! Invariant: no touch begins in a frame that touches cannot explain. Touches that are down wait for the next frame that
//! they explain, for half a second at most.

mod detector;
mod drawn;
mod electrodes;
mod palm;
mod reference;
mod renumbered;
mod repeats;
mod shift;
mod sign;
mod views;

pub use detector::Detector;
