//! Motion of the player, with the constants of Super Mario Bros on the NES.
//!
//! Each step (60 a second) adds the velocity to the position, then gravity to the velocity. Gravity is weak while jump is
//! held and the body rises: the length of the press sets the height of the jump. A jump from a run is stronger, and so is
//! its gravity. Units: pixels (16 a tile) and steps; y points up.
//!
//! As in modern games, a jump pressed slightly before landing counts on landing (jump buffering), and one pressed slightly
//! after walking off an edge still counts (coyote time).

use super::level::Level;

/// Steps per second.
pub(super) const STEPS_PER_S: f64 = 60.0;

/// Jump from standing or walking, and from running.
const JUMP: JumpPhysics = JumpPhysics {
    velocity: 4.0,
    held: 0.125,
    free: 0.4375,
};
const RUNNING_JUMP: JumpPhysics = JumpPhysics {
    velocity: 5.0,
    held: 0.156_25,
    free: 0.5625,
};
/// Speed from which a jump is a running jump, px per step.
const RUNNING: f64 = 2.3125;
/// Maximum speed of walking, running and falling, px per step.
const WALK: f64 = 1.5625;
const RUN: f64 = 2.5625;
const FALL: f64 = 4.0;
/// Acceleration when walking and running, and deceleration with nothing held, px per step^2.
const WALK_GAIN: f64 = 0.037;
const RUN_GAIN: f64 = 0.0557;
const LOSS: f64 = 0.051;
/// A jump pressed this many steps before landing, or after walking off an edge, still counts.
const EARLY_STEPS: u32 = 5;
const LATE_STEPS: u32 = 5;
/// Width and height of the player, px.
pub(super) const SIZE: [f64; 2] = [12.0, 15.0];

#[derive(Clone, Copy, Debug, PartialEq)]
struct JumpPhysics {
    /// Initial velocity, px per step.
    velocity: f64,
    /// Gravity while jump is held, and otherwise, px per step^2.
    held: f64,
    free: f64,
}

/// Buttons held in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Buttons {
    /// Walk towards the start.
    pub(super) left: bool,
    /// Walk towards the flag.
    pub(super) right: bool,
    /// Run.
    pub(super) run: bool,
    /// Jump.
    pub(super) jump: bool,
}

/// The player.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Body {
    /// Centre of the feet, px.
    pub(super) place: [f64; 2],
    /// Velocity, px per step.
    pub(super) velocity: [f64; 2],
    /// Whether the player stands on something.
    pub(super) on_ground: bool,
    /// Height of the feet when the last jump began, px.
    pub(super) jumped_from: f64,
    jump: JumpPhysics,
    /// Steps since the player stood, and since jump was pressed.
    since_ground: u32,
    since_press: u32,
    was_held: bool,
    jumping: bool,
}

/// Changes of the player's state in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct StepEvents {
    /// A jump began.
    pub(super) jumped: bool,
    /// A jump reached its highest point.
    pub(super) peaked: bool,
    /// The player landed.
    pub(super) landed: bool,
}

impl Body {
    /// A player who stands at a point.
    pub(super) fn new(place: [f64; 2]) -> Self {
        Self {
            place,
            velocity: [0.0; 2],
            on_ground: true,
            jumped_from: place[1],
            jump: JUMP,
            since_ground: 0,
            since_press: u32::MAX,
            was_held: false,
            jumping: false,
        }
    }

    /// Whether the last jump began from a run.
    pub(super) fn is_running_jump(&self) -> bool {
        self.jump == RUNNING_JUMP
    }

    /// Ends the press of jump, so that the next one counts even if no step runs in between.
    pub(super) fn release_jump(&mut self) {
        self.was_held = false;
    }

