//! Views without a game behind them: what the window shows before anything plays, and what tests show it.

use std::sync::Arc;

use crate::pad::{DEFAULT_PAD, Pad, shipped_pad};
use crate::profile::{DEFAULT_PROFILE, Profile, shipped_profile};
use crate::runtime::View;
use crate::types::{Contact, Image, Phase, PixelGrid, PointMm, Touch, TouchId};

/// Pixels across the blank image.
const PIXELS: usize = 50;

/// The pad that is shown before one is chosen.
///
/// # Panics
/// Never: tests hold the shipped pad to be sound.
#[must_use]
pub fn pad() -> Pad {
    let shipped = shipped_pad(DEFAULT_PAD).expect("compiled in");
    Pad::from_toml(shipped.name, shipped.toml).expect("held sound by tests")
}

/// The profile that is shown before one is chosen.
///
/// # Panics
/// Never: tests hold the shipped profile to be sound.
#[must_use]
pub fn profile() -> Arc<Profile> {
    let shipped = shipped_profile(DEFAULT_PROFILE).expect("compiled in");
    Arc::new(Profile::from_toml(shipped.name, shipped.toml).expect("held sound by tests"))
}

/// A view of the untouched pad before its first frame.
#[must_use]
pub fn view() -> View {
    view_of(&pad(), profile())
}

/// A view of a pad before its first frame.
#[must_use]
pub fn view_of(pad: &Pad, profile: Arc<Profile>) -> View {
    let [width, height] = pad.outline.size_mm();
    let pixel_mm = width.max(height) / PIXELS as f64;
    let image = Image::blank(PixelGrid {
        origin_mm: [0.0, 0.0],
        pixel_mm,
        columns: (width / pixel_mm).ceil() as usize,
        rows: (height / pixel_mm).ceil() as usize,
    });
    View::blank(profile, image)
}

/// A touch that moves.
#[must_use]
pub fn touch(id: u64, centre_mm: PointMm, force: f64) -> Touch {
    Touch {
        id: TouchId(id),
        phase: Phase::Move,
        since_ns: 0,
        contact: Contact {
            centre_mm,
            area_mm2: 150.0,
            force,
            confidence: 1.0,
        },
    }
}
