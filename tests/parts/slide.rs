//! A fast slide on a board whose drives are read in turn: the touch is where the finger is, not where its frame began, and it is one touch.

use gelpad::eit::Press;
use gelpad::engine::Input;
use gelpad::source::{Noise, SimulatedPad};
use gelpad::types::{Nanos, Part, PointMm};

use super::board::pad;
use super::play::{builder, engine};

const DRIVES: usize = 16;
/// 100 frames a second.
const PART_NS: Nanos = 625_000;
const MM_PER_S: f64 = 300.0;
/// Parts before the finger lands, while it slides and after it has lifted.
const PARTS: [usize; 3] = [480, 280, 160];
/// A finger lands at rest: its velocity is known some frames later.
const SETTLED_PARTS: usize = 80;
/// Both coordinates grow alike.
const DIAGONAL: [f64; 2] = [std::f64::consts::FRAC_1_SQRT_2; 2];

/// A finger that slides from a place along a unit vector.
#[derive(Clone, Copy)]
struct Slide {
    seed: u64,
    from_mm: PointMm,
    direction: [f64; 2],
    radius_mm: f64,
    rise: f64,
    /// Where another finger lands and rests, and how many parts later.
    second: Option<(PointMm, usize)>,
    /// What happens to a part.
    damage: Option<(usize, Damage)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Damage {
    /// Its readings arrive in the wrong order.
    Reversed,
    /// It does not arrive.
    Lost,
}

/// What was seen of a slide.
struct Seen {
    /// How far the touch is behind its finger at each part, mm.
    lags_mm: Vec<f64>,
    /// For each touch, the part since the finger landed in which it was first seen.
    downs: Vec<usize>,
}

impl Slide {
    fn new(seed: u64, from_mm: PointMm, direction: [f64; 2]) -> Self {
        Self {
            seed,
            from_mm,
            direction,
            radius_mm: 7.0,
            rise: 1.2,
            second: None,
            damage: None,
        }
    }

    fn at_mm(&self, part: usize) -> PointMm {
        let way_mm = MM_PER_S * part as f64 * PART_NS as f64 * 1e-9;
        [0, 1].map(|k| self.from_mm[k] + way_mm * self.direction[k])
    }

    /// The fingers on the pad at a part since the first landed.
    fn presses(&self, part: usize) -> Vec<Press> {
        let press = |centre_mm| Press {
            centre_mm,
            radius_mm: self.radius_mm,
            rise: self.rise,
        };
        let second = self.second.filter(|(_, lands)| part >= *lands);
        let places = [self.at_mm(part)].into_iter();
        let places = places.chain(second.map(|(at_mm, _)| at_mm));
        places.map(press).collect()
    }

