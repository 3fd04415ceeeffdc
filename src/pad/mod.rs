//! Pads: outline, lattice, electrodes and protocol.
//!
//! A pad is a TOML file (`pads/*.toml`) that users read, copy and edit. [`Pad::from_toml`] checks it and refuses what
//! cannot be built or measured, with the place in the text; afterwards nothing is optional and every number is in range.
//!
//! Lengths are in millimetres; the origin is the bottom-left of the bounding box, y up. Places of electrodes are counted
//! counter-clockwise from 0, and so are electrodes unless the file says otherwise.

mod conductor;
mod deviations;
mod electrodes;
mod learned;
mod numbering;
mod outline;
mod protocol;
mod shipped;
mod spec;

pub use conductor::{Conductor, Lattice};
pub use deviations::{Deviations, ElectrodeDeviation, cell_sites_mm};
pub use electrodes::Electrode;
pub use learned::LearnedMaps;
pub use numbering::{Direction, Numbering, Renumbered};
pub use outline::Outline;
pub use protocol::{Channel, Pair, Protocol, ProtocolError};
pub use shipped::{DEFAULT_PAD, SHIPPED_PADS, ShippedPad, shipped_pad};

use std::sync::Arc;

use crate::types::{Method, SourceErrors};

/// How a touch changes the conductivity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TouchSign {
    /// A touch raises it.
    Rise,
    /// A touch lowers it.
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

    /// The other sign.
    #[must_use]
    pub fn opposite(self) -> Self {
        match self {
            Self::Rise => Self::Fall,
            Self::Fall => Self::Rise,
        }
    }
}

/// A pad that can be built and measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Pad {
    /// Name.
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
    /// How the pad differs from its drawing. The electrodes include theirs.
    pub deviations: Deviations,
    /// What presses taught about the pad, for one that its drawing does not describe.
    pub learned: Option<Arc<LearnedMaps>>,
    /// Electrodes on the outline, as the board numbers them.
    pub electrodes: Vec<Electrode>,
    /// How the board numbers the electrodes.
    pub numbering: Numbering,
    /// Contact impedance of an electrode, ohm m2.
    pub contact_impedance_ohm_m2: f64,
    /// Drives and measurements, in the order of a frame.
    pub protocol: Protocol,
    /// How a touch is expected to change the conductivity. Play learns it from the first touches where the pad's response table
    /// holds both signs; simulated touches have this one.
    pub touch_sign: TouchSign,
    /// Reconstruction method, unless the profile or the command line sets one.
    pub method: Option<Method>,
}

impl Pad {
    /// Reads a pad; `name` is the file name in messages.
    ///
    /// # Errors
    /// The first mistake in the text, with its place.
    pub fn from_toml(name: &str, text: &str) -> Result<Self, SourceErrors> {
        spec::read(name, text)
    }

    /// Number of voltages in a frame.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.protocol.channels.len()
    }

    /// Conductivity of the untouched layer at a point that holds conductor, S/m.
    #[must_use]
    pub fn conductivity_at(&self, point: [f64; 2]) -> f64 {
        self.background_s_per_m * self.deviations.factor_at(point)
    }

    /// Whether there is conductor at a point.
    #[must_use]
    pub fn conducts_at(&self, point: [f64; 2]) -> bool {
        self.outline.contains(point) && self.conductor.contains(point)
    }
}
