//! What the last few frames left unexplained, while the same touches were down.

/// Rests kept.
const KEPT: usize = super::MEAN_FRAMES;

/// The last rests, and their mean.
#[derive(Clone, Debug, Default)]
pub struct Recent {
    touches: usize,
    taken: usize,
    rests: [Vec<f32>; KEPT],
    mean: Vec<f32>,
}

impl Recent {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.taken = 0;
    }

    /// Takes the rest of a frame with so many touches; returns how many rests the mean is of.
    pub fn take(&mut self, touches: usize, rest: &[f32]) -> usize {
        if touches != self.touches {
            self.touches = touches;
            self.taken = 0;
        }
        self.rests[self.taken % KEPT].clear();
        self.rests[self.taken % KEPT].extend_from_slice(rest);
        self.taken += 1;
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
    pub fn mean(&self) -> &[f32] {
        &self.mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_is_of_the_last_rests_with_the_same_touches() {
        let mut recent = Recent::default();
        for value in 0..6 {
            recent.take(1, &[value as f32]);
        }
        assert_eq!(recent.mean(), [3.5], "2, 3, 4 and 5");
        assert_eq!(recent.take(2, &[9.0]), 1);
        assert_eq!(recent.mean(), [9.0]);
    }
}