    fn play(&self) -> Seen {
        let pad = pad("edinburgh-lattice");
        let simulated = SimulatedPad::new(&pad).expect("solvable");
        let builder = builder(&pad);
        let mut engine = engine(&pad, &builder);
        let mut noise = Noise::new(60.0, self.seed);
        let per_drive = pad.channels() / DRIVES;
        let untouched = simulated.volts(&[]).expect("solvable");
        let (mut lags_mm, mut ids, mut downs) = (Vec::new(), Vec::new(), Vec::new());
        for index in 0..PARTS.iter().sum() {
            let since = index.saturating_sub(PARTS[0]);
            let is_pressed = (PARTS[0]..PARTS[0] + PARTS[1]).contains(&index);
            let volts = match is_pressed {
                true => &simulated.volts(&self.presses(since)).expect("solvable"),
                false => &untouched,
            };
            let first = index % DRIVES * per_drive;
            let mut part = Part {
                t_ns: (index as Nanos + 1) * PART_NS,
                first,
                volts: noise.read(&volts[first..first + per_drive]),
            };
            match self.damage.filter(|(at, _)| is_pressed && *at == since) {
                Some((_, Damage::Lost)) => continue,
                Some((_, Damage::Reversed)) => part.volts.reverse(),
                None => {}
            }
            engine.input(&Input::Part(part), &mut Vec::new());
            for touch in engine.touches_down() {
                if !ids.contains(&touch.id) {
                    ids.push(touch.id);
                    downs.push(since);
                }
            }
            let own = engine
                .touches_down()
                .iter()
                .find(|touch| touch.id == ids[0]);
            if let Some(touch) = own.filter(|_| is_pressed && since > SETTLED_PARTS) {
                let off_mm = [0, 1].map(|k| self.at_mm(since)[k] - touch.contact.centre_mm[k]);
                lags_mm.push(self.direction[0] * off_mm[0] + self.direction[1] * off_mm[1]);
            }
        }
        assert!(engine.touches_down().is_empty(), "it has lifted");
        Seen { lags_mm, downs }
    }
}

#[test]
fn slides_at_300_mm_per_s_hardly_lag() {
    let mut all_mm = Vec::new();
    for (seed, from_mm, direction) in [
        (1, [20.0, 30.0], [1.0, 0.0]),
        (2, [75.0, 80.0], [0.0, -1.0]),
        (3, [75.0, 25.0], [-0.6, 0.8]),
    ] {
        let Seen { lags_mm, downs } = Slide::new(seed, from_mm, direction).play();
        let held = PARTS[1] - SETTLED_PARTS - 1;
        assert_eq!(lags_mm.len(), held, "held all the way");
        assert_eq!(downs.len(), 1, "one finger is one touch: {downs:?}");
        let furthest_mm = lags_mm.iter().fold(0.0f64, |most, lag| most.max(lag.abs()));
        assert!(furthest_mm < 3.0, "{furthest_mm:.1} mm off");
        all_mm.extend(lags_mm);
    }
    let mean_mm = all_mm.iter().sum::<f64>() / all_mm.len() as f64;
    assert!(mean_mm.abs() < 0.3, "{mean_mm:.2} mm behind");
}

/// While a finger slides, its readings are not quite as expected: that is no other finger, nor has it lifted.
#[test]
fn fingers_of_other_sizes_that_slide_are_one_touch() {
    for (seed, radius_mm, rise, from_mm, direction) in [
        (1, 5.0, 2.5, [20.0, 20.0], DIAGONAL),
        (5, 5.0, 2.5, [20.0, 20.0], DIAGONAL),
        (50, 5.0, 2.5, [20.0, 20.0], DIAGONAL),
        (51, 5.0, 2.5, [80.0, 75.0], [-0.8, -0.6]),
        (62, 9.0, 0.6, [20.0, 20.0], DIAGONAL),
        (70, 10.0, 3.0, [30.0, 85.0], [0.0, -1.0]),
    ] {
        let slide = Slide {
            radius_mm,
            rise,
            ..Slide::new(seed, from_mm, direction)
        };
        let Seen { lags_mm, downs } = slide.play();
        assert_eq!(downs.len(), 1, "radius {radius_mm} mm: {downs:?}");
        let furthest_mm = lags_mm.iter().fold(0.0f64, |most, lag| most.max(lag.abs()));
        assert!(furthest_mm < 7.0, "{furthest_mm:.1} mm off");
    }
}

/// Seen in the third part, as a finger that lands alone.
#[test]
fn a_finger_that_lands_beside_one_that_slides_is_seen_as_soon_as_any() {
    for (seed, second_mm, lands) in [
        (151, [80.0, 70.0], 20),
        (153, [80.0, 70.0], 100),
        (163, [30.0, 60.0], 37),
    ] {
        let slide = Slide {
            second: Some((second_mm, lands)),
            ..Slide::new(seed, [20.0, 30.0], [1.0, 0.0])
        };
        let downs = slide.play().downs;
        assert_eq!(downs.len(), 2, "{downs:?}");
        assert!((lands..lands + 4).contains(&downs[1]), "{downs:?}");
    }
}

/// A damaged or lost part neither lifts the finger that slides nor stays as a touch.
#[test]
fn a_damaged_part_of_a_slide_leaves_nothing_behind() {
    for (seed, at, damage) in [
        (171, 40, Damage::Reversed),
        (172, 101, Damage::Reversed),
        (173, 170, Damage::Lost),
        (174, 231, Damage::Lost),
    ] {
        let slide = Slide {
            damage: Some((at, damage)),
            ..Slide::new(seed, [20.0, 30.0], [1.0, 0.0])
        };
        let Seen { lags_mm, downs } = slide.play();
        let held = PARTS[1] - SETTLED_PARTS - 1 - usize::from(damage == Damage::Lost);
        assert_eq!(lags_mm.len(), held, "{damage:?} at {at}: held all the way");
        assert_eq!(downs.len(), 1, "{damage:?} at {at}: {downs:?}");
    }
}
