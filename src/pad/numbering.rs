//! How a board numbers the electrodes: the place of its electrode 0 and the direction in which it counts.
//!
//! The places of a pad are counted counter-clockwise from 0. A board may be plugged in a quarter turn off, or upside down:
//! then its electrode 0 is elsewhere, or its numbers run clockwise. Reciprocity holds either way, so the voltages at rest of
//! a symmetric pad do not show it; presses do (`calibrate::orientation`).

use std::fmt;

use super::{Channel, Pair, Protocol};

/// Direction in which electrodes are numbered, seen from above.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Direction {
    /// In the direction of the places.
    #[default]
    CounterClockwise,
    /// Against the direction of the places.
    Clockwise,
}

impl Direction {
    /// The name in pad files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::CounterClockwise => "counter-clockwise",
            Self::Clockwise => "clockwise",
        }
    }
}

/// A board's numbering of the places of a pad.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Numbering {
    /// The place of electrode 0.
    pub first: usize,
    /// Direction of the others.
    pub direction: Direction,
}

impl Numbering {
    /// Every numbering: first that of the places, then rotated ones, then mirrored ones.
    pub fn all(electrodes: usize) -> impl Iterator<Item = Self> {
        [Direction::CounterClockwise, Direction::Clockwise]
            .into_iter()
            .flat_map(move |direction| (0..electrodes).map(move |first| Self { first, direction }))
    }

    /// The place of an electrode.
    #[must_use]
    pub fn place(self, electrode: usize, electrodes: usize) -> usize {
        match self.direction {
            Direction::CounterClockwise => (self.first + electrode) % electrodes,
            Direction::Clockwise => (self.first + electrodes - electrode % electrodes) % electrodes,
        }
    }

    /// The composition of two numberings: `self` numbers what `outer` takes for places, and the result gives the places of
    /// the pad.
    #[must_use]
    pub fn compose(self, outer: Self, electrodes: usize) -> Self {
        Self {
            first: outer.place(self.first, electrodes),
            direction: if self.direction == outer.direction {
                Direction::CounterClockwise
            } else {
                Direction::Clockwise
            },
        }
    }
}

impl fmt::Display for Numbering {
    /// For people, who count electrodes from 1: `from electrode 5, clockwise`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "from electrode {}, {}",
            self.first + 1,
            self.direction.name()
        )
    }
}

/// Reorders the frames of a board to the order of the places.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Renumbered {
    /// For each reading of the pad, the index of the board's reading, and whether its sign is reversed.
    board_indices: Vec<(usize, bool)>,
}

impl Renumbered {
    /// The order for a protocol and a board's numbering; `None` if the board does not measure every reading of the
    /// protocol, as with an asymmetric list of pairs.
    #[must_use]
    pub fn new(protocol: &Protocol, numbering: Numbering) -> Option<Self> {
        let count = protocol.electrodes;
        let placed = |pair: Pair| {
            Pair(
                numbering.place(pair.0, count),
                numbering.place(pair.1, count),
            )
        };
        // Sorted in canonical form, which finds swapped leads and reciprocal readings alike.
        let mut sent: Vec<(Channel, bool, usize)> = protocol
            .channels
            .iter()
            .enumerate()
            .map(|(index, channel)| {
                let (channel, flipped) = canonical(Channel {
                    drive: placed(channel.drive),
                    measure: placed(channel.measure),
                });
                (channel, flipped, index)
            })
            .collect();
        sent.sort_by_key(|(channel, _, index)| {
            let Channel { drive, measure } = *channel;
            (drive, measure, *index)
        });
        let mut taken = vec![false; sent.len()];
        let board_indices = protocol
            .channels
            .iter()
            .map(|channel| {
                let exact = *channel;
                let (wanted, flipped) = canonical(exact);
                let first = sent.partition_point(|(channel, ..)| {
                    (channel.drive, channel.measure) < (wanted.drive, wanted.measure)
                });
                // If both of two reciprocal readings are sent, each is used once; the one with the same drive first.
                let alike = sent[first..]
                    .iter()
                    .take_while(|(channel, ..)| *channel == wanted);
                let best =
                    alike
                        .filter(|(.., index)| !taken[*index])
                        .min_by_key(|(.., index)| {
                            let drive = placed(protocol.channels[*index].drive);
                            (sorted(drive) != sorted(exact.drive), *index)
                        })?;
                taken[best.2] = true;
                Some((best.2, best.1 != flipped))
            })
            .collect::<Option<Vec<_>>>()?;
        Some(Self { board_indices })
    }

    /// A frame in the order and sign of the places.
    ///
    /// # Panics
    /// If the frame has another number of readings than the protocol.
    #[must_use]
    pub fn apply<V: Copy + std::ops::Neg<Output = V>>(&self, volts: &[V]) -> Vec<V> {
        let mut placed = Vec::with_capacity(volts.len());
        self.apply_into(volts, &mut placed);
        placed
    }

