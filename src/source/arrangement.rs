//! From the order in which a board lists its readings to the pad's.
//!
//! The first frames tell the order ([`recognise`]), unless the board names its drives or the player declares it. A reading
//! that the pad wants and the board lacks is taken from its reciprocal twin, so 104 readings serve a pad of 208.
//!
//! Invariant: an arrangement only moves readings and turns signs; every bit of a voltage stays.

use crate::eit::order::{Layout, Order, OrderError, recognise};
use crate::pad::{Channel, Pad, Pair};

use super::wire::DeclaredOrder;

/// Where each of a pad's readings stands in a board's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Arrangement {
    /// For each of the pad's channels the place in the frame and the sign.
    places: Vec<(usize, f32)>,
    /// Values of the board's frame.
    values: usize,
    /// In words.
    told: String,
}

/// Why a board's frames do not fit a pad.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ArrangementError {
    /// The board measures something else.
    #[error(
        "the board sends {sent}, which the pad {pad} ({wanted} voltages) is not measured with\n  help: choose the pad that the board is wired to: --pad NAME (`gelpad pad list`), or a file of your own"
    )]
    OtherProtocol {
        /// What it sends.
        sent: String,
        /// The pad.
        pad: String,
        /// Voltages of its frames.
        wanted: usize,
    },
    /// No layout has so many values.
    #[error(transparent)]
    Order(#[from] OrderError),
}

