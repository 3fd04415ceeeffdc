//! Which order and sign a stream of voltages has, told from the voltages themselves.
//!
//! Boards and files list the same readings in different orders: measurements ascending from electrode 0, or "rotated",
//! starting behind the drive (EIDORS' `rotate_meas`, pyEIT's `fmmu`); with or without the driven pairs; with the meter's
//! leads either way round. Reciprocity tells them apart: exchanging drive and measurement leaves a reading, so the right
//! order shows an error of a few per cent and a wrong one of about 80. Opposite drives have no reciprocal readings, but
//! every drive has its reversed twin. The sign is the one that makes an adjacent pad's readings positive.
//!
//! Invariant: an [`Order`] only moves and flips readings; [`Order::apply`] gives them in the order of
//! [`Protocol::crossed`](crate::pad::Protocol::crossed), whatever the stream's was.

use crate::pad::{Channel, Pair};

/// A right order shows less than this: measured pads show 2 to 5 %, wrong orders about 80 %.
const SURE_ERROR: f64 = 0.25;
/// The second best order must be this many times worse, else the voltages do not tell.
const SURE_RATIO: f64 = 2.0;

/// What a stream lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// Adjacent drive and measurement without the pairs that meet the drive: n (n - 3), 208 for 16 electrodes.
    Adjacent,
    /// The half of these that reciprocity leaves: n (n - 3) / 2, 104 for 16 electrodes.
    AdjacentHalf,
    /// Every adjacent pair for every adjacent drive, the driven ones too: n x n, 256 for 16 electrodes.
    Square,
    /// Opposite drive with adjacent measurement: n (n - 4), 192 for 16 electrodes.
    Opposite,
}

/// A recognised order.
#[derive(Clone, Debug, PartialEq)]
pub struct Order {
    /// What the stream lists.
    pub layout: Layout,
    /// Whether each drive's measurements begin behind the drive instead of at electrode 0.
    pub rotated: bool,
    /// Whether the meter's leads are the other way round; always false for opposite drives, whose readings have both
    /// signs.
    pub flipped: bool,
    /// Norm of the differences of what should be equal over the norm of all; none where nothing is read twice.
    pub error: Option<f64>,
    /// For each reading in gelpad's order, its place in the stream.
    source: Vec<usize>,
}

/// Why no order is recognised.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OrderError {
    /// No layout has that many readings.
    #[error(
        "{count} voltages a frame fit no layout of {electrodes} electrodes: adjacent gives {}, its half {}, all pairs {}, opposite {}",
        .electrodes * (.electrodes.saturating_sub(3)),
        .electrodes * (.electrodes.saturating_sub(3)) / 2,
        .electrodes * .electrodes,
        .electrodes * (.electrodes.saturating_sub(4))
    )]
    Count {
        /// Voltages in the frame.
        count: usize,
        /// Electrodes of the pad.
        electrodes: usize,
    },
    /// A voltage is no number.
    #[error("voltage {0} of the frame is not finite")]
    NotFinite(usize),
    /// No order makes equal what must be.
    #[error(
        "no known order fits: the best shows a reciprocity error of {:.0} %; check that the electrodes are wired in order and none is loose",
        .0 * 100.0
    )]
    NoneFits(f64),
    /// Two orders fit alike.
    #[error("the voltages do not tell their order: two fit alike; give the order by hand")]
    Ambiguous,
}

impl Order {
    /// The frame in gelpad's order and sign.
    ///
    /// # Panics
    /// If the frame has another number of voltages than the one that was recognised.
    #[must_use]
    pub fn apply(&self, volts: &[f64]) -> Vec<f64> {
        let sign = if self.flipped { -1.0 } else { 1.0 };
        self.source
            .iter()
            .map(|index| sign * volts[*index])
            .collect()
    }

    /// For each reading in gelpad's order, its place in the stream.
    #[must_use]
    pub fn source(&self) -> &[usize] {
        &self.source
    }

