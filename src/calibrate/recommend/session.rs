//! Requests presses one after the other and records the touches of each.
//!
//! The next press is requested when the pad was touched and then released for [`QUIET_NS`], or longer while a second tap is missing, so a player may press as slowly
//! and as often as needed.

use super::trial::{PressLength, PressRequest, PressTrial};
use crate::profile::{Gesture, Mode, Profile};
use crate::types::{NANOS_PER_MS, Nanos, Phase, Touch};

/// A request ends when the pad was released for this long: longer than the gap between two slow presses.
pub const QUIET_NS: Nanos = 2_000 * NANOS_PER_MS;
/// Where two taps are requested, the second one may come this much later: it must not count for the next request.
const SECOND_TAP_NS: Nanos = 10_000 * NANOS_PER_MS;
/// Most touch changes recorded for one request.
const MOST_TOUCHES: usize = 20_000;
/// Press lengths in the order of the requests.
const LENGTHS: [PressLength; 5] = [
    PressLength::Short,
    PressLength::Long,
    PressLength::Twice,
    PressLength::Short,
    PressLength::Long,
];

/// Requests and their recorded touches.
#[derive(Clone, Debug)]
pub struct PressSession {
    requests: Vec<PressRequest>,
    done: Vec<PressTrial>,
    open: Vec<(Nanos, Touch)>,
    down: usize,
    last_ns: Nanos,
}

impl PressSession {
    /// A session with these requests.
    #[must_use]
    pub fn new(requests: Vec<PressRequest>) -> Self {
        Self {
            requests,
            done: Vec::new(),
            open: Vec::new(),
            down: 0,
            last_ns: 0,
        }
    }

