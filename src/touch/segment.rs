//! Contacts in an image: smoothing, peaks, and a watershed.
//!
//! The image of a lattice is confined to its channels, so it is first smoothed as a mean over the conductor near each pixel
//! (normalised convolution): a finger over a hole becomes one hill, not four. Each pixel belongs to the peak that steepest
//! ascent leads to (watershed); a peak that hardly rises above the saddle to a higher one is merged with it.
//!
//! Sums run in the order of the pixels: the same image gives the same contacts, bit for bit.

use crate::eit::cholesky::add_scaled;
use crate::types::{Contact, Image, PixelGrid, PointMm};

/// Standard deviation of the smoothing, mm: about the size of a fingertip, and half of a lattice's pitch.
const SMOOTHING_MM: f64 = 3.5;
/// A peak below this share of the strongest may be ringing.
const LEAST_SHARE: f32 = 0.18;
/// A peak is separate if the saddle to every higher peak is below this share of it.
const SADDLE_SHARE: f32 = 0.85;
/// The footprint is where the smoothed image exceeds this share of the contact's peak.
const FOOTPRINT_SHARE: f32 = 0.5;
/// Volume under the image of full force, relative rise x mm2.
const FULL_FORCE_MM2: f64 = 150.0;
/// A peak of this many times the threshold has confidence 1.
const SURE_TIMES: f64 = 3.0;

/// The smoothed peak above which there is a contact, relative rise of conductivity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Threshold(pub f32);

/// Finds contacts in images of one grid.
#[derive(Clone, Debug)]
pub struct Segmenter {
    grid: PixelGrid,
    coverage: Vec<f32>,
    kernel: Vec<f32>,
    /// One over the smoothed coverage; zero where no conductor is near.
    inverse_weight: Vec<f32>,
    smooth: Vec<f32>,
    scratch: Vec<f32>,
    /// Index of the peak of each pixel.
    peak_of: Vec<usize>,
    /// Pixels above the floor, highest first.
    order: Vec<usize>,
    /// Local maxima, highest first.
    peaks: Vec<Peak>,
    /// Two peaks, the higher first, and the height of the saddle between them; highest first.
    saddles: Vec<((usize, usize), f32)>,
}

/// A contact and its peak.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blob {
    /// The contact.
    pub contact: Contact,
    /// Peak of the smoothed image, relative rise of conductivity.
    pub peak: f32,
    /// Whether it is so much weaker than the strongest that it may be ringing.
    pub may_be_ringing: bool,
}

/// A local maximum of the smoothed image.
#[derive(Clone, Copy, Debug)]
struct Peak {
    pixel: usize,
    value: f32,
    /// The higher peak with which it is merged, if any.
    merged_into: Option<usize>,
}

const NO_PEAK: usize = usize::MAX;

impl Segmenter {
    /// A segmenter for images of a grid; `coverage` is the share of conductor of each pixel.
    ///
    /// # Panics
    /// If there is not one share per pixel.
    #[must_use]
    pub fn new(grid: PixelGrid, coverage: &[f32]) -> Self {
        assert_eq!(coverage.len(), grid.len());
        let mut segmenter = Self {
            grid,
            coverage: coverage.to_vec(),
            kernel: gaussian(SMOOTHING_MM / grid.pixel_mm),
            inverse_weight: vec![0.0; grid.len()],
            smooth: vec![0.0; grid.len()],
            scratch: vec![0.0; grid.len()],
            peak_of: vec![NO_PEAK; grid.len()],
            order: Vec::new(),
            peaks: Vec::new(),
            saddles: Vec::new(),
        };
        segmenter.smooth.copy_from_slice(coverage);
        segmenter.blur();
        for (inverse, weight) in segmenter.inverse_weight.iter_mut().zip(&segmenter.smooth) {
            // With less than 5 % conductor within reach there is no mean.
            *inverse = if *weight > 0.05 { 1.0 / weight } else { 0.0 };
        }
        segmenter
    }

    /// Appends the contacts of an image whose peaks reach a threshold, strongest first. Returns the highest value of the
    /// smoothed image.
    pub fn blobs(&mut self, image: &Image, threshold: Threshold, blobs: &mut Vec<Blob>) -> f32 {
        for ((smooth, value), coverage) in self
            .smooth
            .iter_mut()
            .zip(&image.values)
            .zip(&self.coverage)
        {
            *smooth = value * coverage;
        }
        self.blur();
        for (smooth, inverse) in self.smooth.iter_mut().zip(&self.inverse_weight) {
            *smooth *= inverse;
        }
        let highest = self.smooth.iter().copied().fold(0.0, f32::max);
        if highest < threshold.0 {
            return highest;
        }
        self.climb(threshold.0 * FOOTPRINT_SHARE);
        self.merge(threshold.0);
        for index in 0..self.peaks.len() {
            let peak = self.peaks[index];
            if peak.merged_into.is_none() && peak.value >= threshold.0 {
                blobs.push(Blob {
                    contact: self.measure(image, index, threshold),
                    peak: peak.value,
                    may_be_ringing: peak.value < LEAST_SHARE * highest,
                });
            }
        }
        highest
    }

