//! Modes with a memory: toggles, sticky keys, macros.

use super::Driver;
use super::binding_memory::StickyState;
use super::macro_runner::{MacroAction, MacroRunner};
use crate::gesture::moment::Moment;
use crate::profile::Mode;

impl Driver {
    pub(super) fn toggle(&mut self, moment: &mut Moment<'_>, index: usize) {
        let targets = &moment.profile.bindings[index].targets;
        let is_toggled = &mut self.memory[index].is_toggled;
        *is_toggled = !*is_toggled;
        if *is_toggled {
            self.hold_all(moment, targets);
        } else {
            self.let_go_all(moment, targets);
        }
    }

    pub(super) fn press_sticky(&mut self, moment: &mut Moment<'_>, index: usize) {
        let targets = &moment.profile.bindings[index].targets;
        let sticky = &mut self.memory[index].sticky;
        match *sticky {
            StickyState::Off => {
                *sticky = StickyState::Latched { is_used: false };
                self.hold_all(moment, targets);
            }
            StickyState::Latched { .. } => *sticky = StickyState::Locked,
            StickyState::Locked => {
                *sticky = StickyState::Off;
                self.let_go_all(moment, targets);
            }
        }
    }

    pub(super) fn mark_stickies_used(&mut self) {
        for index in &self.stickies {
            if let StickyState::Latched { is_used } = &mut self.memory[*index].sticky {
                *is_used = true;
            }
        }
    }

    /// The press that a sticky key was for is over.
    pub(super) fn unlatch_stickies(&mut self, moment: &mut Moment<'_>) {
        for listed in 0..self.stickies.len() {
            let index = self.stickies[listed];
            if self.memory[index].sticky == (StickyState::Latched { is_used: true }) {
                self.memory[index].sticky = StickyState::Off;
                self.let_go_all(moment, &moment.profile.bindings[index].targets);
            }
        }
    }

    /// Macros that run.
    pub(super) fn runners(&self) -> impl Iterator<Item = &MacroRunner> {
        let macros = self.macros.iter();
        macros.filter_map(|index| self.memory[*index].runner.as_ref())
    }

    /// Starts a macro, unless it runs already.
    pub(super) fn start_macro(&mut self, moment: &mut Moment<'_>, index: usize) {
        let runner = &mut self.memory[index].runner;
        runner.get_or_insert_with(|| MacroRunner::new(moment.t_ns));
        self.run_macro(moment, index);
    }

    pub(super) fn tick_macros(&mut self, moment: &mut Moment<'_>) {
        let t_ns = moment.t_ns;
        for listed in 0..self.macros.len() {
            let index = self.macros[listed];
            let runner = self.memory[index].runner.as_ref();
            if runner.is_some_and(|runner| runner.next_due() <= t_ns) {
                self.run_macro(moment, index);
            }
        }
    }

    fn run_macro(&mut self, moment: &mut Moment<'_>, index: usize) {
        let Moment { profile, t_ns, .. } = *moment;
        let Mode::Macro(steps) = &profile.bindings[index].mode else {
            return;
        };
        while let Some(runner) = &mut self.memory[index].runner {
            match runner.next_action(steps, t_ns) {
                MacroAction::Press(target) => self.hold(moment, target),
                MacroAction::Release(target) => self.let_go(moment, target),
                MacroAction::Wait => return,
                MacroAction::End => {
                    self.memory[index].runner = None;
                    self.unlatch_stickies(moment);
                }
            }
        }
    }
}
