//! Touches to events: each binding decides when it wants its output held, and the outputs see to it that no
//! press and no gap is shorter than a game can see.
//!
//! Time is passed in. A decision that falls between two frames (the end of a minimum hold, of a latch, of a gap)
//! is made at its due time, which [`Gestures::next_due`] tells; the event carries that time, however late the
//! call comes. So events do not depend on how frames are batched.

mod latch;
mod outputs;

use std::sync::Arc;

use crate::profile::{Mode, Profile};
use crate::types::{Event, Nanos, Output, Phase, Touch, TouchId};
use latch::Latched;
use outputs::Outputs;

/// The gestures of one profile on one pad.
#[derive(Clone, Debug)]
pub struct Gestures {
    profile: Arc<Profile>,
    pad_mm: [f64; 2],
    outputs: Outputs,
    holds: Vec<Hold>,
}

/// A binding that holds its output for a touch.
#[derive(Clone, Copy, Debug)]
struct Hold {
    touch: TouchId,
    binding: usize,
    output: usize,
    kind: HoldKind,
}

#[derive(Clone, Copy, Debug)]
enum HoldKind {
    /// Ends with the touch.
    Direct,
    /// Ends when the latch says.
    Classified(Latched),
}

impl Gestures {
    /// Gestures of a profile on a pad of a size (width, height).
    #[must_use]
    pub fn new(profile: Arc<Profile>, pad_mm: [f64; 2]) -> Self {
        Self {
            outputs: Outputs::new(&profile),
            profile,
            pad_mm,
            holds: Vec::new(),
        }
    }

    /// The profile in force.
    #[must_use]
    pub fn profile(&self) -> &Arc<Profile> {
        &self.profile
    }

    /// The outputs that are down.
    pub fn held(&self) -> impl Iterator<Item = Output> + '_ {
        self.outputs.held()
    }

    /// When the next decision falls, if one is pending.
    #[must_use]
    pub fn next_due(&self) -> Option<Nanos> {
        let latches = self.holds.iter().filter_map(|hold| match hold.kind {
            HoldKind::Direct => None,
            HoldKind::Classified(latch) => latch.next_due(),
        });
        latches.chain(self.outputs.next_due()).min()
    }

    /// Makes every decision that is due by a time, in the order in which they fall.
    pub fn tick(&mut self, t_ns: Nanos, events: &mut Vec<Event>) {
        while let Some(due) = self.next_due().filter(|due| *due <= t_ns) {
            self.end_latches(due, events);
            self.outputs.tick(due, events);
        }
    }

    /// Takes what became of the touches in a frame.
    pub fn touches(&mut self, t_ns: Nanos, changed: &[Touch], events: &mut Vec<Event>) {
        self.tick(t_ns, events);
        for touch in changed {
            match touch.phase {
                Phase::Down => self.down(t_ns, touch, events),
                Phase::Move => {}
                Phase::Up => self.up(t_ns, touch.id, events),
            }
        }
        // A latch may end in the frame in which its touch lifts.
        self.tick(t_ns, events);
    }

    /// Releases everything now and forgets what was pending: the source is gone, or the profile changes.
    pub fn release_all(&mut self, t_ns: Nanos, events: &mut Vec<Event>) {
        self.holds.clear();
        self.outputs.release_all(t_ns, events);
    }

    fn down(&mut self, t_ns: Nanos, touch: &Touch, events: &mut Vec<Event>) {
        let Some(region) = self.profile.region_at(touch.contact.centre_mm, self.pad_mm) else {
            return;
        };
        let profile = Arc::clone(&self.profile);
        for (index, binding) in profile.bindings.iter().enumerate() {
            if binding.region != region {
                continue;
            }
            let kind = match binding.mode {
                Mode::Direct => HoldKind::Direct,
                Mode::Classified(lengths) => {
                    self.cut_short(t_ns, index, events);
                    let pressed_ns = self.outputs.press_time(binding.output, t_ns);
                    HoldKind::Classified(Latched::new(lengths, t_ns, pressed_ns))
                }
            };
            self.outputs.hold(binding.output, t_ns, events);
            self.holds.push(Hold {
                touch: touch.id,
                binding: index,
                output: binding.output,
                kind,
            });
        }
    }

    fn up(&mut self, t_ns: Nanos, touch: TouchId, events: &mut Vec<Event>) {
        let outputs = &mut self.outputs;
        self.holds.retain_mut(|hold| {
            if hold.touch != touch {
                return true;
            }
            match &mut hold.kind {
                HoldKind::Direct => {
                    outputs.let_go(hold.output, t_ns, events);
                    false
                }
                HoldKind::Classified(latch) => {
                    latch.lift(t_ns);
                    true
                }
            }
        });
    }

    /// A fresh touch ends what an earlier one holds by the same binding, lifted or not: a new jump needs a new press.
    fn cut_short(&mut self, t_ns: Nanos, binding: usize, events: &mut Vec<Event>) {
        let outputs = &mut self.outputs;
        self.holds.retain(|hold| {
            let earlier = hold.binding == binding;
            if earlier {
                outputs.let_go(hold.output, t_ns, events);
            }
            !earlier
        });
    }

    fn end_latches(&mut self, due: Nanos, events: &mut Vec<Event>) {
        let outputs = &mut self.outputs;
        self.holds.retain_mut(|hold| {
            let HoldKind::Classified(latch) = &mut hold.kind else {
                return true;
            };
            let ended = latch.tick(due);
            if ended {
                outputs.let_go(hold.output, due, events);
            }
            !ended
        });
    }
}
