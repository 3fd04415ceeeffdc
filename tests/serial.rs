//! A board on a pseudo-terminal: OpenEIT's text compared with the same frames from a CSV file, garbled lines,
//! a port that is unplugged and comes back.

use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use gelpad::eit::{Press, Reconstruction};
use gelpad::pad::{Pad, shipped_pad};
use gelpad::source::serial::{DEFAULT_BAUD, SerialSource};
use gelpad::source::wire::WireFormat;
use gelpad::source::wire::openeit;
use gelpad::source::{FramesCsv, Noise, SimulatedPad, Source, SourceReading};
use gelpad::touch::Detector;
use gelpad::types::{Frame, Method};
use rustix::process::{Pid, Signal, kill_process};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

const PAD: &str = "openeit-lattice";
/// Scale from V/A to the board's unit: its text has four decimals.
const SCALE: f64 = 1e4;
const FRAME: Duration = Duration::from_millis(10);

/// A pseudo-terminal: the board's end, and the path that gelpad opens.
fn pty() -> (File, String) {
    // Closed on exec: a child process with the board's end would keep the port alive.
    let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
    let board = openpt(flags).expect("a pseudo-terminal");
    grantpt(&board).expect("granted");
    unlockpt(&board).expect("unlocked");
    // Raw mode from the start: nothing that is written before gelpad opens the port may be echoed or edited.
    let mut modes = tcgetattr(&board).expect("modes");
    modes.make_raw();
    tcsetattr(&board, OptionalActions::Now, &modes).expect("raw");
    let path = ptsname(&board, Vec::new()).expect("its path");
    (File::from(board), path.into_string().expect("a text"))
}

fn pad() -> Pad {
    Pad::from_toml(PAD, shipped_pad(PAD).expect("shipped").toml).expect("sound")
}

/// Frames as a board sends them: untouched, one finger, two fingers, untouched, one finger to the end.
fn frames() -> Vec<Vec<f32>> {
    let finger = |x, y| Press {
        centre_mm: [x, y],
        radius_mm: 7.0,
        rise: 1.2,
    };
    let pad = SimulatedPad::new(&pad()).expect("solvable");
    let one = [finger(80.0, 50.0)];
    let two = [finger(80.0, 50.0), finger(13.0, 55.0)];
    let states: Vec<Vec<f64>> = [&[] as &[Press], &one, &two]
        .iter()
        .map(|fingers| {
            let volts = pad.volts(fingers).expect("solved");
            volts.iter().map(|volt| volt.abs() * SCALE).collect()
        })
        .collect();
    let mut noise = Noise::new(60.0, 5);
    [(0, 30), (1, 20), (2, 20), (0, 20), (1, 20)]
        .iter()
        .flat_map(|(state, count)| std::iter::repeat_n(*state, *count))
        .map(|state: usize| {
            // Rounded to the board's four decimals.
            noise
                .read(&states[state])
                .iter()
                .map(|value| format!("{value:.4}").parse().expect("a number"))
                .collect()
        })
        .collect()
}

fn open(path: &str) -> SerialSource {
    SerialSource::open(path, DEFAULT_BAUD, &pad(), WireFormat::OpenEit.into()).expect("opened")
}

/// A link that keeps its path: pseudo-terminals come back under other names.
fn link(link: &Path, port: &str) {
    let _ = std::fs::remove_file(link);
    std::os::unix::fs::symlink(port, link).expect("linked");
}

fn read_frame(source: &mut dyn Source) -> Frame {
    for _ in 0..200 {
        match source.read().expect("the board is there") {
            SourceReading::Frame(frame) => return frame,
            SourceReading::Idle => {}
            other => panic!("{other:?} instead of a frame"),
        }
    }
    panic!("no frame within 10 s");
}

