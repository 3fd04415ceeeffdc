//! A pad as it is, found from its own readings at rest: the conductance of every cell, and the places and lengths of the electrodes.
//!
//! A pad differs from its drawing by some percent everywhere, and so do its readings. There are more unknowns than readings, so what is
//! found is the likeliest pad (maximum a posteriori): Gaussian priors say how pads differ ([`prior`]), the forward model is linearised
//! about the present estimate (Gauss-Newton), and how much pads of this kind differ is chosen by the evidence of the readings (MacKay 1992).
//! The unknown gain of the board is an unknown like the others. Contact impedances are not: four-electrode readings hardly show
//! them.
//!
//! Invariant: readings that no such pad explains are refused, never fitted half.

mod fit;
mod prior;
mod sensitivity;

use super::{ContactModel, ForwardError, ForwardModel, Mesh, MeshSize};
use crate::pad::{Electrode, Pad, Unevenness, cell_sites_mm};
use fit::{Estimate, LinearModel};

/// The forward model's own error, as a share of a reading: two meshes differ by so much.
const MODEL_ERROR: f64 = 2e-3;
/// Readings below this share of the largest count as if they were that large: their relative errors have no bound.
const LEAST_SHARE: f64 = 0.01;
/// Linearisations. The estimate changes by less than a tenth of its deviation after three.
const ROUNDS: usize = 4;
/// A found pad whose readings differ from those measured by more than this share, root mean square, explains nothing.
const MOST_MISFIT: f64 = 0.05;
/// Electrodes are found at most this far from their drawing, mm, and this much longer or shorter, as a share.
const MOST_SHIFT_MM: f64 = 2.0;
const MOST_STRETCH: f64 = 0.5;

/// A pad as found.
#[derive(Clone, Debug)]
pub struct IdentifiedPad {
    /// The drawing with the conductance and the electrodes that were found.
    pub pad: Pad,
    /// How far each electrode is from its drawing, along the edge, and how much longer it is, mm.
    pub electrodes: Vec<ElectrodeDeviation>,
    /// Root mean square of the relative differences between readings and model: as drawn, and as found.
    pub misfit: [f64; 2],
    /// How much the pad differs from its drawing, in units of what is usual.
    pub spread: f64,
}

/// How an electrode differs from its drawing, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ElectrodeDeviation {
    /// Along the edge, counter-clockwise.
    pub shift_mm: f64,
    /// Of its length.
    pub stretch_mm: f64,
}

/// Why no pad is found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum IdentifyError {
    /// The forward model fails.
    #[error(transparent)]
    Forward(#[from] ForwardError),
    /// The readings do not determine anything.
    #[error("only {usable} of {channels} readings are usable: check the wires")]
    TooFew {
        /// Finite readings that are not zero.
        usable: usize,
        /// Readings of the pad.
        channels: usize,
    },
    /// No pad that is built as drawn has such readings.
    #[error(
        "no pad like {pad} has these readings: as drawn they are {:.0} % off, and still {:.1} % with everything that can differ; check that --pad names the pad that is connected, that its electrodes are wired in order and that nothing touches it",
        100.0 * .misfit[0],
        100.0 * .misfit[1]
    )]
    OtherPad {
        /// Name of the pad.
        pad: String,
        /// Misfits as drawn and as found.
        misfit: [f64; 2],
    },
}

/// Finds the pad that has these readings at rest (any unit), whose relative standard deviations are given; infinite for readings
/// to leave out. What the drawing says of the conductance is ignored.
///
/// # Errors
/// See [`IdentifyError`].
///
/// # Panics
/// If there is not one reading and one deviation for each channel.
pub fn identify(
    drawing: &Pad,
    volts: &[f64],
    deviations: &[f64],
) -> Result<IdentifiedPad, IdentifyError> {
    let channels = drawing.channels();
    assert_eq!([volts.len(), deviations.len()], [channels; 2]);
    let usable: Vec<usize> = (0..channels)
        .filter(|c| volts[*c].is_finite() && volts[*c] != 0.0 && deviations[*c].is_finite())
        .collect();
    if 2 * usable.len() < channels {
        return Err(IdentifyError::TooFew {
            usable: usable.len(),
            channels,
        });
    }
    let drawing = Pad {
        unevenness: Unevenness::default(),
        ..drawing.clone()
    };
    let sites = cell_sites_mm(&drawing);
    let prior = prior::covariance(&drawing, &sites);
    let electrode_slopes = sensitivity::of_electrodes(&drawing)?;
    let mut estimate = Estimate::none(prior.len());
    let mut misfits = Vec::with_capacity(ROUNDS + 1);
    for round in 0..=ROUNDS {
        let pad = pad_with(&drawing, &sites, &estimate.values);
        let solved = Solved::new(&pad)?;
        let compared = Compared::new(&solved.volts, volts, &usable);
        misfits.push(compared.misfit());
        if round == ROUNDS {
            break;
        }
        let cell_slopes = sensitivity::of_cells(&solved, &pad, sites.len());
        let model = LinearModel::new(&compared, &cell_slopes, &electrode_slopes, deviations);
        estimate = fit::most_likely(&model, &prior, &estimate);
    }
    let misfit = [misfits[0], misfits[ROUNDS]];
    if misfit[1] > MOST_MISFIT || misfit[1].is_nan() {
        return Err(IdentifyError::OtherPad {
            pad: drawing.name,
            misfit,
        });
    }
    let electrodes = deviations_of(&drawing, sites.len(), &estimate.values);
    Ok(IdentifiedPad {
        pad: pad_with(&drawing, &sites, &estimate.values),
        electrodes,
        misfit,
        spread: estimate.spread,
    })
}

