//! Simulated people, at the level of the contacts that a pad would find 100 times a second, followed by the real tracker.
//!
//! The habits of a person are drawn once from the distributions below, and each press from the habits. docs/calibration.md
//! lists the same distributions; keep them in step.

use gelpad::calibrate::recommend::{PressLength, PressRequest, PressTrial};
use gelpad::touch::Tracker;
use gelpad::types::{Contact, NANOS_PER_MS, PointMm};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, LogNormal, Normal, StandardUniform, Uniform};

/// 100 frames a second.
const FRAME_MS: f64 = 10.0;
/// Standard deviation of measured places, mm.
const MEASURED_MM: f64 = 0.3;
/// Requested regions of `super-mario`: name, centre on the paper's pad in mm, share.
const REGIONS: [(&str, PointMm, f64); 4] = [
    ("jump", [81.0, 52.0], 0.6),
    ("right", [37.0, 57.0], 0.15),
    ("left", [13.0, 57.0], 0.15),
    ("run", [75.0, 9.0], 0.1),
];
/// Shares of short and of long presses; the rest are double presses.
const LENGTHS: [f64; 2] = [0.40, 0.35];

/// A kind of people.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Steady,
    Slow,
    Tremor,
}

pub const KINDS: [Kind; 3] = [Kind::Steady, Kind::Slow, Kind::Tremor];

/// A time that varies from press to press: median, ms, and standard deviation of the logarithm.
#[derive(Clone, Copy, Debug)]
struct Time(f64, f64);

/// One person's habits.
#[derive(Clone, Debug)]
pub struct Person {
    random: ChaCha8Rng,
    short: Time,
    long: Time,
    /// Between two presses.
    gap: Time,
    /// Standard deviation of each coordinate from the centre of a region.
    aim_mm: f64,
    /// Shares of presses before which the hand brushes the pad, and its length and distance.
    brush: f64,
    brush_ms: [f64; 2],
    brush_mm: [f64; 2],
    /// Shares of presses that are cut, and how many cuts at most.
    cut: f64,
    cuts: usize,
    cut_ms: [f64; 2],
    tremor_hz: f64,
    tremor_mm: f64,
    force: f64,
}

/// An interval in which the pad is touched, ms, and the place.
struct Stretch {
    from_ms: f64,
    to_ms: f64,
    at_mm: PointMm,
}

impl Person {
    pub fn new(kind: Kind, seed: u64) -> Self {
        let stream = match kind {
            Kind::Steady => 1,
            Kind::Slow => 2,
            Kind::Tremor => 3,
        };
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(stream);
        let mut between = |low: f64, high: f64| between(&mut random, low, high);
        let mut person = match kind {
            Kind::Steady => Self {
                short: Time(between(70.0, 120.0), 0.2),
                long: Time(between(350.0, 600.0), 0.2),
                gap: Time(between(80.0, 160.0), 0.2),
                aim_mm: 3.0,
                brush: 0.01,
                brush_ms: [20.0, 60.0],
                brush_mm: [15.0, 40.0],
                cut: 0.02,
                cuts: 1,
                cut_ms: [10.0, 30.0],
                tremor_hz: between(8.0, 12.0),
                tremor_mm: 0.2,
                force: between(0.3, 0.7),
                random: ChaCha8Rng::seed_from_u64(0),
            },
            Kind::Slow => {
                let short_ms = 250.0 * (between(0.0, 1.0) * f64::ln(700.0 / 250.0)).exp();
                Self {
                    short: Time(short_ms, 0.25),
                    long: Time(short_ms * between(2.2, 3.0), 0.2),
                    gap: Time(between(350.0, 900.0), 0.2),
                    aim_mm: 4.0,
                    brush: between(0.15, 0.45),
                    brush_ms: [30.0, 150.0],
                    brush_mm: [15.0, 40.0],
                    cut: 0.05,
                    cuts: 1,
                    cut_ms: [20.0, 60.0],
                    tremor_hz: between(4.0, 8.0),
                    tremor_mm: 0.5,
                    force: between(0.2, 0.6),
                    random: ChaCha8Rng::seed_from_u64(0),
                }
            }
            Kind::Tremor => {
                // A trembling hand may be as fast as a steady one or as slow as a slow one.
                let short_ms = 70.0 * (between(0.0, 1.0) * f64::ln(700.0 / 70.0)).exp();
                let long_ms = (short_ms * between(2.2, 3.0)).max(between(350.0, 600.0));
                let tremor_hz = between(4.0, 8.0);
                let period_ms = 1000.0 / tremor_hz;
                Self {
                    short: Time(short_ms, 0.25),
                    long: Time(long_ms, 0.2),
                    gap: Time(between(300.0, 900.0), 0.2),
                    aim_mm: 4.0,
                    brush: between(0.05, 0.15),
                    brush_ms: [20.0, 80.0],
                    brush_mm: [15.0, 40.0],
                    cut: between(0.3, 0.8),
                    cuts: 3,
                    // The finger is off the pad for 0.25 to 0.6 of a tremor period: 31 to 150 ms.
                    cut_ms: [0.25 * period_ms, 0.6 * period_ms],
                    tremor_hz,
                    tremor_mm: between(2.0, 8.0),
                    force: between(0.2, 0.6),
                    random: ChaCha8Rng::seed_from_u64(0),
                }
            }
        };
        person.random = random;
        person
    }

