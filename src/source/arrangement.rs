//! Maps the order in which a board lists its readings to the pad's order.
//!
//! The first frames tell the order (`recognise_order`), unless the board names its drives or the player declares the order. A
//! reading that the board lacks is taken from its reciprocal twin, so 104 readings serve a pad of 208 channels.
//!
//! Invariant: an arrangement only moves readings and changes signs; every bit of a magnitude stays.

use crate::eit::order::{Layout, Order, OrderError, recognise_order};
use crate::pad::{Channel, Pad, Pair};

use super::own_order::is_own_order;
use super::wire::DeclaredOrder;

/// Where each of a pad's channels is in a board's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Arrangement {
    /// For each of the pad's channels the index in the frame and the sign.
    places: Vec<(usize, f32)>,
    /// Number of values of the board's frame.
    values: usize,
    /// The drive of each of the pad's channels.
    drives: Vec<u16>,
    /// Description for people.
    summary: String,
}

/// The readings of one drive of the pad, in a board's frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PartPlace {
    /// The first of the pad's channels.
    pub first: usize,
    /// Number of channels.
    pub channels: usize,
    /// So many of the frame's first values hold them.
    pub needs: usize,
}

/// The reason why a board's frames do not fit a pad.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ArrangementError {
    /// The board measures with another protocol.
    #[error(
        "the board sends {sent}, but the pad {pad} is measured with another protocol ({wanted} voltages)\n  help: choose the pad that the board is wired to with --pad NAME (see `gelpad pad list`) or --pad FILE"
    )]
    OtherProtocol {
        /// What the board sends.
        sent: String,
        /// The pad.
        pad: String,
        /// Number of voltages of the pad's frames.
        wanted: usize,
    },
    /// No layout has this number of values.
    #[error(transparent)]
    Order(#[from] OrderError),
}

impl Arrangement {
    /// The arrangement of a board from the values of its first frame, or the median of some frames.
    ///
    /// # Errors
    /// The board measures with another protocol than the pad's.
    pub fn find(
        values: &[f32],
        listing: Option<&[Channel]>,
        declared: Option<DeclaredOrder>,
        pad: &Pad,
    ) -> Result<Self, ArrangementError> {
        let electrodes = pad.protocol.electrodes;
        if let Some(listing) = listing {
            return Self::from_listing(values, listing, pad);
        }
        if declared.is_none() && is_own_order(values, pad) {
            return Ok(Self::unchanged(pad, ""));
        }
        let volts: Vec<f64> = values.iter().map(|value| f64::from(*value)).collect();
        let order = match declared {
            Some(DeclaredOrder { rotated, flipped }) => {
                Order::from_declaration(values.len(), electrodes, rotated, flipped)
            }
            None => recognise_order(&volts, electrodes),
        };
        match order {
            Ok(order) => Self::from_order(&order, values.len(), pad),
            Err(error) if values.len() == pad.channels() => {
                let why = match error {
                    OrderError::NoneFits(_) => " is assumed: no known order fits",
                    _ => " is assumed: the order cannot be recognised",
                };
                Ok(Self::unchanged(pad, why))
            }
            Err(OrderError::Ambiguous | OrderError::NoneFits(_)) => {
                let order = Order::from_declaration(values.len(), electrodes, false, false)?;
                let found = Self::from_order(&order, values.len(), pad)?;
                Ok(Self {
                    summary: format!(
                        "{}; the order cannot be recognised: assumed not rotated",
                        found.summary
                    ),
                    ..found
                })
            }
            Err(error) => Err(error.into()),
        }
    }

    /// The frame is taken as it is, in the pad's order; `why` ends the description.
    fn unchanged(pad: &Pad, why: &str) -> Self {
        let count = pad.channels();
        Self {
            places: (0..count).map(|place| (place, 1.0)).collect(),
            values: count,
            drives: pad.protocol.drives(),
            summary: format!("{count} voltages a frame; the pad's own order{why}"),
        }
    }

