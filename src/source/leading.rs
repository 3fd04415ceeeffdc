//! Columns before the readings: a counter or a time stamp that a board prints at the start of each line.

/// Most columns before the readings.
const MOST_COLUMNS: usize = 3;

/// Number of columns before the readings of consecutive frames with the same number of values, if `is_plausible` accepts
/// what is left without them. A counter or a time never decreases.
#[must_use]
pub(super) fn leading_columns<'a>(
    frames: impl Iterator<Item = &'a [f32]> + Clone,
    is_plausible: impl Fn(usize) -> bool,
) -> Option<usize> {
    let count = frames.clone().next()?.len();
    if is_plausible(count) {
        return None;
    }
    let never_decreases = |column: usize| {
        let values = frames
            .clone()
            .filter_map(|frame| frame.get(column).copied());
        values.is_sorted()
    };
    (1..=MOST_COLUMNS.min(count))
        .take_while(|columns| never_decreases(columns - 1))
        .find(|columns| is_plausible(count - columns))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_counter_and_a_time_are_found() {
        let found = |frames: &[[f32; 6]], wanted: usize| {
            leading_columns(frames.iter().map(<[f32; 6]>::as_slice), |count| {
                count == wanted
            })
        };
        let both = [
            [1.0, 20.0, 5.0, 5.0, 5.0, 5.0],
            [2.0, 31.0, 4.0, 4.0, 6.0, 5.0],
            [3.0, 39.0, 6.0, 5.0, 4.0, 5.0],
        ];
        assert_eq!(found(&both, 4), Some(2));
        assert_eq!(found(&both, 5), Some(1));
        // The third column is a reading.
        assert_eq!(found(&both, 3), None);
        assert_eq!(found(&both, 6), None);
        assert_eq!(found(&[], 4), None);
    }
}