    /// The trials of `count` requests, and their duration, minutes.
    pub fn session(&mut self, count: usize) -> (Vec<PressTrial>, f64) {
        let mut minutes = 0.0;
        let trials = (0..count)
            .map(|_| {
                let (trial, ms) = self.trial();
                minutes += ms / 60_000.0;
                trial
            })
            .collect();
        (trials, minutes)
    }

    fn trial(&mut self) -> (PressTrial, f64) {
        let pick: f64 = self.share();
        let mut sum = 0.0;
        let (region, middle, _) = REGIONS
            .into_iter()
            .find(|(.., share)| {
                sum += share;
                pick < sum
            })
            .unwrap_or(REGIONS[0]);
        let pick = self.share();
        let length = if pick < LENGTHS[0] {
            PressLength::Short
        } else if pick < LENGTHS[0] + LENGTHS[1] {
            PressLength::Long
        } else {
            PressLength::Twice
        };
        let stretches = self.stretches(middle, length);
        let end_ms = stretches.last().map_or(0.0, |stretch| stretch.to_ms);
        let trial = PressTrial {
            request: Some(PressRequest {
                region: region.to_owned(),
                length,
            }),
            touches: self.followed(&stretches),
        };
        (trial, end_ms + between(&mut self.random, 800.0, 1500.0))
    }

    /// When and where the pad is touched.
    fn stretches(&mut self, middle: PointMm, length: PressLength) -> Vec<Stretch> {
        let mut stretches = Vec::new();
        let mut t_ms = 500.0;
        let normal = Normal::new(0.0, self.aim_mm).expect("a deviation");
        let at_mm = middle.map(|mm| mm + normal.sample(&mut self.random));
        if self.share() < self.brush {
            let angle = between(&mut self.random, 0.0, std::f64::consts::TAU);
            let [near, far] = self.brush_mm;
            let off_mm = between(&mut self.random, near, far);
            let brush_mm = [
                at_mm[0] + off_mm * angle.cos(),
                at_mm[1] + off_mm * angle.sin(),
            ];
            let [short, long] = self.brush_ms;
            let to_ms = t_ms + between(&mut self.random, short, long);
            stretches.push(Stretch {
                from_ms: t_ms,
                to_ms,
                at_mm: brush_mm.map(|mm| mm.clamp(1.0, 99.0)),
            });
            t_ms = to_ms + between(&mut self.random, 50.0, 300.0);
        }
        let presses = match length {
            PressLength::Short => vec![self.short],
            PressLength::Long => vec![self.long],
            PressLength::Twice => vec![self.short; 2],
        };
        for (index, time) in presses.into_iter().enumerate() {
            if index > 0 {
                t_ms += self.time(self.gap);
            }
            t_ms = self.press(&mut stretches, t_ms, time, at_mm);
        }
        stretches
    }

