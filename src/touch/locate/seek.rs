//! Another touch: where it may be, whether it is one, and whether all together are not better told otherwise.
//!
//! A greedy search ends in local minima of many times the least cost, above all where two touches are near or begin in the
//! same frame. So a new touch is tried beside the others and, near one, as one half of it in every direction; a fit that stays
//! poor is sought anew touch by touch; and what the others can do without is taken out.

use super::metric::energy;
use super::{DOWN_GAIN, LEAST_MM2, Locator, volume_mm2};
use crate::eit::response::Bump;
use crate::types::PointMm;

/// A touch too faint for one frame is sought in the mean of so many.
pub(super) const MEAN_FRAMES: usize = 4;
/// Two touches are never nearer than this: a finger's width. What looks like it is one wide or oval finger.
const LEAST_APART_MM: f64 = 12.5;
/// A new touch has its middle so far within the pad: what pulls a fit to the very edge is a contact's error.
const LEAST_DEPTH_MM: f64 = 1.5;
/// Of two touches nearer than this, the second must explain most of what one leaves.
const NEAR_MM: f64 = 28.0;
/// ... namely this share.
const NEAR_DROP: f64 = 0.55;
/// Within so many mm of a strong touch, one of less than such a share of its volume is that one's odd shape.
const SHADOWS: [(f64, f64); 2] = [(NEAR_MM, 0.12), (50.0, 0.04)];
/// What two near touches leave of one that is fitted to both has its peak within so many mm of it.
const SPLIT_WITHIN_MM: f64 = 50.0;
/// Two halves of one touch start this far from its middle, mm, ...
const SPLITS_MM: [f64; 2] = [7.0, 10.0];
/// ... in so many directions.
const DIRECTIONS: usize = 8;
/// No more touches than two hands have fingers.
const MOST_TOUCHES: usize = 10;
/// Steps that settle a new touch.
const SETTLE_STEPS: usize = 25;
/// Steps that tell which way a touch splits.
const SPLIT_STEPS: usize = 3;
/// The most likely splits are settled.
const SPLITS_SETTLED: usize = 3;
/// A template of a usual finger explains at least this share of what the fitted touch will.
const TEMPLATE_SHARE: f64 = 0.5;
/// Another touch that was refused is tried again when the rest has grown by this factor.
pub(super) const REFUSED_GROWTH: f64 = 1.3;
/// A touch whose fit leaves less than this, of what noise and the model's error explain, needs no other try.
const WELL_REST: f64 = 0.5;
/// A fit that leaves more than this is sought anew, ...
const POOR_REST: f64 = 0.8;
/// ... at most so many times over all touches, and kept if its cost falls below this share.
const MOST_ROUNDS: usize = 3;
const BETTER_SHARE: f64 = 0.9;

impl Locator {
    /// Adds touches while another explains enough.
    pub(super) fn seek(&mut self, noise: f64) {
        let before = self.fit.bumps.len();
        let least_gain = DOWN_GAIN * noise + self.model_error();
        while self.fit.bumps.len() < MOST_TOUCHES {
            let rest = energy(&self.fit.residual);
            if rest < least_gain || rest < REFUSED_GROWTH * self.refused_cost {
                break;
            }
            let peak = self.templates.peak(&self.fit.residual);
            // A template is never quite the touch: it explains part of what the fitted one will.
            let Some(peak) = peak.filter(|peak| peak.gain > TEMPLATE_SHARE * least_gain) else {
                break;
            };
            if !self.try_add(peak.place_mm, least_gain, noise) {
                self.refused_cost = rest;
                break;
            }
            self.refused_cost = 0.0;
            // Touches that begin together may first have been taken for one between them.
            if self.settle(noise) || self.fit.bumps.len() > before + 1 {
                self.prune(least_gain);
            }
        }
    }

    /// Seeks touches that are too faint for one frame in the mean of the last few.
    pub(super) fn seek_faint(&mut self, noise: f64, steady: f64) {
        if self.recent.take(self.fit.bumps.len(), &self.fit.residual) < MEAN_FRAMES {
            return;
        }
        let noise = steady + (noise - steady) / MEAN_FRAMES as f64;
        let least_gain = DOWN_GAIN * noise + self.model_error();
        let peak = self.templates.peak(self.recent.mean());
        let Some(peak) = peak.filter(|peak| peak.gain > TEMPLATE_SHARE * least_gain) else {
            return;
        };
        if !self.recent.is_news(peak.gain) {
            return;
        }
        // The frame as it would be with the mean's noise.
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
        let bumps = std::mem::take(&mut self.fit.bumps);
        self.bounds.usual_weight = noise;
        self.try_fit(&bumps, 0);
        std::mem::swap(&mut self.fit, &mut self.trial);
        // What one noisy frame refused says nothing about the mean.
        let refused_cost = std::mem::take(&mut self.refused_cost);
        self.seek(noise);
        self.refused_cost = refused_cost;
        if self.fit.bumps.len() > bumps.len() {
            self.recent.clear();
        } else {
            std::mem::swap(&mut self.fit, &mut self.present);
            self.frame.coordinates = now;
        }
    }

    /// Takes out touches that the others, settled, do not need.
    fn prune(&mut self, least_gain: f64) {
        let mut index = 0;
        while index < self.fit.bumps.len() && self.fit.bumps.len() > 1 {
            let others = with(&self.fit.bumps, &[], Some(index));
            self.try_fit(&others, SETTLE_STEPS);
            if self.trial.cost - self.fit.cost < least_gain {
                std::mem::swap(&mut self.fit, &mut self.trial);
            } else {
                index += 1;
            }
        }
    }

