//! How the player of the level moves: like the plumber of the NES, since that is what many will play next.
//!
//! Once a step (60 a second) the velocity is added to the place, then gravity to the velocity. Gravity is light while the
//! jump is held and the body rises, heavy else: so how long the pad is pressed is how high the jump goes, to the step.
//! A jump from a run is stronger, and so is its gravity. Units are pixels (16 a tile) and steps; y is up.
//!
//! Two mercies that players expect of a level of today: a jump that is pressed a little too early counts when the feet touch
//! the ground, and one a little too late counts behind the edge.

use super::level::Level;

/// Steps a second.
pub const STEPS_PER_S: f64 = 60.0;

/// Upward velocity of a jump, gravity while it is held, and else, px a step and step: standing or walking; running.
const JUMP: Lift = Lift {
    velocity: 4.0,
    held: 0.125,
    free: 0.4375,
};
const RUNNING_JUMP: Lift = Lift {
    velocity: 5.0,
    held: 0.156_25,
    free: 0.5625,
};
/// A jump is a running one from this speed on, px a step.
const RUNNING: f64 = 2.3125;
/// Fastest walk, run and fall, px a step.
const WALK: f64 = 1.5625;
const RUN: f64 = 2.5625;
const FALL: f64 = 4.0;
/// Gain of speed when walking and when running, and loss with nothing held, px a step and step.
const WALK_GAIN: f64 = 0.037;
const RUN_GAIN: f64 = 0.0557;
const LOSS: f64 = 0.051;
/// A jump pressed this many steps before landing, or after walking off an edge, still counts.
const EARLY_STEPS: u32 = 5;
const LATE_STEPS: u32 = 5;
/// The player's size, px.
pub(super) const SIZE: [f64; 2] = [12.0, 15.0];

#[derive(Clone, Copy, Debug, PartialEq)]
struct Lift {
    velocity: f64,
    held: f64,
    free: f64,
}

/// What is held in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Buttons {
    /// Towards the start.
    pub left: bool,
    /// Towards the end.
    pub right: bool,
    /// Faster.
    pub run: bool,
    /// Higher.
    pub jump: bool,
}

/// The player.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Middle of the feet, px.
    pub place: [f64; 2],
    /// Velocity, px a step.
    pub velocity: [f64; 2],
    /// Whether it stands.
    pub on_ground: bool,
    /// Where the last jump began, px.
    pub took_off: f64,
    lift: Lift,
    /// Steps since it stood, since jump was pressed.
    since_ground: u32,
    since_press: u32,
    was_held: bool,
    jumping: bool,
}

/// What a step has brought.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Happened {
    /// It has taken off.
    pub jumped: bool,
    /// It has begun to fall after a jump: as high as it gets.
    pub peaked: bool,
    /// It has landed.
    pub landed: bool,
}

impl Body {
    /// Stands at a place.
    #[must_use]
    pub fn new(place: [f64; 2]) -> Self {
        Self {
            place,
            velocity: [0.0; 2],
            on_ground: true,
            took_off: place[1],
            lift: JUMP,
            since_ground: 0,
            since_press: u32::MAX,
            was_held: false,
            jumping: false,
        }
    }

    /// Whether it rises from a jump.
    #[must_use]
    pub fn is_rising(&self) -> bool {
        self.jumping
    }

    /// Whether its last jump began from a run.
    #[must_use]
    pub fn is_running_jump(&self) -> bool {
        self.lift == RUNNING_JUMP
    }

    /// The press that was seen last is over: the next is a new one, even if no step has seen the jump not held.
    pub fn let_go(&mut self) {
        self.was_held = false;
    }

    /// One step.
    pub fn step(&mut self, buttons: Buttons, level: &Level) -> Happened {
        let mut happened = Happened::default();
        self.since_press = if buttons.jump && !self.was_held {
            0
        } else {
            self.since_press.saturating_add(1)
        };
        self.was_held = buttons.jump;
        self.walk(buttons);
        if self.since_press <= EARLY_STEPS && self.since_ground <= LATE_STEPS && !self.jumping {
            self.lift = if self.velocity[0].abs() >= RUNNING {
                RUNNING_JUMP
            } else {
                JUMP
            };
            self.velocity[1] = self.lift.velocity;
            self.took_off = self.place[1];
            self.jumping = true;
            self.since_press = u32::MAX;
            self.since_ground = u32::MAX;
            happened.jumped = true;
        }
        self.slide(level);
        let was_on_ground = self.on_ground;
        let rose = self.jumping;
        self.fall(level);
        happened.landed = self.on_ground && !was_on_ground;
        let gravity = if buttons.jump && self.velocity[1] > 0.0 {
            self.lift.held
        } else {
            self.lift.free
        };
        if self.on_ground {
            self.since_ground = 0;
            self.lift = JUMP;
        } else {
            self.since_ground = self.since_ground.saturating_add(1);
            self.velocity[1] = (self.velocity[1] - gravity).max(-FALL);
        }
        if self.jumping && self.velocity[1] <= 0.0 {
            self.jumping = false;
        }
        happened.peaked = rose && !self.jumping;
        happened
    }

