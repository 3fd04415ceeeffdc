//! Whether a board lists its readings in the pad's own order where no layout has that order: the pad's text lists its channels,
//! or reads its drives in another order.
//!
//! Such an order is checked like the known ones (`eit::order`): readings of the same thing must agree.

use crate::eit::order::{Layout, SURE_ERROR};
use crate::pad::{Channel, Pad, Pair};

/// At least this share of the readings must be taken twice, or they prove nothing and the pad's text is believed.
const FEWEST_TWINS_SHARE: f64 = 0.25;

/// Whether these values of a frame are the pad's channels in the order of its text. False for pads in the order of a layout.
pub(super) fn is_own_order(values: &[f32], pad: &Pad) -> bool {
    let protocol = &pad.protocol;
    values.len() == pad.channels()
        && Layout::of_channels(&protocol.channels, protocol.electrodes).is_none()
        && twin_error(values, &protocol.channels).is_none_or(|error| error < SURE_ERROR)
}

/// Norm of the differences of magnitudes that should be equal, over the norm of all; `None` with too few twins.
fn twin_error(values: &[f32], channels: &[Channel]) -> Option<f64> {
    let place: std::collections::HashMap<Channel, usize> = channels
        .iter()
        .enumerate()
        .map(|(index, channel)| (*channel, index))
        .collect();
    let (mut off, mut all, mut twins) = (0.0, 0.0, 0);
    for (channel, value) in channels.iter().zip(values) {
        let reversed = Pair(channel.drive.1, channel.drive.0);
        let twin = [
            (channel.measure, channel.drive),
            (reversed, channel.measure),
        ]
        .into_iter()
        .find_map(|(drive, measure)| place.get(&Channel { drive, measure }));
        if let Some(twin) = twin {
            let size = f64::from(value.abs());
            off += (size - f64::from(values[*twin].abs())).powi(2);
            all += size * size;
            twins += 1;
        }
    }
    let is_enough = twins as f64 >= FEWEST_TWINS_SHARE * channels.len() as f64;
    (is_enough && all > 0.0).then(|| libm::sqrt(off / all))
}
