//! Locates the touches of one frame after the other.

use std::sync::Arc;

use super::fit::{Bounds, Fit};
use super::metric::{Whitened, energy};
use super::model::LocatorModel;
use super::motion::{Motion, nearest};
use super::recent::RecentResiduals;
use crate::eit::response::{Response, Shape, TouchModel};
use crate::types::{Contact, Nanos};

/// A new touch lowers the cost by at least this many squared deviations: noise alone reaches half of it once in hours.
pub(super) const DOWN_GAIN: f64 = 45.0;
/// A touch stays while it explains this many squared deviations.
const STAY_GAIN: f64 = 9.0;
/// Rise of conductivity x area of the lightest new touch, mm2.
pub(super) const LEAST_MM2: f64 = 4.0;
/// A touch ends below this share of [`LEAST_MM2`].
const STAY_SHARE: f64 = 0.5;
/// Touches that leave more than this many times noise and model error are looked for elsewhere, too.
const MISFIT_REST: f64 = 4.0;
/// A touch ends if less than this share of its response is left: the finger moved on or lifted.
const LEFT_SHARE: f64 = 0.3;
/// Steps of the fit that follow a touch from frame to frame.
const FOLLOW_STEPS: usize = 4;
/// Rise x area of full force, mm2.
const FULL_FORCE_MM2: f64 = 150.0;
/// A contact that explains this many times [`DOWN_GAIN`] has confidence 1.
const SURE_TIMES: f64 = 4.0;

/// Finds the touches of one frame after another.
#[derive(Clone, Debug)]
pub struct Locator {
    pub(super) model: Arc<LocatorModel>,
    pub(super) bounds: Bounds,
    pub(super) frame: Whitened,
    pub(super) fit: Fit,
    pub(super) trial: Fit,
    pub(super) best: Fit,
    /// The best fit before its touches are split.
    pub(super) whole: Fit,
    /// The fit of the frame, while a mean of frames is tried.
    pub(super) present: Fit,
    pub(super) recent: RecentResiduals,
    /// How many touches may begin, if frames share readings: then nothing is looked for in their mean.
    pub(super) most_new: Option<usize>,
    /// New touches must explain this many times [`DOWN_GAIN`].
    pub(super) down_gains: f64,
    /// Whether the board's converter rounds coarsely.
    pub(super) is_rounded: bool,
    /// The cost at which the last search for another touch failed; the search is repeated when it has grown.
    pub(super) refused_cost: f64,
    /// The cost of the last frame that neither touches nor the lift of a finger explain.
    pub(super) unclear_cost: f64,
    /// The touches of the previous frame.
    pub(super) before: Vec<TouchModel>,
    /// How each touch of the fit moves, in the same order, ...
    pub(super) motions: Vec<Motion>,
    /// ... and scratch memory.
    last_motions: Vec<Motion>,
    /// What the pad's deformation changed in the last frame, in the table's coordinates; empty if nothing.
    pub(super) deformation: Vec<f32>,
    /// What it changed since the first of the touches that are down, or were down last; empty if nothing.
    pub(super) bent: Vec<f32>,
    /// Time of the last located frame.
    located_ns: Nanos,
    pub(super) response: Response,
    pub(super) sum: Vec<f32>,
}

/// How well touches explain a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitQuality {
    /// Mean squared deviation of what no touches at all could explain, model error allowed for: 1 for noise alone.
    pub outside: f64,
    /// Mean squared deviation of what the located touches leave, likewise.
    pub rest: f64,
}

impl Locator {
    /// A locator before its first frame.
    #[must_use]
    pub fn new(model: Arc<LocatorModel>) -> Self {
        Self {
            bounds: model.bounds,
            model,
            frame: Whitened::default(),
            fit: Fit::default(),
            trial: Fit::default(),
            best: Fit::default(),
            whole: Fit::default(),
            present: Fit::default(),
            recent: RecentResiduals::default(),
            most_new: None,
            down_gains: 1.0,
            is_rounded: false,
            refused_cost: 0.0,
            unclear_cost: 0.0,
            before: Vec::new(),
            motions: Vec::new(),
            last_motions: Vec::new(),
            deformation: Vec::new(),
            bent: Vec::new(),
            located_ns: 0,
            response: Response::default(),
            sum: Vec::new(),
        }
    }

    /// Replaces the weights; the touches stay.
    pub fn set_weights(&mut self, model: Arc<LocatorModel>) {
        self.model = model;
        self.bent.clear();
        self.recent.clear();
        self.forget_held();
        self.refused_cost = 0.0;
        self.unclear_cost = 0.0;
    }

    /// New touches must explain `times` as much as usual: while the reference is young, its noise is little known.
    pub fn demand(&mut self, times: f64) {
        self.down_gains = times;
    }

    /// Whether the board's converter rounds so coarsely that its steps are seen.
    pub fn expect_rounding(&mut self, is_rounded: bool) {
        self.is_rounded = is_rounded;
    }

