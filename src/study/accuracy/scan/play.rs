//! A session on a pad whose drives are read in turn.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::source::Noise;
use crate::study::accuracy::Bench;
use crate::study::accuracy::draws::Draws;
use crate::study::accuracy::score::REACH_MM;
use crate::study::accuracy::specimen::Specimen;
use crate::study::{Press, StudyError, conductivity_factor};
use crate::touch::{Detector, Scan};
use crate::types::{Frame, Nanos, Part, Phase, PointMm, Touch, TouchId};

/// The pad rests for so long, s, ...
const REST_S: f64 = 2.0;
/// ... and at least so many frames before the first press.
const REST_FRAMES: f64 = 40.0;
/// Length of a press, s.
const PRESS_S: [f64; 2] = [0.12, 0.5];
/// Time between presses, s.
const PAUSE_S: [f64; 2] = [0.5, 1.0];
/// Size and rise of the finger that slides.
const SLIDING: (f64, f64) = (7.0, 1.2);
/// The error of a slide counts from this time on, s: a finger lands at rest.
const SETTLED_S: f64 = 0.05;

/// What became of a session.
#[derive(Clone, Debug, Default)]
pub(super) struct Played {
    pub presses: usize,
    pub found: usize,
    /// Touches that are none of the presses.
    pub others: usize,
    /// Delays of downs and ups, ms.
    pub down_ms: Vec<f64>,
    pub up_ms: Vec<f64>,
    /// Errors of place where a press is first seen, ...
    pub first_mm: Vec<f64>,
    /// ... and at the end of the first frame that lies within the press.
    pub whole_mm: Vec<f64>,
    /// How far a sliding finger is ahead of its touch, mm.
    pub lag_mm: Vec<f64>,
}

/// A finger: since when it presses and where it is at a time.
#[derive(Clone, Copy)]
struct Finger {
    from_s: f64,
    to_s: f64,
    start_mm: PointMm,
    /// mm/s.
    velocity: PointMm,
}

impl Finger {
    fn at_mm(&self, t_s: f64) -> PointMm {
        let elapsed_s = (t_s - self.from_s).clamp(0.0, self.to_s - self.from_s);
        [0, 1].map(|k| self.start_mm[k] + elapsed_s * self.velocity[k])
    }
}

/// A detector that reads a specimen.
pub(super) struct Session<'a> {
    bench: &'a Bench,
    specimen: &'a Specimen,
    detector: Detector,
    /// Reads part by part, not frame by frame.
    scan: Option<Scan>,
    noise: Noise,
    /// First channel of each drive, and the end of the last.
    bounds: Vec<usize>,
    period_s: f64,
    /// Parts read so far.
    parts: usize,
    frame: Vec<f32>,
    seen: BTreeMap<TouchId, bool>,
    changed: Vec<Touch>,
    played: Played,
}

impl<'a> Session<'a> {
    pub(super) fn new(
        bench: &'a Bench,
        specimen: &'a Specimen,
        rate: f64,
        snr_db: f64,
        by_parts: bool,
    ) -> Self {
        Self {
            bench,
            specimen,
            detector: bench.sensing.new_detector(),
            scan: by_parts.then(Scan::default),
            noise: Noise::new(snr_db, bench.seed ^ 0x5ca9),
            bounds: bench.pad.protocol.drive_bounds(),
            period_s: 1.0 / rate,
            parts: 0,
            frame: vec![0.0; bench.pad.channels()],
            seen: BTreeMap::new(),
            changed: Vec::new(),
            played: Played::default(),
        }
    }

    /// Lets the detector take its reference.
    pub(super) fn rest(&mut self) -> Result<(), StudyError> {
        self.idle(REST_S.max(REST_FRAMES * self.period_s))
    }

    /// Reads the untouched pad for a time.
    pub(super) fn idle(&mut self, for_s: f64) -> Result<(), StudyError> {
        let end_s = self.now_s() + for_s;
        while self.now_s() < end_s {
            self.read_part(None, &[])?;
        }
        Ok(())
    }

    /// One press of random length at a random moment, and a pause.
    pub(super) fn press(&mut self, press: &Press, draws: &mut Draws) -> Result<(), StudyError> {
        let sign = self.bench.pad.touch_sign;
        let pressed = self
            .specimen
            .touched(|point| conductivity_factor(&[*press], sign, point))?
            .voltages(&self.bench.pad.protocol);
        let from_s = self.now_s() + draws.between(0.0, self.period_s);
        let to_s = from_s + draws.between(PRESS_S[0], PRESS_S[1]);
        let end_s = to_s + draws.between(PAUSE_S[0], PAUSE_S[1]);
        let finger = Finger {
            from_s,
            to_s,
            start_mm: press.centre_mm,
            velocity: [0.0; 2],
        };
        self.follow(finger, end_s, |_| Ok(pressed.clone()))
    }

