//! The five phantoms: what the paper's reconstruction figure shows, in simulation only.
//!
//! Voltages come from a mesh other than the reconstruction's, with noise; Tikhonov and L1 make images; each picture stands
//! with its figures of merit.

use serde::{Deserialize, Serialize};

use super::figure::{Gallery, short};
use super::job::Study;
use super::report::{Report, Table};
use super::{Merit, Phantom, Raster, Shape, StudyError};
use crate::eit::reconstruct::l1::{ITERATIONS, L1Model};
use crate::eit::{
    ContactModel, ForwardModel, Imager, LAMBDA, Linearised, Mesh, MeshSize, REFERENCE_FRAMES,
    Reconstruction, Reference,
};
use crate::pad::Pad;
use crate::source::Noise;
use crate::types::{Image, Method};

/// Conductivity of a phantom in units of the background: our choice; the paper gives none.
const LEVEL: f64 = 2.0;
/// Noise, dB.
const SNR_DB: f64 = 60.0;
/// Radius of a point, mm: our choice.
const POINT_MM: f64 = 5.0;
/// Images are smoothed with this deviation before they are judged, mm.
const SMOOTHING_MM: f64 = 4.0;

/// How the study makes its images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    Tikhonov,
    /// The paper's budget: 200 accelerated iterations from zero.
    L1,
    /// The same problem at its optimum, as in play.
    L1Optimum,
}

impl Way {
    const ALL: [Self; 3] = [Self::Tikhonov, Self::L1, Self::L1Optimum];

    fn name(self) -> &'static str {
        match self {
            Self::Tikhonov => "Tikhonov",
            Self::L1 => "L1, 200 iterations",
            Self::L1Optimum => "L1, optimum",
        }
    }
}

/// What is studied. Its text is the study's identity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Version of gelpad.
    pub version: String,
    /// The pad's name.
    pub pad: String,
    /// Its text.
    pub pad_toml: String,
    /// Seed of the noise.
    pub seed: u64,
}

/// The five.
#[must_use]
pub fn phantoms() -> [Phantom; 5] {
    [
        Phantom::discs("one point", &[[50.0, 50.0]], POINT_MM),
        Phantom::discs("two points", &[[30.0, 50.0], [70.0, 50.0]], POINT_MM),
        Phantom::discs(
            "three points",
            &[[30.0, 30.0], [70.0, 30.0], [50.0, 70.0]],
            POINT_MM,
        ),
        Phantom {
            name: "annulus",
            shapes: vec![Shape::Annulus {
                centre_mm: [50.0, 50.0],
                radii_mm: [15.0, 25.0],
            }],
        },
        Phantom {
            name: "bar",
            shapes: vec![Shape::Bar {
                ends_mm: [[25.0, 35.0], [75.0, 65.0]],
                width_mm: 10.0,
            }],
        },
    ]
}

/// What one phantom gave: for each method, its picture and figures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    methods: Vec<Shown>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Shown {
    /// The smoothed image on the judging grid, negative values included.
    values: Vec<f64>,
    /// One for each shape.
    merits: Vec<Merit>,
    overlap: f64,
    euler_number: i64,
}

/// A study that is checked.
#[derive(Clone, Debug)]
pub struct Phantoms {
    settings: Settings,
    pad: Pad,
    phantoms: [Phantom; 5],
}

impl Study for Phantoms {
    type Case = Phantom;
    type Outcome = Outcome;

    fn cases(&self) -> &[Phantom] {
        &self.phantoms
    }

    fn id(phantom: &Phantom) -> String {
        phantom.name.replace(' ', "-")
    }

    fn solve(&self, phantom: &Phantom) -> Result<Outcome, StudyError> {
        let pad = &self.pad;
        let mesh = Mesh::of_pad(pad, MeshSize::simulation(pad));
        let model = ForwardModel::new(mesh, &ContactModel::of_pad(pad))?;
        let background = pad.background_s_per_m;
        let rest = model.solve_even(background)?.voltages(&pad.protocol);
        let touched = model.mesh().mean_over_triangles(|point| {
            if phantom.contains(point) {
                LEVEL * background
            } else {
                background
            }
        });
        let touched = model.solve(&touched)?.voltages(&pad.protocol);
        let mut noise = Noise::new(SNR_DB, self.settings.seed);
        let mut reference = Reference::new(pad.channels());
        for _ in 0..REFERENCE_FRAMES {
            reference.begin(0, &noise.read(&rest));
        }
        let mut changes = vec![0.0; pad.channels()];
        reference.changes(&noise.read(&touched), &mut changes);
        let linear = Linearised::of_pad(pad)?;
        let coverage: Vec<f32> = linear.coverage.iter().map(|share| *share as f32).collect();
        let methods = Way::ALL.into_iter().map(|way| {
            let image = image(&linear, pad, way, &changes, reference.change_noise())?;
            let raster = Raster::smoothed(&image, &coverage, pad.outline.size_mm(), SMOOTHING_MM);
            Ok(judge(phantom, raster))
        });
        Ok(Outcome {
            methods: methods.collect::<Result<_, StudyError>>()?,
        })
    }

