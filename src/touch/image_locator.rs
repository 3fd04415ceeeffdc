//! Contacts from an image, with thresholds in units of its noise and with hysteresis; palms.

use std::sync::Arc;

use super::{Blob, Segmenter, Threshold};
use crate::eit::Reconstruction;
use crate::types::{Contact, Image, Touch};

/// A new touch needs a smoothed peak of this many times the untouched image's: noise never reaches it.
const DOWN_OVER_NOISE: f32 = 2.2;
/// It also needs this relative rise of conductivity: smaller ones may be model error.
const LEAST_DOWN: f32 = 0.015;
/// A touch stays down while its peak is above this share of the threshold of a new one (hysteresis). The reference's
/// uncertainty, which grows while a press is held, raises the threshold of new touches only.
const STAY_SHARE: f32 = 0.7;
/// Most that the uncertainty raises the threshold.
const MOST_DOUBT: f32 = 3.0;
/// A weaker peak continues a touch within this distance.
const STAY_WITHIN_MM: f64 = 10.0;
/// Weight of an untouched frame in the running estimate of the noise.
const NOISE_FOLLOW: f32 = 0.01;
/// A palm or an arm covers this share of the pad.
const PALM_SHARE: f64 = 0.09;
/// A part of a palm covers at least this share of [`PALM_SHARE`].
const PART_SHARE: f64 = 0.35;
/// Two parts adjoin if their centres are closer than this many times the sum of their radii.
const ADJOINING: f64 = 1.25;
/// A palm may be smaller by this factor if the located touches look like one, too.
const LIKELY_SHARE: f64 = 0.6;

/// Finds contacts in images.
#[derive(Clone, Debug)]
pub(super) struct ImageLocator {
    segmenter: Segmenter,
    blobs: Vec<Blob>,
    /// Mean highest value of an untouched, smoothed image.
    noise_peak: f32,
    palm_mm2: f64,
}

impl ImageLocator {
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

    /// Replaces the reconstruction of the pad.
    pub(super) fn set_reconstruction(&mut self, reconstruction: &Reconstruction) {
        self.segmenter = Segmenter::new(reconstruction.grid, &reconstruction.coverage);
    }

    /// The highest value of the smoothed image.
    pub(super) fn peak(&mut self, image: &Image) -> f32 {
        self.blobs.clear();
        self.segmenter
            .blobs(image, Threshold(f32::INFINITY), &mut self.blobs)
    }

    /// Sets the noise from the peaks of the untouched pad's first images.
    pub(super) fn set_noise(&mut self, mut peaks: Vec<f32>) {
        // The median is not affected by a finger that brushes the pad.
        peaks.sort_by(f32::total_cmp);
        self.noise_peak = peaks[peaks.len() / 2];
    }

    /// Finds the contacts of an image: those that continue a touch, each touch once, and others that are strong enough for a
    /// new touch. Returns whether the image is that of an untouched pad; if so, the noise follows its highest value.
    pub(super) fn contacts(
        &mut self,
        image: &Image,
        doubt: f64,
        down: &[Touch],
        contacts: &mut Vec<Contact>,
    ) -> bool {
        let down_peak = LEAST_DOWN.max(DOWN_OVER_NOISE * self.noise_peak);
        let doubt = (doubt as f32).min(MOST_DOUBT);
        let stay = Threshold(STAY_SHARE * down_peak);
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
            let is_new = blob.peak >= doubt * down_peak && !blob.may_be_ringing;
            if near.is_some() || is_new {
                contacts.push(blob.contact);
            }
        }
        let is_quiet = contacts.is_empty() && highest < doubt * stay.0;
        if is_quiet {
            self.follow_noise(highest);
        }
        is_quiet
    }

    /// Moves the level of the noise towards the highest value of an untouched pad's image.
    fn follow_noise(&mut self, highest: f32) {
        self.noise_peak += NOISE_FOLLOW * (highest - self.noise_peak);
    }

    /// If the image shows a palm, replaces the contacts by those of the image, with the parts of the palm merged into one.
    /// Returns whether it does. `is_likely`: the located touches look like a palm.
    pub(super) fn replace_by_palm(
        &mut self,
        image: &Image,
        doubt: f64,
        down: &[Touch],
        is_likely: bool,
        contacts: &mut Vec<Contact>,
    ) -> bool {
        let mut seen = Vec::new();
        self.contacts(image, doubt, down, &mut seen);
        let (parts, others) = self.separate_palm(&seen);
        let area_mm2: f64 = parts.iter().map(|part| part.area_mm2).sum();
        let least = if is_likely { LIKELY_SHARE } else { 1.0 };
        let is_palm = area_mm2 > least * self.palm_mm2;
        if is_palm {
            contacts.clear();
            contacts.push(self.merged(&parts));
            contacts.extend(others);
        }
        is_palm
    }

    /// Separates the widest contact, with all wide ones that adjoin it, from the others.
    fn separate_palm(&self, contacts: &[Contact]) -> (Vec<Contact>, Vec<Contact>) {
        let (mut wide, mut others): (Vec<Contact>, Vec<Contact>) = contacts
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
        others.extend(wide);
        (parts, others)
    }

    /// One contact in place of several.
    fn merged(&self, parts: &[Contact]) -> Contact {
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

/// Whether two footprints, as discs, are close enough to be parts of one that noise split.
fn adjoin(a: &Contact, b: &Contact) -> bool {
    let radius_mm = |contact: &Contact| libm::sqrt(contact.area_mm2 / std::f64::consts::PI);
    distance_mm(a, b) < ADJOINING * (radius_mm(a) + radius_mm(b))
}

fn distance_mm(a: &Contact, b: &Contact) -> f64 {
    let [dx, dy] = [0, 1].map(|i| a.centre_mm[i] - b.centre_mm[i]);
    libm::sqrt(dx * dx + dy * dy)
}