    /// The order that someone declares for frames of so many voltages.
    ///
    /// # Errors
    /// [`OrderError::Count`].
    pub fn declared(
        count: usize,
        electrodes: usize,
        rotated: bool,
        flipped: bool,
    ) -> Result<Self, OrderError> {
        let layout =
            Layout::of(count, electrodes).ok_or(OrderError::Count { count, electrodes })?;
        Ok(Self {
            flipped,
            error: None,
            ..candidate(&vec![0.0; count], electrodes, layout, rotated)
        })
    }

    /// What each reading in gelpad's order is a reading of.
    #[must_use]
    pub fn channels(&self, electrodes: usize) -> Vec<Channel> {
        let mut pairs = listed(self.layout, electrodes, false);
        if self.layout == Layout::Square {
            pairs.retain(|(drive, measure)| !meets(electrodes, *drive, *measure, 1));
        }
        pairs
            .into_iter()
            .map(|(drive, measure)| channel(self.layout, electrodes, drive, measure))
            .collect()
    }
}

impl Layout {
    /// The layout of frames of so many voltages.
    #[must_use]
    pub fn of(voltages: usize, electrodes: usize) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|layout| count(*layout, electrodes) == Some(voltages))
    }

    /// All layouts.
    pub const ALL: [Self; 4] = [
        Self::Adjacent,
        Self::AdjacentHalf,
        Self::Square,
        Self::Opposite,
    ];

    /// What a stream of this layout lists, in its order; the driven pairs of a square too.
    #[must_use]
    pub fn stream(self, electrodes: usize, rotated: bool) -> Vec<Channel> {
        listed(self, electrodes, rotated)
            .into_iter()
            .map(|(drive, measure)| channel(self, electrodes, drive, measure))
            .collect()
    }
}

fn channel(layout: Layout, n: usize, drive: usize, measure: usize) -> Channel {
    let step = match layout {
        Layout::Opposite => n / 2,
        _ => 1,
    };
    Channel {
        drive: Pair(drive, (drive + step) % n),
        measure: Pair(measure, (measure + 1) % n),
    }
}

/// Recognises the order of a frame of an untouched or little touched pad.
///
/// # Errors
/// See [`OrderError`].
pub fn recognise(volts: &[f64], electrodes: usize) -> Result<Order, OrderError> {
    if let Some(index) = volts.iter().position(|volt| !volt.is_finite()) {
        return Err(OrderError::NotFinite(index));
    }
    let layouts: Vec<Layout> = Layout::ALL
        .into_iter()
        .filter(|layout| count(*layout, electrodes) == Some(volts.len()))
        .collect();
    let mut fits: Vec<Order> = layouts
        .iter()
        .flat_map(|layout| {
            // The half begins behind the drive either way: its order is one.
            let rotations: &[bool] = match layout {
                Layout::AdjacentHalf => &[false],
                _ => &[false, true],
            };
            rotations
                .iter()
                .map(|rotated| candidate(volts, electrodes, *layout, *rotated))
        })
        .collect();
    let measure = |order: &Order| order.error.unwrap_or(0.0);
    fits.sort_by(|a, b| measure(a).total_cmp(&measure(b)));
    let Some(best) = fits.first() else {
        return Err(OrderError::Count {
            count: volts.len(),
            electrodes,
        });
    };
    let error = measure(best);
    if error > SURE_ERROR {
        return Err(OrderError::NoneFits(error));
    }
    if fits
        .get(1)
        .is_some_and(|second| measure(second) < SURE_RATIO * error.max(f64::EPSILON))
    {
        return Err(OrderError::Ambiguous);
    }
    Ok(best.clone())
}

/// Readings of a layout; none where it needs more electrodes.
fn count(layout: Layout, n: usize) -> Option<usize> {
    match layout {
        Layout::Adjacent if n >= 5 => Some(n * (n - 3)),
        Layout::AdjacentHalf if n >= 5 => Some(n * (n - 3) / 2),
        Layout::Square if n >= 5 => Some(n * n),
        Layout::Opposite if n >= 6 && n.is_multiple_of(2) => Some(n * (n - 4)),
        _ => None,
    }
}

