//! A pad is found from its own readings at rest: conductance and electrodes.

use std::fmt::Write as _;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::thread::sleep;
use std::time::{Duration, Instant};

use gelpad::cache;
use gelpad::eit::Press;
use gelpad::eit::identify::{
    IdentifiedPad, IdentifyError, KnownPress, KnownPresses, RestReadings, identify,
    identify_with_presses, one_by_one,
};
use gelpad::pad::{Deviations, ElectrodeDeviation, Pad, cell_sites_mm, shipped_pad};
use gelpad::source::{Noise, SimulatedPad};
use rustix::process::{Pid, Signal, kill_process};

fn drawing(name: &str) -> Pad {
    Pad::from_toml(name, shipped_pad(name).expect("shipped").toml).expect("sound")
}

/// A pad whose pieces, thickness and electrodes differ from the drawing.
fn built(drawing: &Pad) -> Pad {
    let cells = cell_sites_mm(drawing)
        .into_iter()
        .enumerate()
        .map(|(index, [x, y])| {
            let piece = 0.06 * libm::sin(2.4 * index as f64);
            let smooth = 0.15 * (libm::sin(x / 25.0) + libm::cos(y / 30.0));
            ([x, y], libm::exp(piece + smooth))
        });
    let electrodes = (0..drawing.electrodes.len()).map(|index| ElectrodeDeviation {
        shift_mm: 0.5 * libm::sin(1.7 * index as f64),
        stretch_mm: 0.0,
    });
    drawing.with_deviations(Deviations::new(cells.collect(), electrodes.collect()))
}

fn rest(pad: &Pad) -> Vec<f64> {
    let simulated = SimulatedPad::new(pad).expect("solvable");
    simulated.volts(&[]).expect("solved")
}

/// Root mean square error of the logarithm of the conductance, which has no common factor, and of the electrodes' places, mm.
fn errors(found: &Pad, truth: &Pad) -> [f64; 2] {
    let pairs = found.deviations.cells.iter().zip(&truth.deviations.cells);
    let off: Vec<f64> = pairs.map(|(a, b)| libm::log(a.1 / b.1)).collect();
    let common = off.iter().sum::<f64>() / off.len() as f64;
    let electrodes = found.electrodes.iter().zip(&truth.electrodes);
    let centre = |e: &gelpad::pad::Electrode| e.start_mm + e.width_mm / 2.0;
    let shifts: Vec<f64> = electrodes.map(|(a, b)| centre(a) - centre(b)).collect();
    let rms = |list: &[f64], middle: f64| {
        let sum: f64 = list
            .iter()
            .map(|value| (value - middle) * (value - middle))
            .sum();
        libm::sqrt(sum / list.len() as f64)
    };
    [rms(&off, common), rms(&shifts, 0.0)]
}

#[test]
fn conductance_and_electrodes_are_found_on_another_mesh_and_in_any_unit() {
    let drawing = drawing("edinburgh-lattice");
    let truth = built(&drawing);
    let even = truth.deviations.cells.iter().map(|(site, _)| (*site, 1.0));
    let as_drawn = drawing.with_deviations(Deviations::new(even.collect(), Vec::new()));
    let [cells_drawn, shifts_drawn] = errors(&as_drawn, &truth);
    let volts: Vec<f64> = rest(&truth).iter().map(|volt| 3.7e4 * volt).collect();
    let found = identify(&drawing, &volts, &vec![1e-4; volts.len()], &one_by_one).expect("found");
    let [cells, shifts] = errors(&found.pad, &truth);
    assert!(
        found.misfit[0] > 0.05 && found.misfit[1] < 0.002,
        "{:?}",
        found.misfit
    );
    assert!(cells < 0.5 * cells_drawn, "{cells} of {cells_drawn}");
    assert!(shifts < 0.6 * shifts_drawn, "{shifts} of {shifts_drawn} mm");
}