    /// Leaves a local minimum: while the fit is poor, each touch in turn is taken out and sought again. Returns whether
    /// that found a better one.
    fn settle(&mut self, noise: f64) -> bool {
        let mut ever = false;
        for _ in 0..MOST_ROUNDS {
            if self.explained(noise).rest < POOR_REST {
                break;
            }
            let mut is_better = false;
            for index in 0..self.fit.bumps.len() {
                let others = with(&self.fit.bumps, &[], Some(index));
                self.try_fit(&others, 0);
                let Some(peak) = self.templates.peak(&self.trial.residual) else {
                    continue;
                };
                let bumps = with(&others, &[self.bounds.usual(peak.place_mm)], None);
                self.try_fit(&bumps, SETTLE_STEPS);
                if self.trial.cost < BETTER_SHARE * self.fit.cost
                    && least_apart_mm(&self.trial.bumps) >= LEAST_APART_MM
                {
                    std::mem::swap(&mut self.fit, &mut self.trial);
                    is_better = true;
                }
            }
            if !is_better {
                break;
            }
            ever = true;
        }
        ever
    }

    /// Explains the frame by other touches, on trial.
    fn try_fit(&mut self, bumps: &[Bump], most_steps: usize) {
        let Self {
            trial,
            frame,
            table,
            metric,
            bounds,
            ..
        } = self;
        trial.start(bumps, frame, table, metric, bounds);
        trial.descend(most_steps, frame, table, metric, bounds);
    }

    /// Tries one more touch near a place; keeps it if it explains enough.
    fn try_add(&mut self, place_mm: PointMm, least_gain: f64, noise: f64) -> bool {
        self.best.cost = f64::INFINITY;
        let another = with(&self.fit.bumps, &[self.bounds.usual(place_mm)], None);
        self.try_fit(&another, SETTLE_STEPS);
        std::mem::swap(&mut self.trial, &mut self.best);
        let well = WELL_REST * (self.inside() * noise + self.model_error());
        if !self.is_worth(least_gain) || energy(&self.best.residual) > well {
            self.try_splits(place_mm);
        }
        let is_better = self.is_worth(least_gain);
        if is_better {
            std::mem::swap(&mut self.fit, &mut self.best);
        }
        is_better
    }

    /// Tries two touches instead of one that is near a place.
    fn try_splits(&mut self, place_mm: PointMm) {
        let nearest = self
            .fit
            .bumps
            .iter()
            .map(|bump| distance_mm(bump.centre_mm, place_mm))
            .enumerate()
            .min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((index, _)) = nearest.filter(|(_, apart)| *apart < SPLIT_WITHIN_MM) else {
            return;
        };
        let middle = self.fit.bumps[index].centre_mm;
        let mut tried = Vec::with_capacity(DIRECTIONS * SPLITS_MM.len());
        for direction in 0..DIRECTIONS {
            let angle = std::f64::consts::PI * direction as f64 / DIRECTIONS as f64;
            let (dx, dy) = (libm::cos(angle), libm::sin(angle));
            for far in SPLITS_MM {
                let halves = [far, -far].map(|side| {
                    self.bounds
                        .usual([middle[0] + side * dx, middle[1] + side * dy])
                });
                let bumps = with(&self.fit.bumps, &halves, Some(index));
                self.try_fit(&bumps, SPLIT_STEPS);
                tried.push((self.trial.cost, self.trial.bumps.clone()));
            }
        }
        tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, bumps) in tried.iter().take(SPLITS_SETTLED) {
            self.try_fit(bumps, SETTLE_STEPS);
            if self.trial.cost < self.best.cost {
                std::mem::swap(&mut self.trial, &mut self.best);
            }
        }
    }

    /// Whether the best trial, with one touch more, is worth that touch.
    fn is_worth(&self, least_gain: f64) -> bool {
        let gain = self.fit.cost - self.best.cost;
        if gain < least_gain {
            return false;
        }
        let bumps = &self.best.bumps;
        let least_apart = least_apart_mm(bumps);
        let lightest = bumps.iter().map(volume_mm2).fold(f64::INFINITY, f64::min);
        let is_shadow = bumps.iter().any(|weak| {
            bumps.iter().any(|strong| {
                let apart = distance_mm(weak.centre_mm, strong.centre_mm);
                let share = volume_mm2(weak) / volume_mm2(strong);
                SHADOWS
                    .iter()
                    .any(|(reach, least)| apart < *reach && share < *least)
            })
        });
        let outermost = bumps
            .iter()
            .map(|bump| self.depth_mm(bump.centre_mm))
            .fold(f64::INFINITY, f64::min);
        least_apart >= LEAST_APART_MM
            && outermost >= LEAST_DEPTH_MM
            && lightest >= LEAST_MM2
            && !is_shadow
            && (least_apart >= NEAR_MM || gain > NEAR_DROP * self.fit.cost)
    }

    /// How far within the pad's box a place lies, mm.
    fn depth_mm(&self, [x, y]: PointMm) -> f64 {
        let [width, height] = self.bounds.size_mm;
        x.min(width - x).min(y).min(height - y)
    }
}

/// Distance of the nearest two, mm.
fn least_apart_mm(bumps: &[Bump]) -> f64 {
    bumps
        .iter()
        .enumerate()
        .flat_map(|(i, a)| {
            bumps[..i]
                .iter()
                .map(|b| distance_mm(a.centre_mm, b.centre_mm))
        })
        .fold(f64::INFINITY, f64::min)
}

/// Touches with one taken out and others put in.
fn with(bumps: &[Bump], more: &[Bump], without: Option<usize>) -> Vec<Bump> {
    bumps
        .iter()
        .enumerate()
        .filter(|(index, _)| Some(*index) != without)
        .map(|(_, bump)| *bump)
        .chain(more.iter().copied())
        .collect()
}

fn distance_mm(a: PointMm, b: PointMm) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}