/// Kills the child process after half a minute unless the flag is set: a test must not hang.
fn deadline(child: Pid) -> Arc<AtomicBool> {
    let done = Arc::new(AtomicBool::new(false));
    let seen = Arc::clone(&done);
    std::thread::Builder::new()
        .spawn(move || {
            for _ in 0..300 {
                std::thread::sleep(Duration::from_millis(100));
                if seen.load(Ordering::Relaxed) {
                    return;
                }
            }
            let _ = kill_process(child, Signal::KILL);
        })
        .expect("a thread");
    done
}

#[test]
fn the_text_stream_gives_the_touches_of_the_same_frames_from_csv() {
    let frames = frames();
    let mut csv = tempfile::NamedTempFile::new().expect("a file");
    let header: Vec<String> = (0..192).map(|i| format!("v{i}")).collect();
    writeln!(csv, "t_ms,{}", header.join(",")).expect("written");
    for (index, volts) in frames.iter().enumerate() {
        let values: Vec<String> = volts.iter().map(f32::to_string).collect();
        writeln!(csv, "{},{}", index * 10, values.join(",")).expect("written");
    }
    let (mut board, path) = pty();
    let mut serial = open(&path);
    let mut file = FramesCsv::open(csv.path(), 192).expect("opened");
    let matrix = Arc::new(Reconstruction::from_pad(&pad(), Method::default()).expect("a matrix"));
    let (mut by_wire, mut by_file) = (Detector::new(Arc::clone(&matrix)), Detector::new(matrix));
    let mut changed = Vec::new();
    let mut most = 0;
    // The first three frames tell the order, so the board is that far ahead.
    let mut ahead = frames.iter().map(|volts| openeit::encode(volts));
    for line in ahead.by_ref().take(3) {
        board.write_all(line.as_bytes()).expect("sent");
    }
    for _ in &frames {
        if let Some(line) = ahead.next() {
            board.write_all(line.as_bytes()).expect("sent");
        }
        let from_wire = read_frame(&mut serial);
        let from_file = read_frame(&mut file);
        assert_eq!(from_wire.volts, from_file.volts, "bit for bit");
        // The board has no clock: only the time of a frame may differ.
        let stamped = Frame {
            t_ns: from_file.t_ns,
            ..from_wire
        };
        by_wire.process_frame(&stamped, &mut changed);
        by_file.process_frame(&from_file, &mut changed);
        assert_eq!(by_wire.touches_down(), by_file.touches_down());
        most = most.max(by_file.touches_down().len());
    }
    assert_eq!(most, 2, "both fingers were seen");
}

#[test]
fn what_arrived_long_before_the_first_reading_is_not_played() {
    let (mut board, path) = pty();
    let mut source = open(&path);
    let frames = frames();
    // The pad is solved meanwhile: the system keeps what the board sends.
    let (old, new) = frames.split_at(2);
    for frame in old {
        board
            .write_all(openeit::encode(frame).as_bytes())
            .expect("sent");
    }
    std::thread::sleep(Duration::from_millis(700));
    // The old frames, then nothing.
    for _ in 0..10 {
        let reading = source.read().expect("a board");
        assert_eq!(reading, SourceReading::Idle, "an old frame is played");
    }
    // The first three frames tell the order, so the board is that far ahead.
    let mut ahead = new.iter().map(|frame| openeit::encode(frame));
    for line in ahead.by_ref().take(2) {
        board.write_all(line.as_bytes()).expect("sent");
    }
    for (frame, line) in new[..20].iter().zip(ahead) {
        board.write_all(line.as_bytes()).expect("sent");
        assert!(read_frame(&mut source).volts == *frame, "all new ones are");
    }
}

