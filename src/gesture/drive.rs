//! How a gesture that lasts drives its outputs: directly, for a length, again and again, by turns, as a sequence.

use super::latch::Latched;
use super::outputs::Outputs;
use super::sequence::{Due, Runner};
use super::step::Step;
use super::tap_hold::Side;
use crate::profile::{Binding, Gesture, Latch, Mode, Profile, Target};
use crate::types::{Action, Event, Nanos, TouchId};

/// Touches that may drive one binding at once, for which there is room from the start.
const ROOM_A_BINDING: usize = 10;

/// Everything that is being driven.
#[derive(Clone, Debug)]
pub(super) struct Driver {
    pub(super) outputs: Outputs,
    /// How many hold each layer.
    layers: Vec<usize>,
    drives: Vec<Drive>,
    memory: Vec<Memory>,
    /// Bindings in mode sticky, and those in mode macro.
    stickies: Vec<usize>,
    macros: Vec<usize>,
    /// A pause was asked for; whoever steps the driver carries it out.
    pub(super) pause_wished: bool,
}

/// A binding that is driven by a touch.
#[derive(Clone, Copy, Debug)]
struct Drive {
    binding: usize,
    touch: TouchId,
    side: Side,
    state: State,
}

#[derive(Clone, Copy, Debug)]
enum State {
    /// Ends with the gesture.
    Direct,
    /// Ends when the latch says.
    Classified(Latched),
    /// Goes down when it is known to be short or long.
    Undecided { lengths: Latch, long_at: Nanos },
    /// Ends at a time.
    Until { at: Nanos },
    /// Changes at a time.
    Turbo {
        down: bool,
        at: Nanos,
        pressed: Nanos,
        first: bool,
    },
}

/// What a binding remembers from one gesture to the next.
#[derive(Clone, Debug, Default)]
struct Memory {
    toggled: bool,
    sticky: Sticky,
    runner: Option<Runner>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Sticky {
    #[default]
    Off,
    /// Until another press is over.
    Latched { used: bool },
    /// Until it comes again.
    Locked,
}

impl Driver {
    pub(super) fn new(profile: &Profile) -> Self {
        Self {
            outputs: Outputs::new(profile),
            layers: vec![0; profile.layers.len()],
            drives: Vec::with_capacity(ROOM_A_BINDING * profile.bindings.len()),
            memory: vec![Memory::default(); profile.bindings.len()],
            stickies: of_mode(profile, |mode| matches!(mode, Mode::Sticky)),
            macros: of_mode(profile, |mode| matches!(mode, Mode::Macro(_))),
            pause_wished: false,
        }
    }

    /// Whether bindings on a layer count now.
    pub(super) fn is_on(&self, layer: usize) -> bool {
        self.layers[layer] > 0
    }

    /// Whether nothing is driven.
    pub(super) fn is_idle(&self) -> bool {
        self.outputs.is_idle() && self.drives.is_empty() && self.runners().next().is_none()
    }

    pub(super) fn next_due(&self) -> Option<Nanos> {
        let drives = self.drives.iter().filter_map(|drive| match drive.state {
            State::Direct => None,
            State::Classified(latch) => latch.next_due(),
            State::Until { at }
            | State::Turbo { at, .. }
            | State::Undecided { long_at: at, .. } => Some(at),
        });
        let runners = self.runners();
        drives
            .chain(runners.map(Runner::next_due))
            .chain(self.outputs.next_due())
            .min()
    }

    /// A gesture begins to drive one side of its binding.
    pub(super) fn begin(&mut self, step: &mut Step<'_>, index: usize, touch: TouchId, side: Side) {
        let Step { profile, t_ns, .. } = *step;
        let binding = &profile.bindings[index];
        if !matches!(binding.mode, Mode::Sticky) {
            self.mark_stickies_used();
        }
        let state = match &binding.mode {
            Mode::Direct => State::Direct,
            Mode::Classified(lengths) if lengths.when_decided => {
                let state = State::Undecided {
                    lengths: *lengths,
                    long_at: t_ns + lengths.long_after_ns,
                };
                self.drives.push(Drive {
                    binding: index,
                    touch,
                    side,
                    state,
                });
                return;
            }
            Mode::Classified(lengths) => {
                self.cut_short(step, index);
                let pressed_ns = self.press_time(binding, t_ns);
                State::Classified(Latched::new(*lengths, t_ns, pressed_ns))
            }
            Mode::Latch(length_ns) => {
                self.cut_short(step, index);
                State::Until {
                    at: self.press_time(binding, t_ns) + length_ns,
                }
            }
            Mode::Turbo { first_ns, .. } => {
                self.cut_short(step, index);
                State::Turbo {
                    down: true,
                    at: t_ns + first_ns / 2,
                    pressed: t_ns,
                    first: true,
                }
            }
            Mode::Toggle => return self.toggle(step, binding, index),
            Mode::Sticky => return self.press_sticky(step, binding, index),
            Mode::Macro(_) => {
                let runner = &mut self.memory[index].runner;
                // One that runs goes on to its end.
                runner.get_or_insert_with(|| Runner::new(t_ns));
                return self.run_macro(step, index);
            }
        };
        for target in targets(binding, side) {
            self.hold(step, *target);
        }
        self.drives.push(Drive {
            binding: index,
            touch,
            side,
            state,
        });
    }