    fn report(&self, outcomes: &[Outcome]) -> Result<Report, StudyError> {
        self.told(outcomes)
    }
}

impl Phantoms {
    /// Checks settings before anything is solved.
    ///
    /// # Errors
    /// A pad that cannot be built, or on which the phantoms do not fit.
    pub fn new(settings: Settings) -> Result<Self, StudyError> {
        let refuse = |reason| StudyError::Refused { reason };
        let pad = Pad::from_toml(&settings.pad, &settings.pad_toml)
            .map_err(|faulty| refuse(faulty.to_string()))?;
        match phantoms().iter().find_map(|phantom| phantom.misfit(&pad)) {
            Some(misfit) => Err(refuse(format!("{}: {misfit}", pad.name))),
            None => Ok(Self {
                settings,
                pad,
                phantoms: phantoms(),
            }),
        }
    }

    /// What is studied.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The report of all phantoms' results, in order.
    fn told(&self, outcomes: &[Outcome]) -> Result<Report, StudyError> {
        let size = self.pad.outline.size_mm();
        let truth = |phantom: &Phantom| Raster::of(size, |point| phantom.contains(point));
        let mut cells: Vec<(Raster, Vec<String>)> = phantoms()
            .iter()
            .map(|phantom| (truth(phantom), Vec::new()))
            .collect();
        let mut rows = Vec::new();
        let mut csv = Vec::new();
        for (index, way) in Way::ALL.into_iter().enumerate() {
            for (phantom, outcome) in phantoms().iter().zip(outcomes) {
                let shown = &outcome.methods[index];
                let merit = shown.mean_merit();
                let raster = Raster {
                    grid: truth(phantom).grid,
                    values: shown.values.clone(),
                };
                cells.push((
                    raster.cut(),
                    vec![
                        format!(
                            "place {} mm, IoU {}",
                            short(merit.place_error_mm),
                            short(shown.overlap)
                        ),
                        format!(
                            "AR {}, RES {}",
                            short(merit.amplitude_response),
                            short(merit.resolution)
                        ),
                        format!(
                            "SD {}, RNG {}",
                            short(merit.shape_deformation),
                            short(merit.ringing)
                        ),
                    ],
                ));
                let figures = [
                    merit.place_error_mm,
                    shown.worst_place_mm(),
                    merit.amplitude_response,
                    merit.resolution,
                    merit.shape_deformation,
                    merit.ringing,
                    shown.overlap,
                ];
                let mut row = vec![phantom.name.to_owned(), way.name().to_owned()];
                row.extend(figures.map(short));
                row.push(shown.euler_number.to_string());
                rows.push(row);
                let mut row = vec![phantom.name.to_owned(), way.name().to_owned()];
                row.extend(figures.map(|value| value.to_string()));
                row.push(shown.euler_number.to_string());
                csv.push(row);
            }
        }
        let columns = [
            "phantom",
            "method",
            "place_error_mm",
            "worst_place_error_mm",
            "amplitude_response",
            "resolution",
            "shape_deformation",
            "ringing",
            "iou",
            "euler_number",
        ];
        let names = phantoms().map(|phantom| phantom.name.to_owned()).to_vec();
        let gallery = Gallery {
            name: "phantoms".to_owned(),
            title: format!(
                "Five phantoms on {}: truth, Tikhonov, L1 (200 iterations), L1 at its optimum",
                self.pad.name
            ),
            rows: ["truth", "Tikhonov", "L1", "optimum"]
                .map(str::to_owned)
                .to_vec(),
            columns: names,
            cells,
        };
        Ok(Report {
            title: "Phantoms: what the pad can show".to_owned(),
            command: format!("gelpad study phantoms --pad {} --seed {}", self.settings.pad, self.settings.seed),
            version: self.settings.version.clone(),
            seed: self.settings.seed,
            paragraphs: vec![
                format!(
                    "The paper's measured phantoms are reproduced here in simulation only: local rises to {LEVEL} times the background, \
                     solved on a mesh other than the reconstruction's, {SNR_DB} dB of noise. Points have a radius of {POINT_MM} mm, the annulus \
                     radii of 15 and 25 mm, the bar is 58 x 10 mm: the paper gives no sizes and no levels, these are our choices."
                ),
                format!(
                    "Tikhonov and L1, lambda = {LAMBDA} in gelpad's scaling. Images are smoothed ({SMOOTHING_MM} mm) onto a 2 mm grid that includes the \
                     holes between channels, negative values cut, normalised to 1. Under each picture: error of place, overlap with the truth at half \
                     the peak (IoU), and GREIT's figures: amplitude response AR, resolution RES, shape deformation SD, ringing RNG (before the cut). Points are \
                     judged one by one and averaged."
                ),
                "L1 stands here twice: with the paper's 200 accelerated iterations from zero, and at the optimum of the same problem, as play uses \
                 it. The budget ends before the optimum and leaves wide shapes whole; at the optimum the penalty breaks an annulus or a bar into \
                 points, while points become sharper still."
                    .to_owned(),
            ],
            tables: vec![Table {
                title: "Figures of merit".to_owned(),
                head: columns.map(|name| name.replace('_', " ")).to_vec(),
                rows,
            }],
            csvs: vec![Table {
                title: "merit".to_owned(),
                head: columns.map(str::to_owned).to_vec(),
                rows: csv,
            }],
            figures: vec![gallery.draw()?],
        })
    }
}