#[test]
fn an_unplugged_port_is_reported_once_and_opened_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let port = folder.path().join("port");
    let (board, path) = pty();
    link(&port, &path);
    let mut serial = open(&port.display().to_string());
    drop(board);
    let gone = (0..10).find_map(|_| match serial.read().expect("it is waited for") {
        SourceReading::Disconnected { reason } => Some(reason),
        SourceReading::Idle => None,
        other => panic!("{other:?} from a port that is gone"),
    });
    assert!(
        gone.expect("reported")
            .contains("Pad disconnected: waiting for")
    );
    std::fs::remove_file(&port).expect("the port is gone");
    for _ in 0..20 {
        assert_eq!(
            serial.read().expect("it is waited for"),
            SourceReading::Idle
        );
    }
    let (mut board, path) = pty();
    link(&port, &path);
    let frames = frames();
    // Half a line first, as from a running board.
    let mut text = openeit::encode(&frames[0]).split_off(1000);
    for volts in &frames[..3] {
        text.push_str(&openeit::encode(volts));
    }
    board.write_all(text.as_bytes()).expect("sent");
    for volts in &frames[..3] {
        assert_eq!(&read_frame(&mut serial).volts, volts);
    }
}

#[test]
fn garbled_lines_are_counted_and_play_continues_when_the_port_is_back() {
    let frames = frames();
    let folder = tempfile::tempdir().expect("a folder");
    let port = folder.path().join("port");
    let (mut board, path) = pty();
    link(&port, &path);
    let mut gelpad = Command::new(env!("CARGO_BIN_EXE_gelpad"))
        .args([
            "play",
            "--headless",
            "--output",
            "trace",
            "--pad",
            PAD,
            "--source",
        ])
        .arg(format!("serial:{}", port.display()))
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("started");
    let pid = Pid::from_child(&gelpad);
    let mut events = BufReader::new(gelpad.stdout.take().expect("piped"));
    let done = deadline(pid);
    // The terminal keeps what the board sends until gelpad is ready.
    std::thread::sleep(Duration::from_millis(1500));
    for (index, volts) in frames.iter().enumerate() {
        let line = openeit::encode(volts);
        match index {
            15 => board
                .write_all(&line.as_bytes()[..line.len() / 2])
                .and_then(|()| board.write_all(b"\r\n")),
            20 => board.write_all(line.replacen("0.", "x.", 1).as_bytes()),
            _ => board.write_all(line.as_bytes()),
        }
        .expect("sent");
        std::thread::sleep(FRAME);
    }
    let mut lines = |count: usize| -> Vec<String> {
        (0..count)
            .map(|_| {
                let mut line = String::new();
                events.read_line(&mut line).expect("a line");
                line.trim_end()
                    .split_once(' ')
                    .expect("a time first")
                    .1
                    .to_owned()
            })
            .collect()
    };
    let pressed = [
        "press key:f",
        "press key:left",
        "release key:f",
        "release key:left",
        "press key:f",
    ];
    assert_eq!(lines(5), pressed);
    drop(board);
    assert_eq!(lines(1), ["release key:f"], "up while it is away");
    let (mut board, path) = pty();
    link(&port, &path);
    // The pad counts as untouched when it comes back: the next finger is a new press.
    std::thread::sleep(Duration::from_millis(600));
    for volts in frames[..30].iter().chain(&frames[70..]) {
        board
            .write_all(openeit::encode(volts).as_bytes())
            .expect("sent");
        std::thread::sleep(FRAME);
    }
    assert_eq!(lines(1), ["press key:f"]);
    kill_process(pid, Signal::TERM).expect("running");
    assert_eq!(lines(1), ["release key:f"]);
    let output = gelpad.wait_with_output().expect("ended");
    done.store(true, Ordering::Relaxed);
    let stderr = String::from_utf8_lossy(&output.stderr);
    for expected in [
        "the board speaks OpenEIT Spectra's text (--format openeit), 192 values a frame",
        "192 voltages a frame",
        "skipped input that is not a frame (2 so far)",
        "2 frames lost (2 of them garbled)",
        "Pad disconnected: waiting for",
        "pad connected again",
    ] {
        assert!(
            stderr.contains(expected),
            "{expected:?} is not in:\n{stderr}"
        );
    }
    assert_eq!(output.status.code(), Some(143), "{stderr}");
}
