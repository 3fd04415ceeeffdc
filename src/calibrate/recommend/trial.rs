//! What a person was asked for, what the pad saw of it, and what a profile makes of that.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::{Overlay, RecommendError};
use crate::gesture::Gestures;
use crate::profile::{self, FindBase, Gesture, Mode, Profile, Source, Target};
use crate::types::{Action, Event, NANOS_PER_MS, Nanos, Output, Phase, Touch};

/// After the last touch, decisions that are still due are waited for so long at most.
const AFTER_NS: Nanos = 5_000 * NANOS_PER_MS;
/// Of a thinned trial's moves, one is kept in this time.
const THINNED_NS: Nanos = 40 * NANOS_PER_MS;

/// How a press was to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Length {
    /// As short as usual.
    Short,
    /// Held.
    Long,
    /// Two short ones, one soon after the other.
    Twice,
}

/// What was asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Asked {
    /// The region's name.
    pub region: String,
    /// How it was to be pressed.
    pub length: Length,
}

/// One thing asked for, and all that the pad saw until the next.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// What was asked for; nothing if the person was to leave the pad alone, or only rest on it.
    pub asked: Option<Asked>,
    /// What became of every touch, when, in order.
    pub touches: Vec<(Nanos, Touch)>,
}

impl Trial {
    /// The same with few moves: as good to choose settings by, and several times as quick.
    #[must_use]
    pub fn thinned(&self) -> Self {
        let mut kept_ns: Nanos = 0;
        let mut touches = self.touches.clone();
        touches.retain(|(t_ns, touch)| {
            let keep = touch.phase != Phase::Move || t_ns.saturating_sub(kept_ns) >= THINNED_NS;
            if keep {
                kept_ns = *t_ns;
            }
            keep
        });
        Self {
            asked: self.asked.clone(),
            touches,
        }
    }
}

/// What a profile made of presses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outcome {
    /// Things that were asked for.
    pub asked: usize,
    /// Those that came out as asked: the right output, as often as asked, short or long as asked, and no other.
    pub right: usize,
    /// Presses that nobody asked for.
    pub wrong: usize,
}

impl Outcome {
    /// Share that came out right, 0 to 1.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.right as f64 / self.asked.max(1) as f64
    }
}

impl std::ops::AddAssign for Outcome {
    fn add_assign(&mut self, other: Self) {
        self.asked += other.asked;
        self.right += other.right;
        self.wrong += other.wrong;
    }
}

/// Plays presses through a profile's gestures under any settings.
pub struct Judge<'a> {
    source: Source,
    find: FindBase<'a>,
    pad_mm: [f64; 2],
}

/// What a region's press is bound to, and how long a press is a long one, if the profile tells them apart.
struct Bound {
    output: Output,
    long_from_ns: Option<Nanos>,
}

impl<'a> Judge<'a> {
    /// For a profile on a pad of a size.
    #[must_use]
    pub fn new(profile: &Source, find: FindBase<'a>, pad_mm: [f64; 2]) -> Self {
        Self {
            source: profile.clone(),
            find,
            pad_mm,
        }
    }

    /// The profile under settings.
    ///
    /// # Errors
    /// A text that cannot be read.
    pub fn profile(&self, overlay: Option<&Overlay>) -> Result<Profile, RecommendError> {
        let user = overlay.map(|overlay| Source {
            name: "the recommended settings".to_owned(),
            toml: overlay.toml(None),
        });
        profile::read(self.source.clone(), user, self.find)
            .map(|checked| checked.profile)
            .map_err(RecommendError::Profile)
    }

    /// What the profile under settings makes of presses.
    ///
    /// # Errors
    /// A text that cannot be read; a region that the profile has not.
    pub fn outcome(
        &self,
        trials: &[Trial],
        overlay: Option<&Overlay>,
    ) -> Result<Outcome, RecommendError> {
        self.outcome_at(trials, overlay, 1.0)
    }

    /// The same with everything so many times as slow.
    pub(super) fn outcome_at(
        &self,
        trials: &[Trial],
        overlay: Option<&Overlay>,
        slower: f64,
    ) -> Result<Outcome, RecommendError> {
        let profile = Arc::new(self.profile(overlay)?);
        let fresh = Gestures::new(Arc::clone(&profile), self.pad_mm);
        let bound = bound(&profile);
        let mut all = Outcome::default();
        for trial in trials {
            let events = play(fresh.clone(), trial, slower);
            all += match &trial.asked {
                None => Outcome {
                    asked: 0,
                    right: 0,
                    wrong: presses(&events).len(),
                },
                Some(asked) => {
                    let bound = bound
                        .get(asked.region.as_str())
                        .ok_or_else(|| RecommendError::Region(asked.region.clone()))?;
                    judged(asked, bound, &presses(&events))
                }
            };
        }
        Ok(all)
    }
}

/// The outputs of the regions that a plain press drives.
fn bound(profile: &Profile) -> BTreeMap<&str, Bound> {
    let mut bound = BTreeMap::new();
    for binding in &profile.bindings {
        let output = binding.targets.iter().find_map(|target| match target {
            Target::Output(index) => Some(profile.outputs[*index]),
            _ => None,
        });
        let (Gesture::Press, Some(output)) = (&binding.gesture, output) else {
            continue;
        };
        let long_from_ns = match &binding.mode {
            Mode::Classified(lengths) => Some((lengths.short_ns + lengths.long_ns) / 2),
            _ => None,
        };
        for region in &binding.regions {
            let name = profile.regions[*region].name.as_str();
            bound.entry(name).or_insert(Bound {
                output,
                long_from_ns,
            });
        }
    }
    bound
}

/// The events of a trial, played by itself.
fn play(mut gestures: Gestures, trial: &Trial, slower: f64) -> Vec<Event> {
    let mut events = Vec::new();
    let start = trial.touches.first().map_or(0, |(t_ns, _)| *t_ns);
    let at = |t_ns: Nanos| libm::round((t_ns - start) as f64 * slower) as Nanos;
    let mut last = 0;
    for same in trial.touches.chunk_by(|a, b| a.0 == b.0) {
        let changed: Vec<Touch> = same.iter().map(|(_, touch)| *touch).collect();
        last = at(same[0].0);
        gestures.touches(last, &changed, &mut events);
    }
    gestures.tick(last + AFTER_NS, &mut events);
    gestures.release_all(last + AFTER_NS, &mut events);
    events
}

/// What was pressed, and for how long.
fn presses(events: &[Event]) -> Vec<(Output, Nanos)> {
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

fn judged(asked: &Asked, bound: &Bound, presses: &[(Output, Nanos)]) -> Outcome {
    let wanted = match asked.length {
        Length::Short | Length::Long => 1,
        Length::Twice => 2,
    };
    let own = presses.iter().filter(|(output, _)| *output == bound.output);
    let found = own.clone().count();
    let wrong = presses.len() - found + found.saturating_sub(wanted);
    let long = asked.length == Length::Long;
    let as_long = own.clone().all(|(_, held_ns)| {
        bound
            .long_from_ns
            .is_none_or(|from| (*held_ns >= from) == long)
    });
    Outcome {
        asked: 1,
        right: usize::from(found == wanted && wrong == 0 && as_long),
        wrong,
    }
}
