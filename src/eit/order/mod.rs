//! Detects the order and sign of the readings of a stream from the voltages themselves.
//!
//! Boards and files list the same readings in different orders: measurements ascending from electrode 0, or "rotated",
//! starting behind the drive (EIDORS' `rotate_meas`, pyEIT's `fmmu`); with or without the driven pairs; with the meter's
//! leads either way round. Reciprocity distinguishes them: exchanging drive and measurement does not change a reading, so
//! the right order shows an error of a few percent and a wrong one of about 80 %. Opposite drives have no reciprocal
//! readings, but every drive has its reversed twin. The sign is the one that makes an adjacent pad's readings positive.
//!
//! Invariant: an [`Order`] only moves and flips readings; [`Order::apply`] returns them in the order of
//! [`Protocol::from_patterns`](crate::pad::Protocol::from_patterns).

mod layout;

pub use layout::Layout;

use crate::pad::Channel;

/// The right order has less error than this: measured pads show 2 to 5 %, wrong orders about 80 %.
pub(crate) const SURE_ERROR: f64 = 0.25;
/// The second best order must be this many times worse, or the order is ambiguous.
const SURE_RATIO: f64 = 2.0;

/// A recognised order.
#[derive(Clone, Debug, PartialEq)]
pub struct Order {
    /// Which readings the stream lists.
    pub layout: Layout,
    /// Whether the measurements of each drive start behind the drive instead of at electrode 0.
    pub rotated: bool,
    /// Whether the meter's leads are swapped; always false for opposite drives, whose readings have both signs.
    pub flipped: bool,
    /// Norm of the differences of readings that should be equal, over their norm; `None` if nothing is read twice.
    pub error: Option<f64>,
    /// For each reading in gelpad's order, its index in the stream.
    stream_indices: Vec<usize>,
}

/// Why no order is recognised.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OrderError {
    /// No layout has this number of readings.
    #[error(
        "{count} voltages per frame fit no layout of {electrodes} electrodes: adjacent has {}, its half {}, all pairs {}, opposite {}",
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
    /// A voltage is not a finite number.
    #[error("voltage {0} of the frame is not finite")]
    NotFinite(usize),
    /// Every order shows too large a reciprocity error.
    #[error(
        "no known order fits: the best one has a reciprocity error of {:.0} %; check that the electrodes are wired in order and none is loose",
        .0 * 100.0
    )]
    NoneFits(f64),
    /// Two orders fit about equally well.
    #[error("two orders fit the voltages equally well; specify the order")]
    Ambiguous,
}

impl Order {
    /// The frame in gelpad's order and sign.
    ///
    /// # Panics
    /// If the frame has another number of voltages than the recognised one.
    #[must_use]
    pub fn apply(&self, volts: &[f64]) -> Vec<f64> {
        let sign = if self.flipped { -1.0 } else { 1.0 };
        self.stream_indices
            .iter()
            .map(|index| sign * volts[*index])
            .collect()
    }

    /// For each reading in gelpad's order, its index in the stream.
    #[must_use]
    pub fn stream_indices(&self) -> &[usize] {
        &self.stream_indices
    }

    /// The order of frames of `count` voltages, as declared by the user.
    ///
    /// # Errors
    /// [`OrderError::Count`].
    pub fn from_declaration(
        count: usize,
        electrodes: usize,
        rotated: bool,
        flipped: bool,
    ) -> Result<Self, OrderError> {
        let layout =
            Layout::from_count(count, electrodes).ok_or(OrderError::Count { count, electrodes })?;
        Ok(Self {
            flipped,
            error: None,
            ..candidate(&vec![0.0; count], electrodes, layout, rotated)
        })
    }

    /// The channel of each reading in gelpad's order.
    #[must_use]
    pub fn channels(&self, electrodes: usize) -> Vec<Channel> {
        let mut channels = self.layout.stream_channels(electrodes, false);
        channels.retain(|channel| !channel.drive.shares_electrode(channel.measure));
        channels
    }
}

