//! Contacts from an image: thresholds in units of its noise, with hysteresis; and palms, which are no fingers.

use std::sync::Arc;

use super::{Blob, Segmenter, Threshold};
use crate::eit::Reconstruction;
use crate::types::{Contact, Image, Touch};

/// A new touch needs a smoothed peak of this many times the untouched image's: noise at any SNR makes none.
const DOWN_OVER_NOISE: f32 = 2.2;
/// On a pad without noise it needs this relative rise of conductivity: below it is what the model cannot tell.
const LEAST_DOWN: f32 = 0.015;
/// A touch stays down while its peak is above this share of what a new one needs: it does not stutter. The reference's
/// doubt, which grows while a press is held, raises what a new one needs but never lifts one that is down.
const STAY_SHARE: f32 = 0.7;
/// Doubt counts up to this factor.
const MOST_DOUBT: f32 = 3.0;
/// A weaker peak continues a touch that is down within this distance.
const STAY_WITHIN_MM: f64 = 10.0;
/// Share by which the estimate of the noise moves with each untouched frame.
const NOISE_FOLLOW: f32 = 0.01;
/// What covers this share of the pad is a palm or an arm.
const PALM_SHARE: f64 = 0.09;

/// What covers at least this share of a palm may be a part of one.
const PART_SHARE: f64 = 0.35;
/// Two parts adjoin if their middles are nearer than their radii together, times this.
const ADJOINING: f64 = 1.25;
/// What the located touches, too, show to be a palm may be smaller by this factor.
const LIKELY_SHARE: f64 = 0.6;

/// Finds contacts in images.
#[derive(Clone, Debug)]
pub(super) struct ByImage {
    segmenter: Segmenter,
    blobs: Vec<Blob>,
    /// Mean highest value of an untouched, smoothed image.
    noise_peak: f32,
    palm_mm2: f64,
}

impl ByImage {
    pub(super) fn new(reconstruction: &Arc<Reconstruction>) -> Self {
        let grid = reconstruction.grid;
        let pixel_mm2 = grid.pixel_mm * grid.pixel_mm;
        Self {
            segmenter: Segmenter::new(grid, &reconstruction.coverage),
            blobs: Vec::new(),
            noise_peak: 0.0,
            palm_mm2: PALM_SHARE * pixel_mm2 * grid.len() as f64,
        }
    }

    /// Goes on with another matrix of the same pad.
    pub(super) fn take(&mut self, reconstruction: &Reconstruction) {
        self.segmenter = Segmenter::new(reconstruction.grid, &reconstruction.coverage);
    }

    /// The highest value of the smoothed image.
    pub(super) fn highest(&mut self, image: &Image) -> f32 {
        self.blobs.clear();
        self.segmenter
            .blobs(image, Threshold(f32::INFINITY), &mut self.blobs)
    }

    /// Learns the noise from the highest values of the untouched pad's first images.
    pub(super) fn learn(&mut self, mut highest: Vec<f32>) {
        // The median: a finger that brushes the pad meanwhile must not deafen it.
        highest.sort_by(f32::total_cmp);
        self.noise_peak = highest[highest.len() / 2];
    }

    /// Finds an image's contacts: those that continue a touch that is down, each touch once, and of the others those strong
    /// enough to be a new one. Returns whether the image is that of an untouched pad.
    pub(super) fn contacts(
        &mut self,
        image: &Image,
        doubt: f64,
        down: &[Touch],
        contacts: &mut Vec<Contact>,
    ) -> bool {
        let sure = LEAST_DOWN.max(DOWN_OVER_NOISE * self.noise_peak);
        let doubt = (doubt as f32).min(MOST_DOUBT);
        let stay = Threshold(STAY_SHARE * sure);
        self.blobs.clear();
        let highest = self.segmenter.blobs(image, stay, &mut self.blobs);
        contacts.clear();
        let mut claimed = vec![false; down.len()];
        for blob in &self.blobs {
            let near = (0..down.len())
                .filter(|index| !claimed[*index])
                .map(|index| (distance_mm(&down[index].contact, &blob.contact), index))
                .filter(|(distance, _)| *distance < STAY_WITHIN_MM)
                .min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((_, index)) = near {
                claimed[index] = true;
            }
            let is_new = blob.peak >= doubt * sure && !blob.may_be_ringing;
            if near.is_some() || is_new {
                contacts.push(blob.contact);
            }
        }
        let is_quiet = contacts.is_empty() && highest < doubt * stay.0;
        if is_quiet {
            self.noise_peak += NOISE_FOLLOW * (highest - self.noise_peak);
        }
        is_quiet
    }

    /// If the image shows a palm, what it shows replaces the located contacts: the palm's parts joined to one, and whatever is
    /// too small to be part of it. `is_likely` says that the located touches are like one's.
    pub(super) fn palm(
        &mut self,
        image: &Image,
        doubt: f64,
        down: &[Touch],
        is_likely: bool,
        contacts: &mut Vec<Contact>,
    ) -> bool {
        let mut seen = Vec::new();
        self.contacts(image, doubt, down, &mut seen);
        let (parts, apart) = self.adjoining(&seen);
        let area_mm2: f64 = parts.iter().map(|part| part.area_mm2).sum();
        let least = if is_likely { LIKELY_SHARE } else { 1.0 };
        let is_palm = area_mm2 > least * self.palm_mm2;
        if is_palm {
            contacts.clear();
            contacts.push(self.joined(&parts));
            contacts.extend(apart);
        }
        is_palm
    }

    /// The widest contact with all wide ones that adjoin it, and the others.
    fn adjoining(&self, seen: &[Contact]) -> (Vec<Contact>, Vec<Contact>) {
        let (mut wide, mut apart): (Vec<Contact>, Vec<Contact>) = seen
            .iter()
            .partition(|contact| contact.area_mm2 > PART_SHARE * self.palm_mm2);
        wide.sort_by(|a, b| b.area_mm2.total_cmp(&a.area_mm2));
        let mut parts: Vec<Contact> = Vec::new();
        while let Some(next) = wide
            .iter()
            .position(|contact| parts.is_empty() || parts.iter().any(|part| adjoin(part, contact)))
        {
            parts.push(wide.remove(next));
        }
        apart.extend(wide);
        (parts, apart)
    }

    /// One contact in the place of several.
    fn joined(&self, parts: &[Contact]) -> Contact {
        let area_mm2: f64 = parts.iter().map(|part| part.area_mm2).sum();
        let middle = |axis: usize| {
            let moment = |part: &Contact| part.area_mm2 * part.centre_mm[axis];
            parts.iter().map(moment).sum::<f64>() / area_mm2
        };
        Contact {
            centre_mm: [middle(0), middle(1)],
            area_mm2: area_mm2.max(self.palm_mm2),
            force: 1.0,
            confidence: 1.0,
        }
    }
}

/// Whether two footprints, taken for discs, are no further apart than noise cuts one in an image.
fn adjoin(a: &Contact, b: &Contact) -> bool {
    let radius_mm = |contact: &Contact| libm::sqrt(contact.area_mm2 / std::f64::consts::PI);
    distance_mm(a, b) < ADJOINING * (radius_mm(a) + radius_mm(b))
}

fn distance_mm(a: &Contact, b: &Contact) -> f64 {
    let [dx, dy] = [0, 1].map(|i| a.centre_mm[i] - b.centre_mm[i]);
    libm::sqrt(dx * dx + dy * dy)
}