    /// `count` requests for a profile's regions: every second one in a region that distinguishes short from long, if there is
    /// any.
    #[must_use]
    pub fn default_requests(profile: &Profile, count: usize) -> Vec<PressRequest> {
        let mut classified: Vec<&str> = Vec::new();
        let mut plain: Vec<&str> = Vec::new();
        for binding in &profile.bindings {
            if !matches!(binding.gesture, Gesture::Press(_)) || binding.layer.is_some() {
                continue;
            }
            let list = if matches!(binding.mode, Mode::Classified(_)) {
                &mut classified
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
        let (even, odd) = match (classified.is_empty(), plain.is_empty()) {
            (false, false) => (&classified, &plain),
            (false, true) => (&classified, &classified),
            (true, false) => (&plain, &plain),
            (true, true) => return Vec::new(),
        };
        (0..count)
            .map(|index| {
                let list = if index % 2 == 0 { even } else { odd };
                PressRequest {
                    region: list[index / 2 % list.len()].to_owned(),
                    length: LENGTHS[index / 2 % LENGTHS.len()],
                }
            })
            .collect()
    }

    /// The current request and its number from 0; `None` at the end.
    #[must_use]
    pub fn current_request(&self) -> Option<(usize, &PressRequest)> {
        let number = self.done.len();
        self.requests.get(number).map(|asked| (number, asked))
    }

    /// Touches that were lifted since the current request began.
    #[must_use]
    pub fn lifts(&self) -> usize {
        let lifted = self.open.iter();
        let lifted = lifted.filter(|(_, touch)| touch.phase == Phase::Up);
        lifted.count()
    }

    /// Number of requests.
    #[must_use]
    pub fn request_count(&self) -> usize {
        self.requests.len()
    }

    /// Takes the changed touches of a frame; returns whether the request has ended.
    pub fn take_frame(&mut self, t_ns: Nanos, changed: &[Touch]) -> bool {
        let Some(asked) = self.requests.get(self.done.len()) else {
            return false;
        };
        for touch in changed {
            match touch.phase {
                Phase::Down => self.down += 1,
                Phase::Up => self.down = self.down.saturating_sub(1),
                Phase::Move => {}
            }
            // A touch that was down before the request does not belong to it.
            let begun = !self.open.is_empty() || touch.phase == Phase::Down;
            if begun && self.open.len() < MOST_TOUCHES {
                self.open.push((t_ns, *touch));
            }
            self.last_ns = t_ns;
        }
        let over = !self.open.is_empty()
            && self.down == 0
            && t_ns.saturating_sub(self.last_ns) >= self.quiet_ns(asked.length);
        if over {
            self.done.push(PressTrial {
                request: Some(asked.clone()),
                touches: std::mem::take(&mut self.open),
            });
        }
        over
    }

    /// How long the pad is at rest after the last touch of a request.
    fn quiet_ns(&self, length: PressLength) -> Nanos {
        let waits = length == PressLength::Twice && self.lifts() == 1;
        if waits { SECOND_TAP_NS } else { QUIET_NS }
    }

    /// Ends the session; a press of the current request counts.
    #[must_use]
    pub fn finish(mut self) -> Vec<PressTrial> {
        if self.down == 0
            && let Some(asked) = self.requests.get(self.done.len())
            && !self.open.is_empty()
        {
            self.done.push(PressTrial {
                request: Some(asked.clone()),
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
    fn the_lift_of_a_finger_that_lay_there_before_is_no_press() {
        let requests = PressSession::default_requests(&profile("super-mario"), 2);
        let mut session = PressSession::new(requests);
        session.take_frame(0, &[touch(Phase::Up)]);
        assert_eq!(session.lifts(), 0);
        assert!(
            !session.take_frame(2 * QUIET_NS, &[]),
            "nothing was pressed"
        );
        session.take_frame(2 * QUIET_NS, &[touch(Phase::Down)]);
        session.take_frame(2 * QUIET_NS, &[touch(Phase::Up)]);
        assert_eq!(session.lifts(), 1);
        assert!(session.take_frame(3 * QUIET_NS, &[]));
        assert_eq!(session.lifts(), 0, "of the next request");
    }

    #[test]
    fn a_slow_second_tap_belongs_to_the_same_request() {
        let asked = PressRequest {
            region: "jump".to_owned(),
            length: PressLength::Twice,
        };
        let mut session = PressSession::new(vec![asked.clone(), asked]);
        let s = |seconds: u64| seconds * 1000 * NANOS_PER_MS;
        session.take_frame(0, &[touch(Phase::Down)]);
        session.take_frame(s(1), &[touch(Phase::Up)]);
        assert!(!session.take_frame(s(8), &[]), "the second tap is missing");
        session.take_frame(s(9), &[touch(Phase::Down)]);
        session.take_frame(s(10), &[touch(Phase::Up)]);
        assert!(session.take_frame(s(12), &[]));
        session.take_frame(s(13), &[touch(Phase::Down)]);
        session.take_frame(s(14), &[touch(Phase::Up)]);
        assert!(session.take_frame(s(24), &[]), "it does not come");
        assert_eq!(session.finish().len(), 2);
    }

    #[test]
    fn half_of_the_requests_are_in_regions_that_distinguish_lengths() {
        let asked = PressSession::default_requests(&profile("super-mario-classified"), 40);
        let jumps = asked.iter().filter(|asked| asked.region == "jump").count();
        assert_eq!((asked.len(), jumps), (40, 20));
        for length in [PressLength::Short, PressLength::Long, PressLength::Twice] {
            let some = asked
                .iter()
                .filter(|a| a.region == "jump" && a.length == length);
            assert!(some.count() >= 4, "{length:?}");
        }
        assert!(!PressSession::default_requests(&profile("super-mario"), 10).is_empty());
    }

    #[test]
    fn the_next_press_is_requested_when_the_pad_was_released() {
        let ms = |ms: u64| ms * NANOS_PER_MS;
        let mut session = PressSession::new(PressSession::default_requests(
            &profile("super-mario-classified"),
            3,
        ));
        assert!(
            !session.take_frame(ms(5000), &[]),
            "nothing was pressed yet"
        );
        for (at, phase) in [
            (6000, Phase::Down),
            (6200, Phase::Up),
            (7500, Phase::Down),
            (7700, Phase::Up),
        ] {
            assert!(!session.take_frame(ms(at), &[touch(phase)]));
        }
        assert!(!session.take_frame(ms(9699), &[]));
        assert!(session.take_frame(ms(9700), &[]));
        assert_eq!(session.current_request().map(|(number, _)| number), Some(1));
        session.take_frame(ms(10_000), &[touch(Phase::Down)]);
        session.take_frame(ms(10_100), &[touch(Phase::Up)]);
        let trials = session.finish();
        let touches: Vec<usize> = trials.iter().map(|trial| trial.touches.len()).collect();
        assert_eq!(touches, [4, 2]);
    }
}
