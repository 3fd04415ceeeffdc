//! Pads as they are built: they differ from their drawing by what hands, moulds and drying do.

use crate::eit::{ContactModel, ForwardError, Mesh, MeshSize};
use crate::pad::{Conductor, Deviations, Electrode, ElectrodeDeviation, Pad, cell_sites_mm};
use crate::study::accuracy::draws::Draws;
use crate::study::accuracy::specimen::Specimen;
use crate::types::PointMm;

/// Waves of the smooth part of the thickness, and most periods of one along a side.
const WAVES: usize = 6;
const MOST_PERIODS: f64 = 1.5;
/// An electrode keeps this distance from corners, mm.
const CORNER_ROOM_MM: f64 = 0.2;

/// How much pads differ from their drawing. Shares and lengths are the ends of uniform distributions unless stated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Tolerance {
    /// Width of each channel, as a change of its conductance.
    pub widths: f64,
    /// Conductance of each piece of a channel.
    pub pieces: f64,
    /// Place of each channel, mm.
    pub lines_mm: f64,
    /// Place of each electrode, mm.
    pub electrodes_mm: f64,
    /// Length of each electrode.
    pub lengths: f64,
    /// Contact impedances lie between one over this and this; 0: all as drawn.
    pub contacts: f64,
    /// Smooth thickness: standard deviation.
    pub thickness: f64,
    /// Conductance from one side to the other along a random direction, half of it.
    pub gradient: f64,
}

/// A pad that was built.
pub(super) struct BuiltPad {
    /// With everything that a pad's text can say.
    pub pad: Pad,
    /// Its readings, on another mesh than that of models.
    pub specimen: Specimen,
}

impl BuiltPad {
    pub(super) fn draw(
        drawing: &Pad,
        tolerance: &Tolerance,
        draws: &mut Draws,
    ) -> Result<Self, ForwardError> {
        let pad = Pad {
            conductor: shifted_lines(drawing, tolerance, draws),
            electrodes: moved_electrodes(drawing, tolerance, draws),
            ..drawing.clone()
        };
        let pad = Pad {
            deviations: Deviations::new(drawn_cells(&pad, tolerance, draws), Vec::new()),
            ..pad
        };
        let even = ContactModel::from_pad(&pad);
        let most = libm::log(tolerance.contacts.max(1.0));
        let contacts = ContactModel {
            impedance_ohm_m2: even
                .impedance_ohm_m2
                .iter()
                .map(|impedance| impedance * libm::exp(draws.between(-most, most)))
                .collect(),
            ..even
        };
        let mesh = Mesh::from_pad(&pad, MeshSize::simulation(&pad));
        let background = mesh.background_s_per_m(&pad);
        let specimen = Specimen::new(&pad, mesh, &contacts, background)?;
        Ok(Self { pad, specimen })
    }

    /// The pad as deviations from its drawing. Places of channels cannot be told so.
    pub(super) fn with_drawing(&self, drawing: &Pad) -> Pad {
        let pairs = self.pad.electrodes.iter().zip(&drawing.electrodes);
        let electrodes = pairs.map(|(built, drawn)| {
            let stretch_mm = built.width_mm - drawn.width_mm;
            ElectrodeDeviation {
                shift_mm: built.start_mm - drawn.start_mm + stretch_mm / 2.0,
                stretch_mm,
            }
        });
        drawing.with_deviations(Deviations::new(
            self.pad.deviations.cells.clone(),
            electrodes.collect(),
        ))
    }
}

/// Channels at their places. Those along the edge stay there: electrodes need them.
fn shifted_lines(drawing: &Pad, tolerance: &Tolerance, draws: &mut Draws) -> Conductor {
    let Conductor::Lattice(mut lattice) = drawing.conductor.clone() else {
        return drawing.conductor.clone();
    };
    for lines in [&mut lattice.x_lines_mm, &mut lattice.y_lines_mm] {
        let last = lines.len() - 1;
        for line in &mut lines[1..last] {
            *line += draws.between(-tolerance.lines_mm, tolerance.lines_mm);
        }
    }
    Conductor::Lattice(lattice)
}

