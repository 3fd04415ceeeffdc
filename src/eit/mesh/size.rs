//! How fine a mesh is.

use crate::pad::{Conductor, Pad};

/// How fine a mesh is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshSize {
    /// Longest edge along x and y away from electrodes and channel edges, mm.
    pub coarse_mm: f64,
    /// Edge at the ends of electrodes and channels, where the field is singular, mm.
    pub fine_mm: f64,
    /// Growth from fine to coarse: mm of edge per mm of distance.
    pub growth: f64,
    /// Mirrors every diagonal, for another mesh on the same grid.
    pub mirrored: bool,
}

impl MeshSize {
    /// The mesh of reconstructions.
    #[must_use]
    pub fn reconstruction(pad: &Pad) -> Self {
        Self::relative(pad, 1.0, false)
    }

    /// The mesh of simulated pads: finer, with other nodes and diagonals than the reconstruction's.
    #[must_use]
    pub fn simulation(pad: &Pad) -> Self {
        Self::relative(pad, 0.85, true)
    }

    /// A mesh whose edges are `scale` times as long as the reconstruction's.
    #[must_use]
    pub fn relative(pad: &Pad, scale: f64, mirrored: bool) -> Self {
        let feature_mm = pad
            .electrodes
            .iter()
            .map(|electrode| electrode.width_mm)
            .fold(f64::INFINITY, f64::min);
        let span_mm = pad.outline.size_mm().into_iter().fold(0.0, f64::max);
        let (coarse_mm, fine_mm) = match &pad.conductor {
            Conductor::Solid => (span_mm / 130.0, feature_mm / 6.0),
            Conductor::Lattice(lattice) => (
                lattice.width_mm / 3.0,
                lattice.width_mm.min(feature_mm) / 6.0,
            ),
        };
        Self {
            coarse_mm: coarse_mm * scale,
            fine_mm: (fine_mm * scale).min(coarse_mm * scale),
            growth: 0.4,
            mirrored,
        }
    }
}
