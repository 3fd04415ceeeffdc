//! The phantom study: what the paper's reconstruction figure shows, in simulation only.
//!
//! Voltages come from another mesh than the reconstruction's, with noise. Each phantom is reconstructed with Tikhonov and
//! L1, and each image is judged by its figures of merit.

mod report;

use serde::{Deserialize, Serialize};

use super::job::Study;
use super::report::Report;
use super::{Merit, Phantom, Raster, Shape, StudyError};
use crate::eit::reconstruct::l1::{ITERATIONS, L1Model};
use crate::eit::{
    ContactModel, ForwardModel, Imager, LAMBDA, Linearised, Mesh, MeshSize, REFERENCE_FRAMES,
    Reconstruction, Reference,
};
use crate::pad::Pad;
use crate::source::Noise;
use crate::stats::{mean, range};
use crate::types::{Image, Method, PointMm};

/// Conductivity of a phantom in units of the background: our choice; the paper gives none.
const LEVEL: f64 = 2.0;
/// Noise, dB.
const SNR_DB: f64 = 60.0;
/// Radius of a point, mm: our choice.
const POINT_MM: f64 = 5.0;
/// Images are smoothed with this deviation before they are judged, mm.
const SMOOTHING_MM: f64 = 4.0;
/// Phantoms of a quick study.
const QUICK: [&str; 2] = ["one point", "annulus"];

/// How an image is reconstructed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Solver {
    Tikhonov,
    /// The paper's budget: 200 accelerated iterations from zero.
    L1,
    /// The same problem at its optimum, as in play.
    L1Optimum,
}

impl Solver {
    const ALL: [Self; 3] = [Self::Tikhonov, Self::L1, Self::L1Optimum];

    fn name(self) -> &'static str {
        match self {
            Self::Tikhonov => "Tikhonov",
            Self::L1 => "L1, 200 iterations",
            Self::L1Optimum => "L1, optimum",
        }
    }
}

/// Settings of the study; stored in `study.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PhantomSettings {
    /// Version of gelpad.
    pub version: String,
    /// The pad as named on the command line.
    pub pad: String,
    /// Its TOML text.
    pub pad_toml: String,
    /// Only one point and the annulus.
    pub quick: bool,
    /// Seed of the noise.
    pub seed: u64,
}

/// One, two and three points, an annulus and a bar.
#[must_use]
pub fn phantoms() -> [Phantom; 5] {
    let [one, two, three] = Phantom::points(POINT_MM);
    let annulus = Shape::Annulus {
        centre_mm: [50.0, 50.0],
        radii_mm: [15.0, 25.0],
    };
    let bar = Shape::Bar {
        ends_mm: [[25.0, 35.0], [75.0, 65.0]],
        width_mm: 10.0,
    };
    [
        one,
        two,
        three,
        Phantom::new("annulus", vec![annulus]),
        Phantom::new("bar", vec![bar]),
    ]
}

/// The images of one phantom, in the order of the solvers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PhantomOutcome {
    methods: Vec<JudgedImage>,
}

/// An image and its figures of merit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct JudgedImage {
    /// The smoothed image on the judging grid, negative values included.
    values: Vec<f64>,
    /// One for each shape of the phantom.
    merits: Vec<Merit>,
    /// Intersection over union with the truth.
    overlap: f64,
    euler_number: i64,
}

/// The study with valid settings.
#[derive(Clone, Debug)]
pub struct Phantoms {
    settings: PhantomSettings,
    pad: Pad,
    phantoms: Vec<Phantom>,
}

impl Study for Phantoms {
    type Case = Phantom;
    type Outcome = PhantomOutcome;

    fn cases(&self) -> &[Phantom] {
        &self.phantoms
    }

    fn id(phantom: &Phantom) -> String {
        phantom.name.replace(' ', "-")
    }

    fn solve(&self, phantom: &Phantom) -> Result<PhantomOutcome, StudyError> {
        let pad = &self.pad;
        let [rest, touched] = simulate(pad, phantom)?;
        let mut noise = Noise::new(SNR_DB, self.settings.seed);
        let mut reference = Reference::new(pad.channels());
        for _ in 0..REFERENCE_FRAMES {
            reference.add_first_frame(0, &noise.read(&rest));
        }
        let mut changes = vec![0.0; pad.channels()];
        reference.relative_changes(&noise.read(&touched), &mut changes);
        let linear = Linearised::from_pad(pad)?;
        let coverage: Vec<f32> = linear.coverage.iter().map(|share| *share as f32).collect();
        let methods = Solver::ALL.into_iter().map(|solver| {
            let image = reconstruct(&linear, pad, solver, &changes, reference.change_noise())?;
            let raster = Raster::smoothed(&image, &coverage, pad.outline.size_mm(), SMOOTHING_MM);
            Ok(JudgedImage::new(phantom, raster))
        });
        Ok(PhantomOutcome {
            methods: methods.collect::<Result<_, StudyError>>()?,
        })
    }

