//! Noise that is the same on all channels, on a pad of many electrodes: the smallest of its 928 readings are below the noise. They once made
//! the detector take its reference again and again, in which every touch was missed.

use std::sync::Arc;

use gelpad::cache;
use gelpad::eit::Press;
use gelpad::pad::{Pad, Pair, shipped_pad};
use gelpad::source::SimulatedPad;
use gelpad::touch::{Detector, SensingBuilder};
use gelpad::types::{Frame, Method, Nanos};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal, Uniform};

const FRAME_NS: Nanos = 10_000_000;
const WITHIN_MM: f64 = 3.0;

fn pad() -> Pad {
    let text = shipped_pad("edinburgh-solid").expect("shipped").toml;
    let text = text
        .replace("count = 16", "count = 32")
        .replace("width_mm = 3.0", "width_mm = 2.5");
    Pad::from_toml("solid with 32 electrodes", &text).expect("valid")
}

/// The pad, its noise and a detector, played frame by frame.
struct Bench {
    pad: Pad,
    simulated: SimulatedPad,
    rest: Vec<f64>,
    builder: SensingBuilder,
    detector: Detector,
    noise_volts: f64,
    draw: ChaCha8Rng,
    t_ns: Nanos,
}

impl Bench {
    /// `noise` is the standard deviation of all readings, as a share of the largest.
    fn new(noise: f64, seed: u64) -> Self {
        let pad = pad();
        let builder = cache::sensing_builder(&pad, Method::Noser, |_, _| ()).expect("solvable");
        let first = Arc::new(builder.build_initial().expect("a matrix"));
        let simulated = SimulatedPad::new(&pad).expect("solvable");
        let rest = simulated.volts(&[]).expect("solved");
        let largest = rest.iter().fold(0.0f64, |most, volt| most.max(volt.abs()));
        Self {
            detector: Detector::for_pad(first, &pad.protocol),
            pad,
            simulated,
            rest,
            builder,
            noise_volts: noise * largest,
            draw: ChaCha8Rng::seed_from_u64(seed),
            t_ns: 0,
        }
    }

    /// Plays frames of these readings; returns how many touches changed.
    fn play(&mut self, volts: &[f64], frames: usize) -> usize {
        let mut changed = Vec::new();
        for _ in 0..frames {
            self.t_ns += FRAME_NS;
            let noisy = volts.iter().map(|volt| {
                let noise: f64 = StandardNormal.sample(&mut self.draw);
                (volt + self.noise_volts * noise) as f32
            });
            let frame = Frame {
                t_ns: self.t_ns,
                volts: noisy.collect(),
            };
            self.detector.process_frame(&frame, &mut changed);
            // Without any channel there is no matrix; as in play, the present one stays.
            let wanted = self.detector.wanted();
            if let Some(Ok(sensing)) = wanted.map(|wanted| self.builder.build(wanted)) {
                self.detector.set_sensing(Arc::new(sensing));
            }
        }
        changed.len()
    }

    fn rest(&mut self, frames: usize) -> usize {
        let rest = self.rest.clone();
        self.play(&rest, frames)
    }
}

#[test]
fn touches_are_found_in_the_first_frame_and_rest_makes_none() {
    let press = Press {
        centre_mm: [35.0, 60.0],
        radius_mm: 8.0,
        rise: 1.5,
    };
    for seed in 1..=10 {
        let mut bench = Bench::new(1e-3, seed);
        assert_eq!(bench.rest(200), 0, "seed {seed}");
        let pressed = bench.simulated.volts(&[press]).expect("solved");
        bench.play(&pressed, 1);
        let detector = &bench.detector;
        assert_eq!(detector.references_retaken(), 0, "seed {seed}");
        assert!(detector.lost_electrodes().is_empty(), "seed {seed}");
        let [touch] = detector.touches_down() else {
            panic!("seed {seed}: {:?}", detector.touches_down());
        };
        let [x, y] = touch.contact.centre_mm;
        let off_mm = (x - press.centre_mm[0]).hypot(y - press.centre_mm[1]);
        assert!(off_mm < WITHIN_MM, "seed {seed}: {off_mm:.2} mm off");
    }
}