#[test]
fn a_pad_as_drawn_stays_as_drawn_whatever_readings_are_lost() {
    let drawing = drawing("edinburgh-lattice");
    let mut volts = rest(&drawing);
    volts[3] = f64::NAN;
    volts[50] = 0.0;
    let mut deviations = vec![1e-4; volts.len()];
    deviations[7] = f64::INFINITY;
    let found = identify(&drawing, &volts, &deviations, &one_by_one).expect("found");
    for (site, factor) in &found.pad.deviations.cells {
        assert!((factor - 1.0).abs() < 0.02, "{site:?}: {factor}");
    }
    for electrode in &found.pad.deviations.electrodes {
        assert!(electrode.shift_mm.abs() < 0.05, "{electrode:?}");
    }
}

#[test]
fn readings_of_another_pad_are_refused() {
    let lattice = drawing("edinburgh-lattice");
    let deviations = vec![1e-4; lattice.channels()];
    // Wires in another order.
    let mut shuffled = rest(&lattice);
    shuffled.rotate_left(13 * 5 + 4);
    let error = identify(&lattice, &shuffled, &deviations, &one_by_one).expect_err("another order");
    assert!(matches!(error, IdentifyError::OtherPad { .. }), "{error}");
    assert!(error.to_string().contains("wired in order"), "{error}");
    // A stuck board.
    let equal = vec![1.0; lattice.channels()];
    let error = identify(&lattice, &equal, &deviations, &one_by_one).expect_err("equal readings");
    assert!(matches!(error, IdentifyError::Uneven { .. }), "{error}");
    assert!(error.to_string().contains("stuck"), "{error}");
    let nothing = vec![0.0; lattice.channels()];
    let error = identify(&lattice, &nothing, &deviations, &one_by_one).expect_err("no reading");
    assert!(
        matches!(error, IdentifyError::TooFew { usable: 0, .. }),
        "{error}"
    );
}

/// A pad of which each piece of channel differs by itself: more unknowns than readings at rest.
fn uneven(drawing: &Pad) -> Pad {
    let cells = cell_sites_mm(drawing).into_iter().enumerate();
    let cells = cells.map(|(index, site)| (site, 1.0 + 0.2 * libm::sin(2.4 * index as f64)));
    drawing.with_deviations(Deviations::new(cells.collect(), Vec::new()))
}

/// Presses on a grid, a finger's width apart, of one hand; each is told to be where it is, or at another place.
fn presses(pad: &Pad, told: impl Fn(usize, [f64; 2]) -> [f64; 2]) -> Vec<KnownPress> {
    let simulated = SimulatedPad::new(pad).expect("solvable");
    let rest = simulated.volts(&[]).expect("solved");
    let places = (0..5).flat_map(|i| (0..5).map(move |j| [i, j].map(|k| 14.0 + 18.0 * k as f64)));
    let press = |(index, place_mm): (usize, [f64; 2])| {
        let finger = Press {
            centre_mm: place_mm,
            radius_mm: 7.0 + 0.5 * libm::sin(index as f64),
            rise: 1.0 + 0.3 * libm::cos(2.0 * index as f64),
        };
        let volts = simulated.volts(&[finger]).expect("solved");
        let pairs = volts.iter().zip(&rest);
        KnownPress {
            place_mm: told(index, place_mm),
            changes: pairs.map(|(volt, rest)| volt / rest - 1.0).collect(),
        }
    };
    places.enumerate().map(press).collect()
}

fn with_presses(
    drawing: &Pad,
    volts: &[f64],
    presses: &[KnownPress],
) -> Result<IdentifiedPad, IdentifyError> {
    let deviations = vec![1e-4; volts.len()];
    let rest = RestReadings {
        volts,
        deviations: &deviations,
    };
    let known = KnownPresses {
        presses,
        noise: 1e-4,
    };
    identify_with_presses(drawing, rest, known, &one_by_one)
}

