//! Colours of the level: evening for the dark theme, morning for the light one.

use egui::Color32;

/// Colours of a picture of the level.
#[derive(Clone, Copy, Debug)]
pub(in crate::gui::practice) struct Colours {
    /// Top, bottom.
    pub(super) sky: [Color32; 2],
    /// Far, near.
    pub(super) hills: [Color32; 2],
    pub(super) ground: Color32,
    pub(super) turf: Color32,
    pub(super) block: Color32,
    pub(super) block_edge: Color32,
    pub(super) coin: Color32,
    pub(super) coin_edge: Color32,
    pub(super) drop: Color32,
    pub(super) drop_light: Color32,
    pub(super) eye: Color32,
    pub(super) flag: Color32,
    pub(in crate::gui::practice) ink: Color32,
}

const EVENING: Colours = Colours {
    sky: [
        Color32::from_rgb(0x1b, 0x1f, 0x3b),
        Color32::from_rgb(0x4a, 0x3f, 0x6b),
    ],
    hills: [
        Color32::from_rgb(0x33, 0x33, 0x5c),
        Color32::from_rgb(0x28, 0x2a, 0x4d),
    ],
    ground: Color32::from_rgb(0x17, 0x2a, 0x3a),
    turf: Color32::from_rgb(0x2f, 0x9c, 0x95),
    block: Color32::from_rgb(0x7a, 0x5c, 0x8e),
    block_edge: Color32::from_rgb(0xa9, 0x8b, 0xbd),
    coin: Color32::from_rgb(0xff, 0xd1, 0x66),
    coin_edge: Color32::from_rgb(0xd9, 0x93, 0x2a),
    drop: Color32::from_rgb(0xff, 0x8f, 0x5c),
    drop_light: Color32::from_rgb(0xff, 0xc7, 0xa1),
    eye: Color32::from_rgb(0x1a, 0x14, 0x20),
    flag: Color32::from_rgb(0x6f, 0xe0, 0xb5),
    ink: Color32::from_rgb(0xf4, 0xf1, 0xff),
};

const MORNING: Colours = Colours {
    sky: [
        Color32::from_rgb(0xa9, 0xd8, 0xf0),
        Color32::from_rgb(0xf6, 0xec, 0xdc),
    ],
    hills: [
        Color32::from_rgb(0xbf, 0xd9, 0xd4),
        Color32::from_rgb(0x9f, 0xc7, 0xbf),
    ],
    ground: Color32::from_rgb(0x5b, 0x4a, 0x42),
    turf: Color32::from_rgb(0x3f, 0x9d, 0x6d),
    block: Color32::from_rgb(0xc9, 0x7b, 0x4a),
    block_edge: Color32::from_rgb(0x8d, 0x4f, 0x2b),
    coin: Color32::from_rgb(0xff, 0xc2, 0x2e),
    coin_edge: Color32::from_rgb(0xa8, 0x6a, 0x00),
    drop: Color32::from_rgb(0xd8, 0x43, 0x5f),
    drop_light: Color32::from_rgb(0xf5, 0x9c, 0xa9),
    eye: Color32::from_rgb(0x2a, 0x12, 0x1a),
    flag: Color32::from_rgb(0x1f, 0x7a, 0x8c),
    ink: Color32::from_rgb(0x23, 0x1f, 0x2e),
};

pub(in crate::gui::practice) fn colours(dark: bool) -> Colours {
    if dark { EVENING } else { MORNING }
}
