//! The sensing under test: the same that plays, fed with frames and asked for touches.

use std::sync::Arc;

use super::noise::Readings;
use crate::eit::{Imager, LAMBDA, Linearised, Reconstruction, Reference};
use crate::pad::{Pad, TouchSign};
use crate::study::{Merit, Press, Raster, StudyError, pressed};
use crate::touch::Detector;
use crate::types::{Contact, Frame, Image, Method, NANOS_PER_MS, Nanos};

/// A hundred frames a second, as in play.
const FRAME_NS: Nanos = 10 * NANOS_PER_MS;
/// Images are smoothed with this deviation before they are judged, mm: as in the study of phantoms.
const SMOOTHING_MM: f64 = 4.0;

/// A pad's sensing, ready to be fed.
#[derive(Clone, Debug)]
pub(super) struct Sensing {
    reconstruction: Arc<Reconstruction>,
    fresh: Detector,
    size_mm: [f64; 2],
    touch_sign: TouchSign,
}

impl Sensing {
    pub(super) fn of_pad(pad: &Pad, method: Method) -> Result<Self, StudyError> {
        let linear = Linearised::of_pad(pad)?;
        let reconstruction =
            Reconstruction::from_linearised(&linear, method, LAMBDA, pad.touch_sign)?;
        let reconstruction = Arc::new(reconstruction);
        Ok(Self {
            fresh: detector(pad, &reconstruction)?,
            reconstruction,
            size_mm: pad.outline.size_mm(),
            touch_sign: pad.touch_sign,
        })
    }

    /// What is seen in the judged frame.
    pub(super) fn contacts(&self, readings: &Readings) -> Vec<Contact> {
        let mut detector = self.fresh.clone();
        let mut changed = Vec::new();
        let frames = readings.untouched.iter().chain([&readings.judged]);
        for (index, volts) in frames.enumerate() {
            let frame = Frame {
                t_ns: index as Nanos * FRAME_NS,
                volts: volts.clone(),
            };
            detector.frame(&frame, &mut changed);
        }
        let touches = detector.state().down;
        touches.iter().map(|touch| touch.contact).collect()
    }

    /// GREIT's figures of the judged frame's image for one press.
    pub(super) fn merit(&self, readings: &Readings, press: &Press) -> Merit {
        let mut reference = Reference::new(readings.judged.len());
        for (index, volts) in readings.untouched.iter().enumerate() {
            reference.begin(index as Nanos * FRAME_NS, volts);
        }
        let mut changes = vec![0.0; readings.judged.len()];
        reference.changes(&readings.judged, &mut changes);
        let mut image = Image::blank(self.reconstruction.grid);
        Imager::new(self.reconstruction.clone()).uncut(
            &changes,
            reference.change_noise(),
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

/// A detector as play makes it, without a reference yet. The one place where the sensing under test is chosen.
fn detector(_pad: &Pad, reconstruction: &Arc<Reconstruction>) -> Result<Detector, StudyError> {
    Ok(Detector::new(reconstruction.clone()))
}