/// Recognises the order of a frame of an untouched or little touched pad.
///
/// # Errors
/// See [`OrderError`].
pub fn recognise_order(volts: &[f64], electrodes: usize) -> Result<Order, OrderError> {
    if let Some(index) = volts.iter().position(|volt| !volt.is_finite()) {
        return Err(OrderError::NotFinite(index));
    }
    let layouts: Vec<Layout> = Layout::ALL
        .into_iter()
        .filter(|layout| layout.readings(electrodes) == Some(volts.len()))
        .collect();
    let mut fits: Vec<Order> = layouts
        .iter()
        .flat_map(|layout| {
            // The half starts behind the drive either way: it has one order.
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

/// One order of a frame, with its reciprocity error.
fn candidate(volts: &[f64], n: usize, layout: Layout, rotated: bool) -> Order {
    let stream = layout.pairs(n, rotated);
    let mut wanted = stream.clone();
    wanted.retain(|(drive, measure)| layout.is_read(n, *drive, *measure));
    wanted.sort_unstable();
    let place = |pair: (usize, usize)| stream.iter().position(|other| *other == pair);
    let source: Vec<usize> = wanted.iter().filter_map(|pair| place(*pair)).collect();
    let twin = |(drive, measure): (usize, usize)| match layout {
        Layout::Opposite => ((drive + n / 2) % n, measure),
        _ => (measure, drive),
    };
    let value = |pair| place(pair).map(|index| volts[index]);
    let (mut off, mut all, mut pairs) = (0.0, 0.0, 0);
    for pair in &wanted {
        if let (Some(a), Some(b)) = (value(*pair), value(twin(*pair))) {
            // A reversed drive changes the sign, which boards that send magnitudes lose.
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
        stream_indices: source,
    }
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
        let mesh = Mesh::from_pad(&pad, MeshSize::reconstruction(&pad));
        let model = ForwardModel::new(mesh, &ContactModel::from_pad(&pad)).expect("solvable");
        let conductivity = model
            .mesh()
            .mean_over_triangles(|[x, y]| if x + 0.3 * y < 110.0 { 0.13 } else { 0.1 });
        model
            .solve(&conductivity)
            .expect("solved")
            .voltages(protocol)
    }

    fn adjacent(half: bool) -> Protocol {
        let pairs = Protocol::pairs_with_step(16, 1);
        Protocol::from_patterns(16, &pairs, &pairs, half).expect("adjacent")
    }

    fn opposite() -> Protocol {
        let drives = Protocol::pairs_with_step(16, 8);
        Protocol::from_patterns(16, &drives, &Protocol::pairs_with_step(16, 1), false)
            .expect("opposite")
    }

    /// What a board with this layout sends.
    fn sent(volts: &[f64], protocol: &Protocol, layout: Layout, rotated: bool) -> Vec<f64> {
        layout
            .pairs(16, rotated)
            .into_iter()
            .map(|(drive, measure)| {
                protocol
                    .channels
                    .iter()
                    .position(|c| c.drive.0 == drive && c.measure.0 == measure)
                    // Driven pairs: boards send leftovers of the last measurement.
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
                let order = recognise_order(&stream, 16).expect("recognised");
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
    fn the_order_of_a_uniform_round_tank_is_recognised() {
        let shipped = shipped_pad("round-tank").expect("shipped");
        let pad = Pad::from_toml(shipped.name, shipped.toml).expect("sound");
        let mesh = Mesh::from_pad(&pad, MeshSize::reconstruction(&pad));
        let model = ForwardModel::new(mesh, &ContactModel::from_pad(&pad)).expect("solvable");
        let volts = model
            .solve_even(1.0)
            .expect("solved")
            .voltages(&pad.protocol);
        let order = recognise_order(&volts, 16).expect("recognised");
        assert!(!order.rotated && !order.flipped);
        assert!(order.error.expect("reciprocal") < 1e-6);
    }

    #[test]
    fn ambiguous_and_invalid_frames_are_refused() {
        assert_eq!(
            recognise_order(&[1.0; 100], 16),
            Err(OrderError::Count {
                count: 100,
                electrodes: 16
            })
        );
        assert_eq!(recognise_order(&[1.0; 208], 16), Err(OrderError::Ambiguous));
        let mut volts = vec![1.0; 208];
        volts[7] = f64::NAN;
        assert_eq!(recognise_order(&volts, 16), Err(OrderError::NotFinite(7)));
    }

    proptest! {
        #[test]
        fn random_voltages_have_no_order(seed in proptest::collection::vec(0.1..1.0f64, 208)) {
            // Similar magnitudes give every order a large error.
            let volts: Vec<f64> = seed.iter().enumerate()
                .map(|(i, v)| if (i * 7) % 3 == 0 { -v } else { *v })
                .collect();
            prop_assert!(recognise_order(&volts, 16).is_err());
        }

        #[test]
        fn an_order_moves_every_reading_once(n in 5usize..33, rotated: bool) {
            for layout in [Layout::Adjacent, Layout::AdjacentHalf, Layout::Opposite] {
                let Some(count) = layout.readings(n) else { continue };
                let mut places = candidate(&vec![1.0; count], n, layout, rotated).stream_indices;
                places.sort_unstable();
                prop_assert_eq!(places, (0..count).collect::<Vec<_>>());
            }
        }
    }
}
