//! Stimulation and measurement patterns: which electrodes carry current, which are read, and the order of the readings in
//! a frame.
//!
//! Order (pyEIT `std`, EIDORS' default): drives outer, measurements ascending from electrode 0, without readings that share
//! an electrode with the drive.
//!
//! Sign: a drive (a, b) sends current into a and out of b; a measurement (p, q) reads V(q) - V(p). With all pairs in the
//! same direction round the pad, the adjacent readings of a homogeneous pad are positive, as in EIDORS and pyEIT, and
//! reciprocity holds: exchanging drive and measurement does not change the value.

/// Two electrodes, counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Pair(pub usize, pub usize);

impl Pair {
    /// Whether the two pairs have an electrode in common.
    #[must_use]
    pub fn shares_electrode(self, other: Self) -> bool {
        [self.0, self.1]
            .iter()
            .any(|e| *e == other.0 || *e == other.1)
    }

    fn is_within(self, electrodes: usize) -> bool {
        self.0 < electrodes && self.1 < electrodes && self.0 != self.1
    }
}

/// One reading of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Channel {
    /// Current flows into the first and out of the second.
    pub drive: Pair,
    /// The reading is the potential of the second minus that of the first.
    pub measure: Pair,
}

/// The readings of a frame, in order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Protocol {
    /// Number of electrodes.
    pub electrodes: usize,
    /// The readings in the order of the frame.
    pub channels: Vec<Channel>,
}

/// Why a protocol is invalid.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ProtocolError {
    /// A pair with an unknown electrode, or with the same one twice.
    #[error("the pair ({}, {}) needs two different electrodes, counted from 0 to {}", .pair.0, .pair.1, .electrodes - 1)]
    NoSuchPair {
        /// The pair.
        pair: Pair,
        /// Number of electrodes.
        electrodes: usize,
    },
    /// No reading is left.
    #[error("no measurement is left: each shares an electrode with its drive")]
    Empty,
    /// The reciprocal half needs equal drives and measurements.
    #[error("the reciprocal half needs the same pattern for stimulation and measurement")]
    NoHalf,
    /// An order of drives that does not list each drive once.
    #[error("`order` must list each of the {drives} drives once, as numbers from 0 to {}", .drives - 1)]
    NoOrder {
        /// Number of drives.
        drives: usize,
    },
}

impl Protocol {
    /// The drive of each channel, numbered from 0 in the order of their first channel.
    #[must_use]
    pub fn drives(&self) -> Vec<u16> {
        let mut seen: Vec<Pair> = Vec::new();
        self.channels
            .iter()
            .map(|channel| {
                let known = seen.iter().position(|drive| *drive == channel.drive);
                let index = known.unwrap_or_else(|| {
                    seen.push(channel.drive);
                    seen.len() - 1
                });
                index as u16
            })
            .collect()
    }

    /// The first channel of each run of channels of one drive, and the number of channels.
    #[must_use]
    pub fn drive_bounds(&self) -> Vec<usize> {
        let channels = &self.channels;
        let starts =
            (0..channels.len()).filter(|c| *c == 0 || channels[*c].drive != channels[*c - 1].drive);
        starts.chain([channels.len()]).collect()
    }

    /// The same readings with the drives in another order: first those of the drive with the number `order[0]`. The readings
    /// of each drive keep their order. Drives are numbered as in [`Protocol::drives`].
    ///
    /// # Errors
    /// [`ProtocolError::NoOrder`].
    pub fn with_drive_order(&self, order: &[usize]) -> Result<Self, ProtocolError> {
        let drive_of = self.drives();
        let drives = drive_of
            .iter()
            .max()
            .map_or(0, |last| usize::from(*last) + 1);
        let mut sorted = order.to_vec();
        sorted.sort_unstable();
        if !sorted.into_iter().eq(0..drives) {
            return Err(ProtocolError::NoOrder { drives });
        }
        let of_drive = |drive: usize| {
            let numbered = self.channels.iter().zip(&drive_of);
            numbered
                .filter_map(move |(channel, of)| (usize::from(*of) == drive).then_some(*channel))
        };
        Ok(Self {
            electrodes: self.electrodes,
            channels: order.iter().flat_map(|drive| of_drive(*drive)).collect(),
        })
    }

    /// Every drive of a list with every measurement of another that shares no electrode with it.
    ///
    /// `half` keeps one of each two reciprocal readings, the one whose measurement comes later in the list: 104 of the 208
    /// adjacent ones.
    ///
    /// # Errors
    /// See [`ProtocolError`].
    pub fn from_patterns(
        electrodes: usize,
        drives: &[Pair],
        measures: &[Pair],
        half: bool,
    ) -> Result<Self, ProtocolError> {
        if let Some(pair) = drives
            .iter()
            .chain(measures)
            .find(|pair| !pair.is_within(electrodes))
        {
            return Err(ProtocolError::NoSuchPair {
                pair: *pair,
                electrodes,
            });
        }
        if half && drives != measures {
            return Err(ProtocolError::NoHalf);
        }
        let channels: Vec<Channel> = drives
            .iter()
            .enumerate()
            .flat_map(|(i, drive)| {
                measures.iter().enumerate().map(move |(m, measure)| {
                    (
                        i,
                        m,
                        Channel {
                            drive: *drive,
                            measure: *measure,
                        },
                    )
                })
            })
            .filter(|(i, m, channel)| {
                !channel.drive.shares_electrode(channel.measure) && (!half || m > i)
            })
            .map(|(_, _, channel)| channel)
            .collect();
        Self::from_channels(electrodes, channels)
    }