    /// Assigns every pixel above `floor` to the local maximum that steepest ascent leads to, highest pixels first. The first
    /// pixel at which two hills meet is the saddle between them.
    fn climb(&mut self, floor: f32) {
        self.order.clear();
        self.order
            .extend((0..self.grid.len()).filter(|pixel| self.smooth[*pixel] > floor));
        let smooth = &self.smooth;
        self.order
            .sort_unstable_by(|a, b| smooth[*b].total_cmp(&smooth[*a]).then(a.cmp(b)));
        self.peak_of.fill(NO_PEAK);
        self.peaks.clear();
        self.saddles.clear();
        for pixel in &self.order {
            let value = self.smooth[*pixel];
            let mut best: Option<(f32, usize)> = None;
            for near in neighbours(&self.grid, *pixel) {
                let owner = self.peak_of[near];
                let higher = best.is_none_or(|(most, _)| self.smooth[near] > most);
                if owner != NO_PEAK && higher {
                    best = Some((self.smooth[near], owner));
                }
            }
            let Some((_, owner)) = best else {
                self.peak_of[*pixel] = self.peaks.len();
                self.peaks.push(Peak {
                    pixel: *pixel,
                    value,
                    merged_into: None,
                });
                continue;
            };
            self.peak_of[*pixel] = owner;
            for near in neighbours(&self.grid, *pixel) {
                let other = self.peak_of[near];
                if other != NO_PEAK && other != owner {
                    let pair = (owner.min(other), owner.max(other));
                    if !self.saddles.iter().any(|(known, _)| *known == pair) {
                        self.saddles.push((pair, value));
                    }
                }
            }
        }
    }

    /// Merges each peak, lowest first, with a higher one if the saddle between them is nearly as high.
    fn merge(&mut self, least: f32) {
        for index in (1..self.peaks.len()).rev() {
            let value = self.peaks[index].value;
            if value < least {
                continue;
            }
            // Saddles are sorted highest first, so the first to a higher peak counts.
            let found = self.saddles.iter().find_map(|((higher, lower), saddle)| {
                let (higher, lower) = (self.root(*higher), self.root(*lower));
                let other = match (higher == index, lower == index) {
                    (true, false) => lower,
                    (false, true) => higher,
                    _ => return None,
                };
                (other < index && *saddle > SADDLE_SHARE * value).then_some(other)
            });
            if let Some(higher) = found {
                self.peaks[index].merged_into = Some(higher);
            }
        }
        for pixel in &self.order {
            self.peak_of[*pixel] = self.root(self.peak_of[*pixel]);
        }
    }

    /// The peak with which a peak is merged in the end: itself, or a higher one.
    fn root(&self, mut peak: usize) -> usize {
        while let Some(higher) = self.peaks[peak].merged_into {
            peak = higher;
        }
        peak
    }

    /// Centre, area and force of the pixels around a peak.
    fn measure(&self, image: &Image, index: usize, threshold: Threshold) -> Contact {
        let peak = self.peaks[index];
        let edge = FOOTPRINT_SHARE * peak.value;
        let pixel_area = self.grid.pixel_mm * self.grid.pixel_mm;
        let (mut sum, mut sum_x, mut sum_y, mut area_mm2) = (0.0, 0.0, 0.0, 0.0);
        let mut volume = 0.0;
        for pixel in self.order.iter().copied() {
            if self.peak_of[pixel] != index {
                continue;
            }
            volume += f64::from(image.values[pixel] * self.coverage[pixel]) * pixel_area;
            let smooth = self.smooth[pixel];
            if smooth < edge {
                continue;
            }
            let [x, y]: PointMm = self.grid.centre_mm(pixel);
            // Weighted by the height above the footprint's edge, pixels enter and leave with weight zero, so the centre
            // moves without steps.
            let weight = f64::from(smooth - edge);
            sum += weight;
            sum_x += weight * x;
            sum_y += weight * y;
            area_mm2 += pixel_area;
        }
        let centre_mm = if sum > 0.0 {
            [sum_x / sum, sum_y / sum]
        } else {
            self.grid.centre_mm(peak.pixel)
        };
        let confidence = f64::from(peak.value / threshold.0);
        Contact {
            centre_mm,
            area_mm2,
            force: (volume / FULL_FORCE_MM2).clamp(0.0, 1.0),
            confidence: (confidence / SURE_TIMES).clamp(0.0, 1.0),
        }
    }