/// At 60 dB, `gelpad accuracy` judges one frame, in which one press of eight is missed. Those are the faintest, and a press lasts longer.
#[test]
fn presses_missed_in_one_frame_are_the_faintest_and_found_within_five() {
    const PRESSES: usize = 60;
    const FRAMES: usize = 5;
    // Standard deviations. A new touch has to explain 6.7 (45 squared), and the noise of its frame adds or takes one.
    const FAINT: f64 = 8.0;
    let mut bench = Bench::new(1e-3, 1);
    assert_eq!(bench.rest(200), 0);
    let (resting, rested_ns) = (bench.detector.clone(), bench.t_ns);
    let mut draw = ChaCha8Rng::seed_from_u64(2);
    let mut between = |least: f64, most: f64| {
        let range = Uniform::new(least, most).expect("a range");
        range.sample(&mut draw)
    };
    // All changes of a press together, in standard deviations of the noise.
    let (mut of_found, mut of_missed) = (Vec::new(), Vec::new());
    let mut found_late = 0;
    for _ in 0..PRESSES {
        let press = Press {
            centre_mm: [between(10.0, 90.0), between(10.0, 90.0)],
            radius_mm: between(5.0, 9.0),
            rise: between(0.5, 2.0),
        };
        let volts = bench.simulated.volts(&[press]).expect("solved");
        let changes = volts.iter().zip(&bench.rest).map(|(now, rest)| now - rest);
        let squares: f64 = changes.map(|change| change * change).sum();
        let deviations = squares.sqrt() / bench.noise_volts;
        (bench.detector, bench.t_ns) = (resting.clone(), rested_ns);
        bench.play(&volts, 1);
        if bench.detector.touches_down().len() == 1 {
            of_found.push(deviations);
            continue;
        }
        of_missed.push(deviations);
        bench.play(&volts, FRAMES - 1);
        found_late += usize::from(bench.detector.touches_down().len() == 1);
    }
    of_found.sort_by(f64::total_cmp);
    of_missed.sort_by(f64::total_cmp);
    println!("found in one frame, {}: {of_found:.1?}", of_found.len());
    println!("missed in it, {}: {of_missed:.1?}", of_missed.len());
    assert!(of_missed.last().is_none_or(|strongest| *strongest < FAINT));
    assert!(of_missed.len() <= PRESSES / 5);
    assert_eq!(found_late, of_missed.len(), "within {FRAMES} frames");
}

/// Readings that are left out as below the noise must not hide that an electrode is lost, nor make it look as if others were.
#[test]
fn an_electrode_that_is_lost_in_more_noise_is_found_and_makes_no_touch() {
    const LOST: usize = 5;
    let mut bench = Bench::new(3e-3, 1);
    assert_eq!(bench.rest(100), 0);
    assert!(bench.detector.lost_electrodes().is_empty());
    let lost = Pair(LOST, LOST);
    let channels = bench.pad.protocol.channels.iter().zip(&bench.rest);
    let open: Vec<f64> = channels
        .map(|(channel, volt)| {
            let is_open =
                channel.drive.shares_electrode(lost) || channel.measure.shares_electrode(lost);
            if is_open { 0.0 } else { *volt }
        })
        .collect();
    assert_eq!(bench.play(&open, 100), 0);
    assert_eq!(bench.detector.lost_electrodes(), [LOST]);
}

/// A board whose cable is off, or with far too little gain: nearly all readings are below the noise.
#[test]
fn a_board_that_reads_little_but_noise_makes_no_touch() {
    for noise in [0.03, 1.0] {
        assert_eq!(Bench::new(noise, 1).rest(200), 0, "{noise}");
    }
}
