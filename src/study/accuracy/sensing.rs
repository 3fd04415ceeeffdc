//! The sensing under test: the detector of play, which turns frames into touches.

use std::sync::Arc;

use super::found::{self, FOUND_FROM_FRAMES};
use super::noise::Instrument;
use super::sensed::{FRAME_NS, Sensed};
use crate::eit::{Imager, REFERENCE_FRAMES, Reference};
use crate::pad::{Pad, TouchSign};
use crate::study::{Merit, Press, Raster, StudyError, conductivity_factor};
use crate::touch::{ChannelNoise, Detector, SensingBuilder};
use crate::types::{Contact, Frame, Image, Nanos};

/// Frames of the untouched pad before the first touch: two seconds, in which the detector takes its reference, learns the noise
/// of each channel, and may request a matrix with matching weights.
pub(super) const REST_FRAMES: usize = 200;
/// Frames of the untouched pad that are read after it is identified, half a second as for `--real`, so that the detector settles
/// before it is pressed.
const FRAMES_AS_FOUND: usize = 50;
/// Images are smoothed with this deviation before they are judged, mm, as in the phantom study.
const SMOOTHING_MM: f64 = 4.0;

/// A pad's sensing, before any frame.
#[derive(Clone, Debug)]
pub(super) struct Sensing {
    builder: SensingBuilder,
    detector: Detector,
    size_mm: [f64; 2],
    touch_sign: TouchSign,
}

/// A detector that has read the untouched pad, ready to be pressed.
#[derive(Clone, Debug)]
pub(super) struct RestedDetector {
    detector: Detector,
    frames: usize,
    reference: Reference,
    size_mm: [f64; 2],
    touch_sign: TouchSign,
}

impl Sensing {
    pub(super) fn from_pad(pad: &Pad, builder: SensingBuilder) -> Result<Self, StudyError> {
        let sensing = Arc::new(builder.build_initial()?);
        Ok(Self {
            builder,
            detector: Detector::for_pad(sensing, &pad.protocol),
            size_mm: pad.outline.size_mm(),
            touch_sign: pad.touch_sign,
        })
    }

    /// What builds the sensing.
    pub(super) fn builder(&self) -> &SensingBuilder {
        &self.builder
    }

    /// A detector before its first frame.
    pub(super) fn new_detector(&self) -> Detector {
        self.detector.clone()
    }

    /// The sensing that a detector requests.
    pub(super) fn build(&self, noise: &ChannelNoise) -> Result<crate::touch::Sensing, StudyError> {
        Ok(self.builder.build(noise)?)
    }

    /// Reads the untouched pad. A matrix that the detector requests is there with the next frame.
    pub(super) fn rested(&self, instrument: &Instrument, seed: u64) -> RestedDetector {
        let mut sensed = Sensed::new(self.detector.clone(), &self.builder);
        let frames = instrument.frames(instrument.rest, seed, REST_FRAMES);
        read(&mut sensed, &frames, 0);
        self.ready(&sensed, &frames)
    }

    /// Reads the untouched pad and identifies it from the last second, as play does.
    ///
    /// # Errors
    /// A pad as found that cannot be solved.
    pub(super) fn rested_as_found(
        &self,
        pad: &Pad,
        instrument: &Instrument,
        seed: u64,
    ) -> Result<RestedDetector, StudyError> {
        let found;
        let mut sensed = Sensed::new(self.detector.clone(), &self.builder);
        let frames = instrument.frames(instrument.rest, seed, REST_FRAMES + FRAMES_AS_FOUND);
        let (drawn, as_found) = frames.split_at(REST_FRAMES);
        read(&mut sensed, drawn, 0);
        let last_second = &drawn[REST_FRAMES - FOUND_FROM_FRAMES..];
        found = found::find(pad, &self.builder, last_second, &sensed.left_out())?;
        let Some(found) = &found else {
            return Ok(self.ready(&sensed, drawn));
        };
        sensed.change_pad(found);
        read(&mut sensed, as_found, REST_FRAMES);
        Ok(self.ready(&sensed, &frames))
    }

    /// The detector that has read these frames.
    fn ready(&self, sensed: &Sensed, frames: &[Vec<f32>]) -> RestedDetector {
        let mut reference = Reference::new(frames[0].len());
        for (index, volts) in frames[..REFERENCE_FRAMES].iter().enumerate() {
            reference.add_first_frame(index as Nanos * FRAME_NS, volts);
        }
        RestedDetector {
            detector: sensed.detector.clone(),
            frames: frames.len(),
            reference,
            size_mm: self.size_mm,
            touch_sign: self.touch_sign,
        }
    }
}

/// Hands frames over, one after another; `first` is the number of the first one.
fn read(sensed: &mut Sensed, frames: &[Vec<f32>], first: usize) {
    for (index, volts) in frames.iter().enumerate() {
        sensed.process(&Frame {
            t_ns: (first + index) as Nanos * FRAME_NS,
            volts: volts.clone(),
        });
    }
}

impl RestedDetector {
    /// The contacts detected in the next frame.
    pub(super) fn contacts(&self, volts: &[f32]) -> Vec<Contact> {
        let mut detector = self.detector.clone();
        let frame = Frame {
            t_ns: self.frames as Nanos * FRAME_NS,
            volts: volts.to_vec(),
        };
        detector.process_frame(&frame, &mut Vec::new());
        let touches = detector.touches_down();
        touches.iter().map(|touch| touch.contact).collect()
    }

    /// GREIT's figures of the image of the next frame for one press, against the reference of the first frames.
    pub(super) fn merit(&self, volts: &[f32], press: &Press) -> Merit {
        let mut changes = vec![0.0; volts.len()];
        self.reference.relative_changes(volts, &mut changes);
        let reconstruction = &self.detector.sensing().reconstruction;
        let mut image = Image::blank(reconstruction.grid);
        Imager::new(Arc::clone(reconstruction)).signed_image(
            &changes,
            self.reference.change_noise(),
            &mut image,
        );
        let raster = Raster::smoothed(&image, &reconstruction.coverage, self.size_mm, SMOOTHING_MM);
        let mut truth = raster.mask(|_| false);
        for (cell, value) in truth.values.iter_mut().enumerate() {
            let point = raster.grid.centre_mm(cell);
            *value = (conductivity_factor(&[*press], self.touch_sign, point) - 1.0).abs();
        }
        raster.merit(&truth, 1.0, press.centre_mm, |_| true)
    }
}
