//! The sensing under test: the detector of play, which turns frames into touches.

use std::sync::Arc;

use super::noise::Instrument;
use crate::eit::{Imager, REFERENCE_FRAMES, Reconstruction, Reference};
use crate::pad::{Pad, TouchSign};
use crate::study::{Merit, Press, Raster, StudyError, conductivity_factor};
use crate::touch::{ChannelNoise, Detector, SensingBuilder};
use crate::types::{Contact, Frame, Image, NANOS_PER_MS, Nanos};

/// A hundred frames a second, as in play.
const FRAME_NS: Nanos = 10 * NANOS_PER_MS;
/// Frames of the untouched pad before the first touch: two seconds, in which the detector takes its reference, learns the noise
/// of each channel, and may request a matrix with matching weights.
pub(super) const REST_FRAMES: usize = 200;
/// Images are smoothed with this deviation before they are judged, mm, as in the phantom study.
const SMOOTHING_MM: f64 = 4.0;

/// A pad's sensing, before any frame.
#[derive(Clone, Debug)]
pub(super) struct Sensing {
    builder: SensingBuilder,
    detector: Detector,
    reconstruction: Arc<Reconstruction>,
    size_mm: [f64; 2],
    touch_sign: TouchSign,
}

/// A detector that has read the untouched pad, ready to be pressed.
#[derive(Clone, Debug)]
pub(super) struct RestedDetector {
    detector: Detector,
    reference: Reference,
    reconstruction: Arc<Reconstruction>,
    size_mm: [f64; 2],
    touch_sign: TouchSign,
}

impl Sensing {
    pub(super) fn from_pad(pad: &Pad, builder: SensingBuilder) -> Result<Self, StudyError> {
        let sensing = Arc::new(builder.build_initial()?);
        let reconstruction = Arc::clone(&sensing.reconstruction);
        Ok(Self {
            builder,
            detector: Detector::for_pad(sensing, &pad.protocol),
            reconstruction,
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
    pub(super) fn rested(
        &self,
        instrument: &Instrument,
        seed: u64,
    ) -> Result<RestedDetector, StudyError> {
        let mut rested = RestedDetector {
            detector: self.detector.clone(),
            reference: Reference::new(instrument.rest.len()),
            reconstruction: Arc::clone(&self.reconstruction),
            size_mm: self.size_mm,
            touch_sign: self.touch_sign,
        };
        let mut changed = Vec::new();
        let frames = instrument.frames(instrument.rest, seed, REST_FRAMES);
        for (index, volts) in frames.into_iter().enumerate() {
            let t_ns = index as Nanos * FRAME_NS;
            if index < REFERENCE_FRAMES {
                rested.reference.add_first_frame(t_ns, &volts);
            }
            rested
                .detector
                .process_frame(&Frame { t_ns, volts }, &mut changed);
            if let Some(wanted) = rested.detector.wanted() {
                let sensing = Arc::new(self.builder.build(wanted)?);
                rested.reconstruction = Arc::clone(&sensing.reconstruction);
                rested.detector.set_sensing(sensing);
            }
        }
        Ok(rested)
    }
}

impl RestedDetector {
    /// The contacts detected in the next frame.
    pub(super) fn contacts(&self, volts: &[f32]) -> Vec<Contact> {
        let mut detector = self.detector.clone();
        let frame = Frame {
            t_ns: REST_FRAMES as Nanos * FRAME_NS,
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
        let mut image = Image::blank(self.reconstruction.grid);
        Imager::new(Arc::clone(&self.reconstruction)).signed_image(
            &changes,
            self.reference.change_noise(),
            &mut image,
        );
        let raster = Raster::smoothed(
            &image,
            &self.reconstruction.coverage,
            self.size_mm,
            SMOOTHING_MM,
        );
        let mut truth = raster.mask(|_| false);
        for (cell, value) in truth.values.iter_mut().enumerate() {
            let point = raster.grid.centre_mm(cell);
            *value = (conductivity_factor(&[*press], self.touch_sign, point) - 1.0).abs();
        }
        raster.merit(&truth, 1.0, press.centre_mm, |_| true)
    }
}
