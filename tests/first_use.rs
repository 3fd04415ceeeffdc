//! What comes into a game that is being played: the response table of a pad that is used for the first time, and a pad that has been
//! identified. Both are inputs between two touches.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::sleep;
use std::time::Duration;

use gelpad::cache;
use gelpad::eit::{Press, ResponseTable};
use gelpad::engine::{Engine, Input};
use gelpad::output::Trace;
use gelpad::pad::{DEFAULT_PAD, Deviations, Pad, cell_sites_mm, shipped_pad};
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

/// For each matrix: the response table with which it locates touches, if any, and the number of touches at that moment.
#[derive(Clone, Default)]
struct Matrices(Arc<Mutex<Vec<TakenMatrix>>>);

type TakenMatrix = (Option<Arc<ResponseTable>>, usize);

impl Matrices {
    /// The number of touches at each matrix with this table.
    fn with_table(&self, table: &Arc<ResponseTable>) -> Vec<usize> {
        let seen = self.0.lock().expect("no panic");
        let own = seen.iter().filter(|(other, _)| {
            other
                .as_ref()
                .is_some_and(|other| Arc::ptr_eq(other, table))
        });
        own.map(|(_, touches)| *touches).collect()
    }
}

impl StepListener for Matrices {
    fn on_step(&mut self, step: &EngineStep<'_>) {
        if let Input::Matrix(sensing) = step.input {
            let model = sensing.locator_model.as_ref();
            let table = model.map(|model| Arc::clone(model.table()));
            self.0
                .lock()
                .expect("no panic")
                .push((table, step.touches.len()));
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

/// A game on a pad that can be pressed at `jump`.
struct Bench {
    game: RunningGame,
    matrices: Matrices,
    is_pressed: Arc<AtomicBool>,
}

impl Bench {
    /// The connected pad has these readings; the game starts with what `builder` knows.
    fn start(connected: &Pad, builder: SensingBuilder) -> Self {
        let mario = shipped_profile("super-mario").expect("shipped");
        let profile = Arc::new(Profile::from_toml("super-mario", mario.toml).expect("sound"));
        let simulated = SimulatedPad::new(connected).expect("solvable");
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
        let sensing = Arc::new(builder.build_initial().expect("a matrix"));
        let mut game = runtime::start_with_listeners(
            Engine::new(&drawing(), sensing, profile),
            builder,
            Box::new(board),
            Box::new(Trace::new(std::io::sink())),
            vec![Box::new(matrices.clone())],
        )
        .expect("threads");
        wait_until(&mut game, |game| game.view().frames > 30);
        Self {
            game,
            matrices,
            is_pressed,
        }
    }

    /// Presses and waits for the key.
    fn press(&mut self) {
        self.is_pressed.store(true, Ordering::Relaxed);
        wait_until(&mut self.game, |game| !game.view().held.is_empty());
    }

    /// After long enough for a matrix, which takes 0.1 s, none with this table has come; a slower computer only tests less.
    fn expect_none_while_held(&mut self, table: &Arc<ResponseTable>) {
        sleep(Duration::from_millis(1500));
        assert!(
            self.matrices.with_table(table).is_empty(),
            "not while a key is held"
        );
        assert!(!self.game.view().held.is_empty(), "the key stays held");
    }

    /// Lifts, waits for a matrix with this table, and presses again; returns how far off the touch is found, mm.
    fn press_with_table(&mut self, table: &Arc<ResponseTable>) -> f64 {
        self.is_pressed.store(false, Ordering::Relaxed);
        let matrices = self.matrices.clone();
        wait_until(&mut self.game, |_| !matrices.with_table(table).is_empty());
        assert_eq!(matrices.with_table(table)[0], 0, "nothing is down");
        self.press();
        let [x, y] = self.game.view().touches[0].contact.centre_mm;
        (x - JUMP_MM[0]).hypot(y - JUMP_MM[1])
    }

    fn end(self) {
        self.game.stop();
        assert_eq!(self.game.join().panicked, None);
    }
}

fn drawing() -> Pad {
    let shipped = shipped_pad(DEFAULT_PAD).expect("shipped");
    Pad::from_toml(shipped.name, shipped.toml).expect("sound")
}

#[test]
fn the_table_is_taken_between_two_touches() {
    let pad = drawing();
    let table = Arc::new(cache::load_or_solve(&pad, &|_, _| ()).expect("solvable"));
    let builder = SensingBuilder::new(&pad, Method::default()).expect("solvable");
    let mut bench = Bench::start(&pad, builder);
    bench.press();
    assert!(
        bench
            .game
            .send_command(PlayCommand::Table(Arc::clone(&table)))
    );
    bench.expect_none_while_held(&table);
    let error_mm = bench.press_with_table(&table);
    assert!(error_mm < 3.0, "{error_mm}");
    bench.end();
}

#[test]
fn an_identified_pad_is_taken_between_two_touches_and_keeps_its_own_table() {
    let pad = drawing();
    let uneven = cell_sites_mm(&pad)
        .into_iter()
        .map(|[x, y]| ([x, y], 0.8 + 0.004 * x));
    let uneven = pad.with_deviations(Deviations::new(uneven.collect(), Vec::new()));
    let of =
        |pad: &Pad| cache::sensing_builder(pad, Method::default(), |_, _| ()).expect("solvable");
    let (drawn, identified) = (of(&pad), of(&uneven));
    let [drawn_table, own_table] =
        [&drawn, &identified].map(|one| Arc::clone(one.table().expect("a table")));
    let mut bench = Bench::start(&uneven, drawn);
    bench.press();
    assert!(
        bench
            .game
            .send_command(PlayCommand::Pad(Box::new(identified)))
    );
    // The drawing's table may arrive later, on a first start.
    let late = Arc::new((*drawn_table).clone());
    assert!(
        bench
            .game
            .send_command(PlayCommand::Table(Arc::clone(&late)))
    );
    bench.expect_none_while_held(&own_table);
    let error_mm = bench.press_with_table(&own_table);
    assert!(error_mm < 1.0, "{error_mm}");
    assert!(
        bench.matrices.with_table(&late).is_empty(),
        "the pad keeps its own table"
    );
    bench.end();
}