#[test]
fn presses_tell_what_the_untouched_pad_leaves_open() {
    let drawing = drawing("edinburgh-lattice");
    let truth = uneven(&drawing);
    let volts = rest(&truth);
    let alone = identify(&drawing, &volts, &vec![1e-4; volts.len()], &one_by_one).expect("found");
    let [alone, _] = errors(&alone.pad, &truth);
    // A hand that is 1 mm beside the places, in all directions.
    let beside = |index: usize, [x, y]: [f64; 2]| {
        let angle = 2.4 * index as f64;
        [x + libm::cos(angle), y + libm::sin(angle)]
    };
    for (name, told, share) in [
        (
            "exact",
            &(|_, place| place) as &dyn Fn(usize, [f64; 2]) -> [f64; 2],
            0.5,
        ),
        ("beside", &beside, 0.7),
    ] {
        let found = with_presses(&drawing, &volts, &presses(&truth, told)).expect("found");
        let [cells, _] = errors(&found.pad, &truth);
        println!("{name}: {cells:.4} of {alone:.4}");
        assert!(cells < share * alone, "{name}: {cells} of {alone}");
        assert!(found.unexplained.is_empty(), "{:?}", found.unexplained);
        assert!(found.misfit[1] < 0.003, "{:?}", found.misfit);
    }
}

#[test]
fn presses_at_other_places_are_left_out_and_those_of_another_pad_refused() {
    let drawing = drawing("edinburgh-lattice");
    let truth = uneven(&drawing);
    let volts = rest(&truth);
    let one_wrong = presses(&truth, |index, [x, y]| match index {
        6 => [x + 50.0, y + 30.0],
        _ => [x, y],
    });
    let found = with_presses(&drawing, &volts, &one_wrong).expect("found");
    assert_eq!(found.unexplained, [6]);
    let mirrored = presses(&truth, |index, [x, y]| [100.0 - y, x + 0.01 * index as f64]);
    let error = with_presses(&drawing, &volts, &mirrored).expect_err("other places");
    assert!(
        matches!(error, IdentifyError::OtherPresses { .. }),
        "{error}"
    );
    assert!(error.to_string().contains("bottom-left"), "{error}");
}

/// `gelpad` in a folder, with its tables.
fn gelpad(folder: &Path, arguments: &[&str]) -> (bool, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_gelpad"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("started");
    let said = [output.stdout, output.stderr].concat();
    (
        output.status.success(),
        String::from_utf8_lossy(&said).into_owned(),
    )
}

