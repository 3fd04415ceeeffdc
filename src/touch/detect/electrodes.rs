//! Lost and recovered electrodes, and requests for other channel weights.
//!
//! The detector only requests weights. The sensing for them is built elsewhere and set when it is ready.

use super::Detector;
use crate::eit::median;
use crate::touch::ChannelNoise;
use crate::types::Frame;

/// Weights are requested when the noise of at least this many channels ...
const NOISIER_CHANNELS: usize = 4;
/// ... changed by this factor relative to the median channel's.
const NOISIER_FACTOR: f64 = 2.0;
/// Weights are also requested when a variance that channels share changed by this factor.
const SHARED_FACTOR: f64 = 3.0;
/// Frames between two checks of the noise.
const REWEIGHT_FRAMES: u64 = 128;

impl Detector {
    /// Excludes the electrodes that the first frames show to be dead.
    pub(super) fn find_dead_electrodes(&mut self) {
        let Some(electrodes) = &mut self.electrodes else {
            return;
        };
        let reference = &self.reference;
        for electrode in electrodes.exclude_muted(|channel| reference.is_muted(channel)) {
            for channel in electrodes.channels(electrode) {
                self.reference.mute(*channel, true, 0.0);
            }
        }
    }

    /// Finds the electrode that spoils a frame, and excludes it if it spoiled the previous one too.
    pub(super) fn find_faulty_electrode(&mut self, frame: &Frame) {
        let Some(electrodes) = &mut self.electrodes else {
            return;
        };
        let (changes, explained) = (&self.changes, &self.explained);
        let reference = &self.reference;
        let deviation = |channel: usize| {
            let [noise, doubt] = reference.variances(channel);
            f64::from(changes[channel] - explained[channel]) / libm::sqrt(noise + doubt)
        };
        // Without a table nothing tells the change of a touch from that of the board.
        let are_touches_removed = self.sensing.locator_model.is_some();
        let lost = electrodes.suspect(deviation, are_touches_removed);
        if let Some(electrode) = lost {
            for channel in electrodes.channels(electrode) {
                self.reference.mute(*channel, true, 0.0);
            }
        }
        electrodes.skip_frame();
        self.request_for_lost_channels();
        self.watch_lost_electrodes(frame);
    }

    /// Takes back a lost electrode that has recovered.
    pub(super) fn watch_lost_electrodes(&mut self, frame: &Frame) {
        let Some(electrodes) = self.electrodes.as_mut().filter(|all| all.any_lost()) else {
            return;
        };
        let (reference, explained) = (&self.reference, &self.explained);
        let change = |channel: usize| {
            let volt = f64::from(frame.volts[channel]);
            let change = volt / reference.volts()[channel] - 1.0 - f64::from(explained[channel]);
            if change.is_finite() { change } else { 1.0 }
        };
        let recovered = electrodes.watch_lost(change, |channel| {
            libm::sqrt(reference.variances(channel)[0])
        });
        if let Some(electrode) = recovered {
            for channel in electrodes.channels(electrode).to_vec() {
                if !electrodes.excludes(channel) {
                    let level_change = electrodes.level_change(channel);
                    self.reference.mute(channel, false, level_change);
                }
            }
        }
        self.request_for_lost_channels();
    }

    /// Takes back an electrode that was lost before its level was known, in a frame that is explained.
    pub(super) fn find_reconnected_electrode(&mut self, frame: &Frame) {
        let Some(electrodes) = self.electrodes.as_mut().filter(|all| all.any_lost()) else {
            return;
        };
        let (reference, explained) = (&self.reference, &self.explained);
        let reading = |channel: usize| {
            let volt = f64::from(frame.volts[channel]);
            volt / (1.0 + f64::from(explained[channel]))
        };
        let sound = |channel: usize| {
            let volt = reference.volts()[channel];
            let is_sound = !reference.is_muted(channel);
            is_sound.then(|| (volt, reference.reading_variance(channel) * volt * volt))
        };
        if let Some(levels) = electrodes.find_reconnected(reading, sound) {
            for (channel, volt) in levels {
                self.reference
                    .reconnect(channel, volt, self.explained[channel]);
            }
            self.request_for_lost_channels();
        }
    }

    /// Requests other weights if the channels in use are not those of the sensing.
    pub(super) fn request_for_lost_channels(&mut self) {
        if self.electrodes.is_none() || !self.reference.is_ready() {
            return;
        }
        let differ = (0..self.changes.len())
            .any(|channel| self.reference.is_muted(channel) == self.sensing.uses_channel(channel));
        if differ {
            self.wanted = Some(self.noise_now());
        }
    }

    /// Requests other weights from time to time, if the noise of some channels changed.
    pub(super) fn maybe_reweight(&mut self) {
        if self.frames.is_multiple_of(REWEIGHT_FRAMES) {
            self.request_for_noise();
        }
    }

    /// The present noise of the channels.
    fn noise_now(&self) -> ChannelNoise {
        ChannelNoise {
            deviations: self.reference.deviations(),
            shared: self.reference.shared_noise(),
        }
    }

    /// Whether the noise that channels share differs, where it matters, from that of the weights.
    fn is_shared_noise_different(&self) -> bool {
        let (now, then) = (self.reference.shared_noise(), self.sensing.shared);
        let channels = self.changes.len() as f64;
        let own = self.reference.change_variance() / channels;
        let differs = |now: f64, then: f64, matters: f64| {
            now.max(then) > matters && (now > SHARED_FACTOR * then || then > SHARED_FACTOR * now)
        };
        let drives = self
            .drives
            .iter()
            .max()
            .map_or(1.0, |last| f64::from(*last) + 1.0);
        differs(now.gain, then.gain, own) || differs(now.drive, then.drive, drives * own)
    }

    /// Requests other weights if the noise of some channels changed relative to the others.
    pub(super) fn request_for_noise(&mut self) {
        let is_ready = self.reference.is_ready() && self.sensing.locator_model.is_some();
        if self.wanted.is_some() || !is_ready {
            return;
        }
        let now = self.reference.deviations();
        let mut ratios: Vec<f64> = now
            .iter()
            .zip(&self.sensing.deviations)
            .filter(|(now, then)| now.is_finite() && then.is_finite())
            .map(|(now, then)| now / then)
            .collect();
        let Some(median) = median(&mut ratios) else {
            return;
        };
        let changed = ratios
            .iter()
            .filter(|ratio| **ratio > NOISIER_FACTOR * median || **ratio * NOISIER_FACTOR < median)
            .count();
        if changed >= NOISIER_CHANNELS || self.is_shared_noise_different() {
            self.wanted = Some(self.noise_now());
        }
    }
}