    /// Convolves `smooth` with the kernel along x, then along y; values outside the grid are zero.
    fn blur(&mut self) {
        let (columns, rows) = (self.grid.columns, self.grid.rows);
        let reach = self.kernel.len() - 1;
        for row in 0..rows {
            let source = &self.smooth[row * columns..(row + 1) * columns];
            let target = &mut self.scratch[row * columns..(row + 1) * columns];
            target.fill(0.0);
            for (shift, factor) in self.kernel.iter().enumerate().take(columns) {
                add_scaled(&mut target[shift..], &source[..columns - shift], *factor);
                if shift > 0 {
                    add_scaled(&mut target[..columns - shift], &source[shift..], *factor);
                }
            }
        }
        for row in 0..rows {
            let target = &mut self.smooth[row * columns..(row + 1) * columns];
            target.fill(0.0);
            for near in row.saturating_sub(reach)..=(row + reach).min(rows - 1) {
                let factor = self.kernel[near.abs_diff(row)];
                let source = &self.scratch[near * columns..(near + 1) * columns];
                add_scaled(target, source, factor);
            }
        }
    }
}

/// Half of a Gaussian, from its middle out to three standard deviations (in pixels).
fn gaussian(deviation: f64) -> Vec<f32> {
    let reach = libm::ceil(3.0 * deviation) as usize;
    (0..=reach)
        .map(|at| {
            let z = at as f64 / deviation;
            libm::exp(-0.5 * z * z) as f32
        })
        .collect()
}

/// The up to eight neighbours of a pixel.
fn neighbours(grid: &PixelGrid, pixel: usize) -> impl Iterator<Item = usize> {
    let (columns, rows) = (grid.columns, grid.rows);
    let (row, column) = (pixel / columns, pixel % columns);
    (row.saturating_sub(1)..=(row + 1).min(rows - 1)).flat_map(move |r| {
        (column.saturating_sub(1)..=(column + 1).min(columns - 1))
            .map(move |c| r * columns + c)
            .filter(move |near| *near != pixel)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const GRID: PixelGrid = PixelGrid {
        origin_mm: [0.0, 0.0],
        pixel_mm: 2.5,
        columns: 40,
        rows: 40,
    };

    /// Hills of height 1 (times their factor) and 5 mm deviation on a fully covered grid.
    fn hills(places: &[(PointMm, f32)]) -> Image {
        let mut image = Image::blank(GRID);
        for pixel in 0..GRID.len() {
            let [x, y] = GRID.centre_mm(pixel);
            for ([cx, cy], height) in places {
                let d2 = (x - cx).powi(2) + (y - cy).powi(2);
                image.values[pixel] += height * (-d2 / 50.0).exp() as f32;
            }
        }
        image
    }

    fn found(image: &Image) -> Vec<Contact> {
        let mut blobs = Vec::new();
        Segmenter::new(GRID, &vec![1.0; GRID.len()]).blobs(image, Threshold(0.1), &mut blobs);
        let sure = blobs.into_iter().filter(|blob| !blob.may_be_ringing);
        sure.map(|blob| blob.contact).collect()
    }

    proptest! {
        #[test]
        fn one_hill_is_one_contact_at_its_place(x in 15.0..85.0f64, y in 15.0..85.0f64) {
            let contacts = found(&hills(&[([x, y], 1.0)]));
            prop_assert_eq!(contacts.len(), 1);
            let [cx, cy] = contacts[0].centre_mm;
            prop_assert!((cx - x).hypot(cy - y) < 0.3, "({cx}, {cy}) for ({x}, {y})");
        }

        #[test]
        fn the_segmentation_follows_a_shift_by_pixels(dx in 0..8usize, dy in 0..8usize) {
            let at = |x: f64, y: f64| found(&hills(&[([x, y], 1.0), ([x + 25.0, y], 0.6)]));
            let (here, there) = (at(30.0, 40.0), at(30.0 + 2.5 * dx as f64, 40.0 + 2.5 * dy as f64));
            prop_assert_eq!(here.len(), 2);
            prop_assert_eq!(there.len(), 2);
            for (a, b) in here.iter().zip(&there) {
                prop_assert!((a.centre_mm[0] + 2.5 * dx as f64 - b.centre_mm[0]).abs() < 1e-3);
                prop_assert!((a.centre_mm[1] + 2.5 * dy as f64 - b.centre_mm[1]).abs() < 1e-3);
            }
        }
    }

    #[test]
    fn hills_that_touch_are_two_and_shoulders_are_one() {
        assert_eq!(
            found(&hills(&[([40.0, 50.0], 1.0), ([60.0, 50.0], 1.0)])).len(),
            2
        );
        assert_eq!(
            found(&hills(&[([40.0, 50.0], 1.0), ([48.0, 50.0], 1.0)])).len(),
            1
        );
    }

    #[test]
    fn ringing_below_a_sixth_of_the_peak_is_no_contact() {
        let contacts = found(&hills(&[([30.0, 30.0], 1.0), ([70.0, 70.0], 0.12)]));
        assert_eq!(contacts.len(), 1);
    }

    #[test]
    fn a_blank_image_has_no_contact() {
        assert!(found(&Image::blank(GRID)).is_empty());
    }
}