    /// Most touches that may begin in the next frames, which share readings; `None` for frames of their own.
    pub fn allow_new_touches(&mut self, most: Option<usize>) {
        self.most_new = most;
    }

    /// Restores the touches of the previous frame.
    pub fn undo_frame(&mut self) {
        self.fit.touches.clone_from(&self.before);
        self.recent.clear();
        self.forget_held();
    }

    /// Forgets all touches.
    pub fn forget_touches(&mut self) {
        self.fit.touches.clear();
        self.motions.clear();
        self.recent.clear();
        self.refused_cost = 0.0;
    }

    /// Takes a frame of relative changes, before its touches are located. `noise` is the variance of a reading in units of
    /// the variances of the weights.
    pub fn take_frame(&mut self, changes: &[f32], noise: f64) -> FitQuality {
        self.model.metric.whiten(changes, &mut self.frame);
        self.quality(noise)
    }

    /// Locates the touches of the frame last taken, of the given time. `steady` is the part of the noise that is the
    /// reference's uncertainty: it does not change from frame to frame.
    pub fn locate(&mut self, t_ns: Nanos, noise: f64, steady: f64) -> FitQuality {
        let elapsed_s = t_ns.saturating_sub(self.located_ns) as f64 * 1e-9;
        self.located_ns = t_ns;
        for motion in &mut self.motions {
            motion.advance(elapsed_s);
        }
        self.find_touches(noise, steady);
        self.follow_motions(noise);
        self.quality(noise)
    }

    /// Finds the touches of the frame last taken, starting from those of the frame before.
    pub(super) fn find_touches(&mut self, noise: f64, steady: f64) {
        self.bounds.prior_weight = noise;
        self.deformation.clear();
        // The reference's uncertainty ends no touch.
        self.follow(noise - steady);
        self.take_back_bend(noise);
        self.end_deformed(noise);
        self.try_landing_beside(noise);
        if self.model.table.has_both_signs() && self.quality(noise).rest > MISFIT_REST {
            // A fast finger is far from where the fit looked for it.
            self.escape_minimum(noise);
        }
        if self.is_settled(noise) && self.may_be_deformed(&self.fit.residual, noise) {
            let residual = self.fit.residual.clone();
            self.take_deformation(&residual, noise);
        }
        let touches = self.fit.touches.len();
        self.add_touches(noise);
        if self.fit.touches.len() == touches {
            if self.most_new.is_none() {
                self.add_faint_touch(noise, steady);
            }
        } else {
            self.recent.clear();
        }
        if self.fit.touches.len() > touches && self.model.table.has_both_signs() {
            self.try_other_sizes(noise);
        }
    }

    /// Places every touch by this frame and those before.
    fn follow_motions(&mut self, noise: f64) {
        std::mem::swap(&mut self.motions, &mut self.last_motions);
        self.motions.clear();
        for (index, touch) in self.fit.touches.iter().enumerate() {
            let variances_mm2 = self.fit.variances_mm2(index).map(|unit| noise * unit);
            let mut motion = match nearest(&self.last_motions, touch.centre_mm) {
                Some(which) => {
                    let mut motion = self.last_motions.swap_remove(which);
                    motion.correct(touch.centre_mm, variances_mm2);
                    motion
                }
                None => Motion::new(touch.centre_mm, variances_mm2),
            };
            motion.weigh(stay_ratio(touch, &self.fit.responses[index], noise));
            self.motions.push(motion);
        }
        // Events of recordings with tables of one sign stay as they were.
        if self.model.table.has_both_signs() {
            self.place_held(noise);
        }
    }