fn moved_electrodes(drawing: &Pad, tolerance: &Tolerance, draws: &mut Draws) -> Vec<Electrode> {
    let perimeter = drawing.outline.perimeter_mm();
    let corners = drawing.outline.corners_mm();
    drawing
        .electrodes
        .iter()
        .map(|electrode| {
            let width_mm =
                electrode.width_mm * (1.0 + draws.between(-tolerance.lengths, tolerance.lengths));
            let shift = draws.between(-tolerance.electrodes_mm, tolerance.electrodes_mm);
            let centre = electrode.start_mm + electrode.width_mm / 2.0 + shift;
            let moved = Electrode::centred_at(centre, width_mm);
            let bends = corners.iter().any(|corner| {
                let into = (corner - moved.start_mm + CORNER_ROOM_MM).rem_euclid(perimeter);
                into < moved.width_mm + 2.0 * CORNER_ROOM_MM
            });
            if bends { *electrode } else { moved }
        })
        .collect()
}

/// The conductance of the cells.
fn drawn_cells(pad: &Pad, tolerance: &Tolerance, draws: &mut Draws) -> Vec<(PointMm, f64)> {
    let sites = cell_sites_mm(pad);
    let mut field = SmoothField::draw(pad, draws);
    let direction = draws.angle();
    let size = pad.outline.size_mm();
    let along = |site: PointMm| {
        let off = [0, 1].map(|k| 2.0 * site[k] / size[k] - 1.0);
        off[0] * libm::cos(direction) + off[1] * libm::sin(direction)
    };
    let mut channels: Vec<(usize, f64, f64)> = Vec::new();
    let mut width_of = |site: PointMm, draws: &mut Draws| {
        let Some((axis, line)) = channel_of(pad, site) else {
            return 1.0;
        };
        if let Some((.., width)) = channels
            .iter()
            .find(|known| (known.0, known.1) == (axis, line))
        {
            return *width;
        }
        let width = 1.0 + draws.between(-tolerance.widths, tolerance.widths);
        channels.push((axis, line, width));
        width
    };
    field.scale(tolerance.thickness);
    let cells = sites.into_iter().map(|site| {
        let piece = 1.0 + draws.between(-tolerance.pieces, tolerance.pieces);
        let factor = width_of(site, draws)
            * piece
            * libm::exp(field.at(site))
            * (1.0 + tolerance.gradient * along(site));
        (site, factor)
    });
    cells.collect()
}

/// The axis and the place of the channel on which a site lies.
fn channel_of(pad: &Pad, site: PointMm) -> Option<(usize, f64)> {
    let Conductor::Lattice(lattice) = &pad.conductor else {
        return None;
    };
    let lines = [&lattice.x_lines_mm, &lattice.y_lines_mm];
    (0..2).find_map(|axis| {
        let line = lines[axis]
            .iter()
            .find(|line| (**line - site[axis]).abs() < 1e-6)?;
        Some((axis, *line))
    })
}

/// A sum of random plane waves with a standard deviation of 1 before it is scaled.
struct SmoothField {
    waves: Vec<([f64; 2], f64, f64)>,
    amplitude: f64,
}

impl SmoothField {
    fn draw(pad: &Pad, draws: &mut Draws) -> Self {
        let size = pad.outline.size_mm();
        let wave = |draws: &mut Draws| {
            let vector = size.map(|length| {
                std::f64::consts::TAU * draws.between(-MOST_PERIODS, MOST_PERIODS) / length
            });
            (vector, draws.angle(), draws.normal())
        };
        Self {
            waves: (0..WAVES).map(|_| wave(draws)).collect(),
            // A cosine of amplitude 1 has a standard deviation of 1 / sqrt 2.
            amplitude: libm::sqrt(2.0 / WAVES as f64),
        }
    }

    fn scale(&mut self, deviation: f64) {
        self.amplitude *= deviation;
    }

    fn at(&self, [x, y]: PointMm) -> f64 {
        let waves = self
            .waves
            .iter()
            .map(|([kx, ky], phase, height)| height * libm::cos(kx * x + ky * y + phase));
        self.amplitude * waves.sum::<f64>()
    }
}
