//! Reports data of a source that is not a frame, without flooding the terminal.

/// Reasons that are logged in full before only every [`EVERY`]th is.
const FIRST: u64 = 5;
/// A board sends a hundred frames a second.
const EVERY: u64 = 100;
/// So much in a row without a frame means that the board measures something else. Another baud rate, where nothing looks like a
/// frame, is an error of the source ([`super::Source::require_frames`]).
const MOST_IN_A_ROW: u64 = 500;

/// A source sends nothing but data that is not a frame of the pad.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the board sends no frame of this pad: {reason}\n  help: `gelpad listen` shows what it sends and names pads that fit"
)]
pub struct NoFrames {
    /// Why the last data was not a frame.
    pub reason: String,
}

/// Counts what is skipped.
#[derive(Clone, Debug, Default)]
pub struct SkipLog {
    total: u64,
    in_a_row: u64,
}

impl SkipLog {
    /// A frame has arrived.
    pub fn frame(&mut self) {
        self.in_a_row = 0;
    }

    /// Logs the first reasons, then every hundredth.
    ///
    /// # Errors
    /// Far too much in a row was not a frame.
    pub fn skip(&mut self, reason: String) -> Result<(), NoFrames> {
        self.total += 1;
        self.in_a_row += 1;
        if self.in_a_row >= MOST_IN_A_ROW {
            return Err(NoFrames { reason });
        }
        if self.total <= FIRST || self.total.is_multiple_of(EVERY) {
            tracing::warn!(
                "skipped data that is not a frame ({} so far): {reason}",
                self.total
            );
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn skipping_ends_only_if_no_frame_comes_between() {
        let mut log = SkipLog::default();
        for _ in 0..10 {
            for _ in 1..MOST_IN_A_ROW {
                assert_eq!(log.skip("cut".to_owned()), Ok(()));
            }
            log.frame();
        }
        for _ in 1..MOST_IN_A_ROW {
            assert_eq!(log.skip("108 values".to_owned()), Ok(()));
        }
        let error = log.skip("108 values".to_owned()).expect_err("no frame");
        assert!(error.to_string().contains("108 values"), "{error}");
    }
}
