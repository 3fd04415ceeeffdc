//! The simulated pad, its board and a detector, played frame by frame.

use std::sync::Arc;

use gelpad::eit::{Press, Reconstruction};
use gelpad::pad::Pad;
use gelpad::source::{Noise, SimulatedPad};
use gelpad::touch::{Detector, SensingBuilder};
use gelpad::types::{Frame, Method, Nanos, Phase, Touch};

use crate::lattice::{builder, pad};

pub const FRAME_NS: Nanos = 10_000_000;
pub const FRAMES_PER_MINUTE: u64 = 6000;

pub struct Bench {
    pub pad: Pad,
    pub simulated: SimulatedPad,
    pub detector: Detector,
    pub builder: SensingBuilder,
    pub noise: Noise,
    pub frame: u64,
    /// The reading of the board, from channel, true reading and frame.
    pub board: Box<dyn Fn(usize, f32, u64) -> f32>,
}

impl Bench {
    pub fn by_image(snr_db: f64, seed: u64) -> Self {
        let matrix = Reconstruction::from_pad(&pad(), Method::default()).expect("a matrix");
        Self::new(Detector::new(Arc::new(matrix)), snr_db, seed)
    }

    pub fn located(snr_db: f64, seed: u64) -> Self {
        Self::monitored(builder().clone(), snr_db, seed)
    }

    pub fn without_table(snr_db: f64, seed: u64) -> Self {
        let builder = SensingBuilder::new(&pad(), Method::Tikhonov).expect("solvable");
        Self::monitored(builder, snr_db, seed)
    }

    pub fn monitored(builder: SensingBuilder, snr_db: f64, seed: u64) -> Self {
        Self::of_pad(pad(), builder, snr_db, seed)
    }

    pub fn new(detector: Detector, snr_db: f64, seed: u64) -> Self {
        Self::of_detector(pad(), builder().clone(), detector, snr_db, seed)
    }

    /// Another pad than the lattice.
    pub fn of_pad(pad: Pad, builder: SensingBuilder, snr_db: f64, seed: u64) -> Self {
        let first = builder.build_initial().expect("a matrix");
        let detector = Detector::for_pad(Arc::new(first), &pad.protocol);
        Self::of_detector(pad, builder, detector, snr_db, seed)
    }

    fn of_detector(
        pad: Pad,
        builder: SensingBuilder,
        detector: Detector,
        snr_db: f64,
        seed: u64,
    ) -> Self {
        Self {
            simulated: SimulatedPad::new(&pad).expect("solvable"),
            pad,
            detector,
            builder,
            noise: Noise::new(snr_db, seed),
            frame: 0,
            board: Box::new(|_, volt, _| volt),
        }
    }

    /// Plays frames with the same fingers; returns how often touches went down and up.
    pub fn play(&mut self, fingers: &[Press], frames: u64) -> (usize, usize) {
        let volts = self.simulated.volts(fingers).expect("solvable");
        let mut changed = Vec::new();
        for _ in 0..frames {
            let volts = self.noise.read(&volts).into_iter().enumerate();
            let volts = volts
                .map(|(c, volt)| (self.board)(c, volt, self.frame))
                .collect();
            let t_ns = self.frame * FRAME_NS;
            self.detector
                .process_frame(&Frame { t_ns, volts }, &mut changed);
            if let Some(deviations) = self.detector.wanted() {
                let sensing = self.builder.build(deviations).expect("a matrix");
                self.detector.set_sensing(Arc::new(sensing));
            }
            self.frame += 1;
        }
        let count = |phase| changed.iter().filter(|touch| touch.phase == phase).count();
        (count(Phase::Down), count(Phase::Up))
    }

    /// Changes the readings of the board; `reading` gets whether a channel uses the electrode.
    pub fn board(
        &mut self,
        electrode: usize,
        reading: impl Fn(bool, usize, f32, u64) -> f32 + 'static,
    ) {
        let uses: Vec<bool> = self
            .pad
            .protocol
            .channels
            .iter()
            .map(|channel| {
                let pairs = [channel.drive, channel.measure];
                pairs
                    .iter()
                    .any(|pair| pair.0 == electrode || pair.1 == electrode)
            })
            .collect();
        self.board =
            Box::new(move |channel, volt, frame| reading(uses[channel], channel, volt, frame));
    }

    /// Bends the pad from now on: by what these touches change and back, and the other way, in three seconds.
    pub fn bend(&mut self, by: &[Press]) {
        let rest = self.simulated.volts(&[]).expect("solvable");
        let bent = self.simulated.volts(by).expect("solvable");
        let changes: Vec<f64> = bent.iter().zip(&rest).map(|(b, r)| b / r - 1.0).collect();
        let from = self.frame;
        self.board = Box::new(move |channel, volt, frame| {
            let share = (std::f64::consts::TAU * (frame - from) as f64 / 300.0).sin();
            (f64::from(volt) * (1.0 + share * changes[channel])) as f32
        });
    }

    pub fn down(&self) -> &[Touch] {
        self.detector.touches_down()
    }
}

/// A pseudo-random number between -1 and 1 for each channel and frame.
pub fn wild(channel: usize, frame: u64) -> f32 {
    let mixed = (channel as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15)
        ^ (frame + 1).wrapping_mul(0xD1B5_4A32_D192_ED03);
    ((mixed.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 40) as f32) / (1u64 << 23) as f32 - 1.0
}

pub fn finger(centre_mm: [f64; 2], radius_mm: f64, rise: f64) -> Press {
    Press {
        centre_mm,
        radius_mm,
        rise,
    }
}
