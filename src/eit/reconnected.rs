//! Whether a lost electrode is connected again, decided by its readings alone, where no level from before it was lost is known.
//!
//! A loose wire can be steady: an open input reads zero, one end of its range or what couples into it. On a regular pad, readings depend
//! on the places of drive and measurement relative to each other much more than on where around the pad they lie, and exchanging drive
//! and measurement does not change a reading. An electrode is connected if nearly all its readings agree with both.

use super::noise::median;
use crate::pad::{Channel, Pair, Protocol};

/// Frames that a decision takes.
const WINDOW_FRAMES: u32 = 30;
/// Readings that a quarter turn of the pad turns into each other differ at most by this factor.
const ALIKE_FACTOR: f64 = 3.0;
/// A reading and that with drive and measurement exchanged differ at most by this share.
const RECIPROCITY_SHARE: f64 = 0.15;
/// At least this share of the readings of an electrode agrees.
const AGREEING_SHARE: f64 = 0.9;
/// Readings of the window spread at most this many times as widely as those that are alike.
const STEADY_FACTOR: f64 = 3.0;
/// An electrode is judged by at least so many readings, ...
const LEAST_JUDGED: usize = 4;
/// ... and by this share of its readings.
const LEAST_JUDGED_SHARE: f64 = 0.2;
/// Fewer sound readings that are alike say nothing.
const LEAST_ALIKE: usize = 2;

/// Mean and sum of squared deviations of the readings of a window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Window {
    mean: f64,
    squares: f64,
}

/// Watches the readings of one lost electrode.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Reconnection {
    frames: u32,
    /// One per channel of the electrode.
    windows: Vec<Window>,
}

impl Reconnection {
    /// Before the first frame of an electrode with so many channels.
    pub(super) fn new(channels: usize) -> Self {
        Self {
            frames: 0,
            windows: vec![Window::default(); channels],
        }
    }

    /// Takes a frame: the readings of the electrode's channels without the change by touches, V. Returns whether a decision is due.
    pub(super) fn take_frame(&mut self, readings: impl Iterator<Item = f64>) -> bool {
        if self.frames == WINDOW_FRAMES {
            self.restart();
        }
        self.frames += 1;
        let share = 1.0 / f64::from(self.frames);
        for (window, reading) in self.windows.iter_mut().zip(readings) {
            let off = reading - window.mean;
            window.mean += share * off;
            window.squares += off * (reading - window.mean);
        }
        self.frames == WINDOW_FRAMES
    }

    /// Begins the window again.
    pub(super) fn restart(&mut self) {
        self.frames = 0;
        self.windows.fill(Window::default());
    }

    /// Mean reading of a channel in the window, V; the channel counted among those of the electrode.
    pub(super) fn mean(&self, index: usize) -> f64 {
        self.windows[index].mean
    }

    /// Variance of the readings of a channel in the window, V^2.
    fn variance(&self, index: usize) -> f64 {
        self.windows[index].squares / f64::from(self.frames.max(2) - 1)
    }
}

/// Which readings of a protocol are alike and which are reciprocal.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LikeReadings {
    /// The group of each channel.
    groups: Vec<usize>,
    /// Channels of each group.
    members: Vec<Vec<usize>>,
    /// The channel with drive and measurement exchanged.
    reciprocal: Vec<Option<usize>>,
}

impl LikeReadings {
    /// Groups the channels of a protocol.
    pub(super) fn new(protocol: &Protocol) -> Self {
        let channels = &protocol.channels;
        let mut keys: Vec<[Pair; 2]> = Vec::new();
        let mut members: Vec<Vec<usize>> = Vec::new();
        let mut groups = Vec::with_capacity(channels.len());
        for (index, channel) in channels.iter().enumerate() {
            let key = alike_key(*channel, protocol.electrodes);
            let known = keys.iter().position(|other| *other == key);
            let group = known.unwrap_or_else(|| {
                keys.push(key);
                members.push(Vec::new());
                keys.len() - 1
            });
            members[group].push(index);
            groups.push(group);
        }
        let exchanged = |channel: &Channel| {
            channels
                .iter()
                .position(|other| other.drive == channel.measure && other.measure == channel.drive)
        };
        Self {
            reciprocal: channels.iter().map(exchanged).collect(),
            groups,
            members,
        }
    }

    /// The readings of a window that nothing speaks against, as numbers among `channels`, those of the electrode; none if the electrode is
    /// not connected. `is_spoiled` tells whether another lost electrode spoils a channel, `sound` gives the reading of a
    /// sound channel, V, and its variance, V^2.
    pub(super) fn connected(
        &self,
        window: &Reconnection,
        channels: &[usize],
        is_spoiled: impl Fn(usize) -> bool,
        sound: impl Fn(usize) -> Option<(f64, f64)>,
    ) -> Option<Vec<usize>> {
        let (mut judged, mut agreeing) = (0usize, 0usize);
        let mut credible = Vec::new();
        let (mut spread, mut expected) = (0.0, 0.0);
        for (index, channel) in channels.iter().enumerate() {
            if is_spoiled(*channel) {
                continue;
            }
            let alike = self.members[self.groups[*channel]].iter();
            let (mut levels, mut variances): (Vec<f64>, Vec<f64>) = alike
                .filter_map(|other| sound(*other))
                .map(|(level, variance)| (level.abs(), variance))
                .unzip();
            if levels.len() < LEAST_ALIKE {
                credible.push(index);
                continue;
            }
            judged += 1;
            let usual = median(&mut levels).unwrap_or(0.0);
            let mean = window.mean(index);
            let is_alike = usual > 0.0
                && mean.abs() <= ALIKE_FACTOR * usual
                && mean.abs() * ALIKE_FACTOR >= usual;
            if is_alike && self.is_reciprocal(window, channels, *channel, mean) {
                credible.push(index);
                agreeing += 1;
                spread += window.variance(index);
                // Noise that grows with the reading, and noise that does not.
                let share = (mean / usual).abs().max(1.0);
                expected += share * share * median(&mut variances).unwrap_or(0.0);
            }
        }
        let is_connected = judged >= LEAST_JUDGED
            && judged as f64 >= LEAST_JUDGED_SHARE * channels.len() as f64
            && agreeing as f64 >= AGREEING_SHARE * judged as f64
            && spread <= STEADY_FACTOR * STEADY_FACTOR * expected;
        is_connected.then_some(credible)
    }