/// The frame read in one order, with what that makes of reciprocity.
fn candidate(volts: &[f64], n: usize, layout: Layout, rotated: bool) -> Order {
    let stream = listed(layout, n, rotated);
    let mut wanted: Vec<(usize, usize)> = stream
        .iter()
        .copied()
        .filter(|(drive, measure)| layout != Layout::Square || !meets(n, *drive, *measure, 1))
        .collect();
    wanted.sort_unstable();
    let place = |pair: (usize, usize)| stream.iter().position(|listed| *listed == pair);
    let source: Vec<usize> = wanted.iter().filter_map(|pair| place(*pair)).collect();
    let twin = |(drive, measure): (usize, usize)| match layout {
        Layout::Opposite => ((drive + n / 2) % n, measure),
        _ => (measure, drive),
    };
    let value = |pair| place(pair).map(|index| volts[index]);
    let (mut off, mut all, mut pairs) = (0.0, 0.0, 0);
    for pair in &wanted {
        if let (Some(a), Some(b)) = (value(*pair), value(twin(*pair))) {
            // A reversed drive turns the sign; boards that send magnitudes lose it.
            let gap = match layout {
                Layout::Opposite => a.abs() - b.abs(),
                _ => a - b,
            };
            off += gap * gap;
            all += a * a;
            pairs += 1;
        }
    }
    let sum: f64 = source.iter().map(|index| volts[*index]).sum();
    Order {
        layout,
        rotated,
        flipped: layout != Layout::Opposite && sum < 0.0,
        error: (pairs > 0).then(|| {
            if all > 0.0 {
                libm::sqrt(off / all)
            } else {
                1.0
            }
        }),
        source,
    }
}

/// Drive and measurement of every reading in the order of a stream.
fn listed(layout: Layout, n: usize, rotated: bool) -> Vec<(usize, usize)> {
    let step = match layout {
        Layout::Opposite => n / 2,
        _ => 1,
    };
    (0..n)
        .flat_map(|drive| {
            (0..n)
                .map(move |k| if rotated { (drive + k) % n } else { k })
                .filter(move |measure| match layout {
                    Layout::Square => true,
                    Layout::AdjacentHalf => *measure > drive && !meets(n, drive, *measure, step),
                    Layout::Adjacent | Layout::Opposite => !meets(n, drive, *measure, step),
                })
                .map(move |measure| (drive, measure))
        })
        .collect()
}

