//! Search for new touches.
//!
//! A greedy search ends in local minima of many times the least cost, above all where two touches are close together or
//! begin in the same frame. So a new touch is tried beside the others and, close to one, as a split of it in several
//! directions; while the fit is poor, each touch is removed and located again; touches that the others make redundant are
//! removed.

use super::locator::{DOWN_GAIN, LEAST_MM2, Locator, volume_mm2};
use super::metric::energy;
use super::recent::{MEAN_FRAMES, REFUSED_GROWTH};
use super::templates::Peak;
use crate::eit::response::TouchModel;
use crate::types::{PointMm, distance_mm};

/// Least distance of a new touch's centre from the edge with tables that end there: a fit at the very edge is an error of an
/// electrode's contact.
const LEAST_DEPTH_MM: f64 = 1.5;
/// With tables that reach further, a new touch lies within this share of their reach: one at its end is not a finger.
const OUTERMOST_SHARE: f64 = 0.97;
/// A touch whose centre lies outside the pad or within [`LEAST_DEPTH_MM`] of its edge leaves less than this many times noise
/// and model error: the contact of an electrode that comes loose resembles such a touch, but less well.
const EDGE_REST: f64 = 3.0;
/// While channels are excluded, a new touch at the edge must explain this many times as much as another one: near a lost
/// electrode the edge is hardly seen.
const BLIND_EDGE_GAINS: f64 = 4.0;
/// Below this distance, the second touch must explain the share [`NEAR_DROP`] of what the first leaves.
const NEAR_MM: f64 = 28.0;
/// Least share of what a touch leaves that a second one near it must explain.
const NEAR_DROP: f64 = 0.55;
/// Within this distance in mm of a strong touch, one with less than this share of its volume is part of its shape.
const SHADOWS: [(f64, f64); 2] = [(NEAR_MM, 0.12), (50.0, 0.04)];
/// Within this distance in mm of a strong touch, one at the edge with less than this share of its volume is what a poor fit of
/// the strong one leaves: outside the pad nothing contradicts it.
const EDGE_SHADOW: (f64, f64) = (50.0, 0.12);
/// Where one touch was fitted to two, the residual has its peak within this distance of it.
const SPLIT_WITHIN_MM: f64 = 50.0;
/// Distances of the halves of a split touch from its centre, mm, at the start of the fit.
const SPLITS_MM: [f64; 2] = [7.0, 10.0];
/// Directions in which the halves of a split touch start.
const DIRECTIONS: usize = 8;
/// Steps of the fit of a new touch.
pub(super) const NEW_TOUCH_STEPS: usize = 25;
/// Steps of the fit that ranks the splits.
const SPLIT_STEPS: usize = 3;
/// Number of splits that are fitted fully.
const SPLITS_FITTED: usize = 3;
/// The template of a typical finger explains at least this share of what the fitted touch will.
const TEMPLATE_SHARE: f64 = 0.5;
/// A new touch that leaves more than this many times noise and model error, more than noise alone does, is tried from other
/// places, too.
const MISPLACED_REST: f64 = 1.6;
/// Directions of the halves where every touch of a frame is tried as two.
const FEW_DIRECTIONS: usize = 4;
/// Distance of those halves from the centre of the touch, mm.
const FAR_SPLIT_MM: f64 = 11.0;
/// Steps of the fit that ranks those splits.
const FEW_STEPS: usize = 3;
/// Such a split is kept if the cost falls below this share.
const WORTH_SPLIT: f64 = 0.6;
/// A new touch whose fit leaves less than this share of noise and model error is accepted without trying splits.
const WELL_REST: f64 = 0.5;
/// A fit that leaves more than this share of noise and model error is improved touch by touch.
const POOR_REST: f64 = 0.8;
/// Most rounds of that improvement.
const MOST_ROUNDS: usize = 3;
/// A change counts as an improvement if the cost falls below this share.
const BETTER_SHARE: f64 = 0.9;

