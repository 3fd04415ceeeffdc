//! The layouts of streams: which readings a frame lists, in which order.

use crate::pad::{Channel, Pair};

/// Which readings a stream lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// Adjacent drive and measurement, without pairs that share an electrode with the drive: n (n - 3), 208 for 16
    /// electrodes.
    Adjacent,
    /// One of each two reciprocal readings of [`Self::Adjacent`]: n (n - 3) / 2, 104 for 16 electrodes.
    AdjacentHalf,
    /// Every adjacent pair for every adjacent drive, including the driven ones: n x n, 256 for 16 electrodes.
    Square,
    /// Opposite drive with adjacent measurement: n (n - 4), 192 for 16 electrodes.
    Opposite,
}

impl Layout {
    /// The layout of frames with a number of voltages.
    #[must_use]
    pub fn from_count(voltages: usize, electrodes: usize) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|layout| layout.readings(electrodes) == Some(voltages))
    }

    /// The layout whose stream has exactly these channels, rotated or not.
    #[must_use]
    pub fn of_channels(channels: &[Channel], electrodes: usize) -> Option<Self> {
        Self::from_count(channels.len(), electrodes).filter(|layout| {
            [false, true]
                .into_iter()
                .any(|rotated| layout.stream_channels(electrodes, rotated) == channels)
        })
    }

    /// All layouts.
    pub const ALL: [Self; 4] = [
        Self::Adjacent,
        Self::AdjacentHalf,
        Self::Square,
        Self::Opposite,
    ];

    /// The readings of a stream in its order, including the driven pairs of [`Self::Square`].
    #[must_use]
    pub fn stream_channels(self, electrodes: usize, rotated: bool) -> Vec<Channel> {
        self.pairs(electrodes, rotated)
            .into_iter()
            .map(|(drive, measure)| self.channel(electrodes, drive, measure))
            .collect()
    }

    /// The reading of a drive and a measurement, given by their first electrodes.
    fn channel(self, n: usize, drive: usize, measure: usize) -> Channel {
        let step = if self == Self::Opposite { n / 2 } else { 1 };
        Channel {
            drive: Pair(drive, (drive + step) % n),
            measure: Pair(measure, (measure + 1) % n),
        }
    }

    /// Number of readings; `None` if the layout needs more electrodes.
    pub(super) fn readings(self, n: usize) -> Option<usize> {
        match self {
            Self::Adjacent if n >= 5 => Some(n * (n - 3)),
            Self::AdjacentHalf if n >= 5 => Some(n * (n - 3) / 2),
            Self::Square if n >= 5 => Some(n * n),
            Self::Opposite if n >= 6 && n.is_multiple_of(2) => Some(n * (n - 4)),
            _ => None,
        }
    }

    /// Drive and measurement of every reading in the order of a stream.
    pub(super) fn pairs(self, n: usize, rotated: bool) -> Vec<(usize, usize)> {
        let lists = |(drive, measure): &(usize, usize)| match self {
            Self::Square => true,
            Self::AdjacentHalf => measure > drive && self.is_read(n, *drive, *measure),
            Self::Adjacent | Self::Opposite => self.is_read(n, *drive, *measure),
        };
        (0..n)
            .flat_map(|drive| {
                let first = if rotated { drive } else { 0 };
                (0..n).map(move |k| (drive, (first + k) % n))
            })
            .filter(lists)
            .collect()
    }

    /// Whether a measurement shares no electrode with its drive.
    pub(super) fn is_read(self, n: usize, drive: usize, measure: usize) -> bool {
        let channel = self.channel(n, drive, measure);
        !channel.drive.shares_electrode(channel.measure)
    }
}
