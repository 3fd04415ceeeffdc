//! A pad as it is, found from its own readings at rest: the conductance of every cell, and the places and lengths of the electrodes.
//!
//! A pad differs from its drawing by some percent everywhere, and so do its readings. There are more unknowns than readings, so what is
//! found is the likeliest pad (maximum a posteriori): Gaussian priors say how pads differ (`prior`), the forward model is linearised
//! about the present estimate (Gauss-Newton), and how much pads of this kind differ is chosen by the evidence of the readings (MacKay 1992).
//! The unknown gain of the board is an unknown like the others. Contact impedances are not: four-electrode readings hardly show
//! them.
//!
//! Presses at known places tell more of the same unknowns (`presses`).
//!
//! Invariant: readings that no such pad explains are refused, never fitted half.

mod at_rest;
mod fit;
mod presses;
mod prior;
mod sensitivity;

use faer::Mat;

use super::{ContactModel, ForwardError, ForwardModel, Mesh, MeshSize};
use crate::pad::{Deviations, ElectrodeDeviation, Pad, cell_sites_mm};
pub use at_rest::rest_medians;
use fit::{Estimate, LinearModel};
pub use presses::KnownPress;

/// A pad whose readings are at most this far from those measured (root mean square, relative) is good enough: the forward model
/// itself is about half as far off.
pub const GOOD_MISFIT: f64 = 5e-3;
/// The forward model's own error, as a share of a reading: two meshes differ by so much.
const MODEL_ERROR: f64 = 2e-3;
/// The linearised model's error as a share of the present misfit: far from the truth, the slopes are those of another pad.
const LINEAR_SHARE: f64 = 0.15;
/// Readings below this share of the largest count as if they were that large: their relative errors have no bound.
const LEAST_SHARE: f64 = 0.01;
/// Most linearisations. Usual pads need three.
const MOST_ROUNDS: usize = 10;
/// A round that lowers the misfit by less than this share is the last, as is one that ends well below the model's own error.
const LEAST_GAIN: f64 = 0.03;
const WELL_BELOW: f64 = 0.3;
/// Rounds after which the electrodes have moved so little that the derivatives by their places stay the same.
const ELECTRODE_ROUNDS: usize = 2;
/// A step that raises the misfit is halved at most this often.
const MOST_HALVINGS: usize = 3;
/// A found pad whose readings differ from those measured by more than this share, root mean square, explains nothing.
const MOST_MISFIT: f64 = 0.05;
/// Nor does one whose cells conduct more unevenly than this, as the root mean square of the logarithms of their factors: readings
/// of a stuck board, equal on all channels, are explained by a pad that is torn nearly everywhere. Pads with ten torn channels
/// of 220 stay below 0.7.
const MOST_UNEVEN: f64 = 1.0;
/// Presses with which the readings at rest are further off than this, and twice as far as without them, contradict these readings.
const MOST_CONTRADICTION: f64 = 0.01;
/// Electrodes are found at most this far from their drawing, mm, and this much longer or shorter, as a share.
const MOST_SHIFT_MM: f64 = 2.0;
const MOST_STRETCH: f64 = 0.5;
/// Cells conduct at most e^3 = 20 times more or less than drawn.
const MOST_LOG: f64 = 3.0;

/// Runs the jobs 0, 1, ... up to a number, in any order, beside each other or not, and returns when all are done.
pub type RunJobs<'a> = dyn Fn(usize, &(dyn Fn(usize) + Sync)) + 'a;

/// Runs jobs one after another: a [`RunJobs`] without threads.
pub fn one_by_one(count: usize, job: &(dyn Fn(usize) + Sync)) {
    (0..count).for_each(job);
}

/// A pad as found.
#[derive(Clone, Debug)]
pub struct IdentifiedPad {
    /// The drawing with the conductance and the electrodes that were found.
    pub pad: Pad,
    /// Root mean square of the relative differences between readings and model: as drawn, and as found.
    pub misfit: [f64; 2],
    /// Presses, by their numbers, that this pad does not explain: at another place than told, or not of one finger.
    pub unexplained: Vec<usize>,
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
        "no pad like {pad} has these readings: as drawn they are {:.0} % off, and still {:.1} % with everything that can differ; check that this is the pad that is connected, that its electrodes are wired in order and that nothing touches it",
        100.0 * .misfit[0],
        100.0 * .misfit[1]
    )]
    OtherPad {
        /// Name of the pad.
        pad: String,
        /// Misfits as drawn and as found.
        misfit: [f64; 2],
    },
    /// The presses belong to another pad, or their places to other presses.
    #[error(
        "{unexplained} of {presses} presses are not explained by any pad like {pad}: check that they were recorded on this pad, with this order of its electrodes, and that their places are in mm from the bottom-left"
    )]
    OtherPresses {
        /// Name of the pad.
        pad: String,
        /// Presses of which too much is left.
        unexplained: usize,
        /// All presses.
        presses: usize,
    },
    /// The presses ask for a pad that has other readings at rest.
    #[error(
        "the presses contradict the untouched pad: its readings are {:.1} % off with them, {:.1} % without; record the presses again, one finger at a time, on the pad as it is now",
        100.0 * .with,
        100.0 * .without
    )]
    Contradicted {
        /// Misfit of the readings at rest with the presses.
        with: f64,
        /// Misfit without them.
        without: f64,
    },
    /// Only a pad that is torn nearly everywhere has such readings.
    #[error(
        "no pad like {pad} has these readings: its layer would conduct {factor:.0} times more or less from place to place; check that the board measures (one that is stuck sends such readings), that its electrodes are wired in order and that nothing touches the pad"
    )]
    Uneven {
        /// Name of the pad.
        pad: String,
        /// How unevenly it would conduct: a usual factor of a cell, above 1.
        factor: f64,
        /// Misfits as drawn and as found.
        misfit: [f64; 2],
    },
}