#[test]
fn the_command_writes_a_pad_that_has_these_readings() {
    let folder = tempfile::tempdir().expect("a folder");
    let drawing = drawing("edinburgh-lattice");
    let truth = built(&drawing);
    let volts = rest(&truth);
    let mut noise = Noise::new(60.0, 5);
    let head: Vec<String> = (0..volts.len())
        .map(|channel| format!(",v{channel}"))
        .collect();
    let mut csv = format!("t_ms{}\n", head.concat());
    for frame in 0..20 {
        let _ = write!(csv, "{}", 10 * frame);
        for volt in noise.read(&volts) {
            let _ = write!(csv, ",{volt}");
        }
        csv.push('\n');
    }
    std::fs::write(folder.path().join("rest.csv"), csv).expect("written");

    let identify = [
        "pad",
        "identify",
        "--source",
        "replay:rest.csv",
        "-o",
        "found.toml",
        "--map",
        "found.png",
    ];
    let (is_done, said) = gelpad(folder.path(), &identify);
    assert!(is_done, "{said}");
    assert!(said.contains("--pad ./found.toml"), "{said}");
    let text = std::fs::read_to_string(folder.path().join("found.toml")).expect("a pad");
    let found = Pad::from_toml("found.toml", &text).expect("sound");
    let [cells, shifts] = errors(&found, &truth);
    assert!(cells < 0.08 && shifts < 0.3, "{cells} {shifts}");
    // What is found again on the found pad is the same: the drawing is in the text.
    assert_eq!(
        found.drawing(),
        Pad {
            name: found.name.clone(),
            ..drawing
        }
    );
    let png = std::fs::read(folder.path().join("found.png")).expect("a map");
    assert!(png.starts_with(b"\x89PNG"));

    let (is_done, said) = gelpad(folder.path(), &identify);
    assert!(!is_done && said.contains("found.toml exists"), "{said}");
    let (is_done, said) = gelpad(folder.path(), &["pad", "check", "./found.toml"]);
    assert!(is_done, "{said}");
    // With presses that were recorded on it.
    let rows = presses(&truth, |_, place| place);
    let mut file = format!("x_mm,y_mm{}\n", head.concat().replace('v', "d"));
    for KnownPress { place_mm, changes } in &rows {
        let [x, y] = place_mm;
        let changes = changes
            .iter()
            .zip(&volts)
            .map(|(d, v)| format!(",{}", d * v));
        let _ = writeln!(file, "{x},{y}{}", changes.collect::<String>());
    }
    std::fs::write(folder.path().join("presses.csv"), &file).expect("written");
    let with_presses = [
        "pad",
        "identify",
        "--source",
        "replay:rest.csv",
        "--presses",
        "presses.csv",
    ];
    let (is_done, said) = gelpad(folder.path(), &with_presses);
    assert!(!is_done && said.contains("row without a place"), "{said}");
    let untouched: Vec<String> = volts.iter().map(|volt| format!(",{volt}")).collect();
    file.push_str(&format!(",{}\n", untouched.concat()));
    std::fs::write(folder.path().join("presses.csv"), &file).expect("written");
    let (is_done, said) = gelpad(folder.path(), &with_presses);
    assert!(
        is_done && said.contains("presses      25, all explained"),
        "{said}"
    );
    // The simulated pad, by default.
    let (is_done, said) = gelpad(folder.path(), &["pad", "identify"]);
    assert!(is_done && said.contains("electrodes "), "{said}");
}

/// The text of a pad with what deviates.
fn text_of(pad: &Pad) -> String {
    let mut text = shipped_pad("edinburgh-lattice")
        .expect("shipped")
        .toml
        .to_owned();
    let electrodes = &pad.deviations.electrodes;
    let list = |length: fn(&ElectrodeDeviation) -> f64| {
        let lengths: Vec<String> = electrodes.iter().map(|e| length(e).to_string()).collect();
        lengths.join(", ")
    };
    let cells = pad.deviations.cells.iter();
    let cells: Vec<String> = cells
        .map(|([x, y], factor)| format!("[{x:?}, {y:?}, {factor:?}]"))
        .collect();
    let _ = write!(
        text,
        "\n[found]\nshift_mm = [{}]\nstretch_mm = [{}]\nconductance = [{}]\n",
        list(|electrode| electrode.shift_mm),
        list(|electrode| electrode.stretch_mm),
        cells.join(", ")
    );
    text
}

/// A simulated board on a pseudo-terminal; dropping it ends it.
struct Board {
    process: Child,
    port: PathBuf,
}

impl Board {
    fn start(folder: &Path, pad: &str, script: &str) -> Self {
        Self::with_options(folder, pad, script, &[])
    }

    fn with_options(folder: &Path, pad: &str, script: &str, options: &[&str]) -> Self {
        std::fs::write(folder.join("script.txt"), script).expect("written");
        let port = folder.join("board");
        let process = Command::new(env!("CARGO_BIN_EXE_gelpad"))
            .current_dir(folder)
            .args(["device", "--format", "gelpad", "--script", "script.txt"])
            .args(["--pad", pad, "--port", "board"])
            .args(options)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("started");
        while !port.exists() {
            sleep(Duration::from_millis(5));
        }
        Self { process, port }
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
        let _ = std::fs::remove_file(&self.port);
    }
}

#[allow(clippy::disallowed_methods, reason = "times are printed, not tested")]
fn now() -> Instant {
    Instant::now()
}

