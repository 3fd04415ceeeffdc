//! How a gesture drives its outputs: directly, for a length, repeatedly, alternately, or as a sequence.

mod binding_memory;
mod classified;
mod macro_runner;
mod memory;

use super::moment::Moment;
use super::outputs::Outputs;
use crate::profile::{Binding, Latch, Mode, Profile, Target};
use crate::types::{Action, Event, Nanos, TouchId};
use binding_memory::BindingMemory;
use classified::ClassifiedPress;
use macro_runner::MacroRunner;

/// Touches that can drive one binding at once without an allocation.
const TOUCHES_PER_BINDING: usize = 10;

/// Everything that is being driven.
#[derive(Clone, Debug)]
pub(super) struct Driver {
    pub(super) outputs: Outputs,
    /// How many hold each layer.
    layers: Vec<usize>,
    presses: Vec<DrivenPress>,
    memory: Vec<BindingMemory>,
    /// Bindings in mode sticky, and those in mode macro.
    stickies: Vec<usize>,
    macros: Vec<usize>,
    /// A pause was requested; the caller carries it out.
    pub(super) pause_requested: bool,
}

/// Which targets of a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TargetSet {
    /// Its `output`, or its `tap`.
    Main,
    /// Its `hold`.
    Hold,
}

/// A press of a binding by a touch.
#[derive(Clone, Copy, Debug)]
struct DrivenPress {
    binding: usize,
    touch: TouchId,
    targets: TargetSet,
    state: PressState,
}

#[derive(Clone, Copy, Debug)]
enum PressState {
    /// Ends with the gesture.
    Direct,
    /// Ends when its length is over.
    Classified(ClassifiedPress),
    /// Goes down when it is known to be short or long.
    Undecided { lengths: Latch, long_at: Nanos },
    /// Ends at a time.
    Until { at: Nanos },
    /// Goes up or down at a time.
    Turbo {
        is_down: bool,
        at: Nanos,
        pressed_ns: Nanos,
        is_first: bool,
    },
}

impl PressState {
    fn next_due(&self) -> Option<Nanos> {
        match self {
            Self::Direct => None,
            Self::Classified(press) => press.next_due(),
            Self::Until { at } | Self::Turbo { at, .. } | Self::Undecided { long_at: at, .. } => {
                Some(*at)
            }
        }
    }

    fn is_down(&self) -> bool {
        !matches!(
            self,
            Self::Turbo { is_down: false, .. } | Self::Undecided { .. }
        )
    }
}

impl DrivenPress {
    fn targets<'p>(&self, profile: &'p Profile) -> &'p [Target] {
        let binding = &profile.bindings[self.binding];
        match self.targets {
            TargetSet::Main => &binding.targets,
            TargetSet::Hold => binding.gesture.hold_targets(),
        }
    }
}

impl Driver {
    pub(super) fn new(profile: &Profile) -> Self {
        Self {
            outputs: Outputs::new(profile),
            layers: vec![0; profile.layers.len()],
            presses: Vec::with_capacity(TOUCHES_PER_BINDING * profile.bindings.len()),
            memory: vec![BindingMemory::default(); profile.bindings.len()],
            stickies: bindings_where(profile, |mode| matches!(mode, Mode::Sticky)),
            macros: bindings_where(profile, |mode| matches!(mode, Mode::Macro(_))),
            pause_requested: false,
        }
    }

    /// Whether a layer is on.
    pub(super) fn is_on(&self, layer: usize) -> bool {
        self.layers[layer] > 0
    }

    /// Whether nothing is driven.
    pub(super) fn is_idle(&self) -> bool {
        self.outputs.is_idle() && self.presses.is_empty() && self.runners().next().is_none()
    }

    pub(super) fn next_due(&self) -> Option<Nanos> {
        let presses = self.presses.iter();
        let presses = presses.filter_map(|press| press.state.next_due());
        let runners = self.runners().map(MacroRunner::next_due);
        presses.chain(runners).chain(self.outputs.next_due()).min()
    }

