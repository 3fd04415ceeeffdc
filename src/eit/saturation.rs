//! Readings at the end of the converter's range.
//!
//! A board whose gain is set too high reads its largest voltages as one and the same number. Such a reading does not move with a touch, or
//! only by a part, which looks like another touch beside it. So it is left out.

/// Where the converter's steps show, one reading may be steady by chance: so many at least agree.
const LEAST_ROUNDED: usize = 2;
/// A steady reading shows saturation only if noise would move it. So of this share of the other readings, the next largest, ...
const NEXT_SHARE: f64 = 0.25;
/// ... at most this share is steady: otherwise the board repeats a frame, or rounds so coarsely that noise does not show.
const MOST_STEADY: f64 = 0.5;

/// The channels, counted from 0, that read the largest number of some frames, or the lowest one below zero, in each of them.
/// `is_rounded`: whether the converter's steps show.
pub(crate) fn saturated_channels(frames: &[Vec<f32>], is_rounded: bool) -> Vec<usize> {
    let Some(first) = frames.first() else {
        return Vec::new();
    };
    let readings = || frames.iter().flatten().copied();
    let ends = [
        readings().fold(0.0, f32::max),
        readings().fold(0.0, f32::min),
    ];
    let is_steady = |channel: usize| {
        let mut all = frames.iter();
        all.all(|frame| frame[channel] == first[channel])
    };
    let is_at_end = |channel: usize| {
        let volt = first[channel];
        volt != 0.0 && ends.contains(&volt) && is_steady(channel)
    };
    let (mut at_end, mut others): (Vec<usize>, Vec<usize>) =
        (0..first.len()).partition(|channel| is_at_end(*channel));
    if at_end.len() > others.len() {
        return Vec::new();
    }
    others.sort_by(|a, b| first[*b].abs().total_cmp(&first[*a].abs()));
    others.truncate((NEXT_SHARE * others.len() as f64).ceil() as usize);
    let steady = others.iter().filter(|channel| is_steady(**channel)).count();
    if steady as f64 > MOST_STEADY * others.len() as f64 {
        return Vec::new();
    }
    let least = if is_rounded { LEAST_ROUNDED } else { 1 };
    for end in ends {
        let is_here = |channel: &usize| first[*channel] == end;
        if at_end.iter().filter(|channel| is_here(channel)).count() < least {
            at_end.retain(|channel| !is_here(channel));
        }
    }
    at_end
}

#[cfg(test)]
mod tests {
    use super::saturated_channels;

    /// Frames of readings whose last digits waver, cut at +-`full`.
    fn frames(readings: &[f32], full: f32) -> Vec<Vec<f32>> {
        let wavering = |frame: usize| {
            let noise = |channel: usize| ((frame * 7 + channel * 3) % 5) as f32 * 1e-3;
            let volts = readings.iter().enumerate();
            volts
                .map(|(channel, volt)| (volt + noise(channel)).clamp(-full, full))
                .collect()
        };
        (0..10).map(wavering).collect()
    }

    const READINGS: [f32; 8] = [5.0, -4.0, 1.0, 2.0, 6.0, 0.5, -7.0, 3.0];

    #[test]
    fn readings_at_either_end_are_saturated() {
        let cut = frames(&READINGS, 3.5);
        assert_eq!(saturated_channels(&cut, false), [0, 1, 4, 6]);
        assert_eq!(saturated_channels(&cut, true), [0, 1, 4, 6]);
    }

    #[test]
    fn a_single_steady_reading_is_saturated_only_where_noise_would_show() {
        let cut = frames(&READINGS[..6], 5.5);
        assert_eq!(saturated_channels(&cut, false), [4]);
        assert!(saturated_channels(&cut, true).is_empty());
    }

    #[test]
    fn readings_within_the_range_are_not_saturated() {
        assert!(saturated_channels(&frames(&READINGS, 10.0), false).is_empty());
    }

    #[test]
    fn small_readings_that_never_change_hide_no_saturation() {
        let mut readings = [0.0; 16];
        readings[..8].copy_from_slice(&READINGS);
        let mut cut = frames(&readings, 3.5);
        for frame in &mut cut {
            frame[8..].fill(0.25);
        }
        assert_eq!(saturated_channels(&cut, true), [0, 1, 4, 6]);
    }

    #[test]
    fn a_board_that_repeats_a_frame_or_reads_nothing_is_not_saturated() {
        assert!(saturated_channels(&vec![vec![1.0; 8]; 10], false).is_empty());
        assert!(saturated_channels(&vec![vec![0.0; 8]; 10], false).is_empty());
        let mut almost = vec![vec![1.0; 8]; 10];
        almost[3][2] = 0.5;
        assert!(saturated_channels(&almost, false).is_empty());
        assert!(saturated_channels(&[], false).is_empty());
    }
}
