//! Asking for presses, one after the other, and keeping what the pad sees of each.
//!
//! The next is asked for when the pad was touched and then left alone for [`QUIET_NS`]: so a person may press as slowly, and
//! as often, as the hand does.

use super::{Asked, Length, Trial};
use crate::profile::{Gesture, Mode, Profile};
use crate::types::{NANOS_PER_MS, Nanos, Phase, Touch};

/// A thing asked for is over when the pad was left alone for so long: longer than between two slow presses.
pub const QUIET_NS: Nanos = 2_000 * NANOS_PER_MS;
/// Touches of one thing asked for that are kept; more are no press.
const MOST_TOUCHES: usize = 20_000;
/// Lengths in the order in which they are asked for.
const LENGTHS: [Length; 5] = [
    Length::Short,
    Length::Long,
    Length::Twice,
    Length::Short,
    Length::Long,
];

/// What is asked for, and what came of it.
#[derive(Clone, Debug)]
pub struct Session {
    asked: Vec<Asked>,
    done: Vec<Trial>,
    open: Vec<(Nanos, Touch)>,
    down: usize,
    last_ns: Nanos,
}

impl Session {
    /// Asks for these.
    #[must_use]
    pub fn new(asked: Vec<Asked>) -> Self {
        Self {
            asked,
            done: Vec::new(),
            open: Vec::new(),
            down: 0,
            last_ns: 0,
        }
    }

    /// So many presses of a profile's regions: every second one where it tells short from long, if it does anywhere.
    #[must_use]
    pub fn usual(profile: &Profile, count: usize) -> Vec<Asked> {
        let mut telling: Vec<&str> = Vec::new();
        let mut plain: Vec<&str> = Vec::new();
        for binding in &profile.bindings {
            if binding.gesture != Gesture::Press || binding.layer.is_some() {
                continue;
            }
            let list = if matches!(binding.mode, Mode::Classified(_)) {
                &mut telling
            } else if binding.mode == Mode::Direct {
                &mut plain
            } else {
                continue;
            };
            list.extend(
                binding
                    .regions
                    .iter()
                    .map(|region| profile.regions[*region].name.as_str()),
            );
        }
        let (even, odd) = match (telling.is_empty(), plain.is_empty()) {
            (false, false) => (&telling, &plain),
            (false, true) => (&telling, &telling),
            (true, false) => (&plain, &plain),
            (true, true) => return Vec::new(),
        };
        (0..count)
            .map(|index| {
                let list = if index % 2 == 0 { even } else { odd };
                Asked {
                    region: list[index / 2 % list.len()].to_owned(),
                    length: LENGTHS[index / 2 % LENGTHS.len()],
                }
            })
            .collect()
    }

    /// What is asked for now, and its number from 0; nothing at the end.
    #[must_use]
    pub fn asked(&self) -> Option<(usize, &Asked)> {
        let number = self.done.len();
        self.asked.get(number).map(|asked| (number, asked))
    }

    /// How many are asked for in all.
    #[must_use]
    pub fn count(&self) -> usize {
        self.asked.len()
    }

    /// Takes what became of the touches in a frame, if anything; returns whether the next is asked for now.
    pub fn frame(&mut self, t_ns: Nanos, changed: &[Touch]) -> bool {
        let Some(asked) = self.asked.get(self.done.len()) else {
            return false;
        };
        for touch in changed {
            match touch.phase {
                Phase::Down => self.down += 1,
                Phase::Up => self.down = self.down.saturating_sub(1),
                Phase::Move => {}
            }
            // What lies on the pad since before the question is none of its answer.
            let begun = !self.open.is_empty() || touch.phase == Phase::Down;
            if begun && self.open.len() < MOST_TOUCHES {
                self.open.push((t_ns, *touch));
            }
            self.last_ns = t_ns;
        }
        let over = !self.open.is_empty()
            && self.down == 0
            && t_ns.saturating_sub(self.last_ns) >= QUIET_NS;
        if over {
            self.done.push(Trial {
                asked: Some(asked.clone()),
                touches: std::mem::take(&mut self.open),
            });
        }
        over
    }

    /// Ends it: what has been pressed counts.
    #[must_use]
    pub fn finish(mut self) -> Vec<Trial> {
        if self.down == 0
            && let Some(asked) = self.asked.get(self.done.len())
            && !self.open.is_empty()
        {
            self.done.push(Trial {
                asked: Some(asked.clone()),
                touches: self.open,
            });
        }
        self.done
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::find_shipped;
    use crate::types::{Contact, TouchId};

    fn profile(name: &str) -> Profile {
        let source = find_shipped(name).expect("shipped");
        Profile::from_toml(&source.name, &source.toml).expect("sound")
    }

    fn touch(phase: Phase) -> Touch {
        Touch {
            id: TouchId(1),
            phase,
            since_ns: 0,
            contact: Contact {
                centre_mm: [80.0, 50.0],
                area_mm2: 150.0,
                force: 0.5,
                confidence: 1.0,
            },
        }
    }

    #[test]
    fn half_of_the_presses_are_asked_for_where_lengths_are_told_apart() {
        let asked = Session::usual(&profile("super-mario-classified"), 40);
        let jumps = asked.iter().filter(|asked| asked.region == "jump").count();
        assert_eq!((asked.len(), jumps), (40, 20));
        for length in [Length::Short, Length::Long, Length::Twice] {
            let some = asked
                .iter()
                .filter(|a| a.region == "jump" && a.length == length);
            assert!(some.count() >= 4, "{length:?}");
        }
        assert!(!Session::usual(&profile("super-mario"), 10).is_empty());
    }

    #[test]
    fn the_next_is_asked_for_when_the_pad_was_left_alone() {
        let ms = |ms: u64| ms * NANOS_PER_MS;
        let mut session = Session::new(Session::usual(&profile("super-mario-classified"), 3));
        assert!(!session.frame(ms(5000), &[]), "nothing was pressed yet");
        for (at, phase) in [
            (6000, Phase::Down),
            (6200, Phase::Up),
            (7500, Phase::Down),
            (7700, Phase::Up),
        ] {
            assert!(!session.frame(ms(at), &[touch(phase)]));
        }
        assert!(!session.frame(ms(9699), &[]));
        assert!(session.frame(ms(9700), &[]));
        assert_eq!(session.asked().map(|(number, _)| number), Some(1));
        session.frame(ms(10_000), &[touch(Phase::Down)]);
        session.frame(ms(10_100), &[touch(Phase::Up)]);
        let trials = session.finish();
        let touches: Vec<usize> = trials.iter().map(|trial| trial.touches.len()).collect();
        assert_eq!(touches, [4, 2]);
    }
}
