//! What the stages hand to each other: frames, states of gamepads, images, contacts, touches, events, and the
//! names of keys and buttons.
//!
//! Every stage of the way of a frame is a plain function between two of these types, so this module
//! imports nothing of ours and everything else imports it.

mod bytes;
mod colour;
mod control;
mod event;
mod fault;
mod frame;
mod image;
mod keys;
mod method;
mod names;
mod touch;

pub use bytes::ByteReader;
pub use colour::heat;
pub use control::{Buttons, Control, Part};
pub use event::{Action, Event, Output};
pub use fault::{Fault, Faulty};
pub use frame::Frame;
pub use image::{Image, PixelGrid};
pub use keys::Key;
pub use method::Method;
pub(crate) use names::nearest;
pub use names::{Axis, Button, MouseButton, UnknownName};
pub use touch::{Contact, Phase, Touch, TouchId};

/// A point on the pad in millimetres: origin at the bottom-left, x to the right, y up.
pub type PointMm = [f64; 2];

/// Nanoseconds of the source's own time: the device's stamps, never a clock's.
pub type Nanos = u64;

/// Nanoseconds in a millisecond.
pub const NANOS_PER_MS: Nanos = 1_000_000;

/// A span of milliseconds as nanoseconds, rounded to the nearest.
#[must_use]
pub fn nanos_from_ms(ms: f64) -> Nanos {
    libm::round(ms * NANOS_PER_MS as f64) as Nanos
}

/// Nanoseconds as milliseconds, for people and for text formats.
#[must_use]
pub fn ms_from_nanos(t: Nanos) -> f64 {
    t as f64 / NANOS_PER_MS as f64
}
