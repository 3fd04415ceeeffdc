//! Every format in parts over a pseudo-terminal: the parts form the frames that the board measured.

use gelpad::pad::Pad;
use gelpad::source::board::{BoardSettings, BoardSignal, CableFaults, ServePlan};
use gelpad::source::serial::{DEFAULT_BAUD, SerialSource};
use gelpad::source::wire::{FormatChoice, WireFormat};
use gelpad::source::{Script, Source, SourceReading};
use gelpad::types::FrameAssembler;

use super::board::{ServedBoard, next, pad, plan};

const SCRIPT: &str = "t:300 down 1 80 50\nt:600 up 1\nt:900 end";
const FRAMES: u64 = 30;
const PERIOD_US: u64 = 50_000;

/// What a source hands on: frames, whole or assembled, the number of parts, and the order of their times.
struct Received {
    frames: Vec<Vec<f32>>,
    parts: usize,
    /// Parts that arrived at least a quarter of a frame before the end of theirs.
    early: usize,
}

/// The script of a board. An instrument is set up first, for a while that varies, so its pad stays untouched.
fn script(kind: WireFormat) -> &'static str {
    match kind {
        WireFormat::Sciospec => "t:900000 down 1 80 50",
        _ => SCRIPT,
    }
}

fn receive(pad: &Pad, settings: &BoardSettings, format: FormatChoice) -> Received {
    let script = script(settings.kind);
    let plan = plan(Some(1e6 / PERIOD_US as f64), None);
    let board = ServedBoard::start(pad, settings, script, (60.0, 9), plan);
    let mut source = SerialSource::open(&board.port, DEFAULT_BAUD, pad, format).expect("opened");
    source.read_in_parts();
    let mut received = Received {
        frames: Vec::new(),
        parts: 0,
        early: 0,
    };
    let mut assembler = FrameAssembler::default();
    let mut arrivals = Vec::new();
    let mut last_ns = 0;
    while received.frames.len() < FRAMES as usize {
        match next(&mut source) {
            (SourceReading::Frame(frame), _) => {
                assert!(frame.t_ns >= last_ns);
                last_ns = frame.t_ns;
                received.frames.push(frame.volts);
            }
            (SourceReading::Part(part), at) => {
                assert!(part.t_ns >= last_ns, "times never run backwards");
                last_ns = part.t_ns;
                received.parts += 1;
                arrivals.push(at);
                if let Some(frame) = assembler.add(&part, pad.channels()) {
                    received.frames.push(frame.volts);
                    let quarter = std::time::Duration::from_micros(PERIOD_US / 4);
                    received.early += arrivals.iter().filter(|t| at - **t > quarter).count();
                    arrivals.clear();
                }
            }
            (other, _) => panic!("{other:?} from a board without faults"),
        }
    }
    drop(source);
    board.end();
    received
}

/// The frames of a board that reads its drives in turn.
fn truth(pad: &Pad, kind: WireFormat) -> Vec<Vec<f32>> {
    let script = Script::parse("s", script(kind)).expect("sound");
    let mut signal = BoardSignal::new(pad, &script, (60.0, 9), 0.0, None).expect("solvable");
    let us = |frame: u64| 1000 * PERIOD_US * frame;
    (0..FRAMES)
        .map(|n| signal.read_in_turn(us(n), us(n + 1)))
        .collect()
}

/// Whether frames are those measured, in a board's scale, to a share of the largest reading.
fn agree(frames: &[Vec<f32>], truth: &[Vec<f32>], scale: f32, share: f32) -> bool {
    let largest = truth
        .iter()
        .flatten()
        .fold(0.0_f32, |most, volt| most.max(volt.abs()));
    frames
        .iter()
        .flatten()
        .zip(truth.iter().flatten())
        .all(|(got, sent)| (got.abs() * scale - sent.abs()).abs() <= share * largest)
}

