//! `gelpad accuracy --real --identify`: pads that differ from their drawing, located with the drawing, with the pad as found from its readings
//! at rest ([`crate::eit::identify`]), the same corrected by presses, and with the pad as it is.

mod built;
mod pressed;

use std::fmt::Write as _;

use serde::Serialize;

use super::Bench;
use super::draws::Draws;
use super::noise::{Instrument, NoiseKind};
use super::score::{REACH_MM, Score};
use super::sensing::Sensing;
use super::solved;
use crate::eit::ResponseBuilder;
use crate::eit::identify::{
    IdentifyError, KnownPresses, RestReadings, identify, identify_with_presses, one_by_one,
};
use crate::pad::Pad;
use crate::stats::mean;
use crate::study::figure::{ConductanceMap, Figure};
use crate::study::{StudyError, job};
use crate::touch::SensingBuilder;
use built::{BuiltPad, Tolerance};
use pressed::{PRESS_FRAMES, PRESSES, press};

/// White noise, dB, proportional to each reading.
const SNR_DB: f64 = 60.0;
/// Frames of the untouched pad from which it is identified: a second.
const REST_FRAMES: usize = 100;
/// The presses of a calibration have random numbers of their own: streams so far from those of the pads.
const PRESS_STREAMS: u64 = 50_000;
/// Half-width of a 95 % interval in standard errors.
const INTERVAL: f64 = 1.96;

/// How much is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IdentifyExtent {
    /// Pads of each kind.
    pub pads: usize,
    /// Touches on each pad.
    pub touches: usize,
}

impl IdentifyExtent {
    /// A quarter of an hour on two cores: the table of the pad as it is takes longest.
    pub const FULL: Self = Self {
        pads: 4,
        touches: 50,
    };
    /// About a minute.
    pub const QUICK: Self = Self {
        pads: 1,
        touches: 20,
    };
}

/// A kind of pads.
struct Kind {
    name: &'static str,
    tolerance: Tolerance,
    /// Mean error of place with the pad as found, mm.
    goal_mm: Option<f64>,
}

/// As good as hands build them: channels +-5 %, pieces +-10 %, lines +-0.2 mm, electrodes +-0.5 mm and +-10 %, contacts x 0.3 to 3.
const REALISTIC: Tolerance = Tolerance {
    widths: 0.05,
    pieces: 0.1,
    lines_mm: 0.2,
    electrodes_mm: 0.5,
    lengths: 0.1,
    contacts: 3.0,
    thickness: 0.1,
    gradient: 0.0,
};
const NOTHING: Tolerance = Tolerance {
    widths: 0.0,
    pieces: 0.0,
    lines_mm: 0.0,
    electrodes_mm: 0.0,
    lengths: 0.0,
    contacts: 0.0,
    thickness: 0.0,
    gradient: 0.0,
};

fn kinds() -> [Kind; 7] {
    let kind = |name, tolerance, goal_mm| Kind {
        name,
        tolerance,
        goal_mm,
    };
    [
        kind("as drawn", NOTHING, None),
        kind("realistic build", REALISTIC, Some(0.33)),
        kind(
            "twice that, gradient 30 %",
            Tolerance {
                widths: 0.1,
                pieces: 0.2,
                lines_mm: 0.4,
                electrodes_mm: 1.0,
                lengths: 0.2,
                contacts: 3.0,
                thickness: 0.2,
                gradient: 0.15,
            },
            Some(0.45),
        ),
        kind(
            "thickness, smooth, sd 20 %",
            Tolerance {
                thickness: 0.2,
                ..NOTHING
            },
            Some(0.22),
        ),
        kind(
            "electrodes +-2 mm",
            Tolerance {
                electrodes_mm: 2.0,
                ..NOTHING
            },
            Some(0.33),
        ),
        kind(
            "pieces +-20 %",
            Tolerance {
                pieces: 0.2,
                ..NOTHING
            },
            Some(0.39),
        ),
        kind(
            "widths +-20 %",
            Tolerance {
                widths: 0.2,
                ..NOTHING
            },
            Some(0.48),
        ),
    ]
}

/// What was found on one pad with one model.
#[derive(Clone, Debug, Default)]
struct Located {
    off_mm: Vec<f64>,
    missed: usize,
    others: usize,
}

impl Located {
    fn add(&mut self, score: &Score) {
        self.missed += score.missed();
        self.others += score.false_touches;
        let found = score.found.iter().flatten();
        self.off_mm.extend(found.map(|found| found.off_mm));
    }
}

