//! The sensing under test: the same that plays, fed with frames and asked for touches.

use std::sync::Arc;

use super::noise::Instrument;
use crate::eit::{Imager, REFERENCE_FRAMES, Reconstruction, Reference};
use crate::pad::{Pad, Protocol, TouchSign};
use crate::study::{Merit, Press, Raster, StudyError, pressed};
use crate::touch::{Detector, SensingBuilder};
use crate::types::{Contact, Frame, Image, NANOS_PER_MS, Nanos};

/// A hundred frames a second, as in play.
const FRAME_NS: Nanos = 10 * NANOS_PER_MS;
/// For so many frames the untouched pad is read first: two seconds, in which the detector takes its reference, learns the
/// noise of each channel, and may ask for weights to match.
pub(super) const REST_FRAMES: usize = 200;
/// Images are smoothed with this deviation before they are judged, mm: as in the study of phantoms.
const SMOOTHING_MM: f64 = 4.0;

/// A pad's sensing, before any frame.
#[derive(Clone, Debug)]
pub(super) struct Sensing {
    builder: SensingBuilder,
    fresh: Detector,
    reconstruction: Arc<Reconstruction>,
    size_mm: [f64; 2],
    touch_sign: TouchSign,
}

/// A detector that has read the untouched pad, ready to be pressed.
#[derive(Clone, Debug)]
pub(super) struct Rested {
    detector: Detector,
    reference: Reference,
    reconstruction: Arc<Reconstruction>,
    size_mm: [f64; 2],
    touch_sign: TouchSign,
}

impl Sensing {
    pub(super) fn of_pad(pad: &Pad, builder: SensingBuilder) -> Result<Self, StudyError> {
        let (fresh, reconstruction) = detector(&builder, &pad.protocol)?;
        Ok(Self {
            builder,
            fresh,
            reconstruction,
            size_mm: pad.outline.size_mm(),
            touch_sign: pad.touch_sign,
        })
    }

    /// Reads the untouched pad. Weights for which the detector asks are there with the next frame.
    pub(super) fn rested(&self, instrument: &Instrument, seed: u64) -> Result<Rested, StudyError> {
        let mut rested = Rested {
            detector: self.fresh.clone(),
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
                rested.reference.begin(t_ns, &volts);
            }
            rested.detector.frame(&Frame { t_ns, volts }, &mut changed);
            if let Some(wanted) = rested.detector.wanted() {
                let sensing = Arc::new(self.builder.build(wanted)?);
                rested.reconstruction = Arc::clone(&sensing.reconstruction);
                rested.detector.take(sensing);
            }
        }
        Ok(rested)
    }
}

impl Rested {
    /// What is seen in the frame that follows.
    pub(super) fn contacts(&self, volts: &[f32]) -> Vec<Contact> {
        let mut detector = self.detector.clone();
        let frame = Frame {
            t_ns: REST_FRAMES as Nanos * FRAME_NS,
            volts: volts.to_vec(),
        };
        detector.frame(&frame, &mut Vec::new());
        let touches = detector.state().down;
        touches.iter().map(|touch| touch.contact).collect()
    }

    /// GREIT's figures of that frame's image for one press, against the reference of the first frames.
    pub(super) fn merit(&self, volts: &[f32], press: &Press) -> Merit {
        let mut changes = vec![0.0; volts.len()];
        self.reference.changes(volts, &mut changes);
        let mut image = Image::blank(self.reconstruction.grid);
        Imager::new(Arc::clone(&self.reconstruction)).uncut(
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
        let truth = Raster {
            grid: raster.grid,
            values: (0..raster.grid.len())
                .map(|cell| {
                    let point = raster.grid.centre_mm(cell);
                    (pressed(&[*press], self.touch_sign, point) - 1.0).abs()
                })
                .collect(),
        };
        raster.merit(&truth, 1.0, press.centre_mm, |_| true)
    }
}

/// A detector as play makes it, without a reference yet, and its matrix. The one place where the sensing under test is
/// chosen.
fn detector(
    builder: &SensingBuilder,
    protocol: &Protocol,
) -> Result<(Detector, Arc<Reconstruction>), StudyError> {
    let sensing = Arc::new(builder.first()?);
    let reconstruction = Arc::clone(&sensing.reconstruction);
    Ok((Detector::of_pad(sensing, protocol), reconstruction))
}
