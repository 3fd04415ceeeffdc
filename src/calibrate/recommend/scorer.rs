//! Plays trials through the gestures of a profile and counts the presses that come out as requested.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::overlay::{RecommendedSettings, TrialScore};
use super::trial::{PressLength, PressRequest, PressTrial};
use crate::gesture::Gestures;
use crate::profile::{self, FindBase, Gesture, Mode, Profile, Source, Target};
use crate::types::{Action, Event, NANOS_PER_MS, Nanos, Output, SourceErrors, Touch};

/// Time after the last touch in which pending decisions are awaited.
const AFTER_NS: Nanos = 5_000 * NANOS_PER_MS;
/// Least number of presses for a recommendation.
pub const FEWEST_TRIALS: usize = 12;

/// Why nothing is recommended.
#[derive(Debug, thiserror::Error)]
pub enum RecommendError {
    /// Too few presses.
    #[error("{found} presses are too few: at least {FEWEST_TRIALS} are needed")]
    TooFew {
        /// Number of presses.
        found: usize,
    },
    /// The profile cannot be read.
    #[error("the profile cannot be read: {}", .0.name)]
    Profile(SourceErrors),
    /// A requested region is not in the profile.
    #[error("the profile has no region `{0}` with a press binding: request regions that it has")]
    Region(String),
}

/// Plays trials through the gestures of a profile with any settings.
pub struct TrialScorer<'a> {
    source: Source,
    find: FindBase<'a>,
    pad_mm: [f64; 2],
}

/// The output of a region's press, and the length of a long press where the profile distinguishes it.
struct BoundPress {
    output: Output,
    long_from_ns: Option<Nanos>,
}

impl<'a> TrialScorer<'a> {
    /// For a profile on a pad of the given size, mm.
    #[must_use]
    pub fn new(profile: &Source, find: FindBase<'a>, pad_mm: [f64; 2]) -> Self {
        Self {
            source: profile.clone(),
            find,
            pad_mm,
        }
    }

    /// The profile with settings.
    ///
    /// # Errors
    /// A profile that cannot be read.
    pub fn profile(
        &self,
        overlay: Option<&RecommendedSettings>,
    ) -> Result<Profile, RecommendError> {
        let user = overlay.map(|overlay| Source {
            name: "the recommended settings".to_owned(),
            toml: overlay.toml(None),
        });
        profile::read(self.source.clone(), user, self.find)
            .map(|checked| checked.profile)
            .map_err(RecommendError::Profile)
    }

    /// The score of trials with settings.
    ///
    /// # Errors
    /// A profile that cannot be read; a region that it does not have.
    pub fn score(
        &self,
        trials: &[PressTrial],
        overlay: Option<&RecommendedSettings>,
    ) -> Result<TrialScore, RecommendError> {
        self.score_at_pace(trials, overlay, 1.0)
    }

    /// The same with all times multiplied by `time_factor`.
    pub(super) fn score_at_pace(
        &self,
        trials: &[PressTrial],
        overlay: Option<&RecommendedSettings>,
        time_factor: f64,
    ) -> Result<TrialScore, RecommendError> {
        let profile = Arc::new(self.profile(overlay)?);
        let fresh = Gestures::new(Arc::clone(&profile), self.pad_mm);
        let bound = bound_presses(&profile);
        let mut all = TrialScore::default();
        for trial in trials {
            let events = play(fresh.clone(), trial, time_factor);
            all += match &trial.request {
                None => TrialScore {
                    requested: 0,
                    right: 0,
                    wrong: pressed_outputs(&events).len(),
                },
                Some(asked) => {
                    let bound = bound
                        .get(asked.region.as_str())
                        .ok_or_else(|| RecommendError::Region(asked.region.clone()))?;
                    score(asked, bound, &pressed_outputs(&events))
                }
            };
        }
        Ok(all)
    }
}

/// The output of each region with a press binding.
fn bound_presses(profile: &Profile) -> BTreeMap<&str, BoundPress> {
    let mut bound = BTreeMap::new();
    for binding in &profile.bindings {
        let output = binding.targets.iter().find_map(|target| match target {
            Target::Output(index) => Some(profile.outputs[*index]),
            _ => None,
        });
        let (Gesture::Press(_), Some(output)) = (&binding.gesture, output) else {
            continue;
        };
        let long_from_ns = match &binding.mode {
            Mode::Classified(lengths) => Some((lengths.short_ns + lengths.long_ns) / 2),
            _ => None,
        };
        for region in &binding.regions {
            let name = profile.regions[*region].name.as_str();
            bound.entry(name).or_insert(BoundPress {
                output,
                long_from_ns,
            });
        }
    }
    bound
}

/// The events of a trial, played from a fresh state.
fn play(mut gestures: Gestures, trial: &PressTrial, time_factor: f64) -> Vec<Event> {
    let mut events = Vec::new();
    let start = trial.touches.first().map_or(0, |(t_ns, _)| *t_ns);
    let at = |t_ns: Nanos| libm::round((t_ns - start) as f64 * time_factor) as Nanos;
    let mut last = 0;
    for simultaneous in trial.touches.chunk_by(|a, b| a.0 == b.0) {
        let changed: Vec<Touch> = simultaneous.iter().map(|(_, touch)| *touch).collect();
        last = at(simultaneous[0].0);
        gestures.touches(last, &changed, &mut events);
    }
    gestures.tick(last + AFTER_NS, &mut events);
    gestures.release_all(last + AFTER_NS, &mut events);
    events
}

/// The pressed outputs, and for how long.
fn pressed_outputs(events: &[Event]) -> Vec<(Output, Nanos)> {
    let mut presses: Vec<(Output, Nanos)> = Vec::new();
    let mut down: Vec<(Output, Nanos, usize)> = Vec::new();
    for event in events {
        match event.action {
            Action::Press(output) => {
                down.push((output, event.t_ns, presses.len()));
                presses.push((output, Nanos::MAX));
            }
            Action::Release(output) => {
                if let Some(at) = down.iter().position(|(other, ..)| *other == output) {
                    let (_, since, index) = down.remove(at);
                    presses[index].1 = event.t_ns - since;
                }
            }
            _ => {}
        }
    }
    presses
}

/// The score of one request.
fn score(asked: &PressRequest, bound: &BoundPress, presses: &[(Output, Nanos)]) -> TrialScore {
    let wanted = match asked.length {
        PressLength::Short | PressLength::Long => 1,
        PressLength::Twice => 2,
    };
    let own = presses.iter().filter(|(output, _)| *output == bound.output);
    let found = own.clone().count();
    let wrong = presses.len() - found + found.saturating_sub(wanted);
    let long = asked.length == PressLength::Long;
    let as_long = own.clone().all(|(_, held_ns)| {
        bound
            .long_from_ns
            .is_none_or(|from| (*held_ns >= from) == long)
    });
    TrialScore {
        requested: 1,
        right: usize::from(found == wanted && wrong == 0 && as_long),
        wrong,
    }
}