    /// A protocol from a list of readings.
    ///
    /// # Errors
    /// An invalid pair; an empty list.
    pub fn from_channels(electrodes: usize, channels: Vec<Channel>) -> Result<Self, ProtocolError> {
        if channels.is_empty() {
            return Err(ProtocolError::Empty);
        }
        let outside = channels
            .iter()
            .flat_map(|channel| [channel.drive, channel.measure])
            .find(|pair| !pair.is_within(electrodes));
        match outside {
            Some(pair) => Err(ProtocolError::NoSuchPair { pair, electrodes }),
            None => Ok(Self {
                electrodes,
                channels,
            }),
        }
    }

    /// Pairs (i, i + step) for every i, round the pad.
    #[must_use]
    pub fn pairs_with_step(electrodes: usize, step: usize) -> Vec<Pair> {
        (0..electrodes)
            .map(|i| Pair(i, (i + step) % electrodes))
            .collect()
    }

    /// For each channel, its reciprocal channel, if the protocol contains it.
    #[must_use]
    pub fn reciprocal(&self) -> Vec<Option<usize>> {
        let place: std::collections::HashMap<Channel, usize> = self
            .channels
            .iter()
            .enumerate()
            .map(|(index, channel)| (*channel, index))
            .collect();
        self.channels
            .iter()
            .map(|channel| {
                let swapped = Channel {
                    drive: channel.measure,
                    measure: channel.drive,
                };
                place.get(&swapped).copied()
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn adjacent(half: bool) -> Protocol {
        let pairs = Protocol::pairs_with_step(16, 1);
        Protocol::from_patterns(16, &pairs, &pairs, half).expect("adjacent")
    }

    #[test]
    fn adjacent_reads_208_and_its_half_104() {
        let full = adjacent(false);
        assert_eq!(full.channels.len(), 208);
        assert_eq!(full.channels[0].measure, Pair(2, 3));
        assert_eq!(
            full.channels[13 * 2].measure,
            Pair(0, 1),
            "drive 2 starts at 0: not rotated"
        );
        let half = adjacent(true);
        assert_eq!(half.channels.len(), 104);
        let per_drive: Vec<usize> = (0..16)
            .map(|i| half.channels.iter().filter(|c| c.drive.0 == i).count())
            .collect();
        assert_eq!(per_drive[..4], [13, 13, 12, 11]);
    }

    #[test]
    fn opposite_drive_with_adjacent_measure_reads_192() {
        let protocol = Protocol::from_patterns(
            16,
            &Protocol::pairs_with_step(16, 8),
            &Protocol::pairs_with_step(16, 1),
            false,
        )
        .expect("opposite");
        assert_eq!(protocol.channels.len(), 192);
    }

    #[test]
    fn every_adjacent_reading_has_its_reciprocal() {
        let protocol = adjacent(false);
        for (index, other) in protocol.reciprocal().into_iter().enumerate() {
            let other = other.expect("in the full set");
            assert_eq!(
                protocol.channels[index].drive,
                protocol.channels[other].measure
            );
        }
        assert!(adjacent(true).reciprocal().iter().all(Option::is_none));
    }

    #[test]
    fn drives_in_another_order_keep_their_readings() {
        let full = adjacent(false);
        let order: Vec<usize> = (0..16).map(|k| 5 * k % 16).collect();
        let spread = full.with_drive_order(&order).expect("each drive once");
        assert_eq!(spread.channels[13].drive, Pair(5, 6));
        assert_eq!(spread.channels[13..26], full.channels[65..78]);
        let mut sorted = spread.channels;
        sorted.sort_by_key(|channel| (channel.drive, channel.measure));
        assert!(sorted.iter().all(|channel| full.channels.contains(channel)));
        sorted.dedup();
        assert_eq!(sorted.len(), full.channels.len());
        for wrong in [&order[..15], &[0; 16]] {
            let error = full
                .with_drive_order(wrong)
                .expect_err("a drive is missing");
            assert_eq!(
                error.to_string(),
                "`order` must list each of the 16 drives once, as numbers from 0 to 15"
            );
        }
    }

    #[test]
    fn an_invalid_pair_is_refused() {
        let error =
            Protocol::from_patterns(8, &[Pair(0, 8)], &[Pair(1, 2)], false).expect_err("8 of 8");
        assert_eq!(
            error.to_string(),
            "the pair (0, 8) needs two different electrodes, counted from 0 to 7"
        );
    }
}