/// Plays the board with a cache of this test's own until a message contains each of these texts in turn, for at most a minute. Returns
/// the messages.
fn play_until(folder: &Path, more: &[&str], texts: &[&str]) -> Vec<String> {
    let mut game = Command::new(env!("CARGO_BIN_EXE_gelpad"))
        .current_dir(folder)
        .env(cache::FOLDER_VARIABLE, folder.join("cache"))
        .args(["play", "--source", "serial:board", "--output", "trace"])
        .args(["--headless"])
        .args(more)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("started");
    let stderr = game.stderr.take().expect("piped");
    let (lines_in, lines) = mpsc::sync_channel(1000);
    let reader = std::thread::Builder::new()
        .spawn(move || {
            for line in BufReader::new(stderr).lines().map_while(Result::ok) {
                if lines_in.send(line).is_err() {
                    break;
                }
            }
        })
        .expect("a thread");
    let started = now();
    let mut said = Vec::new();
    let mut awaited = texts.iter();
    let mut next = awaited.next();
    while let Some(text) = next {
        match lines.recv_timeout(Duration::from_secs(60)) {
            Ok(line) => {
                println!("{:.2} s: {line}", started.elapsed().as_secs_f64());
                if line.contains(text) {
                    next = awaited.next();
                }
                said.push(line);
            }
            Err(error) => {
                let _ = game.kill();
                panic!("no `{text}` ({error}) after {said:#?}");
            }
        }
    }
    game.kill().expect("ended");
    let _ = game.wait();
    reader.join().expect("ended");
    said
}

/// The identified pad that a cache keeps.
fn kept_pad(folder: &Path) -> Pad {
    let kept: Vec<PathBuf> = std::fs::read_dir(folder.join("cache"))
        .expect("a cache")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "toml"))
        .collect();
    let [path] = kept.as_slice() else {
        panic!("one kept pad: {kept:?}");
    };
    let text = std::fs::read_to_string(path).expect("a text");
    Pad::from_toml("edinburgh-lattice", &text).expect("sound")
}

/// A folder with a pad as built and a cache with the table of the drawing.
fn bench() -> (tempfile::TempDir, Pad) {
    let folder = tempfile::tempdir().expect("a folder");
    let drawing = drawing("edinburgh-lattice");
    let table = cache::load_or_solve(&drawing, &|_, _| ()).expect("solvable");
    cache::store(&table, &folder.path().join("cache")).expect("stored");
    let truth = built(&drawing);
    std::fs::write(folder.path().join("built.toml"), text_of(&truth)).expect("written");
    (folder, truth)
}

#[test]
fn a_board_is_identified_in_play_and_known_the_next_time() {
    let (folder, truth) = bench();
    let untouched = "t:60000 down 1 80 50\nt:60100 up 1\nt:60200 end";
    {
        let _board = Board::start(folder.path(), "./built.toml", untouched);
        play_until(folder.path(), &[], &["pad identified: its readings are"]);
        let [cells, shifts] = errors(&kept_pad(folder.path()), &truth);
        assert!(cells < 0.08 && shifts < 0.3, "{cells} {shifts}");
        let said = play_until(folder.path(), &[], &["this pad was identified before"]);
        assert!(!said.concat().contains("pad identified:"), "{said:?}");
    }
    // Another board at the same port, whose pad is as drawn, is played as drawn.
    let _board = Board::start(folder.path(), "edinburgh-lattice", untouched);
    let said = play_until(folder.path(), &["-vv"], &["readings at rest:"]);
    assert!(!said.concat().contains("identified"), "{said:?}");
}

/// Prints what is said and when (`--nocapture`): how long the first use of a board takes, and the second.
#[test]
fn a_board_plays_at_once_from_nothing_is_identified_and_needs_neither_the_next_time() {
    let (folder, _) = bench();
    std::fs::remove_dir_all(folder.path().join("cache")).expect("removed");
    let untouched = "t:60000 down 1 80 50\nt:60100 up 1\nt:60200 end";
    let _board = Board::start(folder.path(), "./built.toml", untouched);
    let in_turn = [
        "first use of this pad",
        "the responses of this pad are solved",
        "pad identified: its readings are",
    ];
    play_until(folder.path(), &[], &in_turn);
    let said = play_until(folder.path(), &[], &["this pad was identified before"]);
    assert!(!said.concat().contains("first use"), "{said:?}");
}