    /// A finger that slides from one place to another.
    pub(super) fn slide(
        &mut self,
        from_mm: PointMm,
        to_mm: PointMm,
        mm_per_s: f64,
    ) -> Result<(), StudyError> {
        let length_mm = libm::hypot(to_mm[0] - from_mm[0], to_mm[1] - from_mm[1]);
        let from_s = self.now_s();
        let finger = Finger {
            from_s,
            to_s: from_s + length_mm / mm_per_s,
            start_mm: from_mm,
            velocity: [0, 1].map(|k| mm_per_s * (to_mm[k] - from_mm[k]) / length_mm),
        };
        let (specimen, bench) = (self.specimen, self.bench);
        self.follow(finger, finger.to_s + PAUSE_S[0], |centre_mm| {
            let press = Press {
                centre_mm,
                radius_mm: SLIDING.0,
                rise: SLIDING.1,
            };
            let sign = bench.pad.touch_sign;
            let fields = specimen.touched(|point| conductivity_factor(&[press], sign, point))?;
            Ok(fields.voltages(&bench.pad.protocol))
        })
    }

    /// Reads parts until a time and scores what is seen of a finger.
    fn follow(
        &mut self,
        finger: Finger,
        end_s: f64,
        volts: impl Fn(PointMm) -> Result<Vec<f64>, StudyError>,
    ) -> Result<(), StudyError> {
        self.played.presses += 1;
        let parts = self.bounds.len() - 1;
        let mut own: Option<TouchId> = None;
        let mut is_placed = false;
        while self.now_s() < end_s {
            let t_s = self.next_s();
            let is_pressed = (finger.from_s..finger.to_s).contains(&t_s);
            let at_mm = finger.at_mm(t_s);
            let pressed = if is_pressed {
                volts(at_mm)?
            } else {
                Vec::new()
            };
            self.read_part(own, &pressed)?;
            let errors = |touch: &Touch| {
                let [x, y] = touch.contact.centre_mm;
                libm::hypot(x - at_mm[0], y - at_mm[1])
            };
            let down = self.detector.touches_down();
            if own.is_none() && t_s >= finger.from_s {
                let reach_mm = REACH_MM * self.bench.scale;
                if let Some(touch) = down.iter().find(|touch| errors(touch) < reach_mm) {
                    own = Some(touch.id);
                    self.played.found += 1;
                    self.played.down_ms.push(1e3 * (t_s - finger.from_s));
                    self.played.first_mm.push(errors(touch));
                }
            }
            let touch = down.iter().find(|touch| Some(touch.id) == own);
            if let Some(touch) = touch.filter(|_| is_pressed) {
                let is_moving = finger.velocity != [0.0; 2];
                if is_moving && t_s > finger.from_s + SETTLED_S {
                    self.played.lag_mm.push(lag_mm(&finger, touch, at_mm));
                }
                let is_whole = t_s - finger.from_s > self.period_s;
                if !is_moving && !is_placed && is_whole && self.parts.is_multiple_of(parts) {
                    is_placed = true;
                    self.played.whole_mm.push(errors(touch));
                }
            }
            let own_up = |touch: &&Touch| Some(touch.id) == own && touch.phase == Phase::Up;
            if self.changed.iter().any(|touch| own_up(&touch)) {
                self.played.up_ms.push(1e3 * (t_s - finger.to_s));
            }
            if let Some(id) = own {
                self.seen.insert(id, true);
            }
        }
        Ok(())
    }

    pub(super) fn finish(mut self) -> Played {
        self.played.others = self.seen.values().filter(|is_own| !**is_own).count();
        self.played
    }

    fn now_s(&self) -> f64 {
        let parts = (self.bounds.len() - 1) as f64;
        self.parts as f64 / parts * self.period_s
    }

    fn next_s(&self) -> f64 {
        let parts = (self.bounds.len() - 1) as f64;
        (self.parts + 1) as f64 / parts * self.period_s
    }

    /// Reads the next drive; an untouched pad if `pressed` is empty.
    fn read_part(&mut self, own: Option<TouchId>, pressed: &[f64]) -> Result<(), StudyError> {
        let t_ns = (self.next_s() * 1e9) as Nanos;
        let drive = self.parts % (self.bounds.len() - 1);
        let span = self.bounds[drive]..self.bounds[drive + 1];
        let true_volts = if pressed.is_empty() {
            &self.specimen.rest
        } else {
            pressed
        };
        let volts = self.noise.read(&true_volts[span.clone()]);
        self.changed.clear();
        if let Some(scan) = &mut self.scan {
            let part = Part {
                t_ns,
                first: span.start,
                volts,
            };
            scan.process_part(&mut self.detector, &part, &mut self.changed);
        } else {
            self.frame[span.clone()].copy_from_slice(&volts);
            if span.end == self.frame.len() {
                let frame = Frame {
                    t_ns,
                    volts: self.frame.clone(),
                };
                self.detector.process_frame(&frame, &mut self.changed);
            }
        }
        if let Some(wanted) = self.detector.wanted()
            && let Ok(sensing) = self.bench.sensing.build(wanted)
        {
            self.detector.set_sensing(Arc::new(sensing));
        }
        for touch in self.detector.touches_down() {
            let is_own = self.seen.entry(touch.id).or_default();
            *is_own |= Some(touch.id) == own;
        }
        self.parts += 1;
        Ok(())
    }
}

/// How far a finger is ahead of its touch along its way, mm.
fn lag_mm(finger: &Finger, touch: &Touch, at_mm: PointMm) -> f64 {
    let [vx, vy] = finger.velocity;
    let [x, y] = touch.contact.centre_mm;
    (vx * (at_mm[0] - x) + vy * (at_mm[1] - y)) / libm::hypot(vx, vy)
}