impl Locator {
    /// Adds touches while another one explains enough.
    pub(super) fn add_touches(&mut self, noise: f64) {
        let before = self.fit.touches.len();
        let least_gain = self.down_gains * DOWN_GAIN * noise + self.model_error();
        let all = self.model.pad.most_touches;
        let most = all.min(before + self.most_new.unwrap_or(all));
        while self.fit.touches.len() < most {
            let rest = energy(&self.fit.residual);
            if rest < least_gain || rest < REFUSED_GROWTH * self.refused_cost {
                break;
            }
            let peak = self.peak(&self.fit.residual);
            let Some(peak) = peak.filter(|peak| peak.gain > TEMPLATE_SHARE * least_gain) else {
                break;
            };
            let (count, cost) = (self.fit.touches.len(), self.fit.cost);
            if !self.try_add(peak.place_mm, least_gain, noise) {
                self.refused_cost = rest;
                break;
            }
            self.refused_cost = 0.0;
            // Touches that begin together may first have been fitted as one between them.
            if self.escape_minimum(noise) || self.fit.touches.len() > before + 1 {
                self.prune(least_gain);
            }
            // A touch that only replaces another could be added and removed for ever.
            if self.fit.touches.len() <= count && self.fit.cost > BETTER_SHARE * cost {
                self.refused_cost = rest;
                break;
            }
        }
    }

    /// Searches the mean of the last few frames for a touch that is too faint for one.
    pub(super) fn add_faint_touch(&mut self, noise: f64, steady: f64) {
        if self.recent.push(self.fit.touches.len(), &self.fit.residual) < MEAN_FRAMES {
            return;
        }
        let noise = steady + (noise - steady) * self.recent.noise_share();
        if self.is_settled(noise) && self.may_be_deformed(self.recent.mean(), noise) {
            let mean = self.recent.mean().to_vec();
            if self.take_deformation(&mean, noise) {
                self.recent.clear();
                return;
            }
        }
        let least_gain = self.down_gains * DOWN_GAIN * noise + self.model_error();
        let peak = self.peak(self.recent.mean());
        let Some(peak) = peak.filter(|peak| peak.gain > TEMPLATE_SHARE * least_gain) else {
            return;
        };
        if !self.recent.exceeds_refused(peak.gain) {
            return;
        }
        // The frame with the noise of the mean.
        self.present.clone_from(&self.fit);
        let now = self.frame.coordinates.clone();
        for ((value, rest), mean) in self
            .frame
            .coordinates
            .iter_mut()
            .zip(&self.fit.residual)
            .zip(self.recent.mean())
        {
            *value += mean - rest;
        }
        let touches = std::mem::take(&mut self.fit.touches);
        self.bounds.prior_weight = noise;
        self.try_fit(&touches, 0);
        std::mem::swap(&mut self.fit, &mut self.trial);
        // A failed search in one noisy frame says nothing about the mean.
        let refused_cost = std::mem::take(&mut self.refused_cost);
        self.add_touches(noise);
        self.refused_cost = refused_cost;
        if self.fit.touches.len() > touches.len() {
            self.recent.clear();
        } else {
            std::mem::swap(&mut self.fit, &mut self.present);
            self.frame.coordinates = now;
        }
    }

    /// Removes touches without which the others, fitted again, explain the frame as well and stay apart.
    fn prune(&mut self, least_gain: f64) {
        let mut index = 0;
        while index < self.fit.touches.len() && self.fit.touches.len() > 1 {
            let others = edited(&self.fit.touches, &[], Some(index));
            self.try_fit(&others, NEW_TOUCH_STEPS);
            if self.trial.cost - self.fit.cost < least_gain
                && least_apart_mm(&self.trial.touches) >= self.model.pad.least_apart_mm
            {
                std::mem::swap(&mut self.fit, &mut self.trial);
            } else {
                index += 1;
            }
        }
    }

    /// Leaves a local minimum: while the fit is poor, removes each touch in turn and locates it again. Returns whether
    /// that improved the fit.
    pub(super) fn escape_minimum(&mut self, noise: f64) -> bool {
        let mut improved = false;
        for _ in 0..MOST_ROUNDS {
            if self.quality(noise).rest < POOR_REST {
                break;
            }
            let mut is_better = false;
            for index in 0..self.fit.touches.len() {
                let others = edited(&self.fit.touches, &[], Some(index));
                self.try_fit(&others, 0);
                let Some(peak) = self.peak(&self.trial.residual) else {
                    continue;
                };
                let touches = edited(&others, &[self.bounds.typical(peak.place_mm)], None);
                self.try_fit(&touches, NEW_TOUCH_STEPS);
                if self.trial.cost < BETTER_SHARE * self.fit.cost
                    && least_apart_mm(&self.trial.touches) >= self.model.pad.least_apart_mm
                {
                    std::mem::swap(&mut self.fit, &mut self.trial);
                    is_better = true;
                }
            }
            if !is_better {
                break;
            }
            improved = true;
        }
        improved
    }

    /// The place where a touch would explain most of a residual.
    pub(super) fn peak(&self, residual: &[f32]) -> Option<Peak> {
        self.model.templates.peak(residual, self.bounds.sign)
    }