/// The image of relative changes, negative values included.
fn image(
    pad: &Linearised,
    built: &Pad,
    way: Way,
    changes: &[f32],
    noise: f64,
) -> Result<Image, StudyError> {
    let mut image = Image::blank(pad.grid);
    let method = match way {
        Way::Tikhonov => Method::Tikhonov,
        Way::L1Optimum => Method::L1,
        Way::L1 => {
            let sign = f64::from(built.touch_sign.factor());
            let changes: Vec<f64> = changes
                .iter()
                .map(|change| sign * f64::from(*change))
                .collect();
            let model = L1Model::new(&pad.jacobian, LAMBDA, true);
            let answer = model.accelerated(&changes, model.lambda_abs(&changes, noise), ITERATIONS);
            for (column, pixel) in pad.active.iter().enumerate() {
                image.values[*pixel] = (answer[column] / model.norm(column)) as f32;
            }
            return Ok(image);
        }
    };
    let made = Reconstruction::from_linearised(pad, method, LAMBDA, built.touch_sign)?;
    Imager::new(made.into()).uncut(changes, noise, &mut image);
    Ok(image)
}

fn judge(phantom: &Phantom, raster: Raster) -> Shown {
    let truth = Raster {
        grid: raster.grid,
        values: (0..raster.grid.len())
            .map(|cell| f64::from(u8::from(phantom.contains(raster.grid.centre_mm(cell)))))
            .collect(),
    };
    let distance = |shape: &Shape, [x, y]: [f64; 2]| {
        let [cx, cy] = shape.centre_mm();
        (x - cx).hypot(y - cy)
    };
    let merits = phantom
        .shapes
        .iter()
        .map(|shape| {
            // A cell belongs to the shape whose middle is nearest.
            let own = |point| {
                phantom
                    .shapes
                    .iter()
                    .all(|other| distance(shape, point) <= distance(other, point))
            };
            raster.merit(&truth, LEVEL - 1.0, shape.centre_mm(), own)
        })
        .collect();
    let cut = raster.cut();
    Shown {
        merits,
        overlap: cut.overlap(&truth),
        euler_number: cut.euler_number(),
        values: raster.values,
    }
}

impl Shown {
    fn worst_place_mm(&self) -> f64 {
        self.merits
            .iter()
            .map(|merit| merit.place_error_mm)
            .fold(0.0, f64::max)
    }

    fn mean_merit(&self) -> Merit {
        let mean = |figure: fn(&Merit) -> f64| {
            self.merits.iter().map(figure).sum::<f64>() / self.merits.len() as f64
        };
        Merit {
            amplitude_response: mean(|m| m.amplitude_response),
            place_error_mm: mean(|m| m.place_error_mm),
            resolution: mean(|m| m.resolution),
            shape_deformation: mean(|m| m.shape_deformation),
            ringing: mean(|m| m.ringing),
        }
    }
}

impl Outcome {
    /// Worst error of a place (mm), overlap and Euler number of a way, by its name in the report.
    #[must_use]
    pub fn figures(&self, way: &str) -> Option<(f64, f64, i64)> {
        let index = Way::ALL.iter().position(|known| known.name() == way)?;
        let shown = &self.methods[index];
        Some((shown.worst_place_mm(), shown.overlap, shown.euler_number))
    }
}
