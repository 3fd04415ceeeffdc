//! The board's count of frames: what is missing, what arrives late or twice, and when the board has restarted.
//!
//! | number | meaning |
//! | --- | --- |
//! | the next | as it should be |
//! | up to [`LARGEST_GAP`] higher | frames are missing |
//! | the same, or up to [`LARGEST_GAP`] lower | a late or repeated frame: it is dropped |
//! | lower, but below [`FIRST_NUMBERS`], or [`RESTART_RUN`] of them in order | the board was reset |
//! | anything else | the board was reset |

/// Largest gap in the board's count that means lost or late frames; a larger one means that the board restarted.
const LARGEST_GAP: u32 = 100_000;
/// Boards that restart count from 0 or 1; the first few numbers may be lost.
const FIRST_NUMBERS: u32 = 16;
/// So many lower numbers in order are a board that continues from another number.
const RESTART_RUN: u32 = 25;

/// What the number of a frame says about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// It is new; this many before it are missing.
    New {
        /// Number of frames that are missing.
        missing: u32,
    },
    /// It arrived before, or is older than one that did.
    Older,
}

/// Follows the numbers of a board.
#[derive(Clone, Debug, Default)]
pub(super) struct Sequence {
    last: Option<u32>,
    /// The last older number, and how many came in order up to it.
    older: Option<(u32, u32)>,
}

impl Sequence {
    /// Takes the number of the next frame; boards that do not count have none.
    pub(super) fn take_number(&mut self, number: Option<u32>) -> Place {
        let (Some(before), Some(number)) = (self.last, number) else {
            self.last = number;
            return Place::New { missing: 0 };
        };
        let ahead = number.wrapping_sub(before);
        let behind = before.wrapping_sub(number);
        if behind <= LARGEST_GAP && (behind == 0 || number >= FIRST_NUMBERS) {
            let run = match self.older {
                Some((last, run)) if number == last.wrapping_add(1) => run + 1,
                _ => 1,
            };
            self.older = Some((number, run));
            if run < RESTART_RUN {
                return Place::Older;
            }
        }
        self.older = None;
        self.last = Some(number);
        let missing = match ahead {
            1..=LARGEST_GAP => ahead - 1,
            _ => 0,
        };
        Place::New { missing }
    }

    /// Whether the board counts its frames.
    pub(super) fn is_counted(&self) -> bool {
        self.last.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(numbers: impl IntoIterator<Item = u32>) -> Vec<Place> {
        let mut sequence = Sequence::default();
        let numbers = numbers.into_iter();
        numbers.map(|one| sequence.take_number(Some(one))).collect()
    }

    const NEXT: Place = Place::New { missing: 0 };

    #[test]
    fn late_and_repeated_frames_are_older() {
        assert_eq!(
            places([70, 71, 71, 73, 72, 70, 74]),
            [
                NEXT,
                NEXT,
                Place::Older,
                Place::New { missing: 1 },
                Place::Older,
                Place::Older,
                NEXT
            ]
        );
        // Across the overflow of the count.
        assert_eq!(places([u32::MAX, 16, u32::MAX, 17])[2], Place::Older);
    }

    #[test]
    fn a_board_that_restarts_is_followed() {
        assert_eq!(places([5000, 0, 1]), [NEXT; 3]);
        assert_eq!(places([5_000_000, 300, 301]), [NEXT; 3]);
        let elsewhere = places([5000].into_iter().chain(300..360));
        assert_eq!(elsewhere[1..25], [Place::Older; 24]);
        assert_eq!(elsewhere[25..], [NEXT; 36]);
    }
}
