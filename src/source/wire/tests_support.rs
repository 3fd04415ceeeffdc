//! Helpers of the formats' tests.

use super::Decoded;

pub(super) fn frames(decoded: &[Decoded]) -> Vec<Vec<f32>> {
    decoded
        .iter()
        .filter_map(|one| match one {
            Decoded::Frame(frame) => Some(frame.values.clone()),
            _ => None,
        })
        .collect()
}

pub(super) fn reasons(decoded: &[Decoded]) -> Vec<&str> {
    decoded
        .iter()
        .filter_map(|one| match one {
            Decoded::Garbled { reason, .. } => Some(reason.as_str()),
            _ => None,
        })
        .collect()
}
