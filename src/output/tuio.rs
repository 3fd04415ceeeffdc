//! Sends touches as TUIO 1.1 over UDP, for programs with multi-touch input: the 2Dcur profile, one bundle a frame.
//!
//! Format: <https://www.tuio.org/?specification>: `source`, `alive` with the ids that are down, one `set` for
//! each (id, place, velocity, acceleration), `fseq`. Places are 0..1 from the top left, as on screens;
//! velocities are in these units per second.

use std::net::{SocketAddr, ToSocketAddrs as _, UdpSocket};

use rosc::{OscBundle, OscMessage, OscPacket, OscTime, OscType, encoder};

use crate::types::{Nanos, Touch};

/// While nothing is touched, one bundle per this time, ns, so that a late receiver learns that no touch is down.
const IDLE_NS: Nanos = 1_000_000_000;
/// The time tag "immediately" of OSC.
const AT_ONCE: OscTime = OscTime {
    seconds: 0,
    fractional: 1,
};

/// The address cannot be used.
#[derive(Debug, thiserror::Error)]
#[error(
    "cannot send TUIO to {address}: {reason}\n  help: write HOST:PORT, as in --tuio 127.0.0.1:3333"
)]
pub struct TuioError {
    /// The address.
    pub address: String,
    /// The cause.
    pub reason: String,
}

/// Sends touches to one address.
pub struct Tuio {
    socket: UdpSocket,
    cursors: Cursors,
    idle_since_ns: Option<Nanos>,
}

impl Tuio {
    /// Resolves the address. No receiver needs to listen there yet.
    ///
    /// # Errors
    /// The address does not exist or has the wrong form.
    pub fn connect(address: &str, pad_mm: [f64; 2]) -> Result<Self, TuioError> {
        let failed = |reason: String| TuioError {
            address: address.to_owned(),
            reason,
        };
        let found: SocketAddr = address
            .to_socket_addrs()
            .map_err(|error| failed(error.to_string()))?
            .next()
            .ok_or_else(|| failed("no such host".to_owned()))?;
        let any = if found.is_ipv4() {
            "0.0.0.0:0"
        } else {
            "[::]:0"
        };
        let socket = UdpSocket::bind(any).and_then(|socket| {
            socket.connect(found)?;
            Ok(socket)
        });
        Ok(Self {
            socket: socket.map_err(|error| failed(error.to_string()))?,
            cursors: Cursors::new(pad_mm),
            idle_since_ns: None,
        })
    }

    /// Reports that no touch is down any more.
    pub fn end(&mut self, t_ns: Nanos) {
        self.idle_since_ns = None;
        self.frame(t_ns, &[]);
    }

    /// Sends the touches that are down in a frame.
    pub fn frame(&mut self, t_ns: Nanos, down: &[Touch]) {
        if down.is_empty() {
            let is_recent = self
                .idle_since_ns
                .is_some_and(|since| t_ns < since.saturating_add(IDLE_NS));
            if is_recent {
                return;
            }
            self.idle_since_ns = Some(t_ns);
        } else {
            self.idle_since_ns = None;
        }
        let bundle = self.cursors.bundle(t_ns, down);
        if let Ok(bytes) = encoder::encode(&bundle) {
            // Without a receiver this fails; the next frame repeats everything.
            let _ = self.socket.send(&bytes);
        }
    }
}

/// The cursors of the last frame: velocities are differences to them.
struct Cursors {
    pad_mm: [f64; 2],
    frame: i32,
    last: Vec<Cursor>,
}

#[derive(Clone, Copy)]
struct Cursor {
    id: u64,
    t_ns: Nanos,
    place: [f64; 2],
    velocity: [f64; 2],
}

impl Cursors {
    fn new(pad_mm: [f64; 2]) -> Self {
        Self {
            pad_mm,
            frame: 0,
            last: Vec::new(),
        }
    }

    fn bundle(&mut self, t_ns: Nanos, down: &[Touch]) -> OscPacket {
        self.frame = self.frame.wrapping_add(1).max(1);
        let ids = down.iter().map(|touch| OscType::Int(id_number(touch.id.0)));
        let mut content = vec![
            message([text("source"), text("gelpad")]),
            message(std::iter::once(text("alive")).chain(ids)),
        ];
        let mut now = Vec::new();
        for touch in down {
            let (cursor, acceleration) = self.cursor(t_ns, touch);
            let float = |value: f64| OscType::Float(value as f32);
            content.push(message([
                text("set"),
                OscType::Int(id_number(cursor.id)),
                float(cursor.place[0]),
                float(cursor.place[1]),
                float(cursor.velocity[0]),
                float(cursor.velocity[1]),
                float(acceleration),
            ]));
            now.push(cursor);
        }
        self.last = now;
        content.push(message([text("fseq"), OscType::Int(self.frame)]));
        OscPacket::Bundle(OscBundle {
            timetag: AT_ONCE,
            content,
        })
    }