    /// Fits other touches to the frame, as a trial.
    pub(super) fn try_fit(&mut self, touches: &[TouchModel], most_steps: usize) {
        let Self {
            trial,
            frame,
            model,
            bounds,
            ..
        } = self;
        let problem = model.problem(frame, bounds);
        trial.set_touches(touches, problem);
        trial.descend(most_steps, problem);
    }

    /// Tries one more touch at a place; keeps it if it explains enough.
    fn try_add(&mut self, place_mm: PointMm, least_gain: f64, noise: f64) -> bool {
        self.best.cost = f64::INFINITY;
        let another = edited(&self.fit.touches, &[self.bounds.typical(place_mm)], None);
        self.try_fit(&another, NEW_TOUCH_STEPS);
        std::mem::swap(&mut self.trial, &mut self.best);
        let well = WELL_REST * (self.inside() * noise + self.model_error());
        if !self.justifies_touch(least_gain) || energy(&self.best.residual) > well {
            self.try_splits(place_mm);
        }
        if let Some(touches) = self.odd_instead(noise) {
            return self.take_odd(&touches, least_gain);
        }
        if energy(&self.best.residual) > well && self.model.table.has_both_signs() {
            if energy(&self.best.residual) > MISPLACED_REST / WELL_REST * well {
                self.try_other_starts();
            }
            if energy(&self.best.residual) > well && self.best.touches.len() > 1 {
                self.whole.clone_from(&self.best);
                self.try_all_splits();
                // A split may only add a shadow of a strong touch: the fit without it still counts.
                if self.odd_instead(noise).is_some() || !self.justifies_touch(least_gain) {
                    std::mem::swap(&mut self.whole, &mut self.best);
                }
            }
        }
        let is_better =
            self.justifies_touch(least_gain) && !self.is_loose_contact(least_gain, noise);
        if is_better {
            std::mem::swap(&mut self.fit, &mut self.best);
        }
        is_better
    }

    /// Whether a touch at the edge is rather an electrode whose contact changes.
    fn is_loose_contact(&self, least_gain: f64, noise: f64) -> bool {
        let at_edge = self
            .best
            .touches
            .iter()
            .any(|touch| self.depth_mm(touch.centre_mm) < LEAST_DEPTH_MM);
        let fair = self.inside() * noise + self.model_error();
        let gain = self.fit.cost - self.best.cost;
        at_edge
            && (energy(&self.best.residual) > EDGE_REST * fair
                || self.model.is_blind() && gain < BLIND_EDGE_GAINS * least_gain)
    }

    /// Tries one more touch at each of the best places: at the edge, the fit that starts from the best one may end beside the
    /// least cost.
    fn try_other_starts(&mut self) {
        let peaks = self
            .model
            .templates
            .peaks(&self.fit.residual, self.bounds.sign);
        for place_mm in peaks.into_iter().skip(1) {
            let another = edited(&self.fit.touches, &[self.bounds.typical(place_mm)], None);
            self.try_fit(&another, NEW_TOUCH_STEPS);
            self.keep_better();
        }
    }

