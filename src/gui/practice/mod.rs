//! The practice level: a small platform level of our own, played by the same events as a game would get.
//!
//! ```text
//! Event ─▶ controls ─▶ physics + level ─▶ view
//! ```
//! The level runs in steps of a sixtieth of a second. Events carry the source's time, and each is given to the step in whose
//! time it falls, however rarely the window is drawn: so the length of a press is as exact as in a game, and the same events
//! give the same run.

mod chart;
mod controls;
mod level;
mod physics;
mod scene;
mod tab;
mod view;

pub use controls::{Controls, Deed};
pub use level::{A_WAY, Level, TILE, Tile};
pub use physics::{Body, Buttons, Happened, STEPS_PER_S, height};
pub use tab::PracticeTab;
pub use view::{Beside, PracticeView};

use std::collections::VecDeque;

use crate::profile::Profile;
use crate::types::{Action, Event, Nanos, ms_from_nanos};

/// Time of a step, ns.
const STEP_NS: i64 = (1e9 / STEPS_PER_S) as i64;
/// A window that was not drawn for longer goes on from where it was, s.
const LONGEST_S: f64 = 0.25;
/// Events that wait for their step; more are too old to matter.
const MOST_EVENTS: usize = 256;
/// Jumps that are remembered.
const MOST_JUMPS: usize = 40;
/// Places that the player was at, for its trail.
const MOST_TRAIL: usize = 48;
/// A coin is taken from so near, px.
const COIN_PX: f64 = 14.0;
/// The flag is reached this far before its pole, px.
const FLAG_PX: f64 = 8.0;
/// After the end, a press begins anew only after so many steps: the one that reached it does not.
const REST_STEPS: u64 = 40;
/// By how much the mapping of the source's time forgets a late event, ns a second.
const FORGET_NS_PER_S: f64 = 1e6;

/// Where a run is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Waits for the first press.
    Ready,
    /// The clock runs.
    Running,
    /// The flag is reached.
    Done {
        /// Whether faster than ever.
        best: bool,
    },
}

/// One jump: how long the press, how high the jump.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// When the press went out, in the source's time.
    since_ns: Nanos,
    /// Length of the press so far; final once it is over.
    pub held_ms: f64,
    /// Whether the press is over.
    pub released: bool,
    /// Height so far, px; final once it falls.
    pub height_px: f64,
    /// Whether it falls.
    pub peaked: bool,
    /// Whether it began from a run.
    pub running: bool,
}

/// The level being played.
#[derive(Clone, Debug)]
pub struct Practice {
    level: Level,
    body: Body,
    controls: Controls,
    buttons: Buttons,
    /// Jump was pressed since the last step: seen by it even if it is over.
    pressed: bool,
    press_ns: Nanos,
    coins: Vec<bool>,
    stage: Stage,
    /// Steps of this run, and of everything.
    steps: u64,
    clock: u64,
    done_at: u64,
    /// By hand, and walking by itself.
    best_steps: [Option<u64>; 2],
    walks: bool,
    falls: u32,
    furthest: f64,
    jumps: VecDeque<Jump>,
    trail: VecDeque<[f64; 2]>,
    /// Time of the level, ns: of the last step, and of the last look at it.
    step_ns: i64,
    now_ns: i64,
    /// What the source's time is ahead of the level's, once an event has come.
    ahead_ns: Option<i64>,
    waiting: VecDeque<Event>,
}

impl Default for Practice {
    fn default() -> Self {
        Self::new(Level::ours())
    }
}

impl Practice {
    /// A level, at its start; controls come with the first profile.
    #[must_use]
    pub fn new(level: Level) -> Self {
        Self {
            body: Body::new(level.starts[0]),
            controls: Controls::default(),
            buttons: Buttons::default(),
            pressed: false,
            press_ns: 0,
            coins: vec![false; level.coins.len()],
            stage: Stage::Ready,
            steps: 0,
            clock: 0,
            done_at: 0,
            best_steps: [None; 2],
            walks: false,
            falls: 0,
            furthest: 0.0,
            jumps: VecDeque::with_capacity(MOST_JUMPS),
            trail: VecDeque::with_capacity(MOST_TRAIL),
            step_ns: 0,
            now_ns: 0,
            ahead_ns: None,
            waiting: VecDeque::with_capacity(MOST_EVENTS),
            level,
        }
    }

    /// Plays by a profile's outputs from now on.
    pub fn follow(&mut self, profile: &Profile) {
        let controls = Controls::of(profile);
        if controls != self.controls {
            self.controls = controls;
            self.buttons = Buttons::default();
        }
    }

