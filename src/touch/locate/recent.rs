//! What the last few frames left unexplained, while the same touches were down.

/// Rests kept.
const KEPT: usize = super::seek::MEAN_FRAMES;

/// Frames after a change of the touches in which the reference is still finding its level: no faint touch can be told from
/// what it is off by.
const SETTLING: usize = 20;

/// The last rests, and their mean.
#[derive(Clone, Debug, Default)]
pub(super) struct Recent {
    touches: usize,
    taken: usize,
    rests: [Vec<f32>; KEPT],
    mean: Vec<f32>,
    /// The gain that was last sought in vain with these touches.
    refused_gain: f64,
}

impl Recent {
    /// Forgets all.
    pub(super) fn clear(&mut self) {
        self.taken = 0;
        self.refused_gain = 0.0;
    }

    /// Whether a gain is far more than was last asked for; a try that follows is expected to fail.
    pub(super) fn is_news(&mut self, gain: f64) -> bool {
        let is_news = gain > super::seek::REFUSED_GROWTH * self.refused_gain;
        if is_news {
            self.refused_gain = gain;
        }
        is_news
    }

    /// Takes the rest of a frame with so many touches; returns how many rests the mean is of, none while the reference
    /// settles.
    pub(super) fn take(&mut self, touches: usize, rest: &[f32]) -> usize {
        if touches != self.touches {
            self.touches = touches;
            self.clear();
        }
        self.rests[self.taken % KEPT].clear();
        self.rests[self.taken % KEPT].extend_from_slice(rest);
        self.taken += 1;
        if self.taken < SETTLING {
            return 0;
        }
        let count = self.taken.min(KEPT);
        self.mean.clear();
        self.mean.resize(rest.len(), 0.0);
        for kept in &self.rests[..count] {
            for (sum, value) in self.mean.iter_mut().zip(kept) {
                *sum += value / count as f32;
            }
        }
        count
    }

    /// The mean of the rests that were taken.
    pub(super) fn mean(&self) -> &[f32] {
        &self.mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_is_of_the_last_rests_with_the_same_touches() {
        let mut recent = Recent::default();
        for value in 1..SETTLING {
            assert_eq!(recent.take(1, &[value as f32]), 0, "settling");
        }
        assert_eq!(recent.take(1, &[SETTLING as f32]), KEPT);
        assert_eq!(recent.mean(), [SETTLING as f32 - 1.5]);
        assert_eq!(recent.take(2, &[9.0]), 0, "another touch");
    }
}