    /// A touch as a TUIO cursor, and its acceleration.
    fn cursor(&self, t_ns: Nanos, touch: &Touch) -> (Cursor, f64) {
        let [x, y] = touch.contact.centre_mm;
        let place = [
            (x / self.pad_mm[0]).clamp(0.0, 1.0),
            (1.0 - y / self.pad_mm[1]).clamp(0.0, 1.0),
        ];
        let mut cursor = Cursor {
            id: touch.id.0,
            t_ns,
            place,
            velocity: [0.0; 2],
        };
        let Some(before) = self
            .last
            .iter()
            .find(|before| before.id == cursor.id && before.t_ns < t_ns)
        else {
            return (cursor, 0.0);
        };
        let seconds = (t_ns - before.t_ns) as f64 * 1e-9;
        cursor.velocity = [0, 1].map(|axis| (place[axis] - before.place[axis]) / seconds);
        let speed = |[x, y]: [f64; 2]| x.hypot(y);
        let acceleration = (speed(cursor.velocity) - speed(before.velocity)) / seconds;
        (cursor, acceleration)
    }
}

/// TUIO ids have 31 bits.
fn id_number(id: u64) -> i32 {
    (id & 0x7FFF_FFFF) as i32
}

fn text(word: &str) -> OscType {
    OscType::String(word.to_owned())
}

fn message(args: impl IntoIterator<Item = OscType>) -> OscPacket {
    OscPacket::Message(OscMessage {
        addr: "/tuio/2Dcur".to_owned(),
        args: args.into_iter().collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::{Contact, Phase, TouchId};

    fn touch(id: u64, centre_mm: [f64; 2]) -> Touch {
        Touch {
            id: TouchId(id),
            phase: Phase::Move,
            since_ns: 0,
            contact: Contact {
                centre_mm,
                area_mm2: 100.0,
                force: 0.5,
                confidence: 1.0,
            },
        }
    }

    fn messages(packet: &OscPacket) -> Vec<Vec<OscType>> {
        let OscPacket::Bundle(bundle) = packet else {
            panic!("a bundle a frame");
        };
        let args = |packet: &OscPacket| match packet {
            OscPacket::Message(message) => {
                assert_eq!(message.addr, "/tuio/2Dcur");
                message.args.clone()
            }
            OscPacket::Bundle(_) => panic!("no bundle in a bundle"),
        };
        bundle.content.iter().map(args).collect()
    }

    #[test]
    fn a_frame_says_who_is_down_and_where_from_the_top_left() {
        let mut cursors = Cursors::new([100.0, 50.0]);
        cursors.bundle(0, &[touch(4, [20.0, 40.0])]);
        let messages = messages(&cursors.bundle(
            100_000_000,
            &[touch(4, [30.0, 40.0]), touch(5, [50.0, 0.0])],
        ));
        assert_eq!(
            messages[1],
            [text("alive"), OscType::Int(4), OscType::Int(5)]
        );
        let floats = |args: &[OscType]| -> Vec<f32> {
            args.iter().filter_map(|arg| arg.clone().float()).collect()
        };
        let set = floats(&messages[2]);
        for (value, expected) in set.iter().zip([0.3, 0.2, 1.0, 0.0, 10.0]) {
            assert!((value - expected).abs() < 1e-5, "{set:?}");
        }
        assert_eq!(floats(&messages[3]), [0.5, 1.0, 0.0, 0.0, 0.0]);
        assert_eq!(messages[4], [text("fseq"), OscType::Int(2)]);
    }

    #[test]
    fn the_last_finger_up_leaves_nobody_alive() {
        let mut cursors = Cursors::new([100.0, 50.0]);
        cursors.bundle(0, &[touch(4, [20.0, 40.0])]);
        let messages = messages(&cursors.bundle(10_000_000, &[]));
        assert_eq!(messages[1], [text("alive")]);
        assert_eq!(messages.len(), 3);
    }
}
