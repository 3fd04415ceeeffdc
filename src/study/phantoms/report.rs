//! The report of the phantom study: the gallery and the figures of merit.

use super::{
    JudgedImage, LAMBDA, LEVEL, POINT_MM, PhantomOutcome, Phantoms, SMOOTHING_MM, SNR_DB, Solver,
};
use crate::stats::{mean, range};
use crate::study::figure::{Gallery, short};
use crate::study::report::{Report, Table};
use crate::study::{CommandLine, Merit, Raster, StudyError};

impl Phantoms {
    pub(super) fn build_report(&self, outcomes: &[PhantomOutcome]) -> Result<Report, StudyError> {
        Ok(Report {
            title: "Phantoms: what the pad can show".to_owned(),
            command: self.command(),
            version: self.settings.version.clone(),
            seed: Some(self.settings.seed),
            advice: advice(outcomes),
            method: method(),
            tables: vec![self.table(outcomes)],
            csvs: vec![self.csv(outcomes)],
            figures: vec![self.gallery(outcomes).draw()?],
            files: Vec::new(),
        })
    }

    /// The shell command that repeats the study.
    #[must_use]
    pub fn command(&self) -> String {
        CommandLine::new("study phantoms", &self.settings.pad)
            .option("seed", self.settings.seed)
            .flag("quick", self.settings.quick)
            .finish()
    }

    /// Each solver with each phantom: names and the image.
    fn images<'a>(
        &'a self,
        outcomes: &'a [PhantomOutcome],
    ) -> impl Iterator<Item = ([String; 2], &'a JudgedImage)> {
        Solver::ALL
            .into_iter()
            .enumerate()
            .flat_map(move |(index, solver)| {
                self.phantoms
                    .iter()
                    .zip(outcomes)
                    .map(move |(phantom, outcome)| {
                        let names = [phantom.name, solver.name()].map(str::to_owned);
                        (names, &outcome.methods[index])
                    })
            })
    }

    fn gallery(&self, outcomes: &[PhantomOutcome]) -> Gallery {
        let size_mm = self.pad.outline.size_mm();
        let truths = self.phantoms.iter().map(|phantom| {
            let truth = Raster::from_mask(size_mm, |point| phantom.contains(point));
            (truth, Vec::new())
        });
        let images = self.images(outcomes).map(|(_, image)| {
            let mut raster = Raster::from_mask(size_mm, |_| false);
            raster.values.clone_from(&image.values);
            (raster.cut(), image.caption())
        });
        Gallery {
            name: "phantoms".to_owned(),
            title: format!("Phantoms on {}", self.pad.name),
            rows: ["truth", "Tikhonov", "L1, 200 it.", "L1, optimum"]
                .map(str::to_owned)
                .to_vec(),
            columns: self
                .phantoms
                .iter()
                .map(|phantom| phantom.name.to_owned())
                .collect(),
            cells: truths.chain(images).collect(),
        }
    }

    fn table(&self, outcomes: &[PhantomOutcome]) -> Table {
        let rows = self.images(outcomes).map(|(names, image)| {
            let merit = image.mean_merit();
            let figures = [
                merit.place_error_mm,
                image.overlap,
                merit.amplitude_response,
                merit.resolution,
                merit.shape_deformation,
                merit.ringing,
            ];
            names.into_iter().chain(figures.map(short)).collect()
        });
        Table::new(
            "Figures of merit",
            &[
                "phantom",
                "method",
                "place error, mm",
                "IoU",
                "AR",
                "RES",
                "SD",
                "RNG",
            ],
            rows,
        )
    }

    fn csv(&self, outcomes: &[PhantomOutcome]) -> Table {
        let rows = self.images(outcomes).map(|(names, image)| {
            let merit = image.mean_merit();
            let figures = [
                merit.place_error_mm,
                image.worst_place_mm(),
                merit.amplitude_response,
                merit.resolution,
                merit.shape_deformation,
                merit.ringing,
                image.overlap,
            ];
            let numbers = figures.map(|value| value.to_string());
            let euler_number = image.euler_number.to_string();
            names
                .into_iter()
                .chain(numbers)
                .chain([euler_number])
                .collect()
        });
        Table::new(
            "merit",
            &[
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
            ],
            rows,
        )
    }
}

impl JudgedImage {
    /// The lines of text under the image.
    fn caption(&self) -> Vec<String> {
        let Merit {
            amplitude_response,
            place_error_mm,
            resolution,
            shape_deformation,
            ringing,
        } = self.mean_merit();
        vec![
            format!(
                "place {} mm, IoU {}",
                short(place_error_mm),
                short(self.overlap)
            ),
            format!(
                "AR {}, RES {}",
                short(amplitude_response),
                short(resolution)
            ),
            format!("SD {}, RNG {}", short(shape_deformation), short(ringing)),
        ]
    }
}

/// Which solver to use.
fn advice(outcomes: &[PhantomOutcome]) -> Vec<String> {
    let overlaps = |solver: usize| {
        outcomes
            .iter()
            .map(move |outcome| outcome.methods[solver].overlap)
    };
    let solvers = Solver::ALL.iter().enumerate();
    let best = solvers.max_by(|(a, _), (b, _)| mean(overlaps(*a)).total_cmp(&mean(overlaps(*b))));
    let images = outcomes.iter().flat_map(|outcome| &outcome.methods);
    let [_, worst_mm] = range(images.map(JudgedImage::worst_place_mm));
    best.map(|(index, solver)| {
        format!(
            "For images of shapes use {}: it has the best overlap with the truth (IoU, mean over the phantoms: {}). Places are \
             right to {} mm or better with every method.",
            solver.name(),
            short(mean(overlaps(index))),
            short(worst_mm)
        )
    })
    .into_iter()
    .collect()
}

fn method() -> Vec<String> {
    vec![
        format!(
            "Simulation only: local rises to {LEVEL} times the background, solved on another mesh than the reconstruction's, with \
             {SNR_DB} dB of noise. Points have a radius of {POINT_MM} mm, the annulus radii of 15 and 25 mm, the bar is 58 x 10 mm: \
             the paper gives no sizes and no levels, these are our choices."
        ),
        format!(
            "Tikhonov and L1 use lambda = {LAMBDA} in gelpad's scaling. Images are smoothed ({SMOOTHING_MM} mm) onto a 2 mm grid \
             that includes the holes between channels; negative values are cut, and the peak is scaled to 1. Under each image: \
             error of place, overlap with the truth at half the peak (IoU), and the GREIT figures: amplitude response AR, \
             resolution RES, shape deformation SD, ringing RNG (before the cut). Points are judged one by one and averaged."
        ),
        "L1 is shown twice: with the paper's 200 accelerated iterations from zero, and at the optimum of the same problem, as in \
         play. 200 iterations end before the optimum and leave wide shapes whole. At the optimum the penalty breaks an annulus or \
         a bar into points, while points become sharper."
            .to_owned(),
    ]
}