    /// Takes an event; it counts in the step in whose time it falls.
    pub fn event(&mut self, event: &Event) {
        if self.waiting.len() == MOST_EVENTS {
            self.waiting.pop_front();
        }
        self.waiting.push_back(*event);
    }

    /// Plays on by a time, s.
    pub fn advance(&mut self, dt_s: f64) {
        let dt_s = if dt_s.is_finite() {
            dt_s.clamp(0.0, LONGEST_S)
        } else {
            0.0
        };
        self.now_ns += (dt_s * 1e9) as i64;
        // The newest event has just come: the source's time is at least that of the level's now.
        if let Some(newest) = self.waiting.iter().map(|event| event.t_ns as i64).max() {
            let ahead = newest - self.now_ns;
            let before = self
                .ahead_ns
                .map(|before| before - (dt_s * FORGET_NS_PER_S) as i64);
            self.ahead_ns = Some(match before {
                // A source that began anew counts its time anew.
                Some(before) if (ahead - before).abs() < 1_000_000_000 => before.max(ahead),
                _ => ahead,
            });
        }
        while self.step_ns + STEP_NS <= self.now_ns {
            self.step_ns += STEP_NS;
            let until = self.step_ns + self.ahead_ns.unwrap_or(0);
            while let Some(event) = self.waiting.front().copied()
                && event.t_ns as i64 <= until
            {
                self.waiting.pop_front();
                self.take(&event);
            }
            self.step();
        }
    }

    /// Back to the start.
    pub fn restart(&mut self) {
        self.body = Body::new(self.level.starts[0]);
        self.coins.fill(false);
        self.stage = Stage::Ready;
        self.steps = 0;
        self.falls = 0;
        self.furthest = 0.0;
        self.trail.clear();
        self.pressed = false;
    }

    fn take(&mut self, event: &Event) {
        match event.action {
            Action::Press(output) => {
                if let Some(deed) = self.controls.deed(output) {
                    self.set(deed, true, event.t_ns);
                }
            }
            Action::Release(output) => {
                if let Some(deed) = self.controls.deed(output) {
                    self.set(deed, false, event.t_ns);
                }
            }
            Action::Axis(axis, value) => {
                if let Some([left, right]) = Controls::axis(axis, value) {
                    self.set(Deed::Left, left, event.t_ns);
                    self.set(Deed::Right, right, event.t_ns);
                }
            }
            Action::Motion { .. } | Action::Wheel { .. } => {}
        }
    }

    fn set(&mut self, deed: Deed, held: bool, t_ns: Nanos) {
        let button = match deed {
            Deed::Left => &mut self.buttons.left,
            Deed::Right => &mut self.buttons.right,
            Deed::Run => &mut self.buttons.run,
            Deed::Jump => &mut self.buttons.jump,
        };
        let before = std::mem::replace(button, held);
        if held && !before {
            if deed == Deed::Jump {
                self.pressed = true;
                self.press_ns = t_ns;
                self.body.let_go();
            }
            match self.stage {
                Stage::Ready if deed != Deed::Run => self.stage = Stage::Running,
                Stage::Done { .. }
                    if deed == Deed::Jump && self.clock >= self.done_at + REST_STEPS =>
                {
                    self.restart();
                }
                _ => {}
            }
        }
        if deed == Deed::Jump && !held && before {
            let press_ns = self.press_ns;
            if let Some(jump) = self
                .jumps
                .back_mut()
                .filter(|jump| jump.since_ns == press_ns && !jump.released)
            {
                jump.held_ms = ms_from_nanos(t_ns.saturating_sub(press_ns));
                jump.released = true;
            }
        }
    }

    fn step(&mut self) {
        self.clock += 1;
        let is_done = matches!(self.stage, Stage::Done { .. });
        let buttons = if is_done {
            Buttons::default()
        } else {
            Buttons {
                jump: self.buttons.jump || self.pressed,
                right: self.buttons.right
                    || (self.walks && self.stage == Stage::Running && !self.buttons.left),
                ..self.buttons
            }
        };
        let was_pressed = std::mem::take(&mut self.pressed);
        let happened = self.body.step(buttons, &self.level);
        if happened.jumped {
            if self.jumps.len() == MOST_JUMPS {
                self.jumps.pop_front();
            }
            self.jumps.push_back(Jump {
                since_ns: self.press_ns,
                held_ms: 1000.0 / STEPS_PER_S,
                released: was_pressed && !self.buttons.jump,
                height_px: 0.0,
                peaked: false,
                running: self.body.is_running_jump(),
            });
            self.trail.clear();
        }
        self.measure(happened);
        if self.stage == Stage::Running {
            self.steps += 1;
            self.collect();
            self.arrive();
        }
    }