/// Readings of a pad at rest.
#[derive(Clone, Copy, Debug)]
pub struct RestReadings<'a> {
    /// A reading for each channel, in any unit.
    pub volts: &'a [f64],
    /// Their relative standard deviations; infinite for readings to leave out.
    pub deviations: &'a [f64],
}

/// Presses at known places, on the same pad.
#[derive(Clone, Copy, Debug)]
pub struct KnownPresses<'a> {
    /// The presses.
    pub presses: &'a [KnownPress],
    /// Relative standard deviation of a change.
    pub noise: f64,
}

/// Finds the pad that has these readings at rest. What the drawing says of the conductance is ignored. Half of the time goes into jobs that
/// `run` may run beside each other.
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
    run: &RunJobs<'_>,
) -> Result<IdentifiedPad, IdentifyError> {
    let none = KnownPresses {
        presses: &[],
        noise: 0.0,
    };
    identify_with_presses(drawing, RestReadings { volts, deviations }, none, run)
}

/// Finds the pad that has these readings at rest and that these presses change so.
///
/// # Errors
/// See [`IdentifyError`].
///
/// # Panics
/// If there is not one reading and one deviation for each channel, or not one change of each press.
pub fn identify_with_presses(
    drawing: &Pad,
    RestReadings { volts, deviations }: RestReadings<'_>,
    known: KnownPresses<'_>,
    run: &RunJobs<'_>,
) -> Result<IdentifiedPad, IdentifyError> {
    let channels = drawing.channels();
    assert_eq!([volts.len(), deviations.len()], [channels; 2]);
    let usable: Vec<usize> = (0..channels)
        .filter(|c| is_usable(volts[*c]) && deviations[*c].is_finite())
        .collect();
    if 2 * usable.len() < channels {
        return Err(IdentifyError::TooFew {
            usable: usable.len(),
            channels,
        });
    }
    let search = Search::new(drawing.drawing(), volts, &usable, deviations);
    let (estimate, misfit) = search.run(run)?;
    search.check(&estimate, misfit)?;
    if known.presses.is_empty() {
        let pad = search.pad_with(&estimate.values);
        return Ok(IdentifiedPad {
            pad,
            misfit,
            unexplained: Vec::new(),
        });
    }
    let (refined, unexplained) = search.refine(estimate, known.presses, known.noise, run)?;
    if 2 * unexplained.len() > known.presses.len() {
        return Err(IdentifyError::OtherPresses {
            pad: search.drawing.name.clone(),
            unexplained: unexplained.len(),
            presses: known.presses.len(),
        });
    }
    let refined = Trial::new(&search, refined)?;
    let (with, without) = (refined.compared.misfit(), misfit[1]);
    if with > MOST_CONTRADICTION.max(2.0 * without) {
        return Err(IdentifyError::Contradicted { with, without });
    }
    let misfit = [misfit[0], with];
    search.check(&refined.estimate, misfit)?;
    Ok(IdentifiedPad {
        pad: refined.pad,
        misfit,
        unexplained,
    })
}

/// How far readings (any unit) are from those of a pad: root mean square of the relative differences, with the gain that fits best.
/// NaN if no reading is usable.
///
/// # Errors
/// A pad that cannot be solved.
pub fn misfit(pad: &Pad, volts: &[f64]) -> Result<f64, ForwardError> {
    let usable: Vec<usize> = (0..volts.len()).filter(|c| is_usable(volts[*c])).collect();
    Ok(Compared::new(&Solved::new(pad)?.volts, volts, &usable).misfit())
}

fn is_usable(volt: f64) -> bool {
    volt.is_finite() && volt != 0.0
}

/// What stays the same while the estimate changes.
struct Search<'a> {
    drawing: Pad,
    sites: Vec<[f64; 2]>,
    prior: prior::Prior,
    measured: &'a [f64],
    usable: &'a [usize],
    deviations: &'a [f64],
}

impl<'a> Search<'a> {
    fn new(drawing: Pad, measured: &'a [f64], usable: &'a [usize], deviations: &'a [f64]) -> Self {
        let sites = cell_sites_mm(&drawing);
        Self {
            prior: prior::Prior::new(&drawing, &sites),
            sites,
            drawing,
            measured,
            usable,
            deviations,
        }
    }

