//! Touches from the voltages themselves: how many, where, how large, how strong.
//!
//! An image is a linear, blurred view of a frame; the frame holds far more. Here each touch is what the pad's table of
//! responses says about a touch of some place, size and strength, and the touches are those that explain the frame
//! best. The last frame's touches start the fit; what they leave unexplained is searched for another; another counts
//! if it explains far more than noise and the model's own error can.
//!
//! Invariant: the same frames give the same touches, bit for bit.

mod fit;
mod metric;
mod recent;
mod search;
mod seek;

use std::sync::Arc;

use crate::eit::ResponseTable;
use crate::eit::response::{Bump, Response};
use crate::pad::Outline;
use crate::types::{ByteReader, Contact};
use fit::{Bounds, Fit};
use metric::{Metric, Whitened, energy};
use recent::Recent;
use search::Templates;

/// A new touch explains at least this much, squared deviations: noise alone reaches half of it once in hours.
const DOWN_GAIN: f64 = 45.0;
/// A touch stays while it explains this much.
const STAY_GAIN: f64 = 9.0;
/// The model's error, as a share of the frame's amplitude: pads differ from their models. A new touch explains at least the
/// energy that this error has.
const MODEL_ERROR: f64 = 0.04;
/// Rise of conductivity times area of the lightest press that counts as a new touch, mm2, ...
const LEAST_MM2: f64 = 4.0;
/// ... and the share of it below which a touch is over.
const STAY_SHARE: f64 = 0.5;
/// A touch of which less than this share of the last frame's response is left has gone: moved on, or up.
const LEFT_SHARE: f64 = 0.3;
/// Steps that follow a touch from frame to frame.
const FOLLOW_STEPS: usize = 4;
/// Rise times area that counts as full force, mm2.
const FULL_FORCE_MM2: f64 = 150.0;
/// A contact that explains this many times what a new one needs is sure.
const SURE_TIMES: f64 = 4.0;

/// What a pad's frames are explained with: its table, and weights for its channels.
#[derive(Clone, Debug)]
pub struct Locating {
    table: Arc<ResponseTable>,
    bounds: Bounds,
    metric: Metric,
    templates: Templates,
}

impl Locating {
    /// Weighs the channels of a pad by their relative deviations; one that is not finite leaves its channel out.
    ///
    /// # Panics
    /// If there is not one deviation a channel.
    #[must_use]
    pub fn new(table: Arc<ResponseTable>, outline: &Outline, deviations: &[f64]) -> Self {
        let metric = Metric::new(&table, deviations);
        Self::with_metric(table, outline, metric)
    }

    /// Appends the weights: with the table and the outline they make all of it.
    pub fn to_bytes(&self, bytes: &mut Vec<u8>) {
        self.metric.to_bytes(bytes);
    }

    /// One of a table and an outline, from what [`Self::to_bytes`] gave; none if the bytes are of something else.
    #[must_use]
    pub fn from_bytes(
        bytes: &mut ByteReader<'_>,
        table: Arc<ResponseTable>,
        outline: &Outline,
    ) -> Option<Self> {
        let metric = Metric::from_bytes(bytes, &table)?;
        Some(Self::with_metric(table, outline, metric))
    }

    /// The table that it explains frames with.
    #[must_use]
    pub fn table(&self) -> &Arc<ResponseTable> {
        &self.table
    }

    fn with_metric(table: Arc<ResponseTable>, outline: &Outline, metric: Metric) -> Self {
        let [least, most] = table.radii_mm();
        let bounds = Bounds {
            size_mm: outline.size_mm(),
            log_radius: [libm::log(least), libm::log(most)],
            usual_weight: 1.0,
        };
        Self {
            templates: Templates::new(&table, &metric, &bounds, outline),
            table,
            bounds,
            metric,
        }
    }
}

/// Finds the touches of one frame after another.
#[derive(Clone, Debug)]
pub struct Locator {
    table: Arc<ResponseTable>,
    bounds: Bounds,
    metric: Metric,
    templates: Templates,
    frame: Whitened,
    fit: Fit,
    trial: Fit,
    best: Fit,
    /// The frame's own fit, while that of a mean is tried.
    present: Fit,
    recent: Recent,
    /// The cost at which one more touch was last sought in vain: sought again only when it has grown.
    refused_cost: f64,
    /// The touches of the frame before.
    before: Vec<Bump>,
    response: Response,
    sum: Vec<f32>,
}

/// What a frame says beside its touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Explained {
    /// Mean squared deviation of what no touches whatever could explain: 1 for noise alone, the model's own error allowed
    /// for.
    pub outside: f64,
    /// Mean squared deviation of what the found touches leave, likewise.
    pub rest: f64,
}

impl Locator {
    /// A locator that has seen no frame.
    #[must_use]
    pub fn new(locating: &Locating) -> Self {
        Self {
            table: Arc::clone(&locating.table),
            bounds: locating.bounds,
            metric: locating.metric.clone(),
            templates: locating.templates.clone(),
            frame: Whitened::default(),
            fit: Fit::default(),
            trial: Fit::default(),
            best: Fit::default(),
            present: Fit::default(),
            recent: Recent::default(),
            refused_cost: 0.0,
            before: Vec::new(),
            response: Response::default(),
            sum: Vec::new(),
        }
    }