    /// Tries to split every touch in two: where several fingers begin together, one may stand for two that are not near the
    /// peak of what it leaves.
    fn try_all_splits(&mut self) {
        let mut tried = Vec::new();
        for index in 0..self.best.touches.len() {
            let middle = self.best.touches[index].centre_mm;
            for direction in 0..FEW_DIRECTIONS {
                let angle = std::f64::consts::PI * direction as f64 / FEW_DIRECTIONS as f64;
                let (dx, dy) = (libm::cos(angle), libm::sin(angle));
                let halves = [FAR_SPLIT_MM, -FAR_SPLIT_MM].map(|side| {
                    self.bounds
                        .typical([middle[0] + side * dx, middle[1] + side * dy])
                });
                let touches = edited(&self.best.touches, &halves, Some(index));
                self.try_fit(&touches, FEW_STEPS);
                tried.push((self.trial.cost, self.trial.touches.clone()));
            }
        }
        tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, touches) in tried.iter().take(SPLITS_FITTED) {
            self.try_fit(touches, NEW_TOUCH_STEPS);
            // One touch more than the others tried so far: it has to be worth it.
            if self.trial.cost < WORTH_SPLIT * self.best.cost
                && least_apart_mm(&self.trial.touches) >= self.model.pad.least_apart_mm
            {
                std::mem::swap(&mut self.trial, &mut self.best);
            }
        }
    }

    /// Keeps the trial if it is the best one so far.
    fn keep_better(&mut self) {
        if self.trial.cost < self.best.cost {
            std::mem::swap(&mut self.trial, &mut self.best);
        }
    }

    /// Tries to split the touch nearest to a place in two.
    fn try_splits(&mut self, place_mm: PointMm) {
        let nearest = self
            .fit
            .touches
            .iter()
            .map(|touch| distance_mm(touch.centre_mm, place_mm))
            .enumerate()
            .min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((index, _)) = nearest.filter(|(_, apart)| *apart < SPLIT_WITHIN_MM) else {
            return;
        };
        let middle = self.fit.touches[index].centre_mm;
        let mut tried = Vec::with_capacity(DIRECTIONS * SPLITS_MM.len());
        for direction in 0..DIRECTIONS {
            let angle = std::f64::consts::PI * direction as f64 / DIRECTIONS as f64;
            let (dx, dy) = (libm::cos(angle), libm::sin(angle));
            for far in SPLITS_MM {
                let halves = [far, -far].map(|side| {
                    self.bounds
                        .typical([middle[0] + side * dx, middle[1] + side * dy])
                });
                let touches = edited(&self.fit.touches, &halves, Some(index));
                self.try_fit(&touches, SPLIT_STEPS);
                tried.push((self.trial.cost, self.trial.touches.clone()));
            }
        }
        tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, touches) in tried.iter().take(SPLITS_FITTED) {
            self.try_fit(touches, NEW_TOUCH_STEPS);
            self.keep_better();
        }
    }

    /// Whether the best trial is good enough to justify one more touch.
    fn justifies_touch(&self, least_gain: f64) -> bool {
        let gain = self.fit.cost - self.best.cost;
        if gain < least_gain {
            return false;
        }
        let touches = &self.best.touches;
        self.may_be_fingers(touches)
            && (least_apart_mm(touches) >= NEAR_MM || gain > NEAR_DROP * self.fit.cost)
    }

    /// Whether touches may all be new fingers: far enough apart, on the pad, heavy enough, and none the shadow of another.
    pub(super) fn may_be_fingers(&self, touches: &[TouchModel]) -> bool {
        let lightest = touches.iter().map(volume_mm2).fold(f64::INFINITY, f64::min);
        let is_shadow = touches.iter().any(|weak| {
            touches.iter().any(|strong| {
                let apart = distance_mm(weak.centre_mm, strong.centre_mm);
                let share = volume_mm2(weak) / volume_mm2(strong);
                let at_edge = self.depth_mm(weak.centre_mm) < LEAST_DEPTH_MM;
                let edge_shadow = at_edge.then_some(&EDGE_SHADOW);
                SHADOWS
                    .iter()
                    .chain(edge_shadow)
                    .any(|(reach, least)| apart < *reach && share < *least)
            })
        });
        let outermost = touches
            .iter()
            .map(|touch| self.depth_mm(touch.centre_mm))
            .fold(f64::INFINITY, f64::min);
        least_apart_mm(touches) >= self.model.pad.least_apart_mm
            && outermost >= self.least_depth_mm()
            && lightest >= LEAST_MM2
            && !is_shadow
    }

    /// Least distance of a new touch's centre from the edge, mm; negative outside.
    fn least_depth_mm(&self) -> f64 {
        if self.bounds.reach_mm > 0.0 {
            OUTERMOST_SHARE * -self.bounds.reach_mm
        } else {
            LEAST_DEPTH_MM
        }
    }

    /// Distance of a place from the nearest side of the pad's box, mm.
    fn depth_mm(&self, [x, y]: PointMm) -> f64 {
        let [width, height] = self.bounds.size_mm;
        x.min(width - x).min(y).min(height - y)
    }
}

/// Least distance between two touches, mm.
pub(super) fn least_apart_mm(touches: &[TouchModel]) -> f64 {
    touches
        .iter()
        .enumerate()
        .flat_map(|(i, a)| {
            touches[..i]
                .iter()
                .map(|b| distance_mm(a.centre_mm, b.centre_mm))
        })
        .fold(f64::INFINITY, f64::min)
}

/// A list of touches without one of them and with others added.
pub(super) fn edited(
    touches: &[TouchModel],
    more: &[TouchModel],
    without: Option<usize>,
) -> Vec<TouchModel> {
    touches
        .iter()
        .enumerate()
        .filter(|(index, _)| Some(*index) != without)
        .map(|(_, touch)| *touch)
        .chain(more.iter().copied())
        .collect()
}