#[test]
fn a_game_that_is_ended_while_its_pad_is_being_solved_leaves_nothing_half_done() {
    let (folder, _) = bench();
    std::fs::remove_dir_all(folder.path().join("cache")).expect("removed");
    let untouched = "t:60000 down 1 80 50\nt:60100 up 1\nt:60200 end";
    let _board = Board::start(folder.path(), "edinburgh-lattice", untouched);
    let start = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_gelpad"));
        command
            .current_dir(folder.path())
            .env(cache::FOLDER_VARIABLE, folder.path().join("cache"))
            .args(["play", "--source", "serial:board", "--output", "trace"])
            .arg("--headless")
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        command.spawn().expect("started")
    };
    let mut stopped = start();
    let mut lines = BufReader::new(stopped.stderr.take().expect("piped")).lines();
    let is_solving = |line: std::io::Result<String>| line.is_ok_and(|l| l.contains("first use"));
    assert!(lines.any(is_solving));
    kill_process(Pid::from_child(&stopped), Signal::INT).expect("running");
    let after: Vec<String> = lines.map_while(Result::ok).collect();
    let ending = stopped.wait().expect("ended");
    assert_eq!(ending.code(), Some(130), "{after:?}");
    assert!(
        after.iter().any(|line| line.contains("frames")),
        "{after:?}"
    );
    // The one that was ended has left nothing that the next takes for a table.
    let solved = "the responses of this pad are solved";
    play_until(folder.path(), &[], &["first use", solved]);
    let next = play_until(folder.path(), &["-vv"], &["readings at rest:"]);
    assert!(!next.concat().contains("first use"), "{next:?}");
}

#[test]
fn a_finger_that_lies_on_the_pad_from_the_start_is_not_kept_as_a_part_of_it() {
    let (folder, truth) = bench();
    let lying = "t:0 down 1 30 30\nt:3000 up 1\nt:60000 down 1 80 50\nt:60100 up 1\nt:60200 end";
    let _board = Board::start(folder.path(), "./built.toml", lying);
    let twice = ["pad identified:", "pad identified:"];
    play_until(folder.path(), &[], &twice);
    let [cells, shifts] = errors(&kept_pad(folder.path()), &truth);
    assert!(cells < 0.08 && shifts < 0.3, "{cells} {shifts}");
}

#[test]
fn a_pad_is_identified_without_the_readings_of_a_lost_electrode() {
    let (folder, truth) = bench();
    let untouched = "t:60000 down 1 80 50\nt:60100 up 1\nt:60200 end";
    let lost = ["--lose-electrode", "5"];
    let _board = Board::with_options(folder.path(), "./built.toml", untouched, &lost);
    let said = play_until(folder.path(), &[], &["pad identified: its readings are"]);
    assert!(said.concat().contains("electrode 5 is loose"), "{said:?}");
    let [cells, shifts] = errors(&kept_pad(folder.path()), &truth);
    assert!(cells < 0.12 && shifts < 0.5, "{cells} {shifts}");
}

#[test]
fn a_pad_is_identified_where_nothing_can_be_kept() {
    let (folder, _) = bench();
    std::fs::remove_dir_all(folder.path().join("cache")).expect("removed");
    std::fs::write(folder.path().join("cache"), "a file").expect("written");
    let untouched = "t:60000 down 1 80 50\nt:60100 up 1\nt:60200 end";
    let _board = Board::start(folder.path(), "./built.toml", untouched);
    let in_turn = [
        "will be identified again",
        "pad identified: its readings are",
    ];
    play_until(folder.path(), &[], &in_turn);
}
