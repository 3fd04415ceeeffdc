//! Changes that looked like a new finger and were refused: a fit takes as long as a frame, and fails again until its readings show more.
//!
//! Every part asks again. What changes slowly (a finger that rolls, a gel that springs back) would be fitted with every part for as long
//! as it lasts, though nothing new is seen.

/// While the place of a finger is unsure, its evidence must grow by this factor: one that lands adds at least that with every part.
const UNSURE_GROWTH: f64 = 1.05;
/// What is no new finger must grow by this factor.
const OTHER_GROWTH: f64 = 1.2;
/// What lasts must grow by this factor.
const LASTING_GROWTH: f64 = 1.5;

/// Why a fitted finger was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refusal {
    /// It may be in more than one place.
    Unsure,
    /// It leaves too much, or is a finger that is down already.
    Other,
    /// It was seen in so many parts that the next ones will not say more.
    Lasting,
}

/// The refusals since the end of the last frame.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Refusals {
    /// A candidate is fitted if it explains more than so many squared deviations.
    needed_gain: f64,
    /// How many there were.
    count: usize,
}

impl Refusals {
    /// Forgets the refusals.
    pub(super) fn clear(&mut self) {
        self.needed_gain = 0.0;
    }

    /// How many refusals there were so far.
    pub(super) fn count(self) -> usize {
        self.count
    }

    /// Whether a candidate that explains so many squared deviations is worth a fit.
    pub(super) fn allow(self, gain: f64) -> bool {
        gain > self.needed_gain
    }

    /// A candidate that explains so many squared deviations was refused.
    pub(super) fn add(&mut self, gain: f64, refusal: Refusal) {
        let growth = match refusal {
            Refusal::Unsure => UNSURE_GROWTH,
            Refusal::Other => OTHER_GROWTH,
            Refusal::Lasting => LASTING_GROWTH,
        };
        self.needed_gain = growth * gain;
        self.count += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refused_candidate_is_fitted_again_once_it_has_grown() {
        let mut refusals = Refusals::default();
        assert!(refusals.allow(60.0));
        refusals.add(60.0, Refusal::Unsure);
        assert!(!refusals.allow(62.0));
        assert!(refusals.allow(64.0));
        refusals.add(70.0, Refusal::Other);
        assert!(!refusals.allow(83.0));
        assert!(refusals.allow(85.0));
        refusals.add(100.0, Refusal::Lasting);
        assert!(!refusals.allow(149.0));
        assert!(refusals.allow(151.0));
        assert_eq!(refusals.count(), 3);
        refusals.clear();
        assert!(refusals.allow(60.0));
    }
}