    fn is_reciprocal(
        &self,
        window: &Reconnection,
        channels: &[usize],
        channel: usize,
        mean: f64,
    ) -> bool {
        let exchanged = self.reciprocal[channel];
        let index = exchanged.and_then(|other| channels.iter().position(|one| *one == other));
        index.is_none_or(|index| {
            let other = window.mean(index);
            (mean - other).abs() <= RECIPROCITY_SHARE * mean.abs().max(other.abs())
        })
    }
}

/// The same for readings that quarter turns of the pad, or exchanging drive and measurement, turn into each other, up to the sign. Without
/// quarter turns of the electrodes, any turn counts.
fn alike_key(channel: Channel, electrodes: usize) -> [Pair; 2] {
    let turn = if electrodes.is_multiple_of(4) {
        electrodes / 4
    } else {
        1
    };
    let turned = |pair: Pair, by: usize| {
        let [a, b] = [pair.0, pair.1].map(|electrode| (electrode + by) % electrodes);
        Pair(a.min(b), a.max(b))
    };
    let keys = (0..electrodes).step_by(turn).map(|by| {
        let (drive, measure) = (turned(channel.drive, by), turned(channel.measure, by));
        [drive.min(measure), drive.max(measure)]
    });
    keys.min().unwrap_or([channel.drive, channel.measure])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eit::{ContactModel, ForwardModel, Mesh, MeshSize};
    use crate::pad::{Pad, SHIPPED_PADS};

    /// The untouched readings of a pad, V.
    fn readings(pad: &Pad) -> Vec<f64> {
        let mesh = Mesh::from_pad(pad, MeshSize::reconstruction(pad));
        let background = mesh.background_s_per_m(pad);
        let model = ForwardModel::new(mesh, &ContactModel::from_pad(pad)).expect("a model");
        let fields = model.solve(&background).expect("solvable");
        fields.voltages(&pad.protocol)
    }

    /// Whether an electrode is connected that reads what `read` makes of a reading of the untouched pad and its channel.
    fn is_connected(
        pad: &Pad,
        electrode: usize,
        volts: &[f64],
        read: impl Fn(f64, &Channel) -> f64,
    ) -> bool {
        let uses = |channel: usize| {
            let Channel { drive, measure } = pad.protocol.channels[channel];
            [drive.0, drive.1, measure.0, measure.1].contains(&electrode)
        };
        let own: Vec<usize> = (0..volts.len()).filter(|channel| uses(*channel)).collect();
        let mut window = Reconnection::new(own.len());
        for frame in 0..WINDOW_FRAMES {
            let noise = if frame % 2 == 0 { 1.001 } else { 0.999 };
            let readings = own
                .iter()
                .map(|channel| noise * read(volts[*channel], &pad.protocol.channels[*channel]));
            let is_due = window.take_frame(readings);
            assert_eq!(is_due, frame + 1 == WINDOW_FRAMES);
        }
        let sound = |channel: usize| {
            let noise = 1e-3 * volts[channel];
            (!uses(channel)).then_some((volts[channel], noise * noise))
        };
        LikeReadings::new(&pad.protocol)
            .connected(&window, &own, |_| false, sound)
            .is_some()
    }

    #[test]
    fn an_electrode_of_a_shipped_pad_is_known_by_its_readings() {
        for shipped in SHIPPED_PADS {
            let pad = Pad::from_toml(shipped.name, shipped.toml).expect("valid");
            let volts = readings(&pad);
            let largest = volts.iter().fold(0.0f64, |most, volt| most.max(volt.abs()));
            for electrode in 0..pad.protocol.electrodes {
                let says = |read: &dyn Fn(f64, &Channel) -> f64| {
                    is_connected(&pad, electrode, &volts, read)
                };
                let name = format!("{}, electrode {electrode}", shipped.name);
                assert!(says(&|volt, _| volt), "{name}: as it is");
                assert!(says(&|volt, _| 1.1 * volt), "{name}: another gain");
                assert!(!says(&|_, _| 0.0), "{name}: zero");
                assert!(!says(&|_, _| largest), "{name}: the end of its range");
                assert!(!says(&|volt, _| volt + 0.3 * largest), "{name}: an offset");
                let open = |volt: f64, channel: &Channel| {
                    let drives = [channel.drive.0, channel.drive.1].contains(&electrode);
                    if drives { 0.0 } else { volt }
                };
                assert!(!says(&open), "{name}: no current");
            }
        }
    }

    #[test]
    fn unsteady_readings_are_no_connection() {
        let shipped = SHIPPED_PADS[0];
        let pad = Pad::from_toml(shipped.name, shipped.toml).expect("valid");
        let volts = readings(&pad);
        let count = std::cell::Cell::new(0.0f64);
        let shaky = |volt: f64, _: &Channel| {
            count.set(count.get() + 1.0);
            volt * (1.0 + 0.02 * count.get().sin())
        };
        assert!(!is_connected(&pad, 3, &volts, shaky));
    }
}
