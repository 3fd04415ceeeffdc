//! Stimulation and measurement patterns: which electrodes carry current, which are read, and in which
//! order a frame lists the readings.
//!
//! Order (pyEIT `std`, EIDORS' default): drives outer, measurements ascending from electrode 0, readings
//! that share an electrode with the drive left out.
//!
//! Sign: a drive (a, b) sends current into a and out of b; a measurement (p, q) reads V(q) - V(p). With
//! pairs that go round the pad the same way, this makes all adjacent readings of a homogeneous pad
//! positive, as EIDORS and pyEIT do, and keeps reciprocity: exchanging drive and measurement leaves
//! the value.

/// Two electrodes, by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Pair(pub usize, pub usize);

impl Pair {
    /// Whether the two pairs have an electrode in common.
    #[must_use]
    pub fn meets(self, other: Self) -> bool {
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
    /// Current goes into the first and out of the second.
    pub drive: Pair,
    /// Second minus first is read.
    pub measure: Pair,
}

/// The readings of a frame, in order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Protocol {
    /// Number of electrodes.
    pub electrodes: usize,
    /// What is read, in the order of the frame.
    pub channels: Vec<Channel>,
}

/// Why a protocol cannot be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ProtocolError {
    /// A pair names an electrode that is not there, or one twice.
    #[error("the pair ({}, {}) needs two different electrodes below {electrodes}", .pair.0, .pair.1)]
    NoSuchPair {
        /// The pair.
        pair: Pair,
        /// How many electrodes there are.
        electrodes: usize,
    },
    /// Nothing is left to read.
    #[error("no measurement is left: each shares an electrode with its drive")]
    Empty,
    /// The reciprocal half exists only where the drives are the measurements.
    #[error(
        "the reciprocal half exists only where stimulation and measurement use the same pattern"
    )]
    NoHalf,
}

impl Protocol {
    /// Every drive of a list with every measurement of another that shares no electrode with it.
    ///
    /// `half` keeps, of each two reciprocal readings, the one whose measurement comes later in the list:
    /// 104 of the 208 adjacent ones.
    ///
    /// # Errors
    /// A pair that names no two electrodes; `half` of two different lists; nothing left.
    pub fn crossed(
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
            .filter(|(i, m, channel)| !channel.drive.meets(channel.measure) && (!half || m > i))
            .map(|(_, _, channel)| channel)
            .collect();
        Self::listed(electrodes, channels)
    }

    /// A protocol given reading by reading.
    ///
    /// # Errors
    /// A pair that names no two electrodes; an empty list.
    pub fn listed(electrodes: usize, channels: Vec<Channel>) -> Result<Self, ProtocolError> {
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
    pub fn stepped(electrodes: usize, step: usize) -> Vec<Pair> {
        (0..electrodes)
            .map(|i| Pair(i, (i + step) % electrodes))
            .collect()
    }

    /// For each channel, the channel that reads the same by reciprocity, if the protocol has it.
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
        let pairs = Protocol::stepped(16, 1);
        Protocol::crossed(16, &pairs, &pairs, half).expect("adjacent")
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
        let protocol = Protocol::crossed(
            16,
            &Protocol::stepped(16, 8),
            &Protocol::stepped(16, 1),
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
    fn a_pair_that_names_no_two_electrodes_is_refused() {
        let error = Protocol::crossed(8, &[Pair(0, 8)], &[Pair(1, 2)], false).expect_err("8 of 8");
        assert_eq!(
            error.to_string(),
            "the pair (0, 8) needs two different electrodes below 8"
        );
    }
}
