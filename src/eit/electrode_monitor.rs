//! Detects electrodes that come loose, short or turn noisy, and those that recover.
//!
//! A touch changes many readings in a known pattern. Readings that no touch explains point to an electrode: each
//! unexplained frame suspects the electrode whose readings deviate most, and two such frames in a row exclude it. The
//! readings of a lost electrode are watched: once they are steady near their earlier level, it counts again, from the level that they have
//! then. An electrode that was never sound since the reference was taken has no such level: it counts again once its readings are those of
//! a connected one (`reconnected`).
//!
//! ```text
//!        suspected                suspected again
//! Sound ───────────▶ Suspect(n) ─────────────────▶ Lost { steady_frames } ──steady for long──▶ Sound
//!       ◀─────────── another frame                        ◀── unsteady: back to 0
//! ```

use super::noise::median;
use super::reconnected::{LikeReadings, Reconnection};
use crate::pad::Protocol;

/// The fault is not that of a single electrode if the median channel deviates by this share of the worst electrode's mean.
const EVERYWHERE_SHARE: f64 = 0.5;
/// Frames in a row that must suspect an electrode.
const SUSPECT_FRAMES: u32 = 2;
/// An electrode is suspected if its readings deviate by this many standard deviations on average, ...
const SUSPECT_MEAN: f64 = 4.0;
/// ... each limited to this many, so that one wild reading is not enough.
const MOST_DEVIATION: f64 = 20.0;
/// Where all channels deviate because a finger lands in the same moment, the readings of a lost electrode still deviate by this many times
/// as much as those of the others: ...
const STANDS_OUT: f64 = 5.0;
/// ... all of its readings but this share, which may be near their old value by chance. Of its neighbours' readings half are its own.
const BY_CHANCE_SHARE: f64 = 0.25;
/// Frames for which a lost electrode must be steady.
const STEADY_FRAMES: u32 = 30;
/// Steady readings stay within this many standard deviations of their mean (root mean square).
const STEADY_DEVIATIONS: f64 = 3.0;
/// A recovered reading lies within this share of its earlier level.
const RECOVERED_WITHIN: f64 = 0.3;
/// One in this many readings of an electrode may be off when it recovers.
const OFF_SHARE: usize = 10;
/// At least this share of all electrodes stays in use.
const LEAST_SHARE: f64 = 0.5;

/// The state of one electrode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ElectrodeState {
    Sound,
    Suspect(u32),
    Lost { steady_frames: u32 },
}

/// Monitors the electrodes of a pad.
#[derive(Clone, Debug, PartialEq)]
pub struct ElectrodeMonitor {
    /// Channels of each electrode.
    channels: Vec<Vec<usize>>,
    states: Vec<ElectrodeState>,
    /// Running mean of the relative change of each channel of a lost electrode.
    means: Vec<f64>,
    /// Electrodes that were lost before their levels were known.
    has_no_level: Vec<bool>,
    like: LikeReadings,
    reconnections: Vec<Reconnection>,
}

impl ElectrodeMonitor {
    /// A monitor with all electrodes sound.
    #[must_use]
    pub fn new(protocol: &Protocol) -> Self {
        let mut channels = vec![Vec::new(); protocol.electrodes];
        for (index, channel) in protocol.channels.iter().enumerate() {
            for electrode in [
                channel.drive.0,
                channel.drive.1,
                channel.measure.0,
                channel.measure.1,
            ] {
                channels[electrode].push(index);
            }
        }
        Self {
            states: vec![ElectrodeState::Sound; protocol.electrodes],
            means: vec![0.0; protocol.channels.len()],
            has_no_level: vec![false; protocol.electrodes],
            like: LikeReadings::new(protocol),
            reconnections: channels
                .iter()
                .map(|own| Reconnection::new(own.len()))
                .collect(),
            channels,
        }
    }

    /// Marks all electrodes as sound.
    pub fn reset(&mut self) {
        self.states.fill(ElectrodeState::Sound);
        self.means.fill(0.0);
        self.has_no_level.fill(false);
    }

    /// Lost electrodes, ascending, counted from 0.
    #[must_use]
    pub fn lost(&self) -> Vec<usize> {
        (0..self.states.len())
            .filter(|electrode| self.is_lost(*electrode))
            .collect()
    }

    /// Whether any electrode is lost.
    #[must_use]
    pub fn any_lost(&self) -> bool {
        (0..self.states.len()).any(|electrode| self.is_lost(electrode))
    }

