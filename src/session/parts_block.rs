//! Parts of frames in the JSON of a recording.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD_NO_PAD as BASE64;
use serde::{Deserialize, Serialize};

use super::lines::LATEST_NS;
use super::volts::{self, MOST_CHANNELS, VoltsDecoder, VoltsEncoder};
use crate::types::{Nanos, Part};

/// Most voltages of a block.
pub(super) const MOST_VOLTS: usize = MOST_CHANNELS;

/// Consecutive parts.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PartBlock {
    /// Time of the first part.
    t_ns: Nanos,
    /// Time from each part to the next.
    dt_ns: Vec<Nanos>,
    /// First channel of each part, ...
    first: Vec<usize>,
    /// ... and number of its voltages.
    count: Vec<usize>,
    /// So many frames that the voltages are stored as: 1 if the parts are not those of whole frames.
    frames: usize,
    /// Base64 of a block of [`volts`].
    volts: String,
}

impl PartBlock {
    pub(super) fn new(parts: &[Part], encoder: Option<&mut VoltsEncoder>) -> Self {
        let all: Vec<f32> = parts
            .iter()
            .flat_map(|part| part.volts.iter().copied())
            .collect();
        let channels = channels_of_frames(parts);
        let (frames, bytes) = match (channels, encoder) {
            (Some(channels), Some(encoder)) => {
                let frames: Vec<&[f32]> = all.chunks_exact(channels).collect();
                (frames.len(), encoder.encode(&frames))
            }
            _ => (1, volts::plain(&[&all])),
        };
        Self {
            t_ns: parts.first().map_or(0, |part| part.t_ns),
            dt_ns: parts
                .windows(2)
                .map(|pair| pair[1].t_ns.wrapping_sub(pair[0].t_ns))
                .collect(),
            first: parts.iter().map(|part| part.first).collect(),
            count: parts.iter().map(|part| part.volts.len()).collect(),
            frames,
            volts: BASE64.encode(bytes),
        }
    }

    pub(super) fn into_parts(self, decoder: &mut VoltsDecoder) -> Result<Vec<Part>, String> {
        let parts = self.count.len();
        let spans = self.first.iter().zip(&self.count);
        let are_small = spans
            .clone()
            .all(|(first, count)| *count > 0 && first.saturating_add(*count) <= MOST_CHANNELS);
        if self.first.len() != parts || self.dt_ns.len() + 1 != parts || !are_small {
            return Err("parts of different numbers".to_owned());
        }
        let bytes = BASE64
            .decode(&self.volts)
            .map_err(|error| error.to_string())?;
        let frames = decoder
            .decode(self.frames, &bytes)
            .map_err(|error| error.to_string())?;
        let all = frames.concat();
        if all.len() != self.count.iter().sum::<usize>() {
            return Err("parts with other voltages than they say".to_owned());
        }
        let mut rest = all.as_slice();
        let mut t_ns = self.t_ns;
        let mut dt_ns = self.dt_ns.iter();
        let mut found = Vec::with_capacity(parts);
        for (first, count) in spans {
            let (volts, after) = rest.split_at(*count);
            rest = after;
            if t_ns > LATEST_NS {
                return Err("a time out of range".to_owned());
            }
            found.push(Part {
                t_ns,
                first: *first,
                volts: volts.to_vec(),
            });
            t_ns = t_ns.wrapping_add(dt_ns.next().copied().unwrap_or(0));
        }
        Ok(found)
    }
}

/// Number of channels of a frame, if the parts are those of whole frames of one pad.
fn channels_of_frames(parts: &[Part]) -> Option<usize> {
    let mut channels = None;
    let mut next = 0;
    for part in parts {
        if part.first == 0 && next > 0 {
            if *channels.get_or_insert(next) != next {
                return None;
            }
            next = 0;
        }
        if part.first != next {
            return None;
        }
        next += part.volts.len();
    }
    (*channels.get_or_insert(next) == next).then_some(next)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn part(t_ns: Nanos, first: usize, count: usize) -> Part {
        let volts = (first..first + count).map(|k| 1.0 + 0.25 * k as f32 + 1e-3 * t_ns as f32);
        Part {
            t_ns,
            first,
            volts: volts.collect(),
        }
    }

    /// Parts that are written and read again, with and without compression.
    fn round_trips(blocks: &[Vec<Part>]) {
        let (mut encoder, mut decoder) = (VoltsEncoder::default(), VoltsDecoder::default());
        for parts in blocks {
            let packed = PartBlock::new(parts, Some(&mut encoder));
            assert_eq!(&packed.into_parts(&mut decoder).expect("sound"), parts);
            let plain = PartBlock::new(parts, None);
            let mut fresh = VoltsDecoder::default();
            assert_eq!(&plain.into_parts(&mut fresh).expect("sound"), parts);
        }
    }

    #[test]
    fn whole_frames_are_compressed_as_frames_and_other_parts_are_kept_too() {
        let frame = |t: Nanos| vec![part(t, 0, 3), part(t + 1, 3, 3), part(t + 2, 6, 2)];
        let frames: Vec<Part> = (0..8).flat_map(|n| frame(10 * n)).collect();
        assert_eq!(channels_of_frames(&frames), Some(8));
        let lost = vec![part(100, 0, 3), part(101, 6, 2), part(102, 0, 3)];
        assert_eq!(channels_of_frames(&lost), None);
        round_trips(&[frames.clone(), lost, frames]);
    }

    proptest! {
        #[test]
        fn all_parts_are_read_back(
            all in proptest::collection::vec((0..9u64, 0..6usize, 1..5usize), 1..40),
        ) {
            let mut t_ns = 0;
            let parts = all.iter().map(|(dt, first, count)| {
                t_ns += dt;
                part(t_ns, *first, *count)
            });
            round_trips(&[parts.collect()]);
        }

        #[test]
        fn no_text_makes_it_panic(
            first in proptest::collection::vec(any::<usize>(), 0..4),
            count in proptest::collection::vec(any::<usize>(), 0..4),
            frames: usize,
        ) {
            let block = PartBlock {
                t_ns: 0,
                dt_ns: vec![0; count.len().saturating_sub(1)],
                first,
                count,
                frames,
                volts: BASE64.encode(volts::plain(&[&[1.0; 4]])),
            };
            let _ = block.into_parts(&mut VoltsDecoder::default());
        }
    }
}