    /// A gesture ends.
    pub(super) fn end(&mut self, step: &mut Step<'_>, index: usize, touch: TouchId) {
        let t_ns = step.t_ns;
        let mut at = 0;
        while at < self.drives.len() {
            let drive = &mut self.drives[at];
            if drive.binding != index || drive.touch != touch {
                at += 1;
                continue;
            }
            match &mut drive.state {
                State::Direct | State::Turbo { .. } => self.drop_drive(step, at),
                State::Classified(latch) => {
                    latch.lift(t_ns);
                    at += 1;
                }
                State::Undecided { lengths, .. } => {
                    let length_ns = lengths.short_ns;
                    self.decide(step, at, length_ns);
                    at += 1;
                }
                State::Until { .. } => at += 1,
            }
        }
    }

    /// A press that waited for its length goes down for it.
    fn decide(&mut self, step: &mut Step<'_>, at: usize, length_ns: Nanos) {
        let Step { profile, t_ns, .. } = *step;
        let mut drive = self.drives.remove(at);
        let binding = &profile.bindings[drive.binding];
        // What an earlier touch still holds ends; one that is not decided yet is a press of its own.
        let held = |other: &Drive| {
            other.binding == drive.binding && !matches!(other.state, State::Undecided { .. })
        };
        while let Some(other) = self.drives.iter().position(held) {
            self.drop_drive(step, other);
        }
        drive.state = State::Until {
            at: self.press_time(binding, t_ns) + length_ns,
        };
        for target in targets(binding, drive.side) {
            self.hold(step, *target);
        }
        self.drives.insert(at.min(self.drives.len()), drive);
    }

    /// Makes the changes that fall due.
    pub(super) fn tick(&mut self, step: &mut Step<'_>) {
        let t_ns = step.t_ns;
        let mut at = 0;
        while at < self.drives.len() {
            let over = match &mut self.drives[at].state {
                State::Direct => false,
                State::Classified(latch) => latch.tick(t_ns),
                State::Until { at } => *at <= t_ns,
                State::Undecided { lengths, long_at } => {
                    if *long_at <= t_ns {
                        let length_ns = lengths.long_ns;
                        self.decide(step, at, length_ns);
                    }
                    false
                }
                State::Turbo { at: due, .. } => {
                    if *due <= t_ns {
                        self.turn(step, at);
                    }
                    false
                }
            };
            if over {
                self.drop_drive(step, at);
            } else {
                at += 1;
            }
        }
        for listed in 0..self.macros.len() {
            let index = self.macros[listed];
            let due = self.memory[index].runner.as_ref().map(Runner::next_due);
            if due.is_some_and(|due| due <= t_ns) {
                self.run_macro(step, index);
            }
        }
        self.outputs.tick(step.t_ns, step.events);
    }

    /// Releases everything and forgets what was pending, toggled or latched.
    pub(super) fn release_all(&mut self, step: &mut Step<'_>) {
        self.drives.clear();
        self.layers.fill(0);
        for memory in &mut self.memory {
            *memory = Memory::default();
        }
        self.outputs.release_all(step.t_ns, step.events);
    }

    /// Macros that run.
    fn runners(&self) -> impl Iterator<Item = &Runner> {
        self.macros
            .iter()
            .filter_map(|index| self.memory[*index].runner.as_ref())
    }

    /// One more wants a target held.
    pub(super) fn hold(&mut self, step: &mut Step<'_>, target: Target) {
        match target {
            Target::Output(index) => self.outputs.hold(index, step.t_ns, step.events),
            Target::Layer(layer) => self.layers[layer] += 1,
            Target::Wheel { dx, dy } => step.events.push(Event {
                t_ns: step.t_ns,
                action: Action::Wheel { dx, dy },
            }),
            Target::Pause => self.pause_wished = true,
        }
    }

    /// One less wants a target held.
    pub(super) fn let_go(&mut self, step: &mut Step<'_>, target: Target) {
        match target {
            Target::Output(index) => self.outputs.let_go(index, step.t_ns, step.events),
            Target::Layer(layer) => self.layers[layer] = self.layers[layer].saturating_sub(1),
            Target::Wheel { .. } | Target::Pause => {}
        }
    }

    /// When a press of a binding that is wanted now would go out.
    fn press_time(&self, binding: &Binding, t_ns: Nanos) -> Nanos {
        let first = binding.targets.iter().find_map(|target| match target {
            Target::Output(index) => Some(*index),
            _ => None,
        });
        first.map_or(t_ns, |index| self.outputs.press_time(index, t_ns))
    }

