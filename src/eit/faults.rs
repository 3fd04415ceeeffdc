//! Electrodes that come loose, short or grow noisy, and those that recover.
//!
//! A touch is a change of conductivity: whatever it does to one reading it does, in a known way, to others. A reading that
//! no touch explains beside sound ones comes from an electrode. Each frame that cannot be explained names the
//! electrode whose readings deviate most; named in consecutive frames, it is taken out. Out, it is watched: readings that
//! keep still again bring it back, from the level that they have then.
//!
//! ```text
//!          named                named again
//! Sound ─────────▶ Suspect(n) ─────────────▶ Out(still frames) ──still for long──▶ Sound
//!        ◀───────── a frame without it            ◀── not still: count anew
//! ```

use crate::pad::Protocol;

/// Frames in a row that must name an electrode.
const NAMED_FRAMES: u32 = 2;
/// An electrode is named if its readings deviate by this many deviations in the mean, ...
const NAMED_MEAN: f64 = 4.0;
/// ... each counted to this many at most, so that a wild one does not speak for all.
const MOST: f64 = 20.0;
/// Frames for which a lost electrode must keep still.
const STILL_FRAMES: u32 = 30;
/// A still electrode's readings stay within this many deviations of their mean (root mean square).
const STILL_DEVIATIONS: f64 = 3.0;
/// A reading that is back lies within this share of where it was.
const BACK_WITHIN: f64 = 0.3;
/// Of an electrode's readings so many, one in this, may be off when it comes back.
const OFF_SHARE: usize = 10;
/// No pad plays with fewer electrodes than this share of all.
const LEAST_SHARE: f64 = 0.5;

/// Where an electrode stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Sound,
    Suspect(u32),
    Out { still: u32 },
}

/// The electrodes of a pad.
#[derive(Clone, Debug, PartialEq)]
pub struct Faults {
    /// Channels of each electrode.
    channels: Vec<Vec<usize>>,
    states: Vec<State>,
    /// Running mean of what each channel of a lost electrode deviates by, relative.
    means: Vec<f64>,
}

/// An electrode's change of state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Leave its readings out.
    Lost(usize),
    /// Take its readings again.
    Back(usize),
}