impl Arrangement {
    /// The arrangement of a board whose first frames (or their median) are these values.
    ///
    /// # Errors
    /// A board that measures with another protocol than the pad's.
    pub fn find(
        values: &[f32],
        listing: Option<&[Channel]>,
        declared: Option<DeclaredOrder>,
        pad: &Pad,
    ) -> Result<Self, ArrangementError> {
        let electrodes = pad.protocol.electrodes;
        if let Some(listing) = listing {
            return Self::of_listing(values, listing, pad);
        }
        let volts: Vec<f64> = values.iter().map(|value| f64::from(*value)).collect();
        let order = match declared {
            Some(DeclaredOrder { rotated, flipped }) => {
                Order::declared(values.len(), electrodes, rotated, flipped)
            }
            None => recognise(&volts, electrodes),
        };
        match order {
            Ok(order) => Self::of_order(&order, values.len(), pad),
            Err(error) if values.len() == pad.channels() => Ok(Self::as_it_comes(pad, &error)),
            Err(OrderError::Ambiguous | OrderError::NoneFits(_)) => {
                let order = Order::declared(values.len(), electrodes, false, false)?;
                let found = Self::of_order(&order, values.len(), pad)?;
                Ok(Self {
                    told: format!(
                        "{}; the voltages do not tell their order: not rotated is taken",
                        found.told
                    ),
                    ..found
                })
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Nothing is moved: the pad's own order is taken, and it is said why.
    fn as_it_comes(pad: &Pad, why: &OrderError) -> Self {
        let count = pad.channels();
        let why = match why {
            OrderError::NoneFits(_) => "they fit no known order",
            _ => "they do not tell their order",
        };
        Self {
            places: (0..count).map(|place| (place, 1.0)).collect(),
            values: count,
            told: format!("{count} voltages a frame; {why}, so the pad's own is taken"),
        }
    }

    fn of_order(order: &Order, count: usize, pad: &Pad) -> Result<Self, ArrangementError> {
        let electrodes = pad.protocol.electrodes;
        let told = told(order, count);
        let flip = if order.flipped { -1.0 } else { 1.0 };
        let places = places(&order.channels(electrodes), pad, order.layout)
            .ok_or_else(|| other_protocol(order.layout, count, pad))?
            .into_iter()
            .map(|(channel, sign)| (order.source()[channel], flip * sign))
            .collect();
        Ok(Self {
            places,
            values: count,
            told,
        })
    }

    fn of_listing(
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
        let turned = if flip < 0.0 { ", signs turned" } else { "" };
        let error = reciprocity_error(values, &places, pad).map_or(String::new(), |error| {
            format!(", reciprocity error {:.1} %", error * 100.0)
        });
        Ok(Self {
            places: places
                .into_iter()
                .map(|(place, sign)| (place, flip * sign))
                .collect(),
            values: listing.len(),
            told: format!(
                "{} voltages a frame, of drives that are named{turned}{error}",
                listing.len()
            ),
        })
    }

    /// A frame in the pad's order.
    ///
    /// # Panics
    /// If it has another number of values than [`Arrangement::values`].
    #[must_use]
    pub fn apply(&self, values: &[f32]) -> Vec<f32> {
        assert_eq!(values.len(), self.values);
        self.places
            .iter()
            .map(|(place, sign)| sign * values[*place])
            .collect()
    }

    /// Values of the board's frame.
    #[must_use]
    pub fn values(&self) -> usize {
        self.values
    }

    /// What was found, for the player.
    #[must_use]
    pub fn told(&self) -> &str {
        &self.told
    }
}

/// Frames of how many values may be frames of a pad.
#[must_use]
pub fn plausible_counts(pad: &Pad) -> Vec<usize> {
    let electrodes = pad.protocol.electrodes;
    let mut counts: Vec<usize> = Layout::ALL
        .into_iter()
        .map(|layout| layout.stream(electrodes, false).len())
        .filter(|count| Layout::of(*count, electrodes).is_some())
        .collect();
    counts.push(pad.channels());
    counts.sort_unstable();
    counts.dedup();
    counts
}

/// An order in words, for the player.
#[must_use]
pub fn told(order: &Order, count: usize) -> String {
    let layout = match order.layout {
        Layout::Adjacent => "adjacent drive",
        Layout::AdjacentHalf => "adjacent drive, the half without reciprocal readings",
        Layout::Square => "adjacent drive, all pairs (the driven ones are left out)",
        Layout::Opposite => "opposite drive",
    };
    let rotated = match (order.layout, order.rotated) {
        (Layout::AdjacentHalf, _) => "",
        (_, true) => ", rotated (each drive begins behind itself)",
        (_, false) => ", not rotated",
    };
    let flipped = if order.flipped { ", signs turned" } else { "" };
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

/// Norm of the differences of reciprocal readings over the norm of all; none where nothing is read twice.
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

/// For each of the pad's channels its place among those that are there, and the sign; none if one is missing.
fn places(there: &[Channel], pad: &Pad, layout: Layout) -> Option<Vec<(usize, f32)>> {
    let turned = |pair: Pair| Pair(pair.1, pair.0);
    let find = |drive: Pair, measure: Pair| {
        there
            .iter()
            .position(|channel| *channel == Channel { drive, measure })
    };
    let either_way = |drive: Pair, measure: Pair| {
        [
            (drive, measure, 1.0),
            (turned(drive), turned(measure), 1.0),
            (turned(drive), measure, -1.0),
            (drive, turned(measure), -1.0),
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
    use crate::pad::{SHIPPED_PADS, shipped_pad};
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

    /// What a board that lists its readings so would send of a pad's frame.
    fn sent(volts: &[f32], pad: &Pad, layout: Layout, rotated: bool, sign: f32) -> Vec<f32> {
        layout
            .stream(pad.protocol.electrodes, rotated)
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
                    // The half's other half is its reciprocal twin, equal to rounding.
                    let near = (got - truth).abs() <= 1e-5 * truth.abs();
                    assert!(
                        got == truth || (layout == Layout::AdjacentHalf && near),
                        "{layout:?} {rotated} {sign} {channel}: {got} {truth}"
                    );
                }
                assert!(found.told().contains("adjacent drive"), "{}", found.told());
            }
        }
    }

    #[test]
    fn what_is_declared_is_not_recognised() {
        let pad = pad("edinburgh-lattice");
        let stream: Vec<f32> = (0..208).map(|value| value as f32).collect();
        let declared = DeclaredOrder {
            rotated: true,
            flipped: true,
        };
        let found = Arrangement::find(&stream, None, Some(declared), &pad).expect("declared");
        // Drive 2 begins behind itself, with (4, 5), and ends with (0, 1).
        assert_eq!(found.apply(&stream)[26], -stream[26 + 12]);
    }

    #[test]
    fn a_board_of_another_protocol_is_told() {
        let opposite = pad("openeit-lattice");
        let volts = rest(&opposite);
        let error = Arrangement::find(&volts, None, None, &pad("edinburgh-lattice"))
            .expect_err("another protocol")
            .to_string();
        assert!(
            error.starts_with("the board sends 192 voltages of opposite drive, which the pad edinburgh-lattice (208 voltages) is not measured with"),
            "{error}"
        );
    }

    #[test]
    fn every_shipped_pad_takes_its_own_frames_as_they_are() {
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