    /// A gesture begins to drive targets of its binding.
    pub(super) fn begin(
        &mut self,
        moment: &mut Moment<'_>,
        index: usize,
        touch: TouchId,
        targets: TargetSet,
    ) {
        let Moment { profile, t_ns, .. } = *moment;
        let binding = &profile.bindings[index];
        if !matches!(binding.mode, Mode::Sticky) {
            self.mark_stickies_used();
        }
        let state = match &binding.mode {
            Mode::Toggle => return self.toggle(moment, index),
            Mode::Sticky => return self.press_sticky(moment, index),
            Mode::Macro(_) => return self.start_macro(moment, index),
            Mode::Direct => PressState::Direct,
            Mode::Classified(lengths) if lengths.when_decided => PressState::Undecided {
                lengths: *lengths,
                long_at: t_ns + lengths.long_after_ns,
            },
            timed => {
                // A new touch ends what an earlier one holds by the same binding: a new jump needs a new press.
                self.drop_presses(moment, |press| press.binding == index);
                self.timed_state(timed, binding, t_ns)
            }
        };
        let press = DrivenPress {
            binding: index,
            touch,
            targets,
            state,
        };
        if state.is_down() {
            self.hold_all(moment, press.targets(profile));
        }
        self.presses.push(press);
    }

    /// The state of a press whose mode gives it a length.
    fn timed_state(&self, mode: &Mode, binding: &Binding, t_ns: Nanos) -> PressState {
        let pressed_ns = self.press_time(binding, t_ns);
        match mode {
            Mode::Classified(lengths) => {
                PressState::Classified(ClassifiedPress::new(*lengths, t_ns, pressed_ns))
            }
            Mode::Latch(length_ns) => PressState::Until {
                at: pressed_ns + length_ns,
            },
            Mode::Turbo { first_ns, .. } => PressState::Turbo {
                is_down: true,
                at: t_ns + first_ns / 2,
                pressed_ns: t_ns,
                is_first: true,
            },
            Mode::Direct | Mode::Toggle | Mode::Sticky | Mode::Macro(_) => PressState::Direct,
        }
    }

    /// A gesture ends.
    pub(super) fn end(&mut self, moment: &mut Moment<'_>, index: usize, touch: TouchId) {
        let t_ns = moment.t_ns;
        let mut at = 0;
        while at < self.presses.len() {
            let press = &mut self.presses[at];
            if press.binding == index && press.touch == touch {
                match &mut press.state {
                    PressState::Direct | PressState::Turbo { .. } => {
                        self.drop_press(moment, at);
                        continue;
                    }
                    PressState::Classified(press) => press.lift(t_ns),
                    PressState::Undecided { lengths, .. } => {
                        let length_ns = lengths.short_ns;
                        self.decide(moment, at, length_ns);
                    }
                    PressState::Until { .. } => {}
                }
            }
            at += 1;
        }
    }

    /// A press that waited for its length goes down for that time.
    fn decide(&mut self, moment: &mut Moment<'_>, at: usize, length_ns: Nanos) {
        let Moment { profile, t_ns, .. } = *moment;
        let mut press = self.presses.remove(at);
        // What an earlier touch still holds ends; one that is not decided yet is a press of its own.
        self.drop_presses(moment, |other| {
            other.binding == press.binding && !matches!(other.state, PressState::Undecided { .. })
        });
        press.state = PressState::Until {
            at: self.press_time(&profile.bindings[press.binding], t_ns) + length_ns,
        };
        self.hold_all(moment, press.targets(profile));
        self.presses.insert(at.min(self.presses.len()), press);
    }

    /// Makes the changes that are due.
    pub(super) fn tick(&mut self, moment: &mut Moment<'_>) {
        let t_ns = moment.t_ns;
        let mut at = 0;
        while at < self.presses.len() {
            let is_over = match &mut self.presses[at].state {
                PressState::Classified(press) => press.tick(t_ns),
                PressState::Until { at } => *at <= t_ns,
                PressState::Undecided { lengths, long_at } if *long_at <= t_ns => {
                    let length_ns = lengths.long_ns;
                    self.decide(moment, at, length_ns);
                    false
                }
                PressState::Turbo { at: due_ns, .. } if *due_ns <= t_ns => {
                    self.turn(moment, at);
                    false
                }
                _ => false,
            };
            if is_over {
                self.drop_press(moment, at);
            } else {
                at += 1;
            }
        }
        self.tick_macros(moment);
        self.outputs.tick(t_ns, moment.events);
    }