/// Whether the measurement (m, m + 1) shares an electrode with the drive (i, i + step).
fn meets(n: usize, drive: usize, measure: usize, step: usize) -> bool {
    [drive, (drive + step) % n]
        .iter()
        .any(|electrode| *electrode == measure || *electrode == (measure + 1) % n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eit::{ContactModel, ForwardModel, Mesh, MeshSize};
    use crate::pad::{Pad, Protocol, shipped_pad};
    use proptest::prelude::*;

    /// Voltages of the round tank with its left half more conductive, so that no symmetry hides a wrong order.
    fn tank_volts(protocol: &Protocol) -> Vec<f64> {
        let shipped = shipped_pad("round-tank").expect("shipped");
        let pad = Pad::from_toml(shipped.name, shipped.toml).expect("sound");
        let mesh = Mesh::of_pad(&pad, MeshSize::reconstruction(&pad));
        let model = ForwardModel::new(mesh, &ContactModel::of_pad(&pad)).expect("solvable");
        let conductivity = model
            .mesh()
            .mean_over_triangles(|[x, y]| if x + 0.3 * y < 110.0 { 0.13 } else { 0.1 });
        model
            .solve(&conductivity)
            .expect("solved")
            .voltages(protocol)
    }

    fn adjacent(half: bool) -> Protocol {
        let pairs = Protocol::stepped(16, 1);
        Protocol::crossed(16, &pairs, &pairs, half).expect("adjacent")
    }

    fn opposite() -> Protocol {
        let drives = Protocol::stepped(16, 8);
        Protocol::crossed(16, &drives, &Protocol::stepped(16, 1), false).expect("opposite")
    }

    /// What a board that lists its readings so would send.
    fn sent(volts: &[f64], protocol: &Protocol, layout: Layout, rotated: bool) -> Vec<f64> {
        listed(layout, 16, rotated)
            .into_iter()
            .map(|(drive, measure)| {
                protocol
                    .channels
                    .iter()
                    .position(|c| c.drive.0 == drive && c.measure.0 == measure)
                    // Driven pairs: boards send what the last measurement left there.
                    .map_or(9.0, |index| volts[index])
            })
            .collect()
    }

    #[test]
    fn every_layout_order_and_sign_is_recognised_under_noise() {
        let cases = [
            (Layout::Adjacent, adjacent(false)),
            (Layout::AdjacentHalf, adjacent(true)),
            (Layout::Square, adjacent(false)),
            (Layout::Opposite, opposite()),
        ];
        for (layout, protocol) in cases {
            let volts = tank_volts(&protocol);
            for (rotated, sign) in [(false, 1.0), (false, -1.0), (true, 1.0), (true, -1.0)] {
                let mut noise = 0.0_f64;
                let stream: Vec<f64> = sent(&volts, &protocol, layout, rotated)
                    .iter()
                    .map(|volt| {
                        noise = (noise + 0.618_034).fract();
                        sign * volt * (1.0 + 0.02 * (noise - 0.5))
                    })
                    .collect();
                let order = recognise(&stream, 16).expect("recognised");
                assert_eq!(order.layout, layout);
                assert_eq!(order.rotated, rotated && layout != Layout::AdjacentHalf);
                let back = order.apply(&stream);
                assert_eq!(back.len(), volts.len());
                let expected_sign = if layout == Layout::Opposite {
                    sign
                } else {
                    1.0
                };
                for (got, truth) in back.iter().zip(&volts) {
                    assert!((got - expected_sign * truth).abs() <= 0.011 * truth.abs());
                }
            }
        }
    }

    #[test]
    fn an_even_round_tank_is_told_too() {
        let shipped = shipped_pad("round-tank").expect("shipped");
        let pad = Pad::from_toml(shipped.name, shipped.toml).expect("sound");
        let mesh = Mesh::of_pad(&pad, MeshSize::reconstruction(&pad));
        let model = ForwardModel::new(mesh, &ContactModel::of_pad(&pad)).expect("solvable");
        let volts = model
            .solve_even(1.0)
            .expect("solved")
            .voltages(&pad.protocol);
        let order = recognise(&volts, 16).expect("recognised");
        assert!(!order.rotated && !order.flipped);
        assert!(order.error.expect("reciprocal") < 1e-6);
    }

    #[test]
    fn what_tells_nothing_is_refused() {
        assert_eq!(
            recognise(&[1.0; 100], 16),
            Err(OrderError::Count {
                count: 100,
                electrodes: 16
            })
        );
        assert_eq!(recognise(&[1.0; 208], 16), Err(OrderError::Ambiguous));
        let mut volts = vec![1.0; 208];
        volts[7] = f64::NAN;
        assert_eq!(recognise(&volts, 16), Err(OrderError::NotFinite(7)));
    }

    proptest! {
        #[test]
        fn random_voltages_are_no_order(seed in proptest::collection::vec(0.1..1.0f64, 208)) {
            // Magnitudes alike, so that the error is large whatever the order: nothing is recognised.
            let volts: Vec<f64> = seed.iter().enumerate()
                .map(|(i, v)| if (i * 7) % 3 == 0 { -v } else { *v })
                .collect();
            prop_assert!(recognise(&volts, 16).is_err());
        }

        #[test]
        fn an_order_moves_every_reading_once(n in 5usize..33, rotated: bool) {
            for layout in [Layout::Adjacent, Layout::AdjacentHalf, Layout::Opposite] {
                let Some(count) = count(layout, n) else { continue };
                let mut places = candidate(&vec![1.0; count], n, layout, rotated).source;
                places.sort_unstable();
                prop_assert_eq!(places, (0..count).collect::<Vec<_>>());
            }
        }
    }
}
