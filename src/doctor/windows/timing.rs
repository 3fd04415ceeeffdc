//! Whether sleeps end on time.

use std::time::Duration;

use crate::doctor::CheckLine;
use crate::output::now;
use crate::platform::timer::FineTimer;

const SUBJECT: &str = "timer";
/// Sleep that is measured, and how often.
const SLEEP: Duration = Duration::from_millis(1);
const ROUNDS: usize = 51;
/// Longest median that is not worth a word.
const FINE: Duration = Duration::from_millis(4);

pub(super) fn check() -> CheckLine {
    let _fine_sleeps = FineTimer::request();
    let mut lengths: Vec<Duration> = (0..ROUNDS)
        .map(|_| {
            let start = now();
            std::thread::park_timeout(SLEEP);
            now().saturating_duration_since(start)
        })
        .collect();
    lengths.sort_unstable();
    judge(lengths[ROUNDS / 2])
}

fn judge(median: Duration) -> CheckLine {
    let ms = median.as_secs_f64() * 1000.0;
    match median <= FINE {
        true => CheckLine::ok(SUBJECT, format!("a sleep of 1 ms takes {ms:.1} ms")),
        false => CheckLine::note(
            SUBJECT,
            format!("a sleep of 1 ms takes {ms:.1} ms: events are late by up to that"),
        )
        .with_fix("turn off the battery saver"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::CheckStatus;

    #[test]
    fn the_ordinary_tick_of_windows_is_too_coarse() {
        assert_eq!(judge(Duration::from_micros(1900)).state, CheckStatus::Ok);
        assert_eq!(
            judge(Duration::from_micros(15_600)).state,
            CheckStatus::Note
        );
    }
}
