//! The first use of a pad: a game that started with images takes the pad's response table as an input between two touches.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::sleep;
use std::time::Duration;

use gelpad::cache;
use gelpad::eit::Press;
use gelpad::engine::{Engine, Input};
use gelpad::output::Trace;
use gelpad::pad::{DEFAULT_PAD, Pad, shipped_pad};
use gelpad::profile::{Profile, shipped_profile};
use gelpad::runtime::{self, EngineStep, PlayCommand, RunningGame, StepListener};
use gelpad::source::{SimulatedPad, Source, SourceError, SourcePace, SourceReading};
use gelpad::touch::SensingBuilder;
use gelpad::types::{Frame, Method};

/// Where super-mario's region `jump` lies, mm.
const JUMP_MM: [f64; 2] = [80.0, 50.0];

/// Rests or presses, as the test asks.
struct Board {
    rest: Vec<f64>,
    pressed: Vec<f64>,
    is_pressed: Arc<AtomicBool>,
    frames: u64,
}

impl Source for Board {
    fn pace(&self) -> SourcePace {
        SourcePace::ByDevice
    }

    fn read(&mut self) -> Result<SourceReading, SourceError> {
        sleep(Duration::from_millis(5));
        self.frames += 1;
        let volts = match self.is_pressed.load(Ordering::Relaxed) {
            true => &self.pressed,
            false => &self.rest,
        };
        // Some noise: identical frames would be those of a board that hangs.
        let noisy = volts.iter().enumerate().map(|(channel, volt)| {
            let step = (self.frames * 7919 + channel as u64 * 104_729) % 2001;
            (volt * (1.0 + (step as f64 - 1000.0) * 2e-7)) as f32
        });
        Ok(SourceReading::Frame(Frame {
            t_ns: self.frames * 5_000_000,
            volts: noisy.collect(),
        }))
    }
}

/// For each matrix: whether it locates touches, and the touches at that moment.
#[derive(Clone, Default)]
struct Matrices(Arc<Mutex<Vec<(bool, usize)>>>);

impl StepListener for Matrices {
    fn on_step(&mut self, step: &EngineStep<'_>) {
        if let Input::Matrix(sensing) = step.input {
            let entry = (sensing.locator_model.is_some(), step.touches.len());
            self.0.lock().expect("no panic").push(entry);
        }
    }
}

/// Waits until something is so in the newest view, for at most a minute.
fn wait_until(game: &mut RunningGame, mut is_so: impl FnMut(&mut RunningGame) -> bool) {
    for _ in 0..6000 {
        if is_so(game) {
            return;
        }
        sleep(Duration::from_millis(10));
    }
    panic!("not within a minute");
}

#[test]
fn the_table_is_taken_between_two_touches() {
    let shipped = shipped_pad(DEFAULT_PAD).expect("shipped");
    let pad = Pad::from_toml(shipped.name, shipped.toml).expect("sound");
    let table = Arc::new(cache::load_or_solve(&pad, &|_, _| ()).expect("solvable"));
    let builder = SensingBuilder::new(&pad, Method::default()).expect("solvable");
    let sensing = Arc::new(builder.build_initial().expect("a matrix"));
    let mario = shipped_profile("super-mario").expect("shipped");
    let profile = Arc::new(Profile::from_toml("super-mario", mario.toml).expect("sound"));
    let simulated = SimulatedPad::new(&pad).expect("solvable");
    let finger = Press {
        centre_mm: JUMP_MM,
        radius_mm: 7.0,
        rise: 1.2,
    };
    let is_pressed = Arc::new(AtomicBool::new(false));
    let board = Board {
        rest: simulated.volts(&[]).expect("solvable"),
        pressed: simulated.volts(&[finger]).expect("solvable"),
        is_pressed: Arc::clone(&is_pressed),
        frames: 0,
    };
    let matrices = Matrices::default();
    let mut game = runtime::start_with_listeners(
        Engine::new(&pad, sensing, profile),
        builder,
        Box::new(board),
        Box::new(Trace::new(std::io::sink())),
        vec![Box::new(matrices.clone())],
    )
    .expect("threads");
    let with_table = || {
        let seen = matrices.0.lock().expect("no panic").clone();
        seen.into_iter().find(|(locates, _)| *locates)
    };

    wait_until(&mut game, |game| game.view().frames > 30);
    is_pressed.store(true, Ordering::Relaxed);
    wait_until(&mut game, |game| !game.view().held.is_empty());
    assert!(game.send_command(PlayCommand::Table(table)));
    // Long enough for the matrix, which takes 0.1 s; a slower computer only tests less.
    sleep(Duration::from_millis(1500));
    assert_eq!(with_table(), None, "not while a key is held");
    assert!(!game.view().held.is_empty(), "the key stays held");

    is_pressed.store(false, Ordering::Relaxed);
    wait_until(&mut game, |_| with_table().is_some());
    assert_eq!(with_table(), Some((true, 0)));

    is_pressed.store(true, Ordering::Relaxed);
    wait_until(&mut game, |game| !game.view().held.is_empty());
    let [x, y] = game.view().touches[0].contact.centre_mm;
    assert!((x - JUMP_MM[0]).hypot(y - JUMP_MM[1]) < 3.0, "{x} {y}");
    game.stop();
    let summary = game.join();
    assert_eq!(summary.panicked, None);
}