    /// Whether a channel uses a lost electrode.
    #[must_use]
    pub fn excludes(&self, channel: usize) -> bool {
        (0..self.states.len())
            .any(|electrode| self.is_lost(electrode) && self.channels[electrode].contains(&channel))
    }

    /// Channels of an electrode, ascending.
    #[must_use]
    pub fn channels(&self, electrode: usize) -> &[usize] {
        &self.channels[electrode]
    }

    /// Relative change of a channel while its electrode was lost.
    #[must_use]
    pub fn level_change(&self, channel: usize) -> f64 {
        self.means[channel]
    }

    /// Marks every electrode as lost of which at least four in five channels are muted, and returns them.
    pub fn exclude_muted(&mut self, is_muted: impl Fn(usize) -> bool) -> Vec<usize> {
        let mut lost = Vec::new();
        for electrode in 0..self.states.len() {
            let channels = &self.channels[electrode];
            let muted = channels
                .iter()
                .filter(|channel| is_muted(**channel))
                .count();
            if !channels.is_empty() && 5 * muted >= 4 * channels.len() {
                self.lose(electrode);
                lost.push(electrode);
            }
        }
        lost
    }

    /// Takes a frame that touches explain: clears all suspicion.
    pub fn accept_frame(&mut self) {
        for state in &mut self.states {
            if matches!(state, ElectrodeState::Suspect(_)) {
                *state = ElectrodeState::Sound;
            }
        }
    }

    /// Takes a frame that no touch explains. `deviation` is the residual of each channel in standard deviations of its
    /// noise; `are_touches_removed` tells whether it is free of the change by touches. Returns an electrode that is lost from
    /// this frame on.
    pub fn suspect(
        &mut self,
        deviation: impl Fn(usize) -> f64,
        are_touches_removed: bool,
    ) -> Option<usize> {
        let usable = self
            .states
            .iter()
            .filter(|state| !matches!(state, ElectrodeState::Lost { .. }))
            .count();
        let (electrode, mean) = (0..self.states.len())
            .filter(|electrode| !self.is_lost(*electrode))
            .map(|electrode| (electrode, self.mean_deviation(electrode, &deviation)))
            .max_by(|a, b| a.1.total_cmp(&b.1))?;
        let is_everywhere = are_touches_removed && self.is_everywhere(mean, &deviation);
        let electrode = match is_everywhere {
            true => self.standing_out(&deviation),
            false => Some(electrode),
        };
        let Some(electrode) = electrode else {
            self.accept_frame();
            return None;
        };
        for other in 0..self.states.len() {
            if other != electrode && matches!(self.states[other], ElectrodeState::Suspect(_)) {
                self.states[other] = ElectrodeState::Sound;
            }
        }
        let enough = usable as f64 - 1.0 >= LEAST_SHARE * self.states.len() as f64;
        if mean < SUSPECT_MEAN || !enough {
            return None;
        }
        let frames = match self.states[electrode] {
            ElectrodeState::Suspect(frames) => frames + 1,
            _ => 1,
        };
        if frames < SUSPECT_FRAMES {
            self.states[electrode] = ElectrodeState::Suspect(frames);
            return None;
        }
        self.lose(electrode);
        Some(electrode)
    }

    /// Whether all channels deviate nearly as much as those of the worst electrode: a spike, another gain or another pad does
    /// that, one electrode does not.
    fn is_everywhere(&self, worst_mean: f64, deviation: &impl Fn(usize) -> f64) -> bool {
        let mut all: Vec<f64> = (0..self.means.len())
            .filter(|channel| !self.excludes(*channel))
            .map(|channel| deviation(channel).abs())
            .map(|off| if off.is_finite() { off } else { MOST_DEVIATION })
            .collect();
        median(&mut all)
            .is_some_and(|median| median > SUSPECT_MEAN && median > EVERYWHERE_SHARE * worst_mean)
    }

    /// The electrode whose readings deviate by many times as much as all others, in a frame in which all channels deviate.
    fn standing_out(&self, deviation: &impl Fn(usize) -> f64) -> Option<usize> {
        let sorted = |channels: &mut dyn Iterator<Item = usize>| -> Vec<f64> {
            let counted = channels.filter(|channel| !self.excludes(*channel));
            let mut sizes: Vec<f64> = counted.map(|channel| deviation(channel).abs()).collect();
            sizes.sort_by(f64::total_cmp);
            sizes
        };
        let least_of = |electrode: usize| {
            let own = sorted(&mut self.channels[electrode].iter().copied());
            own.get((BY_CHANCE_SHARE * own.len() as f64) as usize)
                .copied()
        };
        let (electrode, least) = (0..self.states.len())
            .filter(|electrode| !self.is_lost(*electrode))
            .filter_map(|electrode| Some((electrode, least_of(electrode)?)))
            .max_by(|a, b| a.1.total_cmp(&b.1))?;
        let own = &self.channels[electrode];
        let others = sorted(&mut (0..self.means.len()).filter(|channel| !own.contains(channel)));
        let usual = others.get(others.len() / 2)?;
        (least > STANDS_OUT * usual).then_some(electrode)
    }