impl Faults {
    /// All sound.
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
            states: vec![State::Sound; protocol.electrodes],
            means: vec![0.0; protocol.channels.len()],
            channels,
        }
    }

    /// Electrodes that are out, ascending.
    #[must_use]
    pub fn lost(&self) -> Vec<usize> {
        (0..self.states.len())
            .filter(|electrode| self.is_out(*electrode))
            .collect()
    }

    /// Whether any electrode is out.
    #[must_use]
    pub fn any_lost(&self) -> bool {
        (0..self.states.len()).any(|electrode| self.is_out(electrode))
    }

    /// Whether a channel uses an electrode that is out.
    #[must_use]
    pub fn cuts(&self, channel: usize) -> bool {
        (0..self.states.len())
            .any(|electrode| self.is_out(electrode) && self.channels[electrode].contains(&channel))
    }

    /// Channels of an electrode, ascending.
    #[must_use]
    pub fn channels(&self, electrode: usize) -> &[usize] {
        &self.channels[electrode]
    }

    /// By how much a channel of an electrode that came back has moved while it was out, as a share.
    #[must_use]
    pub fn moved(&self, channel: usize) -> f64 {
        self.means[channel]
    }

    /// Takes out every electrode most of whose channels are known to be no readings.
    pub fn begin(&mut self, is_muted: impl Fn(usize) -> bool) -> Vec<Verdict> {
        let mut verdicts = Vec::new();
        for electrode in 0..self.states.len() {
            let channels = &self.channels[electrode];
            let muted = channels
                .iter()
                .filter(|channel| is_muted(**channel))
                .count();
            if !channels.is_empty() && 5 * muted >= 4 * channels.len() {
                self.states[electrode] = State::Out { still: 0 };
                verdicts.push(Verdict::Lost(electrode));
            }
        }
        verdicts
    }

    /// A frame that the touches explain.
    pub fn explained(&mut self) {
        for state in &mut self.states {
            if matches!(state, State::Suspect(_)) {
                *state = State::Sound;
            }
        }
    }

    /// A frame that no touch explains: `deviation` is what the touches leave of each channel, in deviations of its noise.
    /// May find an electrode lost.
    pub fn unexplained(&mut self, deviation: impl Fn(usize) -> f64) -> Option<Verdict> {
        let usable = self
            .states
            .iter()
            .filter(|state| !matches!(state, State::Out { .. }))
            .count();
        let (electrode, mean) = (0..self.states.len())
            .filter(|electrode| !self.is_out(*electrode))
            .map(|electrode| (electrode, self.mean_deviation(electrode, &deviation)))
            .max_by(|a, b| a.1.total_cmp(&b.1))?;
        for other in 0..self.states.len() {
            if other != electrode && matches!(self.states[other], State::Suspect(_)) {
                self.states[other] = State::Sound;
            }
        }
        let enough = usable as f64 - 1.0 >= LEAST_SHARE * self.states.len() as f64;
        if mean < NAMED_MEAN || !enough {
            return None;
        }
        let named = match self.states[electrode] {
            State::Suspect(named) => named + 1,
            _ => 1,
        };
        if named < NAMED_FRAMES {
            self.states[electrode] = State::Suspect(named);
            return None;
        }
        self.states[electrode] = State::Out { still: 0 };
        Some(Verdict::Lost(electrode))
    }

    /// Watches the lost electrodes: `change` is what the touches leave of each channel, relative; `noise` its deviation.
    pub fn watch(
        &mut self,
        change: impl Fn(usize) -> f64,
        noise: impl Fn(usize) -> f64,
    ) -> Option<Verdict> {
        let mut back = None;
        for electrode in 0..self.states.len() {
            let State::Out { still } = self.states[electrode] else {
                continue;
            };
            // Channels that another lost electrode spoils tell nothing about this one.
            let own: Vec<usize> = self.channels[electrode]
                .iter()
                .copied()
                .filter(|channel| {
                    (0..self.states.len()).all(|other| {
                        other == electrode
                            || !self.is_out(other)
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
            let is_still = square < STILL_DEVIATIONS * STILL_DEVIATIONS * own.len() as f64;
            let still = if is_still { still + 1 } else { 0 };
            for channel in &self.channels[electrode] {
                let mean = &mut self.means[*channel];
                *mean += (change(*channel) - *mean) / f64::from(still + 1);
            }
            self.states[electrode] = State::Out { still };
            let off = own
                .iter()
                .filter(|channel| self.means[**channel].abs() > BACK_WITHIN)
                .count();
            if still >= STILL_FRAMES && off * OFF_SHARE <= own.len() && back.is_none() {
                self.states[electrode] = State::Sound;
                back = Some(Verdict::Back(electrode));
            }
        }
        back
    }

    fn is_out(&self, electrode: usize) -> bool {
        matches!(self.states[electrode], State::Out { .. })
    }

    fn mean_deviation(&self, electrode: usize, deviation: &impl Fn(usize) -> f64) -> f64 {
        let mut sum = 0.0;
        let mut count = 0usize;
        for channel in self.channels[electrode].iter().filter(|c| !self.cuts(**c)) {
            let off = deviation(*channel).abs();
            sum += if off.is_finite() { off.min(MOST) } else { MOST };
            count += 1;
        }
        sum / count.max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults() -> Faults {
        let pairs = Protocol::stepped(16, 1);
        Faults::new(&Protocol::crossed(16, &pairs, &pairs, false).expect("adjacent"))
    }

    /// Deviations of a frame in which an electrode's channels are wild.
    fn wild(faults: &Faults, electrode: usize) -> impl Fn(usize) -> f64 + use<> {
        let channels = faults.channels(electrode).to_vec();
        move |channel| {
            if channels.contains(&channel) {
                300.0
            } else {
                1.0
            }
        }
    }

    #[test]
    fn an_electrode_is_lost_when_two_frames_in_a_row_name_it() {
        let mut faults = faults();
        let deviation = wild(&faults, 5);
        assert_eq!(faults.unexplained(&deviation), None, "one frame is chance");
        assert_eq!(faults.unexplained(&deviation), Some(Verdict::Lost(5)));
        assert_eq!(faults.lost(), [5]);
        assert!(faults.cuts(faults.channels(5)[0]));
    }

    #[test]
    fn a_frame_that_is_explained_clears_the_suspect() {
        let mut faults = faults();
        let deviation = wild(&faults, 5);
        faults.unexplained(&deviation);
        faults.explained();
        assert_eq!(faults.unexplained(&deviation), None);
    }

    #[test]
    fn noise_names_nobody() {
        let mut faults = faults();
        for _ in 0..10 {
            assert_eq!(faults.unexplained(|channel| (channel % 3) as f64), None);
        }
    }

    #[test]
    fn half_of_the_electrodes_are_kept() {
        let mut faults = faults();
        for electrode in 0..16 {
            let deviation = wild(&faults, electrode);
            faults.unexplained(&deviation);
            faults.unexplained(&deviation);
        }
        assert_eq!(faults.lost().len(), 8);
    }

    #[test]
    fn a_still_electrode_comes_back_from_where_it_is_now() {
        let mut faults = faults();
        let deviation = wild(&faults, 5);
        faults.unexplained(&deviation);
        faults.unexplained(&deviation);
        let mut back = None;
        let mut frames = 0;
        while back.is_none() && frames < 100 {
            back = faults.watch(|_| 0.02, |_| 1e-3);
            frames += 1;
        }
        assert_eq!(back, Some(Verdict::Back(5)));
        assert!((u32::try_from(frames).expect("few")) >= STILL_FRAMES);
        assert!((faults.moved(faults.channels(5)[0]) - 0.02).abs() < 1e-9);
        assert!(faults.lost().is_empty());
    }

    #[test]
    fn a_dead_electrode_is_still_but_does_not_come_back() {
        let mut faults = faults();
        let deviation = wild(&faults, 5);
        faults.unexplained(&deviation);
        faults.unexplained(&deviation);
        for _ in 0..200 {
            assert_eq!(faults.watch(|_| -1.0, |_| 1e-3), None, "it reads nothing");
        }
    }
}