    fn from_order(order: &Order, count: usize, pad: &Pad) -> Result<Self, ArrangementError> {
        let electrodes = pad.protocol.electrodes;
        let summary = describe_order(order, count);
        let flip = if order.flipped { -1.0 } else { 1.0 };
        let places = places(&order.channels(electrodes), pad, order.layout)
            .ok_or_else(|| other_protocol(order.layout, count, pad))?
            .into_iter()
            .map(|(channel, sign)| (order.stream_indices()[channel], flip * sign))
            .collect();
        Ok(Self {
            places,
            values: count,
            drives: pad.protocol.drives(),
            summary,
        })
    }

    fn from_listing(
        values: &[f32],
        listing: &[Channel],
        pad: &Pad,
    ) -> Result<Self, ArrangementError> {
        let Some(places) = places(listing, pad, Layout::Adjacent) else {
            return Err(ArrangementError::OtherProtocol {
                sent: format!("{} voltages of drives that it names", values.len()),
                pad: pad.name.clone(),
                wanted: pad.channels(),
            });
        };
        let sum: f32 = places
            .iter()
            .map(|(place, sign)| sign * values[*place])
            .sum();
        let is_adjacent = pad.protocol.channels.iter().all(|channel| {
            let Pair(a, b) = channel.drive;
            (a + 1) % pad.protocol.electrodes == b
        });
        let flip = if is_adjacent && sum < 0.0 { -1.0 } else { 1.0 };
        let inverted = if flip < 0.0 { ", signs inverted" } else { "" };
        let error = reciprocity_error(values, &places, pad).map_or(String::new(), |error| {
            format!(", reciprocity error {:.1} %", error * 100.0)
        });
        Ok(Self {
            places: places
                .into_iter()
                .map(|(place, sign)| (place, flip * sign))
                .collect(),
            values: listing.len(),
            drives: pad.protocol.drives(),
            summary: format!(
                "{} voltages a frame, with named drives{inverted}{error}",
                listing.len()
            ),
        })
    }

    /// A frame in the pad's order.
    ///
    /// # Panics
    /// If the frame has another number of values than [`Arrangement::values`].
    #[must_use]
    pub fn apply(&self, values: &[f32]) -> Vec<f32> {
        assert_eq!(values.len(), self.values);
        self.places
            .iter()
            .map(|(place, sign)| sign * values[*place])
            .collect()
    }

    /// The readings of each drive of the pad, if a board sends them drive after drive; `None` if it sends them in another
    /// order, or some drives not at all.
    #[must_use]
    pub fn parts(&self) -> Option<Vec<PartPlace>> {
        let mut parts: Vec<PartPlace> = Vec::new();
        let mut first = 0;
        for drive in self.drives.chunk_by(|a, b| a == b) {
            let places = &self.places[first..first + drive.len()];
            let indices = places.iter().map(|(place, _)| *place);
            let (least, most) = (indices.clone().min()?, indices.max()?);
            if parts.last().is_some_and(|before| least < before.needs) {
                return None;
            }
            parts.push(PartPlace {
                first,
                channels: drive.len(),
                needs: most + 1,
            });
            first += drive.len();
        }
        (parts.len() > 1).then_some(parts)
    }

    /// The voltages of a part, from the first values of the board's frame.
    ///
    /// # Panics
    /// If there are fewer values than the part needs.
    #[must_use]
    pub fn apply_part(&self, values: &[f32], part: &PartPlace) -> Vec<f32> {
        self.places[part.first..part.first + part.channels]
            .iter()
            .map(|(place, sign)| sign * values[*place])
            .collect()
    }

    /// Whether another arrangement gives the same frames.
    #[must_use]
    pub fn reads_as(&self, other: &Self) -> bool {
        (&self.places, self.values) == (&other.places, other.values)
    }

    /// Values of the board's frame.
    #[must_use]
    pub fn values(&self) -> usize {
        self.values
    }

    /// What was found, for people.
    #[must_use]
    pub fn summary(&self) -> &str {
        &self.summary
    }
}

/// The numbers of values that a frame of a pad may have.
#[must_use]
pub fn plausible_counts(pad: &Pad) -> Vec<usize> {
    let electrodes = pad.protocol.electrodes;
    let mut counts: Vec<usize> = Layout::ALL
        .into_iter()
        .map(|layout| layout.stream_channels(electrodes, false).len())
        .filter(|count| Layout::from_count(*count, electrodes).is_some())
        .collect();
    counts.push(pad.channels());
    counts.sort_unstable();
    counts.dedup();
    counts
}