    /// The touches of the last frame, in the order in which they were found.
    pub fn contacts(&self) -> impl Iterator<Item = Contact> + '_ {
        // Events of recordings with tables of one sign stay as they were.
        let is_fused = self.model.table.has_both_signs();
        self.fit
            .touches
            .iter()
            .zip(&self.fit.responses)
            .zip(&self.motions)
            .map(move |((touch, response), motion)| {
                let confidence = energy(&response.value) / (SURE_TIMES * DOWN_GAIN);
                let [x, y] = if is_fused {
                    motion.place_mm()
                } else {
                    touch.centre_mm
                };
                let [width, height] = self.bounds.size_mm;
                Contact {
                    centre_mm: [x.clamp(0.0, width), y.clamp(0.0, height)],
                    area_mm2: area_mm2(touch),
                    force: (volume_mm2(touch) / FULL_FORCE_MM2).clamp(0.0, 1.0),
                    confidence: confidence.clamp(0.0, 1.0),
                }
            })
    }

    /// Writes the relative changes that the touches explain, one per channel.
    pub fn explain(&mut self, changes: &mut [f32]) {
        let table = &self.model.table;
        let rank = table.rank();
        self.sum.clear();
        self.sum.resize(rank, 0.0);
        for touch in &self.fit.touches {
            table.respond(touch, &mut self.response);
            for (total, value) in self.sum.iter_mut().zip(&self.response.value) {
                *total += value;
            }
        }
        table.expand(&self.sum, changes);
    }

    /// Fits the touches of the previous frame to this one and drops those that ended.
    fn follow(&mut self, noise: f64) {
        self.before.clone_from(&self.fit.touches);
        let Self {
            fit,
            before,
            frame,
            model,
            bounds,
            motions,
            ..
        } = self;
        // Events of recordings with tables of one sign stay as they were.
        let is_fused = model.table.has_both_signs();
        let problem = model.problem(frame, bounds);
        if is_fused && before.len() == motions.len() {
            for (touch, motion) in before.iter_mut().zip(motions.iter()) {
                let [dx, dy] = motion.step_mm();
                touch.centre_mm[0] += dx;
                touch.centre_mm[1] += dy;
            }
        }
        fit.set_touches(before, problem);
        // First those that have left, or the fit would drag them to new touches elsewhere.
        while let Some(gone) = fit.least_remaining().filter(|(_, left)| *left < LEFT_SHARE) {
            let mut touches = std::mem::take(&mut fit.touches);
            touches.remove(gone.0);
            fit.set_touches(&touches, problem);
        }
        fit.descend(FOLLOW_STEPS, problem);
        loop {
            let weakest = fit
                .touches
                .iter()
                .zip(&fit.responses)
                .map(|(touch, response)| stay_ratio(touch, response, noise))
                .enumerate()
                .min_by(|a, b| a.1.total_cmp(&b.1));
            match weakest {
                Some((index, ratio)) if ratio < 1.0 => {
                    let place_mm = fit.touches[index].centre_mm;
                    if is_fused
                        && nearest(motions, place_mm)
                            .is_some_and(|which| motions[which].survives_weak_frame())
                    {
                        break;
                    }
                    let mut touches = std::mem::take(&mut fit.touches);
                    touches.remove(index);
                    fit.set_touches(&touches, problem);
                    fit.descend(FOLLOW_STEPS, problem);
                }
                _ => break,
            }
        }
    }

    /// Fits the touches to the frame as it is now.
    pub(super) fn fit_again(&mut self) {
        let touches = std::mem::take(&mut self.fit.touches);
        let problem = self.model.problem(&self.frame, &self.bounds);
        self.fit.set_touches(&touches, problem);
        self.fit.descend(FOLLOW_STEPS, problem);
    }

    /// Energy of the model error in this frame.
    pub(super) fn model_error(&self) -> f64 {
        self.model.error_energy(energy(&self.frame.coordinates))
    }

    /// Number of dimensions that touches can explain.
    pub(super) fn inside(&self) -> f64 {
        self.model.table.rank().min(self.model.metric.counted()) as f64
    }

    pub(super) fn quality(&self, noise: f64) -> FitQuality {
        let inside = self.inside();
        let outside = (self.model.metric.counted() as f64 - inside).max(1.0);
        let error = self.model_error();
        FitQuality {
            outside: self.frame.outside() / (outside * noise + error),
            rest: energy(&self.fit.residual) / (inside * noise + error),
        }
    }
}

/// What a touch explains as a multiple of what it needs to stay.
pub(super) fn stay_ratio(touch: &TouchModel, response: &Response, noise: f64) -> f64 {
    let gain = energy(&response.value) / (STAY_GAIN * noise);
    gain.min(volume_mm2(touch) / (STAY_SHARE * LEAST_MM2))
}

/// Rise of conductivity x area: the mean rise of a paraboloid is half of the rise at its centre.
pub(super) fn volume_mm2(touch: &TouchModel) -> f64 {
    let of_part = |part: TouchModel| {
        let radius_mm = libm::exp(part.log_radius);
        0.5 * std::f64::consts::PI * radius_mm * radius_mm * part.rise()
    };
    match touch.shape {
        Shape::Round => of_part(*touch),
        Shape::Long { .. } | Shape::Palm { .. } | Shape::Ring { .. } => {
            touch.round_parts().map(of_part).sum()
        }
    }
}

/// The footprint at half of the rise, as in an image, mm2.
fn area_mm2(touch: &TouchModel) -> f64 {
    let radius_mm = libm::exp(touch.log_radius);
    let half_axes_mm = match touch.shape {
        Shape::Round => [radius_mm; 2],
        Shape::Long {
            half_mm: [x, y], ..
        } => [radius_mm + libm::hypot(x, y), radius_mm],
        Shape::Palm {
            half_mm: [x, y],
            width_mm,
        } => [radius_mm + libm::hypot(x, y), radius_mm + width_mm],
        Shape::Ring {
            radius_mm: ring_mm, ..
        } => [radius_mm + ring_mm; 2],
    };
    0.5 * std::f64::consts::PI * half_axes_mm[0] * half_axes_mm[1]
}
