//! What error to expect with the presses made so far: estimated beside the presses, since that takes up to half a second.
//!
//! One estimate runs at a time. Presses that come meanwhile wait; of those only the latest count.

use std::sync::mpsc;
use std::thread;

use crate::calibrate::{FEWEST_PRESSES, Press, Presses, fit_correction};

/// What presses promise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ExpectedError {
    /// Number of presses.
    pub presses: usize,
    /// Mean error of a lone touch with a calibration from them, mm, by leaving each press out in turn.
    pub calibrated_mm: f64,
    /// The same without a calibration.
    pub model_mm: f64,
}

impl std::fmt::Display for ExpectedError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            presses,
            calibrated_mm,
            model_mm,
        } = self;
        write!(
            f,
            "expected error with {presses} presses: {calibrated_mm:.1} mm ({model_mm:.1} without a calibration)"
        )
    }
}

/// Estimates beside the presses.
#[derive(Debug, Default)]
pub(crate) struct ErrorEstimate {
    running: Option<mpsc::Receiver<Option<ExpectedError>>>,
    waiting: Option<Vec<Press>>,
    size_mm: [f64; 2],
}

impl ErrorEstimate {
    /// Begins to estimate for all presses so far, on a pad of the given size.
    pub(crate) fn begin(&mut self, presses: &[Press], size_mm: [f64; 2]) {
        if presses.len() < FEWEST_PRESSES {
            return;
        }
        self.size_mm = size_mm;
        self.waiting = Some(presses.to_vec());
        self.start();
    }

    /// A finished estimate, once.
    pub(crate) fn poll(&mut self) -> Option<ExpectedError> {
        let found = match self.running.as_ref()?.try_recv() {
            Err(mpsc::TryRecvError::Empty) => return None,
            Ok(found) => found,
            // Its thread is gone: nothing is known.
            Err(mpsc::TryRecvError::Disconnected) => None,
        };
        self.running = None;
        self.start();
        found
    }

    fn start(&mut self) {
        if self.running.is_some() {
            return;
        }
        let Some(presses) = self.waiting.take() else {
            return;
        };
        let size_mm = self.size_mm;
        let (sender, receiver) = mpsc::sync_channel(1);
        let spawned = thread::Builder::new()
            .name("expected error".to_owned())
            .spawn(move || {
                // Whoever asked may be gone.
                let _ = sender.send(expected_error(presses, size_mm));
            });
        // Without a thread there is no estimate; the presses count all the same.
        self.running = spawned.is_ok().then_some(receiver);
    }
}

/// The error to expect; none if nothing can be learned from the presses yet.
fn expected_error(list: Vec<Press>, size_mm: [f64; 2]) -> Option<ExpectedError> {
    let presses = Presses::new("the presses", list).ok()?;
    let fitted = fit_correction(&presses, size_mm).ok()?;
    Some(ExpectedError {
        presses: presses.len(),
        calibrated_mm: fitted.lone.mean_mm,
        model_mm: fitted.model.mean_mm,
    })
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::calibrate::ModelPrediction;

    fn press(index: usize) -> Press {
        let place_mm = [
            10.0 + 80.0 * (0.75 * index as f64).fract(),
            10.0 + 80.0 * (0.57 * index as f64).fract(),
        ];
        Press {
            place_mm,
            modelled: Some(ModelPrediction {
                force: 0.5,
                place_mm: [place_mm[0] + 3.0, place_mm[1] - 1.0],
            }),
            changes: (0..8)
                .map(|c| 0.01 * (place_mm[0] + f64::from(c) * place_mm[1]))
                .collect(),
        }
    }

    #[test]
    fn the_latest_presses_are_estimated_while_more_come() {
        let mut estimate = ErrorEstimate::default();
        let mut list: Vec<Press> = (0..FEWEST_PRESSES - 1).map(press).collect();
        estimate.begin(&list, [100.0; 2]);
        assert!(estimate.running.is_none(), "too few to learn from");
        for index in list.len()..30 {
            list.push(press(index));
            estimate.begin(&list, [100.0; 2]);
        }
        let mut last = None;
        // At most a minute.
        for _ in 0..60_000 {
            last = estimate.poll().or(last);
            if last.is_some_and(|found: ExpectedError| found.presses == 30) {
                break;
            }
            thread::sleep(Duration::from_millis(1));
        }
        let last = last.expect("estimated");
        assert_eq!(last.presses, 30);
        assert!((last.model_mm - libm::hypot(3.0, 1.0)).abs() < 0.01);
        assert!(last.calibrated_mm < 1.0, "{last:?}");
        assert_eq!(estimate.poll(), None, "once");
    }
}