#[test]
fn slow_frames_are_handed_on_drive_by_drive_in_every_format() {
    let lattice = pad("edinburgh-lattice");
    let spectra = pad("openeit-lattice");
    let settings = BoardSettings::new;
    let by_drive = BoardSettings {
        by_drive: true,
        ..settings(WireFormat::Gelpad)
    };
    let no_menu = BoardSettings {
        menu: false,
        ..settings(WireFormat::OpenEit)
    };
    let rotated = BoardSettings {
        rotated: true,
        layout: Some(gelpad::eit::order::Layout::Adjacent),
        ..settings(WireFormat::Lines)
    };
    let cases = [
        (&lattice, settings(WireFormat::Lines), 1.0, 0.0),
        (&lattice, rotated, 1.0, 0.0),
        (&lattice, settings(WireFormat::Square), 0.01, 1e-5),
        (&lattice, settings(WireFormat::Sciospec), 1e3, 1e-5),
        (&lattice, by_drive, 1.0, 0.0),
        (&spectra, no_menu, 0.01, 1e-5),
    ];
    std::thread::scope(|scope| {
        for (pad, settings, scale, share) in cases {
            scope.spawn(move || {
                let kind = settings.kind;
                let received = receive(pad, &settings, kind.into());
                assert!(
                    agree(&received.frames, &truth(pad, kind), scale, share),
                    "{kind:?}: other readings than measured"
                );
                let most = 16 * FRAMES as usize;
                assert!(
                    received.parts > most / 2,
                    "{kind:?}: {} parts",
                    received.parts
                );
                assert!(
                    received.early > most / 10,
                    "{kind:?}: {} early",
                    received.early
                );
            });
        }
    });
}

#[test]
fn frames_stay_whole_where_parts_cannot_be_had_or_are_not_wanted() {
    let lattice = pad("edinburgh-lattice");
    let half = BoardSettings {
        layout: Some(gelpad::eit::order::Layout::AdjacentHalf),
        ..BoardSettings::new(WireFormat::Lines)
    };
    let cases = [
        // A packet of a whole frame; the half layout, where a drive's readings are spread over the frame.
        (BoardSettings::new(WireFormat::Gelpad), "gelpad"),
        (half, "lines"),
        (BoardSettings::new(WireFormat::Lines), "lines:whole"),
    ];
    for (settings, format) in cases {
        let received = receive(&lattice, &settings, format.parse().expect("a format"));
        assert_eq!(received.parts, 0, "{format}");
    }
}

#[test]
fn damaged_bytes_cost_their_frames_and_never_the_order_of_the_parts() {
    let lattice = pad("edinburgh-lattice");
    for (kind, by_drive) in [
        (WireFormat::Lines, false),
        (WireFormat::Square, false),
        (WireFormat::Sciospec, false),
        (WireFormat::Gelpad, true),
    ] {
        let settings = BoardSettings {
            by_drive,
            ..BoardSettings::new(kind)
        };
        let plan = ServePlan {
            faults: CableFaults {
                lost_bytes: 0.0003,
                flipped_bits: 0.00001,
                ..CableFaults::default()
            },
            ..plan(Some(50.0), None)
        };
        let board = ServedBoard::start(&lattice, &settings, SCRIPT, (60.0, 9), plan);
        let mut source =
            SerialSource::open(&board.port, DEFAULT_BAUD, &lattice, kind.into()).expect("opened");
        source.read_in_parts();
        let (mut parts, mut skipped, mut last_ns, mut next_first) = (0, 0, 0, 0);
        while parts < 600 {
            match next(&mut source).0 {
                SourceReading::Part(part) => {
                    parts += 1;
                    assert!(part.t_ns >= last_ns);
                    last_ns = part.t_ns;
                    assert!(
                        part.first == 0 || part.first == next_first,
                        "{kind:?}: a part at {} after one up to {next_first}",
                        part.first
                    );
                    assert!(part.volts.iter().all(|volt| volt.is_finite()));
                    next_first = part.first + part.volts.len();
                }
                SourceReading::Skipped { .. } => skipped += 1,
                SourceReading::Frame(_) => {}
                other => panic!("{other:?}"),
            }
        }
        drop(source);
        let report = board.end();
        assert!(report.lost_bytes > 10, "{report:?}");
        assert!(skipped > 3, "{kind:?}: {skipped} reports of damage");
    }
}