/// A pad with its solution.
struct Solved {
    model: ForwardModel,
    fields: super::Fields,
    volts: Vec<f64>,
}

impl Solved {
    fn new(pad: &Pad) -> Result<Self, ForwardError> {
        let mesh = Mesh::from_pad(pad, MeshSize::reconstruction(pad));
        let background = mesh.background_s_per_m(pad);
        let model = ForwardModel::new(mesh, &ContactModel::from_pad(pad))?;
        let fields = model.solve(&background)?;
        Ok(Self {
            volts: fields.voltages(&pad.protocol),
            model,
            fields,
        })
    }
}

/// Measured readings beside those of a model, with the gain that fits best.
struct Compared<'a> {
    usable: &'a [usize],
    model: &'a [f64],
    /// Unit of each usable reading's differences: its own size in the model, within limits.
    units: Vec<f64>,
    /// Measured minus modelled, in these units.
    residuals: Vec<f64>,
}

impl<'a> Compared<'a> {
    fn new(model: &'a [f64], measured: &[f64], usable: &'a [usize]) -> Self {
        let largest = model.iter().fold(0.0f64, |most, volt| most.max(volt.abs()));
        let units: Vec<f64> = usable
            .iter()
            .map(|channel| model[*channel].abs().max(LEAST_SHARE * largest))
            .collect();
        // Some boards send magnitudes only.
        let has_signs = usable.iter().any(|channel| measured[*channel] < 0.0);
        let read = |channel: usize| match has_signs {
            true => measured[channel],
            false => measured[channel] * model[channel].signum(),
        };
        let (mut both, mut own) = (0.0, 0.0);
        for (channel, unit) in usable.iter().zip(&units) {
            both += model[*channel] * read(*channel) / (unit * unit);
            own += read(*channel) * read(*channel) / (unit * unit);
        }
        let gain = both / own;
        Self {
            residuals: usable
                .iter()
                .zip(&units)
                .map(|(channel, unit)| (gain * read(*channel) - model[*channel]) / unit)
                .collect(),
            usable,
            model,
            units,
        }
    }

    /// Root mean square of the differences, relative.
    fn misfit(&self) -> f64 {
        let sum: f64 = self.residuals.iter().map(|r| r * r).sum();
        libm::sqrt(sum / self.residuals.len() as f64)
    }
}

/// The drawing with these values of the unknowns: logarithms of the cells' factors, then shifts and stretches of the electrodes.
fn pad_with(drawing: &Pad, sites: &[[f64; 2]], values: &[f64]) -> Pad {
    let cells = sites
        .iter()
        .zip(values)
        .map(|(site, log)| (*site, libm::exp(*log)))
        .collect();
    let moved = deviations_of(drawing, sites.len(), values);
    let electrodes = drawing.electrodes.iter().zip(moved);
    Pad {
        unevenness: Unevenness::new(cells),
        electrodes: electrodes
            .map(|(electrode, deviation)| deviation.applied_to(electrode))
            .collect(),
        ..drawing.clone()
    }
}

/// The electrodes' part of the unknowns, within limits.
fn deviations_of(drawing: &Pad, cells: usize, values: &[f64]) -> Vec<ElectrodeDeviation> {
    let count = drawing.electrodes.len();
    let (shifts, stretches) = values[cells..cells + 2 * count].split_at(count);
    drawing
        .electrodes
        .iter()
        .zip(shifts.iter().zip(stretches))
        .map(|(electrode, (shift, stretch))| {
            let most = MOST_STRETCH * electrode.width_mm;
            ElectrodeDeviation {
                shift_mm: shift.clamp(-MOST_SHIFT_MM, MOST_SHIFT_MM),
                stretch_mm: stretch.clamp(-most, most),
            }
        })
        .collect()
}

impl ElectrodeDeviation {
    fn applied_to(self, electrode: &Electrode) -> Electrode {
        Electrode {
            start_mm: electrode.start_mm + self.shift_mm - self.stretch_mm / 2.0,
            width_mm: electrode.width_mm + self.stretch_mm,
        }
    }
}
