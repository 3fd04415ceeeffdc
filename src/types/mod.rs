//! The types that the stages exchange: frames, gamepad states, images, contacts, touches, events, and the names of keys and
//! buttons.
//!
//! This module imports no other module of the crate.

mod bytes;
mod colour;
mod control;
mod diagnostic;
mod event;
mod frame;
mod image;
mod keys;
mod method;
mod names;
mod printable;
mod touch;

pub use bytes::ByteReader;
pub use colour::heat_colour;
pub use control::{Buttons, Control, GamepadPart};
pub use diagnostic::{Diagnostic, SourceErrors};
pub use event::{Action, Event, Output};
pub use frame::{Frame, FrameAssembler, Part};
pub use image::{Image, PixelGrid};
pub use keys::Key;
pub use method::Method;
pub(crate) use names::nearest;
pub use names::{Axis, Button, MouseButton, UnknownName};
pub use printable::{printable, printable_in_place};
pub use touch::{Contact, Phase, Touch, TouchId};

/// A point on the pad, mm: origin at the bottom-left, x to the right, y up.
pub type PointMm = [f64; 2];

/// Distance of two places, mm.
#[must_use]
pub fn distance_mm(a: PointMm, b: PointMm) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}

/// Nanoseconds in the time of the source: time stamps of the device, not of a clock.
pub type Nanos = u64;

/// Nanoseconds in a millisecond.
pub const NANOS_PER_MS: Nanos = 1_000_000;

/// Converts milliseconds to nanoseconds, rounded to the nearest.
#[must_use]
pub fn nanos_from_ms(ms: f64) -> Nanos {
    libm::round(ms * NANOS_PER_MS as f64) as Nanos
}

/// Converts nanoseconds to milliseconds, for display and text formats.
#[must_use]
pub fn ms_from_nanos(t: Nanos) -> f64 {
    t as f64 / NANOS_PER_MS as f64
}