    /// Advances by one step.
    pub(super) fn step(&mut self, buttons: Buttons, level: &Level) -> StepEvents {
        let mut events = StepEvents::default();
        self.since_press = if buttons.jump && !self.was_held {
            0
        } else {
            self.since_press.saturating_add(1)
        };
        self.was_held = buttons.jump;
        self.walk(buttons);
        if self.since_press <= EARLY_STEPS && self.since_ground <= LATE_STEPS && !self.jumping {
            self.jump = if self.velocity[0].abs() >= RUNNING {
                RUNNING_JUMP
            } else {
                JUMP
            };
            self.velocity[1] = self.jump.velocity;
            self.jumped_from = self.place[1];
            self.jumping = true;
            self.since_press = u32::MAX;
            self.since_ground = u32::MAX;
            events.jumped = true;
        }
        self.move_sideways(level);
        let was_on_ground = self.on_ground;
        let rose = self.jumping;
        self.move_vertically(level);
        events.landed = self.on_ground && !was_on_ground;
        let gravity = if buttons.jump && self.velocity[1] > 0.0 {
            self.jump.held
        } else {
            self.jump.free
        };
        if self.on_ground {
            self.since_ground = 0;
            self.jump = JUMP;
        } else {
            self.since_ground = self.since_ground.saturating_add(1);
            self.velocity[1] = (self.velocity[1] - gravity).max(-FALL);
        }
        if self.jumping && self.velocity[1] <= 0.0 {
            self.jumping = false;
        }
        events.peaked = rose && !self.jumping;
        events
    }

    fn walk(&mut self, buttons: Buttons) {
        let direction = f64::from(i8::from(buttons.right) - i8::from(buttons.left));
        let speed = &mut self.velocity[0];
        if direction == 0.0 {
            let less = (speed.abs() - LOSS).max(0.0);
            *speed = less.copysign(*speed);
            return;
        }
        let (gain, most) = if buttons.run {
            (RUN_GAIN, RUN)
        } else {
            (WALK_GAIN, WALK)
        };
        // Against the current direction, deceleration is added.
        let gain = if *speed * direction < 0.0 {
            gain + LOSS
        } else {
            gain
        };
        let faster = *speed + direction * gain;
        *speed = if faster.abs() <= most {
            faster
        } else {
            // From a run to a walk the speed falls gradually.
            (speed.abs() - LOSS).max(most).copysign(faster)
        };
    }

    /// Moves sideways, up to a wall.
    fn move_sideways(&mut self, level: &Level) {
        let [speed, _] = self.velocity;
        if speed == 0.0 {
            return;
        }
        let next = self.place[0] + speed;
        let half = SIZE[0] / 2.0;
        let edge = next + half.copysign(speed);
        if level.blocks_side(edge, self.place[1], SIZE[1]) {
            let wall = level.wall(edge, speed > 0.0);
            self.place[0] = wall - half.copysign(speed);
            self.velocity[0] = 0.0;
        } else {
            self.place[0] = next.clamp(half, level.width() - half);
        }
    }

    /// Moves up to a ceiling or down to the ground.
    fn move_vertically(&mut self, level: &Level) {
        let [x, y] = self.place;
        let next = y + self.velocity[1];
        let half = SIZE[0] / 2.0;
        if self.velocity[1] > 0.0 {
            self.on_ground = false;
            match level.ceiling(x, half, y + SIZE[1], next + SIZE[1]) {
                Some(ceiling) => {
                    self.place[1] = ceiling - SIZE[1];
                    self.velocity[1] = 0.0;
                }
                None => self.place[1] = next,
            }
            return;
        }
        // A standing player looks for ground 1 px below.
        let below = if self.on_ground { y - 1.0 } else { next };
        match level.ground(x, half, y, below) {
            Some(ground) => {
                self.place[1] = ground;
                self.velocity[1] = 0.0;
                self.on_ground = true;
            }
            None => {
                self.place[1] = next;
                self.on_ground = false;
            }
        }
    }
}