    fn walk(&mut self, buttons: Buttons) {
        let wish = f64::from(i8::from(buttons.right) - i8::from(buttons.left));
        let speed = &mut self.velocity[0];
        if wish == 0.0 {
            let less = (speed.abs() - LOSS).max(0.0);
            *speed = less.copysign(*speed);
            return;
        }
        let (gain, most) = if buttons.run {
            (RUN_GAIN, RUN)
        } else {
            (WALK_GAIN, WALK)
        };
        // Against the way it goes, both the loss and the gain slow it down.
        let gain = if *speed * wish < 0.0 {
            gain + LOSS
        } else {
            gain
        };
        let faster = *speed + wish * gain;
        *speed = if faster.abs() <= most {
            faster
        } else {
            // From a run to a walk it slows down by and by.
            (speed.abs() - LOSS).max(most).copysign(faster)
        };
    }

    /// Moves to the side, up to a wall.
    fn slide(&mut self, level: &Level) {
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

    /// Moves up or down, to a ceiling or onto the ground.
    fn fall(&mut self, level: &Level) {
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
        // Standing, the ground is looked for a little below.
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

/// How high a jump goes whose press is held for so many steps, px, from a standing or a running start.
#[must_use]
pub fn height(steps_held: u32, running: bool) -> f64 {
    let lift = if running { RUNNING_JUMP } else { JUMP };
    let (mut y, mut velocity) = (0.0, lift.velocity);
    let mut step = 0;
    while velocity > 0.0 {
        y += velocity;
        step += 1;
        velocity -= if step <= steps_held {
            lift.held
        } else {
            lift.free
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
    /// Whole pixels were counted there, from a place that was rounded too.
    const TOLERANCE_PX: f64 = 1.0;

    /// The height that a body reaches on level ground.
    fn jumped(steps_held: u32, running: bool) -> f64 {
        let level = Level::flat(400);
        let mut body = Body::new([40.0, level.floor()]);
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
            highest = highest.max(body.place[1] - level.floor());
        }
        assert!(body.on_ground, "down again");
        highest
    }

    #[test]
    fn jumps_are_as_high_as_on_the_nes() {
        for (steps, standing, running) in NES {
            for (is_running, wanted) in [(false, standing), (true, running)] {
                let reached = jumped(steps, is_running);
                assert!(
                    (reached - wanted).abs() <= TOLERANCE_PX,
                    "{steps} steps, running {is_running}: {reached:.1} for {wanted}"
                );
                assert!((height(steps, is_running) - reached).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn a_longer_press_is_a_higher_jump_up_to_the_top() {
        let heights: Vec<f64> = (1..=31).map(|steps| height(steps, false)).collect();
        assert!(heights.windows(2).all(|pair| pair[0] < pair[1]));
        assert_eq!(height(40, false), height(60, false));
    }

    #[test]
    fn a_new_jump_needs_a_new_press() {
        let level = Level::flat(100);
        let mut body = Body::new([40.0, level.floor()]);
        let held = Buttons {
            jump: true,
            ..Buttons::default()
        };
        let jumps = (0..300).filter(|_| body.step(held, &level).jumped).count();
        assert_eq!(jumps, 1);
    }

    #[test]
    fn a_press_just_before_landing_jumps_on_landing() {
        for (early, jumps) in [(4, 2), (12, 1)] {
            let level = Level::flat(100);
            let mut body = Body::new([40.0, level.floor()]);
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
    fn a_press_just_behind_an_edge_still_jumps() {
        for (late, jumps) in [(3, true), (10, false)] {
            let level = Level::ledge();
            let mut body = Body::new([40.0, level.floor()]);
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