    /// Goes on with other weights; the touches stay.
    pub fn take(&mut self, locating: &Locating) {
        self.metric = locating.metric.clone();
        self.templates = locating.templates.clone();
        self.recent.clear();
        self.refused_cost = 0.0;
    }

    /// Takes back what the last frame was taken for: its touches are again those of the frame before.
    pub fn go_back(&mut self) {
        self.fit.bumps.clone_from(&self.before);
        self.recent.clear();
    }

    /// Forgets the touches of the last frame.
    pub fn forget(&mut self) {
        self.fit.bumps.clear();
        self.recent.clear();
        self.refused_cost = 0.0;
    }

    /// Takes a frame of relative changes, and says how much of it is like no touch. `noise` is the variance of a reading
    /// in units of the weights' (1: as it was when weighed).
    pub fn take_frame(&mut self, changes: &[f32], noise: f64) -> Explained {
        self.metric.whiten(changes, &mut self.frame);
        self.explained(noise)
    }

    /// Finds the touches of the frame that was taken. Of the noise, `steady` is what does not change from frame to frame: the
    /// reference's doubt.
    pub fn locate(&mut self, noise: f64, steady: f64) -> Explained {
        self.bounds.usual_weight = noise;
        // The reference's doubt makes no touch end.
        self.follow(noise - steady);
        let touches = self.fit.bumps.len();
        self.seek(noise);
        if self.fit.bumps.len() == touches {
            self.seek_faint(noise, steady);
        } else {
            self.recent.clear();
        }
        self.explained(noise)
    }

    /// The touches of the last frame, the first found first.
    pub fn contacts(&self) -> impl Iterator<Item = Contact> + '_ {
        self.fit
            .bumps
            .iter()
            .zip(&self.fit.responses)
            .map(|(bump, response)| {
                let radius_mm = libm::exp(bump.log_radius);
                let surplus = energy(&response.value) / (SURE_TIMES * DOWN_GAIN);
                Contact {
                    centre_mm: bump.centre_mm,
                    // The footprint at half of the rise, as an image shows it.
                    area_mm2: 0.5 * std::f64::consts::PI * radius_mm * radius_mm,
                    force: (volume_mm2(bump) / FULL_FORCE_MM2).clamp(0.0, 1.0),
                    confidence: surplus.clamp(0.0, 1.0),
                }
            })
    }

    /// The touches of the last frame as the table knows them.
    #[must_use]
    pub fn bumps(&self) -> &[Bump] {
        &self.fit.bumps
    }

    /// What the touches change in the readings: relative changes, one a channel.
    pub fn explain(&mut self, changes: &mut [f32]) {
        let rank = self.table.rank();
        self.sum.clear();
        self.sum.resize(rank, 0.0);
        for bump in &self.fit.bumps {
            self.table.respond(bump, &mut self.response);
            for (total, value) in self.sum.iter_mut().zip(&self.response.value) {
                *total += value;
            }
        }
        self.table.expand(&self.sum, changes);
    }

    /// Follows the touches of the last frame and drops those that are over.
    fn follow(&mut self, noise: f64) {
        self.before.clone_from(&self.fit.bumps);
        let Self {
            fit,
            before,
            frame,
            table,
            metric,
            bounds,
            ..
        } = self;
        fit.start(before, frame, table, metric, bounds);
        // First those that have left, or the fit would drag them to whatever is new elsewhere.
        while let Some(gone) = fit.least_left().filter(|(_, left)| *left < LEFT_SHARE) {
            let mut bumps = std::mem::take(&mut fit.bumps);
            bumps.remove(gone.0);
            fit.start(&bumps, frame, table, metric, bounds);
        }
        fit.descend(FOLLOW_STEPS, frame, table, metric, bounds);
        loop {
            let weakest = fit
                .bumps
                .iter()
                .zip(&fit.responses)
                .map(|(bump, response)| {
                    let gain = energy(&response.value) / (STAY_GAIN * noise);
                    gain.min(volume_mm2(bump) / (STAY_SHARE * LEAST_MM2))
                })
                .enumerate()
                .min_by(|a, b| a.1.total_cmp(&b.1));
            match weakest {
                Some((index, ratio)) if ratio < 1.0 => {
                    let mut bumps = std::mem::take(&mut fit.bumps);
                    bumps.remove(index);
                    fit.start(&bumps, frame, table, metric, bounds);
                    fit.descend(FOLLOW_STEPS, frame, table, metric, bounds);
                }
                _ => break,
            }
        }
    }

    /// Energy of what the model gets wrong in this frame.
    fn model_error(&self) -> f64 {
        MODEL_ERROR * MODEL_ERROR * energy(&self.frame.coordinates)
    }

    /// Dimensions of a frame that touches can explain.
    fn inside(&self) -> f64 {
        self.table.rank().min(self.metric.counted()) as f64
    }

    fn explained(&self, noise: f64) -> Explained {
        let inside = self.inside();
        let outside = (self.metric.counted() as f64 - inside).max(1.0);
        let error = self.model_error();
        Explained {
            outside: self.frame.outside() / (outside * noise + error),
            rest: energy(&self.fit.residual) / (inside * noise + error),
        }
    }
}

/// Rise of conductivity times area: the mean rise of a paraboloid is half of its middle's.
fn volume_mm2(bump: &Bump) -> f64 {
    let radius_mm = libm::exp(bump.log_radius);
    0.5 * std::f64::consts::PI * radius_mm * radius_mm * bump.rise()
}