/// An order in words, for people.
#[must_use]
pub fn describe_order(order: &Order, count: usize) -> String {
    let layout = match order.layout {
        Layout::Adjacent => "adjacent drive",
        Layout::AdjacentHalf => "adjacent drive, without reciprocal readings",
        Layout::Square => "adjacent drive, all pairs (driven ones are ignored)",
        Layout::Opposite => "opposite drive",
    };
    let rotated = match (order.layout, order.rotated) {
        (Layout::AdjacentHalf, _) => "",
        (_, true) => ", rotated (measurements start after the drive)",
        (_, false) => ", not rotated",
    };
    let flipped = if order.flipped {
        ", signs inverted"
    } else {
        ""
    };
    let error = order.error.map_or(String::new(), |error| {
        format!(", reciprocity error {:.1} %", error * 100.0)
    });
    format!("{count} voltages a frame: {layout}{rotated}{flipped}{error}")
}

fn other_protocol(layout: Layout, count: usize, pad: &Pad) -> ArrangementError {
    let drive = match layout {
        Layout::Opposite => "opposite drive",
        _ => "adjacent drive",
    };
    ArrangementError::OtherProtocol {
        sent: format!("{count} voltages of {drive}"),
        pad: pad.name.clone(),
        wanted: pad.channels(),
    }
}

/// Norm of the differences of reciprocal readings over the norm of all readings; none if no channel has a twin.
fn reciprocity_error(values: &[f32], places: &[(usize, f32)], pad: &Pad) -> Option<f64> {
    let volt = |channel: usize| {
        let (place, sign) = places[channel];
        f64::from(sign * values[place])
    };
    let (mut off, mut all) = (0.0, 0.0);
    for (channel, twin) in pad.protocol.reciprocal().into_iter().enumerate() {
        let gap = volt(channel) - volt(twin?);
        off += gap * gap;
        all += volt(channel) * volt(channel);
    }
    (all > 0.0).then(|| libm::sqrt(off / all))
}