    /// Follows the last jump.
    fn measure(&mut self, happened: Happened) {
        let rise = self.body.place[1] - self.body.took_off;
        if let Some(jump) = self.jumps.back_mut() {
            if !jump.released && !happened.jumped {
                jump.held_ms += 1000.0 / STEPS_PER_S;
            }
            if !jump.peaked {
                jump.height_px = jump.height_px.max(rise);
                jump.peaked = happened.peaked || self.body.on_ground;
            }
        }
        if !self.body.on_ground {
            if self.trail.len() == MOST_TRAIL {
                self.trail.pop_front();
            }
            self.trail.push_back(self.body.place);
        }
    }

    fn collect(&mut self) {
        let [x, y] = self.body.place;
        let middle = y + physics::SIZE[1] / 2.0;
        for (coin, taken) in self.level.coins.iter().zip(&mut self.coins) {
            *taken |= libm::hypot(coin[0] - x, coin[1] - middle) < COIN_PX;
        }
    }

    fn arrive(&mut self) {
        let [x, y] = self.body.place;
        if self.body.on_ground {
            self.furthest = self.furthest.max(x);
        }
        if y < level::BOTTOM {
            let start = self
                .level
                .starts
                .iter()
                .rev()
                .find(|start| start[0] <= self.furthest);
            self.body = Body::new(*start.unwrap_or(&self.level.starts[0]));
            self.falls += 1;
            self.trail.clear();
        } else if x >= self.level.flag[0] - FLAG_PX {
            let fastest = &mut self.best_steps[usize::from(self.walks)];
            let best = fastest.is_none_or(|best| self.steps < best);
            if best {
                *fastest = Some(self.steps);
            }
            self.stage = Stage::Done { best };
            self.done_at = self.clock;
        }
    }

    /// The level.
    #[must_use]
    pub fn level(&self) -> &Level {
        &self.level
    }

    /// The player.
    #[must_use]
    pub fn body(&self) -> &Body {
        &self.body
    }

    /// What plays it.
    #[must_use]
    pub fn controls(&self) -> &Controls {
        &self.controls
    }

    /// What is held.
    #[must_use]
    pub fn buttons(&self) -> Buttons {
        self.buttons
    }

    /// Where the run is.
    #[must_use]
    pub fn stage(&self) -> Stage {
        self.stage
    }

    /// Time of this run, s.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.steps as f64 / STEPS_PER_S
    }

    /// Whether the player walks to the right by itself: then one finger or one switch plays the level.
    #[must_use]
    pub fn walks(&self) -> bool {
        self.walks
    }

    /// Lets the player walk by itself, or not; begins anew.
    pub fn set_walks(&mut self, walks: bool) {
        if walks != self.walks {
            self.walks = walks;
            self.restart();
        }
    }

    /// The fastest run of this way of playing, s.
    #[must_use]
    pub fn best_s(&self) -> Option<f64> {
        self.best_steps[usize::from(self.walks)].map(|steps| steps as f64 / STEPS_PER_S)
    }

    /// Sets the fastest run: from what was kept.
    pub fn set_best_s(&mut self, best_s: Option<f64>) {
        self.best_steps[usize::from(self.walks)] = best_s
            .filter(|seconds| seconds.is_finite() && *seconds > 0.0)
            .map(|seconds| libm::round(seconds * STEPS_PER_S) as u64);
    }

    /// For each coin of the level, whether it is taken.
    #[must_use]
    pub fn taken(&self) -> &[bool] {
        &self.coins
    }

    /// How often the player fell in this run.
    #[must_use]
    pub fn falls(&self) -> u32 {
        self.falls
    }

    /// The last jumps, the newest at the end.
    pub fn jumps(&self) -> impl DoubleEndedIterator<Item = &Jump> + ExactSizeIterator {
        self.jumps.iter()
    }

    /// Where the player was in the air, lately.
    pub fn trail(&self) -> impl ExactSizeIterator<Item = &[f64; 2]> {
        self.trail.iter()
    }

    /// Steps since it was made: for what moves by itself.
    #[must_use]
    pub fn clock(&self) -> u64 {
        self.clock
    }

    /// Whether it must be drawn again though no event comes.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.stage == Stage::Running
            || !self.body.on_ground
            || !self.waiting.is_empty()
            || (matches!(self.stage, Stage::Done { .. }) && self.clock < self.done_at + REST_STEPS)
    }
}

#[cfg(test)]
mod tests;