    /// Refuses an estimate that does not explain the readings.
    fn check(&self, estimate: &Estimate, misfit: [f64; 2]) -> Result<(), IdentifyError> {
        let cells = &estimate.values[..self.sites.len()];
        let square: f64 = cells.iter().map(|log| log * log).sum();
        let unevenness = libm::sqrt(square / cells.len().max(1) as f64);
        let pad = self.drawing.name.clone();
        // NaN explains nothing either.
        let is_explained = misfit[1] <= MOST_MISFIT;
        if !is_explained {
            return Err(IdentifyError::OtherPad { pad, misfit });
        }
        if unevenness > MOST_UNEVEN {
            return Err(IdentifyError::Uneven {
                pad,
                factor: libm::exp(unevenness),
                misfit,
            });
        }
        Ok(())
    }

    /// The most likely estimate, and the misfits of the drawing and of the estimate.
    fn run(&self, run: &RunJobs<'_>) -> Result<(Estimate, [f64; 2]), ForwardError> {
        let mut best = Trial::new(self, Estimate::none(&self.prior))?;
        let drawn = best.compared.misfit();
        let mut electrode_slopes = sensitivity::of_electrodes(&best.pad, run)?;
        for round in 1..=MOST_ROUNDS {
            let before = best.compared.misfit();
            let Some(next) = self.step(&best, &electrode_slopes)? else {
                break;
            };
            best = next;
            let misfit = best.compared.misfit();
            let is_last = misfit > (1.0 - LEAST_GAIN) * before || misfit < WELL_BELOW * MODEL_ERROR;
            if is_last && round > ELECTRODE_ROUNDS {
                break;
            }
            if round < ELECTRODE_ROUNDS {
                electrode_slopes = sensitivity::of_electrodes(&best.pad, run)?;
            }
        }
        let found = best.compared.misfit();
        Ok((best.estimate, [drawn, found]))
    }

    /// A better trial; `None` if even a short step makes the misfit larger.
    fn step(
        &self,
        best: &Trial,
        electrode_slopes: &Mat<f64>,
    ) -> Result<Option<Trial>, ForwardError> {
        let slopes = sensitivity::of_cells(&best.solved, &best.pad, self.sites.len());
        let model = LinearModel::new(
            &best.compared,
            &best.solved.volts,
            [&slopes, electrode_slopes],
            self.deviations,
            MODEL_ERROR.max(LINEAR_SHARE * best.compared.misfit()),
        );
        let mut aim = fit::most_likely(&model, &self.prior, &best.estimate);
        for _ in 0..=MOST_HALVINGS {
            let trial = Trial::new(self, aim.clone())?;
            if trial.compared.misfit() < best.compared.misfit() {
                return Ok(Some(trial));
            }
            aim = aim.halfway_to(&best.estimate);
        }
        Ok(None)
    }

    /// The drawing with these values of the unknowns: logarithms of the cells' factors, then shifts and stretches of the
    /// electrodes, within limits.
    fn pad_with(&self, values: &[f64]) -> Pad {
        let (cells, electrodes) = values.split_at(self.sites.len());
        let (shifts, stretches) = electrodes.split_at(self.drawing.electrodes.len());
        let moved = self
            .drawing
            .electrodes
            .iter()
            .zip(shifts.iter().zip(stretches));
        self.drawing.with_deviations(Deviations::new(
            self.sites
                .iter()
                .zip(cells)
                .map(|(site, log)| (*site, libm::exp(log.clamp(-MOST_LOG, MOST_LOG))))
                .collect(),
            moved
                .map(|(electrode, (shift, stretch))| {
                    let most = MOST_STRETCH * electrode.width_mm;
                    ElectrodeDeviation {
                        shift_mm: shift.clamp(-MOST_SHIFT_MM, MOST_SHIFT_MM),
                        stretch_mm: stretch.clamp(-most, most),
                    }
                })
                .collect(),
        ))
    }
}

/// An estimate, solved and compared with the readings.
struct Trial {
    estimate: Estimate,
    pad: Pad,
    solved: Solved,
    compared: Compared,
}

impl Trial {
    fn new(search: &Search, estimate: Estimate) -> Result<Self, ForwardError> {
        let pad = search.pad_with(&estimate.values);
        let solved = Solved::new(&pad)?;
        Ok(Self {
            compared: Compared::new(&solved.volts, search.measured, search.usable),
            estimate,
            pad,
            solved,
        })
    }
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
struct Compared {
    usable: Vec<usize>,
    /// Unit of each usable reading's differences: its own size in the model, within limits.
    units: Vec<f64>,
    /// Measured minus modelled, in these units.
    residuals: Vec<f64>,
}

impl Compared {
    fn new(model: &[f64], measured: &[f64], usable: &[usize]) -> Self {
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
            usable: usable.to_vec(),
            units,
        }
    }

    /// Root mean square of the differences, relative.
    fn misfit(&self) -> f64 {
        let sum: f64 = self.residuals.iter().map(|r| r * r).sum();
        libm::sqrt(sum / self.residuals.len() as f64)
    }
}
