//! The whole path of a board's bytes: decoder, arrangement, engine. Bytes of a simulated board are damaged, whatever the
//! damage: frames have the pad's number of finite values, the engine takes them, and every key that went down comes up.
//!
//! The first byte chooses the format, the second the length of the pieces in which bytes arrive; then come edits of four bytes
//! (message, what to do, place, value). `cargo fuzz run -s none path` (with RUSTC_BOOTSTRAP=1 without a nightly compiler).

#![no_main]

mod common;

use std::sync::OnceLock;

use common::{FRAME_NS, down, engine, pad, readings, tick};
use gelpad::engine::{Engine, Input};
use gelpad::pad::Pad;
use gelpad::source::Arrangement;
use gelpad::source::board::{Board, BoardSettings};
use gelpad::source::wire::{Auto, Decoded, Dialect, WireFormat, Wiring};
use gelpad::types::{Event, Frame};
use libfuzzer_sys::fuzz_target;

/// Frames that must agree on their number of values before they are trusted.
const SURE_FRAMES: usize = 3;
/// Frames of rest, with a finger, and of rest again.
const FRAMES: [usize; 3] = [14, 6, 4];
struct World {
    pad: Pad,
    /// Before the first frame.
    engine: Engine,
    /// For each format, what an undamaged board sends: a message for each frame, after that of its reset.
    streams: Vec<Vec<Vec<u8>>>,
}

fn world() -> &'static World {
    static WORLD: OnceLock<World> = OnceLock::new();
    WORLD.get_or_init(|| {
        let pad = pad();
        let volts = volts(&pad);
        let streams = WireFormat::ALL.map(|kind| stream(kind, &pad, &volts));
        World {
            engine: engine(&pad),
            streams: streams.to_vec(),
            pad,
        }
    })
}

fn volts(pad: &Pad) -> Vec<Vec<f32>> {
    let parts = FRAMES.iter().enumerate();
    let is_pressed = parts.flat_map(|(part, count)| std::iter::repeat_n(part % 2 == 1, *count));
    readings(pad, is_pressed)
}

/// What a board sends, after the commands of its dialect.
fn stream(kind: WireFormat, pad: &Pad, volts: &[Vec<f32>]) -> Vec<Vec<u8>> {
    let mut board = Board::new(pad, &BoardSettings::new(kind)).expect("a board");
    let mut dialect = kind.dialect(&Wiring::from_pad(pad), false);
    let mut messages = vec![board.reset()];
    let mut decoded = Vec::new();
    for (index, frame) in volts.iter().enumerate() {
        let now_ns = index as u64 * FRAME_NS;
        let mut message = Vec::new();
        dialect.feed(now_ns, &messages[index], &mut decoded);
        while let Some(command) = dialect.poll_command(now_ns) {
            let answer = board.receive(&command);
            dialect.feed(now_ns, &answer, &mut decoded);
            message.extend(answer);
        }
        message.extend(board.frame(now_ns / 1000, frame));
        messages.push(message);
    }
    messages
}

/// Damages the messages of a board.
fn damage(messages: &mut Vec<Vec<u8>>, edits: &[u8]) {
    for edit in edits.chunks_exact(4) {
        let count = messages.len();
        let message = usize::from(edit[0]) % count;
        let bytes = &mut messages[message];
        let at = usize::from(edit[2]) * 8 % bytes.len().max(1);
        match edit[1] % 8 {
            0 if !bytes.is_empty() => bytes[at] = edit[3],
            1 if !bytes.is_empty() => bytes[at] ^= 1 << (edit[3] % 8),
            2 => bytes.truncate(at),
            3 => bytes.insert(at, edit[3]),
            4 => messages.swap(message, usize::from(edit[3]) % count),
            5 => {
                let copy = messages[message].clone();
                messages.insert(usize::from(edit[3]) % count, copy);
            }
            6 => bytes.extend_from_slice(edits),
            _ => drop(bytes.drain(at..(at + usize::from(edit[3])).min(bytes.len()))),
        }
    }
}

/// An engine behind an arrangement.
struct Player {
    engine: Engine,
    arrangement: Option<Arrangement>,
    /// Number of values of the last frames, and how many had it.
    sure: (usize, usize),
    t_ns: u64,
    events: Vec<Event>,
}

impl Player {
    fn new(world: &World) -> Self {
        Self {
            engine: world.engine.clone(),
            arrangement: None,
            sure: (0, 0),
            t_ns: 0,
            events: Vec::new(),
        }
    }

    fn take(&mut self, one: Decoded, pad: &Pad) {
        let Decoded::Frame(frame) = one else {
            self.engine
                .input(&Input::Lost { frames: 1 }, &mut self.events);
            return;
        };
        let count = frame.values.len();
        self.sure = (
            count,
            if self.sure.0 == count {
                self.sure.1 + 1
            } else {
                1
            },
        );
        if self.sure.1 >= SURE_FRAMES && self.arrangement.is_none() {
            let listing = frame.listing.as_deref();
            self.arrangement = Arrangement::find(&frame.values, listing, None, pad).ok();
        }
        let known = self.arrangement.as_ref();
        if let Some(arrangement) = known.filter(|known| known.values() == count) {
            let volts = arrangement.apply(&frame.values);
            assert_eq!(volts.len(), pad.channels());
            assert!(volts.iter().all(|volt| volt.is_finite()));
            self.t_ns += FRAME_NS;
            tick(&mut self.engine, self.t_ns, &mut self.events);
            let t_ns = self.t_ns;
            self.engine
                .input(&Input::Frame(Frame { t_ns, volts }), &mut self.events);
            let mut down = self.engine.touches_down().iter();
            assert!(down.all(|touch| touch.contact.centre_mm.iter().all(|at| at.is_finite())));
        }
    }
}

fuzz_target!(|bytes: &[u8]| {
    let [choice, size, edits @ ..] = bytes else {
        return;
    };
    let world = world();
    let format = usize::from(choice & 7) % WireFormat::ALL.len();
    let wiring = Wiring::from_pad(&world.pad);
    let mut dialect: Box<dyn Dialect> = if choice & 8 == 0 {
        WireFormat::ALL[format].dialect(&wiring, choice & 16 != 0)
    } else {
        Box::new(Auto::new(wiring))
    };
    let mut messages = world.streams[format].clone();
    damage(&mut messages, edits);
    let mut player = Player::new(world);
    let mut decoded = Vec::new();
    for (index, message) in messages.iter().enumerate() {
        let now_ns = index as u64 * FRAME_NS;
        for piece in message.chunks(1 + usize::from(*size) * 16) {
            dialect.feed(now_ns, piece, &mut decoded);
            let _ = dialect.poll_command(now_ns);
            for one in decoded.drain(..) {
                player.take(one, &world.pad);
            }
        }
        if choice & 32 != 0 && index % 9 == 8 {
            dialect.reopened();
        }
    }
    let t_ns = player.t_ns + FRAME_NS;
    player
        .engine
        .input(&Input::End { t_ns }, &mut player.events);
    assert_eq!(player.engine.held_outputs().count(), 0);
    assert_eq!(down(&player.events), []);
    if edits.is_empty() && choice & 56 == 0 {
        assert!(
            !player.events.is_empty(),
            "an undamaged board plays, format {format}"
        );
    }
});
