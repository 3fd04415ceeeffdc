//! Views without a running game: for the window before the first game, and for tests.

use std::sync::Arc;

use crate::pad::{DEFAULT_PAD, Pad, shipped_pad};
use crate::profile::{DEFAULT_PROFILE, Profile, shipped_profile};
use crate::runtime::View;
use crate::types::{Contact, Image, Phase, PixelGrid, PointMm, Touch, TouchId};

/// Pixels along the longer side of the blank image.
const PIXELS: usize = 50;

/// The default pad.
pub fn pad() -> Pad {
    let shipped = shipped_pad(DEFAULT_PAD).expect("compiled in");
    Pad::from_toml(shipped.name, shipped.toml).expect("parsed by tests")
}

/// The default profile.
pub fn profile() -> Arc<Profile> {
    let shipped = shipped_profile(DEFAULT_PROFILE).expect("compiled in");
    Arc::new(Profile::from_toml(shipped.name, shipped.toml).expect("parsed by tests"))
}

/// A view of the default pad before its first frame.
pub fn view() -> View {
    view_of_pad(&pad(), profile())
}

/// A view of a pad before its first frame.
pub fn view_of_pad(pad: &Pad, profile: Arc<Profile>) -> View {
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

/// A touch in its `Move` phase.
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