    /// A fresh touch ends what an earlier one holds by the same binding, lifted or not: a new jump needs a new press.
    fn cut_short(&mut self, step: &mut Step<'_>, index: usize) {
        while let Some(at) = self.drives.iter().position(|drive| drive.binding == index) {
            self.drop_drive(step, at);
        }
    }

    fn drop_drive(&mut self, step: &mut Step<'_>, at: usize) {
        let profile = step.profile;
        let drive = self.drives.remove(at);
        let is_up = matches!(
            drive.state,
            State::Turbo { down: false, .. } | State::Undecided { .. }
        );
        if !is_up {
            for target in targets(&profile.bindings[drive.binding], drive.side) {
                self.let_go(step, *target);
            }
        }
        self.unlatch_stickies(step);
    }

    /// Up or down again: half of a period each.
    fn turn(&mut self, step: &mut Step<'_>, at: usize) {
        let Step { profile, t_ns, .. } = *step;
        let Drive {
            binding: index,
            side,
            state,
            ..
        } = self.drives[at];
        let binding = &profile.bindings[index];
        let (
            State::Turbo {
                down,
                pressed,
                first,
                ..
            },
            Mode::Turbo {
                first_ns,
                period_ns,
            },
        ) = (state, &binding.mode)
        else {
            return;
        };
        let length_ns = if first { *first_ns } else { *period_ns };
        for target in targets(binding, side) {
            if down {
                self.let_go(step, *target);
            } else {
                self.hold(step, *target);
            }
        }
        self.drives[at].state = if down {
            State::Turbo {
                down: false,
                at: pressed + length_ns,
                pressed,
                first,
            }
        } else {
            State::Turbo {
                down: true,
                at: t_ns + period_ns / 2,
                pressed: t_ns,
                first: false,
            }
        };
    }

    fn toggle(&mut self, step: &mut Step<'_>, binding: &Binding, index: usize) {
        let toggled = &mut self.memory[index].toggled;
        *toggled = !*toggled;
        let down = *toggled;
        for target in &binding.targets {
            if down {
                self.hold(step, *target);
            } else {
                self.let_go(step, *target);
            }
        }
    }

    fn press_sticky(&mut self, step: &mut Step<'_>, binding: &Binding, index: usize) {
        let next = match self.memory[index].sticky {
            Sticky::Off => Sticky::Latched { used: false },
            Sticky::Latched { .. } => Sticky::Locked,
            Sticky::Locked => Sticky::Off,
        };
        let before = std::mem::replace(&mut self.memory[index].sticky, next);
        for target in &binding.targets {
            match (before, next) {
                (Sticky::Off, _) => self.hold(step, *target),
                (_, Sticky::Off) => self.let_go(step, *target),
                _ => {}
            }
        }
    }

    fn mark_stickies_used(&mut self) {
        for index in &self.stickies {
            if let Sticky::Latched { used } = &mut self.memory[*index].sticky {
                *used = true;
            }
        }
    }

    /// The press for which a sticky key was meant is over.
    fn unlatch_stickies(&mut self, step: &mut Step<'_>) {
        let profile = step.profile;
        for listed in 0..self.stickies.len() {
            let index = self.stickies[listed];
            if self.memory[index].sticky == (Sticky::Latched { used: true }) {
                self.memory[index].sticky = Sticky::Off;
                for target in &profile.bindings[index].targets {
                    self.let_go(step, *target);
                }
            }
        }
    }

    fn run_macro(&mut self, step: &mut Step<'_>, index: usize) {
        let Step { profile, t_ns, .. } = *step;
        let Mode::Macro(steps) = &profile.bindings[index].mode else {
            return;
        };
        while let Some(mut runner) = self.memory[index].runner {
            match runner.step(steps, t_ns) {
                Due::Press(target) => self.hold(step, target),
                Due::Release(target) => self.let_go(step, target),
                Due::Wait => {
                    self.memory[index].runner = Some(runner);
                    return;
                }
                Due::End => {
                    self.memory[index].runner = None;
                    self.unlatch_stickies(step);
                    return;
                }
            }
            self.memory[index].runner = Some(runner);
        }
    }
}

/// Bindings of a mode.
fn of_mode(profile: &Profile, is_one: fn(&Mode) -> bool) -> Vec<usize> {
    let all = profile.bindings.iter().enumerate();
    all.filter(|(_, binding)| is_one(&binding.mode))
        .map(|(index, _)| index)
        .collect()
}

/// What one side of a binding drives.
fn targets(binding: &Binding, side: Side) -> &[Target] {
    match (side, &binding.gesture) {
        (Side::Second, Gesture::TapHold(own)) => &own.hold,
        _ => &binding.targets,
    }
}