    /// One press, interrupted where the finger leaves the pad for a moment: before, within, or after the actual press.
    fn press(
        &mut self,
        stretches: &mut Vec<Stretch>,
        from_ms: f64,
        time: Time,
        at_mm: PointMm,
    ) -> f64 {
        let mut pieces = vec![(from_ms, from_ms + self.time(time).max(FRAME_MS))];
        if self.share() < self.cut {
            let cuts = 1 + (self.share() * self.cuts as f64) as usize;
            for _ in 0..cuts {
                let [least, most] = self.cut_ms;
                let gap_ms = between(&mut self.random, least, most);
                let end_ms = pieces.last().expect("a piece").1;
                match (self.share() * 3.0) as usize {
                    // It lands twice: the press follows a first short contact.
                    0 => {
                        let first_ms = between(&mut self.random, 20.0, 80.0);
                        let shift_ms = first_ms + gap_ms;
                        for piece in &mut pieces {
                            *piece = (piece.0 + shift_ms, piece.1 + shift_ms);
                        }
                        pieces.insert(0, (from_ms, from_ms + first_ms));
                    }
                    // It leaves the pad within the longest piece.
                    1 => {
                        let longest = (0..pieces.len())
                            .max_by(|a, b| {
                                let length = |at: &usize| pieces[*at].1 - pieces[*at].0;
                                length(a).total_cmp(&length(b))
                            })
                            .expect("a piece");
                        let (from, to) = pieces[longest];
                        if to - from > gap_ms + 4.0 * FRAME_MS {
                            let cut = between(
                                &mut self.random,
                                from + 2.0 * FRAME_MS,
                                to - gap_ms - 2.0 * FRAME_MS,
                            );
                            pieces[longest] = (from, cut);
                            pieces.insert(longest + 1, (cut + gap_ms, to));
                        }
                    }
                    // It returns once more after the press.
                    _ => {
                        let from = end_ms + gap_ms;
                        pieces.push((from, from + between(&mut self.random, 20.0, 100.0)));
                    }
                }
            }
        }
        let end_ms = pieces.last().expect("a piece").1;
        stretches.extend(pieces.into_iter().map(|(from_ms, to_ms)| Stretch {
            from_ms,
            to_ms,
            at_mm,
        }));
        end_ms
    }

    /// The touches from the tracker.
    fn followed(
        &mut self,
        stretches: &[Stretch],
    ) -> Vec<(gelpad::types::Nanos, gelpad::types::Touch)> {
        let mut tracker = Tracker::default();
        let mut touches = Vec::new();
        let mut changed = Vec::new();
        let phase = between(&mut self.random, 0.0, std::f64::consts::TAU);
        let along = between(&mut self.random, 0.0, std::f64::consts::PI);
        let measured = Normal::new(0.0, MEASURED_MM).expect("a deviation");
        let end_ms = stretches.last().map_or(0.0, |stretch| stretch.to_ms) + 5.0 * FRAME_MS;
        for frame in 0..(end_ms / FRAME_MS) as u64 {
            let t_ms = frame as f64 * FRAME_MS;
            let swing = self.tremor_mm
                * (std::f64::consts::TAU * self.tremor_hz * t_ms / 1000.0 + phase).sin();
            let contacts: Vec<Contact> = stretches
                .iter()
                .filter(|stretch| (stretch.from_ms..stretch.to_ms).contains(&t_ms))
                .map(|stretch| Contact {
                    centre_mm: [
                        stretch.at_mm[0] + swing * along.cos() + measured.sample(&mut self.random),
                        stretch.at_mm[1] + swing * along.sin() + measured.sample(&mut self.random),
                    ]
                    .map(|mm| mm.clamp(0.0, 100.0)),
                    area_mm2: 150.0,
                    force: self.force,
                    confidence: 1.0,
                })
                .collect();
            changed.clear();
            let t_ns = frame * 10 * NANOS_PER_MS;
            tracker.follow(t_ns, &contacts, &mut changed);
            touches.extend(changed.iter().map(|touch| (t_ns, *touch)));
        }
        touches
    }

    fn time(&mut self, Time(median_ms, spread): Time) -> f64 {
        LogNormal::new(median_ms.ln(), spread)
            .expect("a spread")
            .sample(&mut self.random)
    }

    fn share(&mut self) -> f64 {
        StandardUniform.sample(&mut self.random)
    }
}

fn between(random: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    Uniform::new(low, high).expect("a range").sample(random)
}