    /// Releases everything and forgets what was pending, toggled or latched.
    pub(super) fn release_all(&mut self, moment: &mut Moment<'_>) {
        self.presses.clear();
        self.layers.fill(0);
        self.memory.fill(BindingMemory::default());
        self.outputs.release_all(moment.t_ns, moment.events);
    }

    /// One more holder of a target.
    pub(super) fn hold(&mut self, moment: &mut Moment<'_>, target: Target) {
        let t_ns = moment.t_ns;
        match target {
            Target::Output(index) => self.outputs.hold(index, t_ns, moment.events),
            Target::Layer(layer) => self.layers[layer] += 1,
            Target::Wheel { dx, dy } => moment.events.push(Event {
                t_ns,
                action: Action::Wheel { dx, dy },
            }),
            Target::Pause => self.pause_requested = true,
        }
    }

    /// One holder of a target less.
    pub(super) fn let_go(&mut self, moment: &mut Moment<'_>, target: Target) {
        match target {
            Target::Output(index) => self.outputs.let_go(index, moment.t_ns, moment.events),
            Target::Layer(layer) => self.layers[layer] = self.layers[layer].saturating_sub(1),
            Target::Wheel { .. } | Target::Pause => {}
        }
    }

    fn hold_all(&mut self, moment: &mut Moment<'_>, targets: &[Target]) {
        for target in targets {
            self.hold(moment, *target);
        }
    }

    fn let_go_all(&mut self, moment: &mut Moment<'_>, targets: &[Target]) {
        for target in targets {
            self.let_go(moment, *target);
        }
    }

    /// When a press of a binding that begins now goes out.
    fn press_time(&self, binding: &Binding, t_ns: Nanos) -> Nanos {
        let first = binding.targets.iter().find_map(|target| match target {
            Target::Output(index) => Some(*index),
            _ => None,
        });
        first.map_or(t_ns, |index| self.outputs.press_time(index, t_ns))
    }

    fn drop_presses(&mut self, moment: &mut Moment<'_>, ends: impl Fn(&DrivenPress) -> bool) {
        while let Some(at) = self.presses.iter().position(&ends) {
            self.drop_press(moment, at);
        }
    }

    fn drop_press(&mut self, moment: &mut Moment<'_>, at: usize) {
        let press = self.presses.remove(at);
        if press.state.is_down() {
            let profile = moment.profile;
            self.let_go_all(moment, press.targets(profile));
        }
        self.unlatch_stickies(moment);
    }

    /// Turbo: goes up or down, half of a period each.
    fn turn(&mut self, moment: &mut Moment<'_>, at: usize) {
        let Moment { profile, t_ns, .. } = *moment;
        let press = self.presses[at];
        let mode = &profile.bindings[press.binding].mode;
        let (
            PressState::Turbo {
                is_down,
                pressed_ns,
                is_first,
                ..
            },
            Mode::Turbo {
                first_ns,
                period_ns,
            },
        ) = (press.state, mode)
        else {
            return;
        };
        self.presses[at].state = if is_down {
            self.let_go_all(moment, press.targets(profile));
            PressState::Turbo {
                is_down: false,
                at: pressed_ns + if is_first { *first_ns } else { *period_ns },
                pressed_ns,
                is_first,
            }
        } else {
            self.hold_all(moment, press.targets(profile));
            PressState::Turbo {
                is_down: true,
                at: t_ns + period_ns / 2,
                pressed_ns: t_ns,
                is_first: false,
            }
        };
    }
}

fn bindings_where(profile: &Profile, is_one: fn(&Mode) -> bool) -> Vec<usize> {
    let all = profile.bindings.iter().enumerate();
    all.filter(|(_, binding)| is_one(&binding.mode))
        .map(|(index, _)| index)
        .collect()
}
