//! The image of a frame, which is drawn when somebody asks for it: touches are located in the voltages, so most frames are processed
//! without one. The image looks the same whenever it is drawn, because the changes that it shows are kept.

use super::Detector;
use crate::types::Image;

/// The changes that the next image shows.
#[derive(Clone, Debug)]
pub(super) struct ImageChanges {
    /// Weighted, muted channels filled in.
    changes: Vec<f32>,
    /// Standard deviation of a change.
    noise: f64,
    /// Whether the image shows them already.
    is_drawn: bool,
}

impl ImageChanges {
    pub(super) fn new(channels: usize) -> Self {
        Self {
            changes: vec![0.0; channels],
            noise: 0.0,
            is_drawn: true,
        }
    }
}

impl Detector {
    /// The image of the last frame; blank until the reference is taken.
    pub fn image(&mut self) -> &Image {
        self.draw_image();
        &self.image
    }

    /// Keeps the changes of the frame for its image; a muted channel reads what the touches explain.
    pub(super) fn keep_image_changes(&mut self) {
        // Touches are bright in the image, whatever their sign.
        let drawn = self.sensing.reconstruction.touch_sign();
        let turn = self.touch_sign().factor() * drawn.factor();
        let kept = &mut self.image_changes;
        for (channel, image_change) in kept.changes.iter_mut().enumerate() {
            let change = if self.reference.is_muted(channel) {
                self.explained[channel]
            } else {
                self.changes[channel]
            };
            *image_change = turn * change * self.sensing.image_weights[channel];
        }
        kept.noise = self.reference.change_noise();
        kept.is_drawn = false;
        // Each of these images starts from the one before.
        if self.imager.has_memory() {
            self.draw_image();
        }
    }

    /// Draws the image, if it does not show the last frame.
    pub(super) fn draw_image(&mut self) {
        let kept = &mut self.image_changes;
        if !kept.is_drawn {
            self.imager
                .image(&kept.changes, kept.noise, &mut self.image);
            kept.is_drawn = true;
        }
    }

    /// Clears the image.
    pub(super) fn blank_image(&mut self) {
        self.image = Image::blank(self.sensing.reconstruction.grid);
        self.image_changes.is_drawn = true;
    }
}