/// Results of one kind of pads.
#[derive(Clone, Debug, Serialize)]
pub struct IdentifyRow {
    /// The kind.
    pub kind: String,
    /// Touches, on all pads.
    pub touches: usize,
    /// Pads that were not found: their drawing was used.
    pub refused: usize,
    /// Root mean square difference of readings at rest from the model as drawn, and as found, mean over the pads.
    pub misfit: [f64; 2],
    /// With the drawing, the pad as found, the pad as found corrected by thirty presses, and the pad as it is.
    pub models: [ModelRow; 4],
    /// Goal of the mean error with the pad as found, mm.
    pub goal_mm: Option<f64>,
}

/// Results with one model of the pads.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ModelRow {
    /// Mean error of place, mm, and half its 95 % interval over the pads.
    pub mean_mm: [f64; 2],
    /// Touches not detected.
    pub missed: usize,
    /// Touches detected where there was none.
    pub others: usize,
}

/// All rows.
#[derive(Clone, Debug, Serialize)]
pub struct IdentifyFindings {
    /// Seed of pads, touches and noise.
    pub seed: u64,
    /// One for each kind.
    pub rows: Vec<IdentifyRow>,
    /// The first realistic pad as found, and as it is.
    #[serde(skip)]
    map: ConductanceMap,
}

/// One pad, read with four models.
struct PadFindings {
    misfit: [f64; 2],
    /// No such pad was found.
    is_refused: bool,
    models: [Located; 4],
    /// As found, and as it is.
    pads: [Pad; 2],
}

/// Draws pads of every kind.
pub(super) fn play_all(
    bench: &Bench,
    builder: &SensingBuilder,
    extent: IdentifyExtent,
    progress: impl Fn(usize, usize) + Sync,
) -> Result<IdentifyFindings, StudyError> {
    let kinds = kinds();
    let runs: Vec<(usize, usize)> = (0..kinds.len())
        .flat_map(|kind| (0..extent.pads).map(move |pad| (kind, pad)))
        .collect();
    let found: Vec<PadFindings> = job::solve_in_parallel(
        &runs,
        |(kind, pad)| {
            let stream = 5000 + 100 * *kind as u64 + *pad as u64;
            locate_on_pad(
                bench,
                builder,
                &kinds[*kind].tolerance,
                extent.touches,
                stream,
            )
        },
        progress,
    )?;
    let rows = kinds.iter().enumerate().map(|(index, kind)| {
        let own = runs.iter().zip(&found).filter(|((of, _), _)| *of == index);
        let own: Vec<&PadFindings> = own.map(|(_, found)| found).collect();
        IdentifyRow {
            kind: kind.name.to_owned(),
            touches: extent.pads * extent.touches,
            refused: own.iter().filter(|found| found.is_refused).count(),
            misfit: [0, 1].map(|k| mean(own.iter().map(|found| found.misfit[k]))),
            models: [0, 1, 2, 3].map(|model| {
                let located: Vec<&Located> = own.iter().map(|found| &found.models[model]).collect();
                ModelRow::new(&located)
            }),
            goal_mm: kind.goal_mm,
        }
    });
    let realistic = runs
        .iter()
        .position(|(kind, _)| kinds[*kind].tolerance == REALISTIC);
    let pads = realistic.map(|run| found[run].pads.clone());
    let captions = ["as found", "as it is"].map(str::to_owned);
    Ok(IdentifyFindings {
        seed: bench.seed,
        rows: rows.collect(),
        map: ConductanceMap {
            name: "found-and-true".to_owned(),
            title: "Conductance of a realistic pad".to_owned(),
            pads: captions
                .into_iter()
                .zip(pads.into_iter().flatten())
                .collect(),
        },
    })
}