    /// Like [`Renumbered::apply`], but reuses a vector.
    ///
    /// # Panics
    /// See [`Renumbered::apply`].
    pub fn apply_into<V: Copy + std::ops::Neg<Output = V>>(
        &self,
        volts: &[V],
        placed: &mut Vec<V>,
    ) {
        placed.clear();
        placed.extend(self.board_indices.iter().map(|(index, flipped)| {
            let volt = volts[*index];
            if *flipped { -volt } else { volt }
        }));
    }

    /// For each reading of the pad, the index of the board's reading: for values without sign, such as relative changes.
    pub fn board_indices(&self) -> impl Iterator<Item = usize> + '_ {
        self.board_indices.iter().map(|(index, _)| *index)
    }
}

fn sorted(pair: Pair) -> Pair {
    Pair(pair.0.min(pair.1), pair.0.max(pair.1))
}

/// The same reading with sorted leads and the lower pair as the drive, and whether that reverses its sign.
fn canonical(channel: Channel) -> (Channel, bool) {
    let (drive, measure) = (sorted(channel.drive), sorted(channel.measure));
    let flipped = (drive != channel.drive) != (measure != channel.measure);
    let channel = Channel {
        drive: drive.min(measure),
        measure: drive.max(measure),
    };
    (channel, flipped)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn protocol(kind: usize, count: usize) -> Protocol {
        let adjacent = Protocol::pairs_with_step(count, 1);
        let opposite = Protocol::pairs_with_step(count, count / 2);
        let skip = Protocol::pairs_with_step(count, 3);
        match kind {
            0 => Protocol::from_patterns(count, &adjacent, &adjacent, false),
            1 => Protocol::from_patterns(count, &adjacent, &adjacent, true),
            2 => Protocol::from_patterns(count, &opposite, &adjacent, false),
            _ => Protocol::from_patterns(count, &skip, &skip, false),
        }
        .expect("a protocol")
    }

    /// A reading of a pad that has no symmetry: each place has its own potential under each current.
    fn reading(place: impl Fn(usize) -> usize, channel: Channel) -> f32 {
        let transfer = |a: usize, b: usize| ((a.min(b) * 31 + a.max(b) * 17) % 101) as f32;
        let [a, b, p, q] = [
            channel.drive.0,
            channel.drive.1,
            channel.measure.0,
            channel.measure.1,
        ]
        .map(place);
        transfer(a, q) - transfer(a, p) - transfer(b, q) + transfer(b, p)
    }

    proptest! {
        #[test]
        fn a_renumbered_frame_reads_as_the_places_would(
            kind in 0usize..4, half in 4usize..12, first in 0usize..24, clockwise: bool,
        ) {
            let count = 2 * half;
            let direction = if clockwise { Direction::Clockwise } else { Direction::CounterClockwise };
            let numbering = Numbering { first: first % count, direction };
            let protocol = protocol(kind, count);
            let board: Vec<f32> = protocol.channels.iter()
                .map(|channel| reading(|e| numbering.place(e, count), *channel)).collect();
            let places: Vec<f32> = protocol.channels.iter().map(|channel| reading(|e| e, *channel)).collect();
            let renumbered = Renumbered::new(&protocol, numbering).expect("all patterns are even");
            prop_assert_eq!(renumbered.apply(&board), places);
            let mut source: Vec<usize> = renumbered.board_indices().collect();
            source.sort_unstable();
            prop_assert_eq!(source, (0..protocol.channels.len()).collect::<Vec<_>>(), "each once");
        }

        #[test]
        fn a_numbering_within_another_is_both(
            first in (0usize..16, 0usize..16), clockwise: (bool, bool), electrode in 0usize..16,
        ) {
            let direction = |clockwise| if clockwise { Direction::Clockwise } else { Direction::CounterClockwise };
            let inner = Numbering { first: first.0, direction: direction(clockwise.0) };
            let outer = Numbering { first: first.1, direction: direction(clockwise.1) };
            let both = inner.compose(outer, 16);
            prop_assert_eq!(both.place(electrode, 16), outer.place(inner.place(electrode, 16), 16));
        }
    }

    #[test]
    fn an_uneven_list_of_readings_cannot_be_renumbered() {
        let channel = Channel {
            drive: Pair(0, 1),
            measure: Pair(3, 4),
        };
        let protocol = Protocol::from_channels(8, vec![channel]).expect("one");
        let turned = Numbering {
            first: 2,
            ..Numbering::default()
        };
        assert_eq!(Renumbered::new(&protocol, turned), None);
    }
}
