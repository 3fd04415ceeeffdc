//! What a pad is: outline, lattice, electrodes, and how it is driven and measured.
//!
//! A pad is a text (`pads/*.toml`) that users read, copy and edit. [`Pad::from_toml`] checks it and
//! refuses what cannot be built or measured, pointing at the wrong word; past that point nothing is
//! optional and every number is in range.
//!
//! Lengths are millimetres; the origin is the bottom-left of the outline's box, y up; places of electrodes are
//! counted counter-clockwise from 0, and electrodes are numbered so too unless the text says otherwise.

mod conductor;
mod electrodes;
mod numbering;
mod outline;
mod protocol;
mod shipped;
mod spec;

pub use conductor::{Conductor, Lattice};
pub use electrodes::Electrode;
pub use numbering::{Direction, Numbering, Renumbered};
pub use outline::Outline;
pub use protocol::{Channel, Pair, Protocol, ProtocolError};
pub use shipped::{DEFAULT_PAD, SHIPPED_PADS, ShippedPad, shipped_pad};

use crate::types::{Faulty, Method};

/// Which way the conductivity goes where the pad is touched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TouchSign {
    /// A touch conducts better.
    Rise,
    /// A touch conducts worse.
    Fall,
}

impl TouchSign {
    /// +1 for a rise, -1 for a fall.
    #[must_use]
    pub fn factor(self) -> f32 {
        match self {
            Self::Rise => 1.0,
            Self::Fall => -1.0,
        }
    }
}

/// A pad that can be built and measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Pad {
    /// Its name.
    pub name: String,
    /// One sentence for lists.
    pub about: String,
    /// The outer edge of the conducting layer.
    pub outline: Outline,
    /// Where inside the outline there is conductor.
    pub conductor: Conductor,
    /// Thickness of the conducting layer, mm.
    pub thickness_mm: f64,
    /// Conductivity of the untouched layer, S/m.
    pub background_s_per_m: f64,
    /// Electrodes on the outline, as the board numbers them.
    pub electrodes: Vec<Electrode>,
    /// How that is: which place has electrode 0, and which way the others follow.
    pub numbering: Numbering,
    /// Contact impedance of an electrode, ohm m2.
    pub contact_impedance_ohm_m2: f64,
    /// Which electrodes are driven and read, in measurement order.
    pub protocol: Protocol,
    /// Which way a touch changes the conductivity.
    pub touch_sign: TouchSign,
    /// How its images are made, unless profile or command line say otherwise.
    pub method: Option<Method>,
}

impl Pad {
    /// Reads a pad from its text; `name` stands for the file in messages.
    ///
    /// # Errors
    /// Everything that is wrong with the text, each at its place.
    pub fn from_toml(name: &str, text: &str) -> Result<Self, Faulty> {
        spec::read(name, text)
    }

    /// Number of voltages in a frame.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.protocol.channels.len()
    }

    /// Whether there is conductor at a point.
    #[must_use]
    pub fn conducts_at(&self, point: [f64; 2]) -> bool {
        self.outline.contains(point) && self.conductor.contains(point)
    }
}