/// For each of the pad's channels its index in `there` and the sign; none if one is missing.
fn places(there: &[Channel], pad: &Pad, layout: Layout) -> Option<Vec<(usize, f32)>> {
    let swapped = |pair: Pair| Pair(pair.1, pair.0);
    let find = |drive: Pair, measure: Pair| {
        there
            .iter()
            .position(|channel| *channel == Channel { drive, measure })
    };
    let either_way = |drive: Pair, measure: Pair| {
        [
            (drive, measure, 1.0),
            (swapped(drive), swapped(measure), 1.0),
            (swapped(drive), measure, -1.0),
            (drive, swapped(measure), -1.0),
        ]
        .into_iter()
        .find_map(|(drive, measure, sign)| Some((find(drive, measure)?, sign)))
    };
    pad.protocol
        .channels
        .iter()
        .map(|channel| {
            either_way(channel.drive, channel.measure).or_else(|| match layout {
                Layout::Opposite => None,
                _ => either_way(channel.measure, channel.drive),
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::{Protocol, SHIPPED_PADS, shipped_pad};
    use crate::source::SimulatedPad;

    fn pad(name: &str) -> Pad {
        Pad::from_toml(name, shipped_pad(name).expect("shipped").toml).expect("sound")
    }

    fn rest(pad: &Pad) -> Vec<f32> {
        let volts = SimulatedPad::new(pad).and_then(|simulated| simulated.volts(&[]));
        volts
            .expect("solved")
            .into_iter()
            .map(|volt| volt as f32)
            .collect()
    }

    /// The frame that a board with this order of readings sends.
    fn sent(volts: &[f32], pad: &Pad, layout: Layout, rotated: bool, sign: f32) -> Vec<f32> {
        layout
            .stream_channels(pad.protocol.electrodes, rotated)
            .iter()
            .map(|channel| {
                let place = pad.protocol.channels.iter().position(|c| c == channel);
                place.map_or(9.0, |place| sign * volts[place])
            })
            .collect()
    }

    #[test]
    fn every_layout_order_and_sign_gives_the_pads_frame_bit_for_bit() {
        let pad = pad("edinburgh-lattice");
        let volts = rest(&pad);
        for layout in [Layout::Adjacent, Layout::AdjacentHalf, Layout::Square] {
            for (rotated, sign) in [(false, 1.0), (true, 1.0), (false, -1.0), (true, -1.0)] {
                let stream = sent(&volts, &pad, layout, rotated, sign);
                let found = Arrangement::find(&stream, None, None, &pad).expect("recognised");
                let got = found.apply(&stream);
                for (channel, (got, truth)) in got.iter().zip(&volts).enumerate() {
                    // The missing half is filled with reciprocal twins, equal up to rounding.
                    let near = (got - truth).abs() <= 1e-5 * truth.abs();
                    assert!(
                        got == truth || (layout == Layout::AdjacentHalf && near),
                        "{layout:?} {rotated} {sign} {channel}: {got} {truth}"
                    );
                }
                assert!(
                    found.summary().contains("adjacent drive"),
                    "{}",
                    found.summary()
                );
            }
        }
    }

    #[test]
    fn a_declared_order_is_used_without_recognition() {
        let pad = pad("edinburgh-lattice");
        let stream: Vec<f32> = (0..208).map(|value| value as f32).collect();
        let declared = DeclaredOrder {
            rotated: true,
            flipped: true,
        };
        let found = Arrangement::find(&stream, None, Some(declared), &pad).expect("declared");
        // The measurements of drive 2 start after it, with (4, 5), and end with (0, 1).
        assert_eq!(found.apply(&stream)[26], -stream[26 + 12]);
    }

    #[test]
    fn a_pads_own_order_is_recognised_beside_that_of_layouts() {
        let standard = pad("edinburgh-lattice");
        let volts = rest(&standard);
        let order: Vec<usize> = (0..16).map(|k| 5 * k % 16).collect();
        let spread = standard.protocol.with_drive_order(&order).expect("sound");
        let half = Layout::AdjacentHalf.stream_channels(16, false);
        let backwards = Protocol {
            electrodes: 16,
            channels: half.into_iter().rev().collect(),
        };
        for protocol in [spread, backwards] {
            let place = |channel: &Channel| {
                let all = &standard.protocol.channels;
                all.iter().position(|c| c == channel).expect("read")
            };
            let own: Vec<f32> = protocol.channels.iter().map(|c| volts[place(c)]).collect();
            let pad = Pad {
                protocol,
                ..standard.clone()
            };
            let found = Arrangement::find(&own, None, None, &pad).expect("its own");
            assert_eq!(found.apply(&own), own, "{}", found.summary());
            assert!(found.summary().ends_with("the pad's own order"));
            // A board that goes round the pad serves it too.
            let found = Arrangement::find(&volts, None, None, &pad).expect("adjacent");
            assert_eq!(found.apply(&volts), own, "{}", found.summary());
        }
    }

    #[test]
    fn a_board_of_another_protocol_is_refused() {
        let opposite = pad("openeit-lattice");
        let volts = rest(&opposite);
        let error = Arrangement::find(&volts, None, None, &pad("edinburgh-lattice"))
            .expect_err("another protocol")
            .to_string();
        assert!(
            error.starts_with("the board sends 192 voltages of opposite drive, but the pad edinburgh-lattice is measured with another protocol (208 voltages)"),
            "{error}"
        );
    }

    #[test]
    fn every_shipped_pad_takes_its_own_frames_unchanged() {
        for shipped in SHIPPED_PADS {
            let pad = pad(shipped.name);
            let volts = rest(&pad);
            let found = Arrangement::find(&volts, None, None, &pad).expect("its own");
            assert_eq!(found.apply(&volts), volts, "{}", pad.name);
            let magnitudes: Vec<f32> = volts.iter().map(|volt| volt.abs()).collect();
            let found = Arrangement::find(&magnitudes, None, None, &pad).expect("its own");
            assert_eq!(found.apply(&magnitudes), magnitudes, "{}", pad.name);
            let found = Arrangement::find(&volts, Some(&pad.protocol.channels), None, &pad);
            assert_eq!(found.expect("named").apply(&volts), volts, "{}", pad.name);
        }
    }
}