    /// Watches the lost electrodes: `change` is the relative residual of each channel, `noise` its standard deviation.
    /// Returns an electrode that has recovered.
    pub fn watch_lost(
        &mut self,
        change: impl Fn(usize) -> f64,
        noise: impl Fn(usize) -> f64,
    ) -> Option<usize> {
        let mut recovered = None;
        for electrode in 0..self.states.len() {
            let ElectrodeState::Lost { steady_frames } = self.states[electrode] else {
                continue;
            };
            // Channels that use another lost electrode say nothing about this one.
            let own: Vec<usize> = self.channels[electrode]
                .iter()
                .copied()
                .filter(|channel| {
                    (0..self.states.len()).all(|other| {
                        other == electrode
                            || !self.is_lost(other)
                            || !self.channels[other].contains(channel)
                    })
                })
                .collect();
            let square: f64 = own
                .iter()
                .map(|channel| {
                    let off = (change(*channel) - self.means[*channel]) / noise(*channel);
                    off * off
                })
                .sum();
            let is_steady = square < STEADY_DEVIATIONS * STEADY_DEVIATIONS * own.len() as f64;
            let steady_frames = if is_steady { steady_frames + 1 } else { 0 };
            for channel in &self.channels[electrode] {
                let mean = &mut self.means[*channel];
                *mean += (change(*channel) - *mean) / f64::from(steady_frames + 1);
            }
            self.states[electrode] = ElectrodeState::Lost { steady_frames };
            let off = own
                .iter()
                .filter(|channel| self.means[**channel].abs() > RECOVERED_WITHIN)
                .count();
            if steady_frames >= STEADY_FRAMES && off * OFF_SHARE <= own.len() && recovered.is_none()
            {
                self.states[electrode] = ElectrodeState::Sound;
                recovered = Some(electrode);
            }
        }
        recovered
    }

    /// The reference was taken: the levels of the electrodes that are lost now are not known.
    pub fn forget_levels_of_lost(&mut self) {
        for electrode in 0..self.states.len() {
            self.has_no_level[electrode] = self.is_lost(electrode);
        }
    }

    /// The frame is not explained, so the readings of lost electrodes may contain a touch.
    pub fn skip_frame(&mut self) {
        for reconnection in &mut self.reconnections {
            reconnection.restart();
        }
    }

    /// Watches the lost electrodes whose levels are not known: `reading` is the present reading of a channel without the change by
    /// touches, V, `sound` the level of a sound channel, V, and the variance of its readings, V^2. Returns the channels of an electrode that
    /// is connected again, each with its level, V.
    pub fn find_reconnected(
        &mut self,
        reading: impl Fn(usize) -> f64,
        sound: impl Fn(usize) -> Option<(f64, f64)>,
    ) -> Option<Vec<(usize, f64)>> {
        let mut found = None;
        for electrode in 0..self.states.len() {
            if !self.is_lost(electrode) || !self.has_no_level[electrode] {
                continue;
            }
            let own = &self.channels[electrode];
            let readings = own.iter().map(|channel| reading(*channel));
            let is_due = self.reconnections[electrode].take_frame(readings);
            if !is_due || found.is_some() {
                continue;
            }
            let is_spoiled = |channel: usize| {
                (0..self.states.len()).any(|other| {
                    other != electrode
                        && self.is_lost(other)
                        && self.channels[other].contains(&channel)
                })
            };
            let window = &self.reconnections[electrode];
            let is_sound = |channel: usize| !self.excludes(channel);
            let sound = |channel: usize| sound(channel).filter(|_| is_sound(channel));
            if let Some(connected) = self.like.connected(window, own, is_spoiled, sound) {
                let levels = connected
                    .iter()
                    .map(|index| (own[*index], window.mean(*index)));
                found = Some((electrode, levels.collect()));
            }
        }
        let (electrode, levels) = found?;
        self.states[electrode] = ElectrodeState::Sound;
        self.has_no_level[electrode] = false;
        Some(levels)
    }