fn locate_on_pad(
    bench: &Bench,
    builder: &SensingBuilder,
    tolerance: &Tolerance,
    touches: usize,
    stream: u64,
) -> Result<PadFindings, StudyError> {
    let drawing = &bench.pad;
    let mut draws = Draws::new(drawing, bench.seed, stream);
    let built = BuiltPad::draw(drawing, tolerance, &mut draws)?;
    let instrument = Instrument {
        kind: NoiseKind::Proportional,
        snr_db: SNR_DB,
        rest: &built.specimen.rest,
    };
    let frames = instrument.frames(&built.specimen.rest, draws.seed(), REST_FRAMES);
    let means = channel_means(&frames);
    let noise = super::noise::share(SNR_DB) / libm::sqrt(REST_FRAMES as f64);
    let deviations = vec![noise; means.len()];
    let identified = identify(drawing, &means, &deviations, &one_by_one);
    // As in play, a pad that is not found is played with its drawing.
    let (found, misfit) = match &identified {
        Ok(identified) => (&identified.pad, identified.misfit),
        Err(IdentifyError::OtherPad { misfit, .. } | IdentifyError::Uneven { misfit, .. }) => {
            (drawing, *misfit)
        }
        Err(error) => return Err(StudyError::refused(error.to_string())),
    };
    let of_true_pad = solved::with_table(&built.pad, builder, ResponseBuilder::new(&built.pad)?)?;
    let readers = [
        Sensing::from_pad(drawing, builder.clone())?,
        Sensing::from_pad(found, solved::found_pad(found, builder)?)?,
        Sensing::from_pad(&built.pad, of_true_pad)?,
    ];
    let seed = draws.seed();
    let rested: Vec<_> = readers
        .iter()
        .map(|sensing| sensing.rested(&instrument, seed))
        .collect();
    let own_draws = Draws::new(drawing, bench.seed, stream + PRESS_STREAMS);
    let presses = press(&built, &instrument, &means, &rested[1], own_draws)?;
    let with_presses = identify_with_presses(
        drawing,
        RestReadings {
            volts: &means,
            deviations: &deviations,
        },
        KnownPresses {
            presses: &presses,
            noise: super::noise::share(SNR_DB)
                * libm::sqrt(1.0 / PRESS_FRAMES as f64 + 1.0 / REST_FRAMES as f64),
        },
        &one_by_one,
    );
    let refined = with_presses.map_or_else(|_| found.clone(), |identified| identified.pad);
    let refined = Sensing::from_pad(&refined, solved::found_pad(&refined, builder)?)?;
    let refined = refined.rested(&instrument, seed);
    let mut models: [Located; 4] = Default::default();
    for _ in 0..touches {
        let presses = draws.presses(1)?;
        let (volts, _) = built.specimen.pressed(&built.pad, &presses)?;
        let frame = instrument.frame(&volts, draws.seed());
        let [drawn, found, true_model] = [0, 1, 2].map(|model| rested[model].contacts(&frame));
        let pressed = refined.contacts(&frame);
        let contacts = [drawn, found, pressed, true_model];
        for (contacts, located) in contacts.iter().zip(&mut models) {
            let score = Score::new(&presses, contacts, REACH_MM * bench.scale);
            located.add(&score);
        }
    }
    Ok(PadFindings {
        misfit,
        is_refused: identified.is_err(),
        models,
        pads: [found.clone(), built.with_drawing(drawing)],
    })
}

/// The mean of each channel over frames.
fn channel_means(frames: &[Vec<f32>]) -> Vec<f64> {
    let channels = frames.first().map_or(0, Vec::len);
    (0..channels)
        .map(|channel| mean(frames.iter().map(|volts| f64::from(volts[channel]))))
        .collect()
}

impl ModelRow {
    fn new(pads: &[&Located]) -> Self {
        let means: Vec<f64> = pads
            .iter()
            .map(|pad| mean(pad.off_mm.iter().copied()))
            .collect();
        let all = mean(means.iter().copied());
        let variance = means.iter().map(|m| (m - all) * (m - all)).sum::<f64>()
            / (means.len() as f64 - 1.0).max(1.0);
        Self {
            mean_mm: [all, INTERVAL * libm::sqrt(variance / means.len() as f64)],
            missed: pads.iter().map(|pad| pad.missed).sum(),
            others: pads.iter().map(|pad| pad.others).sum(),
        }
    }
}

impl IdentifyFindings {
    /// As JSON.
    ///
    /// # Errors
    /// A defect.
    pub fn json(&self) -> Result<String, StudyError> {
        serde_json::to_string_pretty(self).map_err(StudyError::internal)
    }

    /// A pad as found next to the truth.
    ///
    /// # Errors
    /// An error of the drawing library.
    pub fn figure(&self) -> Result<Figure, StudyError> {
        self.map.draw()
    }

    /// As a Markdown table.
    #[must_use]
    pub fn table(&self) -> String {
        let mut text = format!(
            "One touch at {SNR_DB} dB, seed {}: mean error of place, mm (half a 95 % interval over pads), and misfit of the readings at rest.\n\n\
             | pad | as drawn | as found | and {PRESSES} presses | as it is | goal, as found | missed, of | not found | misfit: drawn, found |\n\
             | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
            self.seed
        );
        for row in &self.rows {
            let [drawn, found, pressed, true_model] = &row.models;
            let figure =
                |model: &ModelRow| format!("{:.2} ({:.2})", model.mean_mm[0], model.mean_mm[1]);
            let goal = row
                .goal_mm
                .map_or("1.05 x drawn".to_owned(), |goal| format!("{goal:.2}"));
            let _ = writeln!(
                text,
                "| {} | {} | {} | {} | {} | {goal} | {}, {}, {} of {} | {} | {:.1} %, {:.2} % |",
                row.kind,
                figure(drawn),
                figure(found),
                figure(pressed),
                figure(true_model),
                drawn.missed,
                found.missed,
                true_model.missed,
                row.touches,
                row.refused,
                100.0 * row.misfit[0],
                100.0 * row.misfit[1],
            );
        }
        text
    }
}