/// Height of a jump, px, by the steps that jump is held.
pub(super) fn jump_height(steps_held: u32, running: bool) -> f64 {
    let jump = if running { RUNNING_JUMP } else { JUMP };
    let (mut y, mut velocity) = (0.0, jump.velocity);
    let mut step = 0;
    while velocity > 0.0 {
        y += velocity;
        step += 1;
        velocity -= if step <= steps_held {
            jump.held
        } else {
            jump.free
        };
    }
    y
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Super Mario Bros on the NES: steps held, height from a standing and a running start, px.
    const NES: [(u32, f64, f64); 7] = [
        (1, 24.0, 29.0),
        (3, 29.0, 36.0),
        (5, 34.0, 42.0),
        (10, 45.0, 56.0),
        (15, 54.0, 67.0),
        (20, 60.0, 75.0),
        (31, 66.0, 83.0),
    ];
    /// The table counts whole pixels.
    const TOLERANCE_PX: f64 = 1.0;

    /// Height that a body reaches on flat ground, px.
    fn jumped(steps_held: u32, running: bool) -> f64 {
        let level = Level::flat(400);
        let mut body = Body::new([40.0, level.starts[0][1]]);
        let ahead = Buttons {
            right: running,
            run: running,
            ..Buttons::default()
        };
        for _ in 0..90 {
            body.step(ahead, &level);
        }
        let mut highest: f64 = 0.0;
        for step in 0..90 {
            let jump = step < steps_held;
            body.step(Buttons { jump, ..ahead }, &level);
            highest = highest.max(body.place[1] - level.starts[0][1]);
        }
        assert!(body.on_ground, "down again");
        highest
    }

    #[test]
    fn jump_heights_match_the_nes() {
        for (steps, standing, running) in NES {
            for (is_running, wanted) in [(false, standing), (true, running)] {
                let reached = jumped(steps, is_running);
                assert!(
                    (reached - wanted).abs() <= TOLERANCE_PX,
                    "{steps} steps, running {is_running}: {reached:.1} for {wanted}"
                );
                assert!((jump_height(steps, is_running) - reached).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn longer_presses_jump_higher_up_to_a_limit() {
        let heights: Vec<f64> = (1..=31).map(|steps| jump_height(steps, false)).collect();
        assert!(heights.windows(2).all(|pair| pair[0] < pair[1]));
        assert_eq!(jump_height(40, false), jump_height(60, false));
    }

    #[test]
    fn a_new_jump_needs_a_new_press() {
        let level = Level::flat(100);
        let mut body = Body::new([40.0, level.starts[0][1]]);
        let held = Buttons {
            jump: true,
            ..Buttons::default()
        };
        let jumps = (0..300).filter(|_| body.step(held, &level).jumped).count();
        assert_eq!(jumps, 1);
    }

    #[test]
    fn a_jump_is_buffered_before_landing() {
        for (early, jumps) in [(4, 2), (12, 1)] {
            let level = Level::flat(100);
            let mut body = Body::new([40.0, level.starts[0][1]]);
            let mut landing = body;
            let press = |jump| Buttons {
                jump,
                ..Buttons::default()
            };
            landing.step(press(true), &level);
            let air = (1..)
                .find(|_| landing.step(press(false), &level).landed)
                .expect("it lands");
            let mut count = 0;
            for step in 0..=air + 40 {
                let jump = step == 0 || step == air - early;
                count += usize::from(body.step(press(jump), &level).jumped);
            }
            assert_eq!(count, jumps, "{early} steps early");
        }
    }

    #[test]
    fn a_jump_just_after_an_edge_counts() {
        for (late, jumps) in [(3, true), (10, false)] {
            let level = Level::ledge();
            let mut body = Body::new([40.0, level.starts[0][1]]);
            let ahead = Buttons {
                right: true,
                ..Buttons::default()
            };
            while body.on_ground {
                body.step(ahead, &level);
            }
            let mut jumped = false;
            for step in 0..=late {
                let jump = step == late;
                jumped |= body.step(Buttons { jump, ..ahead }, &level).jumped;
            }
            assert_eq!(jumped, jumps, "{late} steps late");
        }
    }
}