    fn report(&self, outcomes: &[PhantomOutcome]) -> Result<Report, StudyError> {
        self.build_report(outcomes)
    }
}

impl Phantoms {
    /// Validates the settings.
    ///
    /// # Errors
    /// A pad that is invalid, or too small for a phantom.
    pub fn new(settings: PhantomSettings) -> Result<Self, StudyError> {
        let pad = super::parse_pad(&settings.pad, &settings.pad_toml)?;
        let mut phantoms = phantoms().to_vec();
        phantoms.retain(|phantom| !settings.quick || QUICK.contains(&phantom.name));
        match phantoms.iter().find_map(|phantom| phantom.misfit(&pad)) {
            Some(misfit) => Err(StudyError::refused(format!("{}: {misfit}", pad.name))),
            None => Ok(Self {
                settings,
                pad,
                phantoms,
            }),
        }
    }

    /// The settings.
    #[must_use]
    pub fn settings(&self) -> &PhantomSettings {
        &self.settings
    }
}

/// Voltages of the untouched pad, and with a phantom.
fn simulate(pad: &Pad, phantom: &Phantom) -> Result<[Vec<f64>; 2], StudyError> {
    let mesh = Mesh::from_pad(pad, MeshSize::simulation(pad));
    let model = ForwardModel::new(mesh, &ContactModel::from_pad(pad))?;
    let background = pad.background_s_per_m;
    let touched = model.mesh().mean_over_triangles(|point| {
        let is_raised = phantom.contains(point);
        background * if is_raised { LEVEL } else { 1.0 }
    });
    Ok([model.solve_even(background)?, model.solve(&touched)?]
        .map(|fields| fields.voltages(&pad.protocol)))
}

/// The image of relative changes, negative values included.
fn reconstruct(
    linear: &Linearised,
    pad: &Pad,
    solver: Solver,
    changes: &[f32],
    noise: f64,
) -> Result<Image, StudyError> {
    let mut image = Image::blank(linear.grid);
    let method = match solver {
        Solver::Tikhonov => Method::Tikhonov,
        Solver::L1Optimum => Method::L1,
        Solver::L1 => {
            let sign = f64::from(pad.touch_sign.factor());
            let signed = |change: &f32| sign * f64::from(*change);
            let changes: Vec<f64> = changes.iter().map(signed).collect();
            let model = L1Model::new(&linear.jacobian, LAMBDA, true);
            let answer = model.solve_fista(&changes, model.lambda_abs(&changes, noise), ITERATIONS);
            for (column, pixel) in linear.active.iter().enumerate() {
                image.values[*pixel] = (answer[column] / model.norm(column)) as f32;
            }
            return Ok(image);
        }
    };
    let matrix = Reconstruction::from_linearised(linear, method, LAMBDA, pad.touch_sign)?;
    Imager::new(matrix.into()).signed_image(changes, noise, &mut image);
    Ok(image)
}

impl JudgedImage {
    fn new(phantom: &Phantom, raster: Raster) -> Self {
        let truth = raster.mask(|point| phantom.contains(point));
        let distance_mm = |shape: &Shape, [x, y]: PointMm| {
            let [cx, cy] = shape.centre_mm();
            (x - cx).hypot(y - cy)
        };
        let merits = phantom.shapes.iter().map(|shape| {
            // A cell belongs to the shape with the nearest centre.
            let is_own = |point| {
                let mut others = phantom.shapes.iter();
                others.all(|other| distance_mm(shape, point) <= distance_mm(other, point))
            };
            raster.merit(&truth, LEVEL - 1.0, shape.centre_mm(), is_own)
        });
        let cut = raster.cut();
        Self {
            merits: merits.collect(),
            overlap: cut.overlap(&truth),
            euler_number: cut.euler_number(),
            values: raster.values,
        }
    }

    fn worst_place_mm(&self) -> f64 {
        let [_, worst] = range(self.merits.iter().map(|merit| merit.place_error_mm));
        worst
    }

    fn mean_merit(&self) -> Merit {
        Merit::summarised(|figure| mean(self.merits.iter().map(figure)))
    }
}

impl PhantomOutcome {
    /// Worst error of place (mm), overlap and Euler number of a solver, by its name in the report.
    #[must_use]
    pub fn figures(&self, solver: &str) -> Option<(f64, f64, i64)> {
        let index = Solver::ALL
            .iter()
            .position(|known| known.name() == solver)?;
        let image = &self.methods[index];
        Some((image.worst_place_mm(), image.overlap, image.euler_number))
    }
}
