//! The state of the practice level: player, coins, run, best times.

use std::collections::VecDeque;

use super::controls::{Controls, GameAction};
use super::event_queue::EventQueue;
use super::jumps::{Jump, JumpLog};
use super::level::{self, Level};
use super::physics::{Body, Buttons, SIZE, STEPS_PER_S};
use crate::profile::Profile;
use crate::types::{Action, Event, Nanos};

/// Points of the trail of a jump.
const MAX_TRAIL: usize = 48;
/// A coin this close to the player is taken, px.
const COIN_PX: f64 = 14.0;
/// The flag is reached this far before its pole, px.
const FLAG_PX: f64 = 8.0;
/// Steps after the end of a run before a jump starts the next one.
const REST_STEPS: u64 = 40;

/// Progress of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunStage {
    /// Waits for the first press.
    Ready,
    /// The clock runs.
    Running,
    /// The flag is reached.
    Done {
        /// Whether this is the best time.
        best: bool,
    },
}

/// The level being played.
#[derive(Clone, Debug)]
pub struct Practice {
    pub(super) level: Level,
    pub(super) body: Body,
    pub(super) controls: Controls,
    buttons: Buttons,
    /// Jump was pressed since the last step, even if it is released again.
    jump_pressed: bool,
    /// Source time of that press.
    press_ns: Nanos,
    /// For each coin of the level, whether it is taken.
    pub(super) coins_taken: Vec<bool>,
    stage: RunStage,
    /// Steps of this run.
    run_steps: u64,
    /// Steps since the start of the program: the clock of animations.
    pub(super) total_steps: u64,
    /// `total_steps` at the end of the last run.
    done_at: u64,
    /// Fastest run without and with auto-walk.
    best_steps: [Option<u64>; 2],
    auto_walk: bool,
    pub(super) falls: u32,
    furthest_px: f64,
    jumps: JumpLog,
    /// Positions of the player in the last jump, px.
    pub(super) trail: VecDeque<[f64; 2]>,
    queue: EventQueue,
}

impl Default for Practice {
    /// The level at its start; [`Practice::set_profile`] sets the controls.
    fn default() -> Self {
        let level = Level::built_in();
        Self {
            body: Body::new(level.starts[0]),
            controls: Controls::default(),
            buttons: Buttons::default(),
            jump_pressed: false,
            press_ns: 0,
            coins_taken: vec![false; level.coins.len()],
            stage: RunStage::Ready,
            run_steps: 0,
            total_steps: 0,
            done_at: 0,
            best_steps: [None; 2],
            auto_walk: false,
            falls: 0,
            furthest_px: 0.0,
            jumps: JumpLog::default(),
            trail: VecDeque::with_capacity(MAX_TRAIL),
            queue: EventQueue::default(),
            level,
        }
    }
}

impl Practice {
    /// Takes the controls from a profile.
    pub fn set_profile(&mut self, profile: &Profile) {
        let controls = Controls::from_profile(profile);
        if controls != self.controls {
            self.controls = controls;
            self.buttons = Buttons::default();
        }
    }

    /// Queues an event for the step in whose time it falls.
    pub fn push_event(&mut self, event: &Event) {
        self.queue.push(*event);
    }

    /// Releases all buttons and forgets events that were not played.
    pub fn release_all(&mut self) {
        self.buttons = Buttons::default();
        self.jump_pressed = false;
        self.queue.clear();
    }

    /// Plays for a time, s.
    pub fn advance(&mut self, dt_s: f64) {
        self.queue.advance(dt_s);
        while self.queue.start_step() {
            while let Some(event) = self.queue.pop_due() {
                self.apply(&event);
            }
            self.step();
        }
    }

    /// Goes back to the start.
    pub fn restart(&mut self) {
        self.body = Body::new(self.level.starts[0]);
        self.coins_taken.fill(false);
        self.stage = RunStage::Ready;
        self.run_steps = 0;
        self.falls = 0;
        self.furthest_px = 0.0;
        self.trail.clear();
        self.jump_pressed = false;
    }

    fn apply(&mut self, event: &Event) {
        match event.action {
            Action::Press(output) | Action::Release(output) => {
                if let Some(action) = self.controls.action(output) {
                    let held = matches!(event.action, Action::Press(_));
                    self.set_held(action, held, event.t_ns);
                }
            }
            Action::Axis(axis, value) => {
                if let Some([left, right]) = Controls::held_by_axis(axis, value) {
                    self.set_held(GameAction::Left, left, event.t_ns);
                    self.set_held(GameAction::Right, right, event.t_ns);
                }
            }
            Action::Motion { .. } | Action::Wheel { .. } => {}
        }
    }

