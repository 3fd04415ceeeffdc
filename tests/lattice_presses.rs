//! Touches in single frames of an independent simulator with added noise, located in images and in the voltages.

mod lattice;

use std::sync::Arc;

use gelpad::eit::{REFERENCE_FRAMES, Reconstruction};
use gelpad::source::Noise;
use gelpad::touch::Detector;
use gelpad::types::{Frame, Method, Nanos};
use lattice::{builder, pad, static_frames, static_truths};

const FOUND_MM: f64 = 10.0;
const SEEDS: [u64; 3] = [1, 2, 3];
const FRAME_NS: Nanos = 10_000_000;

/// Results over all frames with the same number of touches.
#[derive(Default)]
struct Score {
    frames: usize,
    /// Frames in which every true touch has a contact within [`FOUND_MM`].
    found: usize,
    /// Frames with as many contacts as touches.
    counted_right: usize,
    /// Error of every true touch that was found.
    errors_mm: Vec<f64>,
}

impl Score {
    fn mean_mm(&self) -> f64 {
        self.errors_mm.iter().sum::<f64>() / self.errors_mm.len() as f64
    }

    fn p95_mm(&self) -> f64 {
        let mut sorted = self.errors_mm.clone();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() * 95 / 100]
    }
}

/// Scores for one, two and three touches; every frame follows a rest.
fn scores(fresh: &Detector, snr_db: f64, seed: u64, label: &str) -> [Score; 3] {
    let frames = static_frames();
    let mut noise = Noise::new(snr_db, seed);
    let mut rested = fresh.clone();
    let mut none = Vec::new();
    for frame in 0..REFERENCE_FRAMES as Nanos {
        let volts = noise.read(&frames[0]);
        let t_ns = frame * FRAME_NS;
        rested.process_frame(&Frame { t_ns, volts }, &mut none);
    }
    let t_ns = REFERENCE_FRAMES as Nanos * FRAME_NS;
    let mut scores: [Score; 3] = Default::default();
    for (volts, truth) in frames.iter().zip(static_truths()).skip(1) {
        let mut detector = rested.clone();
        let volts = noise.read(volts);
        detector.process_frame(&Frame { t_ns, volts }, &mut none);
        let score = &mut scores[truth.touches.len() - 1];
        let contacts = detector.touches_down();
        let errors_mm = truth.touches.iter().map(|touch| {
            contacts
                .iter()
                .map(|c| {
                    (c.contact.centre_mm[0] - touch.x_mm).hypot(c.contact.centre_mm[1] - touch.y_mm)
                })
                .fold(f64::INFINITY, f64::min)
        });
        let errors_mm: Vec<f64> = errors_mm.collect();
        score.frames += 1;
        score.found += usize::from(errors_mm.iter().all(|error| *error < FOUND_MM));
        score.counted_right += usize::from(contacts.len() == truth.touches.len());
        score
            .errors_mm
            .extend(errors_mm.iter().filter(|error| **error < FOUND_MM));
    }
    for (touches, score) in scores.iter().enumerate() {
        println!(
            "{label}, {snr_db} dB, seed {seed}, {} touches: found {}, counted right {} of {}, mean {:.2} mm, p95 {:.2} mm",
            touches + 1,
            score.found,
            score.counted_right,
            score.frames,
            score.mean_mm(),
            score.p95_mm()
        );
    }
    scores
}

fn by_image(method: Method) -> Detector {
    let matrix = Reconstruction::from_pad(&pad(), method).expect("a matrix");
    Detector::new(Arc::new(matrix))
}

fn located() -> Detector {
    let sensing = builder().build_initial().expect("a matrix");
    Detector::for_pad(Arc::new(sensing), &pad().protocol)
}

#[test]
fn tikhonov_images_find_every_single_touch_within_two_millimetres() {
    for seed in SEEDS {
        let [one, _, _] = scores(&by_image(Method::Tikhonov), 60.0, seed, "tikhonov image");
        assert_eq!((one.found, one.frames), (100, 100));
        assert!(one.mean_mm() <= 2.0);
    }
}

#[test]
fn noser_images_find_every_single_touch_within_one_and_a_half_and_count_two() {
    for seed in SEEDS {
        let [one, two, _] = scores(&by_image(Method::Noser), 60.0, seed, "noser image");
        assert_eq!((one.found, one.frames), (100, 100));
        assert!(one.mean_mm() <= 1.5);
        assert!(two.counted_right >= 95 && two.frames == 100);
    }
}

#[test]
fn voltages_place_touches_to_a_few_tenths_of_a_millimetre_and_count_them() {
    for seed in SEEDS {
        let [one, two, three] = scores(&located(), 60.0, seed, "located");
        assert_eq!(one.found, 100);
        assert!(one.mean_mm() <= 0.30 && one.p95_mm() <= 0.75);
        for score in [&two, &three] {
            assert!(score.mean_mm() <= 0.45 && score.p95_mm() <= 1.2);
        }
        let right = one.counted_right + two.counted_right + three.counted_right;
        assert!(right >= 297, "{right} of 300");
    }
}

/// One of the hundred lies over a hole of the lattice: at 40 dB it reaches only 4.4 standard deviations in a single frame, so
/// it is found in the mean of several.
#[test]
fn at_40_db_every_touch_is_found_within_five_frames_and_the_untouched_pad_stays_quiet() {
    for seed in SEEDS {
        let [one, _, _] = scores(&located(), 40.0, seed, "located");
        assert!(one.found >= 99 && one.mean_mm() <= 1.2);

        let frames = static_frames();
        let mut noise = Noise::new(40.0, seed);
        let mut rested = located();
        let mut t_ns = 0;
        let mut play = |detector: &mut Detector, volts: &[f64], count: usize| {
            let mut changed = Vec::new();
            for _ in 0..count {
                let volts = noise.read(volts);
                t_ns += FRAME_NS;
                detector.process_frame(&Frame { t_ns, volts }, &mut changed);
            }
            changed.len()
        };
        assert_eq!(play(&mut rested, &frames[0], 6000), 0, "a quiet minute");
        let found = frames[1..=100].iter().filter(|volts| {
            let mut detector = rested.clone();
            play(&mut detector, volts, 5);
            !detector.touches_down().is_empty()
        });
        assert_eq!(found.count(), 100, "seed {seed}");
    }
}