    fn lose(&mut self, electrode: usize) {
        self.states[electrode] = ElectrodeState::Lost { steady_frames: 0 };
        self.reconnections[electrode].restart();
    }

    fn is_lost(&self, electrode: usize) -> bool {
        matches!(self.states[electrode], ElectrodeState::Lost { .. })
    }

    fn mean_deviation(&self, electrode: usize, deviation: &impl Fn(usize) -> f64) -> f64 {
        let mut sum = 0.0;
        let mut count = 0usize;
        for channel in self.channels[electrode]
            .iter()
            .filter(|c| !self.excludes(**c))
        {
            let off = deviation(*channel).abs();
            sum += if off.is_finite() {
                off.min(MOST_DEVIATION)
            } else {
                MOST_DEVIATION
            };
            count += 1;
        }
        sum / count.max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn monitor() -> ElectrodeMonitor {
        let pairs = Protocol::pairs_with_step(16, 1);
        ElectrodeMonitor::new(
            &Protocol::from_patterns(16, &pairs, &pairs, false).expect("adjacent"),
        )
    }

    /// Deviations of a frame in which an electrode's channels are wild.
    fn wild(monitor: &ElectrodeMonitor, electrode: usize) -> impl Fn(usize) -> f64 + use<> {
        let channels = monitor.channels(electrode).to_vec();
        move |channel| {
            if channels.contains(&channel) {
                300.0
            } else {
                1.0
            }
        }
    }

    #[test]
    fn two_suspect_frames_in_a_row_lose_an_electrode() {
        let mut monitor = monitor();
        let deviation = wild(&monitor, 5);
        assert_eq!(
            monitor.suspect(&deviation, true),
            None,
            "one frame may be chance"
        );
        assert_eq!(monitor.suspect(&deviation, true), Some(5));
        assert_eq!(monitor.lost(), [5]);
        assert!(monitor.excludes(monitor.channels(5)[0]));
    }

    #[test]
    fn an_electrode_is_lost_while_a_finger_lands() {
        let mut monitor = monitor();
        let lost = wild(&monitor, 5);
        let deviation = |channel: usize| lost(channel) + 30.0;
        monitor.suspect(deviation, true);
        assert_eq!(monitor.suspect(deviation, true), Some(5));
    }

    #[test]
    fn another_gain_of_all_channels_loses_no_electrode() {
        let mut monitor = monitor();
        for _ in 0..10 {
            assert_eq!(monitor.suspect(|c| 200.0 + (c % 60) as f64, true), None);
        }
    }

    #[test]
    fn an_explained_frame_clears_the_suspect() {
        let mut monitor = monitor();
        let deviation = wild(&monitor, 5);
        monitor.suspect(&deviation, true);
        monitor.accept_frame();
        assert_eq!(monitor.suspect(&deviation, true), None);
    }

    #[test]
    fn noise_loses_no_electrode() {
        let mut monitor = monitor();
        for _ in 0..10 {
            assert_eq!(monitor.suspect(|channel| (channel % 3) as f64, true), None);
        }
    }

    #[test]
    fn half_of_the_electrodes_stay_in_use() {
        let mut monitor = monitor();
        for electrode in 0..16 {
            let deviation = wild(&monitor, electrode);
            monitor.suspect(&deviation, true);
            monitor.suspect(&deviation, true);
        }
        assert_eq!(monitor.lost().len(), 8);
    }

    #[test]
    fn a_steady_electrode_recovers_at_its_present_level() {
        let mut monitor = monitor();
        let deviation = wild(&monitor, 5);
        monitor.suspect(&deviation, true);
        monitor.suspect(&deviation, true);
        let mut recovered = None;
        let mut frames = 0;
        while recovered.is_none() && frames < 100 {
            recovered = monitor.watch_lost(|_| 0.02, |_| 1e-3);
            frames += 1;
        }
        assert_eq!(recovered, Some(5));
        assert!((u32::try_from(frames).expect("few")) >= STEADY_FRAMES);
        assert!((monitor.level_change(monitor.channels(5)[0]) - 0.02).abs() < 1e-9);
        assert!(monitor.lost().is_empty());
    }

    #[test]
    fn a_dead_electrode_is_steady_but_does_not_recover() {
        let mut monitor = monitor();
        let deviation = wild(&monitor, 5);
        monitor.suspect(&deviation, true);
        monitor.suspect(&deviation, true);
        for _ in 0..200 {
            assert_eq!(
                monitor.watch_lost(|_| -1.0, |_| 1e-3),
                None,
                "it reads zero"
            );
        }
    }
}