    fn set_held(&mut self, action: GameAction, held: bool, t_ns: Nanos) {
        let button = match action {
            GameAction::Left => &mut self.buttons.left,
            GameAction::Right => &mut self.buttons.right,
            GameAction::Run => &mut self.buttons.run,
            GameAction::Jump => &mut self.buttons.jump,
        };
        let was_held = std::mem::replace(button, held);
        let is_jump = action == GameAction::Jump;
        if held && !was_held {
            if is_jump {
                self.jump_pressed = true;
                self.press_ns = t_ns;
                self.body.release_jump();
            }
            match self.stage {
                RunStage::Ready if action != GameAction::Run => self.stage = RunStage::Running,
                RunStage::Done { .. }
                    if is_jump && self.total_steps >= self.done_at + REST_STEPS =>
                {
                    self.restart();
                }
                _ => {}
            }
        }
        if is_jump && was_held && !held {
            self.jumps.release(self.press_ns, t_ns);
        }
    }

    fn step(&mut self) {
        self.total_steps += 1;
        let buttons = self.effective_buttons();
        let was_pressed = std::mem::take(&mut self.jump_pressed);
        let events = self.body.step(buttons, &self.level);
        if events.jumped {
            let released = was_pressed && !self.buttons.jump;
            let running = self.body.is_running_jump();
            self.jumps.start(self.press_ns, released, running);
            self.trail.clear();
        }
        let rise_px = self.body.place[1] - self.body.jumped_from;
        let peaked = events.peaked || self.body.on_ground;
        self.jumps.measure_step(rise_px, events.jumped, peaked);
        if !self.body.on_ground {
            if self.trail.len() == MAX_TRAIL {
                self.trail.pop_front();
            }
            self.trail.push_back(self.body.place);
        }
        if self.stage == RunStage::Running {
            self.run_steps += 1;
            self.take_coins();
            self.check_fall_or_flag();
        }
    }

    /// The buttons of this step: none after the end; with auto-walk, right unless left is held.
    fn effective_buttons(&self) -> Buttons {
        if matches!(self.stage, RunStage::Done { .. }) {
            return Buttons::default();
        }
        let walks = self.auto_walk && self.stage == RunStage::Running && !self.buttons.left;
        Buttons {
            jump: self.buttons.jump || self.jump_pressed,
            right: self.buttons.right || walks,
            ..self.buttons
        }
    }

    fn take_coins(&mut self) {
        let [x, y] = self.body.place;
        let middle = y + SIZE[1] / 2.0;
        for (coin, taken) in self.level.coins.iter().zip(&mut self.coins_taken) {
            *taken |= libm::hypot(coin[0] - x, coin[1] - middle) < COIN_PX;
        }
    }

    fn check_fall_or_flag(&mut self) {
        let [x, y] = self.body.place;
        if self.body.on_ground {
            self.furthest_px = self.furthest_px.max(x);
        }
        if y < level::BOTTOM {
            let starts = self.level.starts.iter().rev();
            let mut passed = starts.filter(|start| start[0] <= self.furthest_px);
            self.body = Body::new(*passed.next().unwrap_or(&self.level.starts[0]));
            self.falls += 1;
            self.trail.clear();
        } else if x >= self.level.flag[0] - FLAG_PX {
            let fastest = &mut self.best_steps[usize::from(self.auto_walk)];
            let best = fastest.is_none_or(|best| self.run_steps < best);
            if best {
                *fastest = Some(self.run_steps);
            }
            self.stage = RunStage::Done { best };
            self.done_at = self.total_steps;
        }
    }

    /// Position of the player's feet, px.
    #[must_use]
    pub fn player_px(&self) -> [f64; 2] {
        self.body.place
    }

    /// Progress of the run.
    #[must_use]
    pub fn stage(&self) -> RunStage {
        self.stage
    }

    /// Time of this run, s.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.run_steps as f64 / STEPS_PER_S
    }

    /// Whether the player walks to the right without input: then one finger or one switch plays the level.
    #[must_use]
    pub fn auto_walk(&self) -> bool {
        self.auto_walk
    }

    /// Switches auto-walk; a change restarts the level.
    pub fn set_auto_walk(&mut self, auto_walk: bool) {
        if auto_walk != self.auto_walk {
            self.auto_walk = auto_walk;
            self.restart();
        }
    }

    /// The best time with the current setting of auto-walk, s.
    #[must_use]
    pub fn best_s(&self) -> Option<f64> {
        self.best_steps[usize::from(self.auto_walk)].map(|steps| steps as f64 / STEPS_PER_S)
    }

    /// Sets the best time, as saved in an earlier session.
    pub fn set_best_s(&mut self, best_s: Option<f64>) {
        self.best_steps[usize::from(self.auto_walk)] = best_s
            .filter(|seconds| seconds.is_finite() && *seconds > 0.0)
            .map(|seconds| libm::round(seconds * STEPS_PER_S) as u64);
    }

    /// The last jumps, oldest first.
    pub fn jumps(&self) -> impl DoubleEndedIterator<Item = &Jump> + ExactSizeIterator {
        self.jumps.iter()
    }

    /// Whether the level has to be repainted although no event arrives.
    pub(super) fn is_moving(&self) -> bool {
        self.stage == RunStage::Running
            || !self.body.on_ground
            || !self.queue.is_empty()
            || (matches!(self.stage, RunStage::Done { .. })
                && self.total_steps < self.done_at + REST_STEPS)
    }
}
