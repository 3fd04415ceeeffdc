//! What the engine's thread reports: views, the frame rate, and log messages about electrodes.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::EngineThread;
use crate::pad::Numbering;
use crate::types::{NANOS_PER_MS, Nanos};

/// The reference and the noise of a view are updated once in this many frames.
const SLOW_SIGNALS: u64 = 50;
/// A longer time between two frames is a board that was away.
const LONGEST_STEP_NS: Nanos = 2000 * NANOS_PER_MS;

impl EngineThread {
    /// Frames a second by the source's time, without the time in which the board was away.
    pub(super) fn frames_per_s(&self) -> f64 {
        match self.played_ns {
            0 => 0.0,
            played_ns => self.steps as f64 / (played_ns as f64 * 1e-9),
        }
    }

    /// Counts the time from the last frame to one at `t_ns`; a longer silence is not part of the frame rate.
    pub(super) fn count_time(&mut self, t_ns: Nanos) {
        if let Some(last_ns) = self.last_end_ns.replace(t_ns)
            && let Some(step_ns) = t_ns.checked_sub(last_ns)
            && step_ns <= LONGEST_STEP_NS
        {
            self.steps += 1;
            self.played_ns += step_ns;
        }
    }

    pub(super) fn measure_rate(&mut self, at: Instant) {
        let (start, frames) = *self.second.get_or_insert((at, self.view.frames));
        let elapsed = at.duration_since(start);
        if elapsed >= Duration::from_secs(1) {
            self.view.frames_per_s = (self.view.frames - frames) as f64 / elapsed.as_secs_f64();
            let emitted = *self.queues.emitted.read();
            self.view.stages = self.times.stages(&emitted);
            self.view.latency_us = self.times.frame_to_events_ns.value_at_quantile(0.5) / 1000;
            self.second = Some((at, self.view.frames));
        }
    }

    pub(super) fn publish(&mut self) {
        let emitted = *self.queues.emitted.read();
        let detector = self.engine.detector();
        if self.view.frames.is_multiple_of(SLOW_SIGNALS) && detector.is_ready() {
            let [reference, noise] = detector.rest_volts_and_deviations();
            self.view.signals.reference = reference;
            self.view.signals.noise = noise;
        }
        let slot = self.queues.views.input_buffer_mut();
        slot.signals.volts.clone_from(&self.view.signals.volts);
        slot.signals.is_turned = detector.board_numbering().0 != Numbering::default();
        slot.signals
            .reference
            .clone_from(&self.view.signals.reference);
        slot.signals.noise.clone_from(&self.view.signals.noise);
        if detector.is_ready() {
            let (changes, explained) = detector.changes_and_explained();
            slot.signals.changes.clear();
            slot.signals.changes.extend_from_slice(changes);
            slot.signals.explained.clear();
            slot.signals.explained.extend_from_slice(explained);
            slot.signals.contacts.clear();
            slot.signals
                .contacts
                .extend_from_slice(detector.uncorrected_contacts());
        }
        slot.events_so_far = self.view.events_so_far;
        slot.t_ns = self.view.t_ns;
        slot.profile = Arc::clone(self.engine.profile());
        slot.paused = self.engine.is_paused();
        slot.image.values.clone_from(&self.engine.image().values);
        slot.touches.clear();
        slot.touches.extend_from_slice(self.engine.touches_down());
        slot.held.clear();
        slot.held.extend(self.engine.held_outputs());
        slot.events.clone_from(&self.view.events);
        slot.frames = self.view.frames;
        slot.lost_frames = self.view.lost_frames;
        slot.lost_electrodes.clone_from(&self.view.lost_electrodes);
        slot.frames_per_s = self.view.frames_per_s;
        slot.latency_us = self.view.latency_us;
        slot.stages = self.view.stages;
        slot.late_events = emitted.late;
        slot.rumble = emitted.rumble;
        let has_changed = self.changes.update(slot);
        self.queues.views.publish();
        self.queues.waker.wake(has_changed);
    }

    /// Logs which electrodes were lost and which work again.
    pub(super) fn log_electrodes(&mut self) {
        let lost = self.engine.lost_electrodes();
        if lost == self.view.lost_electrodes {
            return;
        }
        let known = &self.view.lost_electrodes;
        // People count electrodes from 1.
        for electrode in lost.iter().filter(|electrode| !known.contains(electrode)) {
            tracing::warn!(
                "electrode {} is loose, shorted or noisy: play continues without it",
                electrode + 1
            );
        }
        for electrode in known.iter().filter(|electrode| !lost.contains(electrode)) {
            tracing::warn!("electrode {} works again", electrode + 1);
        }
        self.view.lost_electrodes = lost;
    }
}
