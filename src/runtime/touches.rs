//! Sends touches on, on a thread of its own: a frame that finds the queue full is left out, as one that UDP loses is.

use std::thread::{Builder, Thread};

use rtrb::{Consumer, Producer, RingBuffer};

use super::NAP;
use super::listen::{Listener, Step};
use crate::engine::Input;
use crate::output::Tuio;
use crate::types::{Nanos, Touch};

/// Frames that may wait.
const FRAME_QUEUE: usize = 64;

struct Seen {
    t_ns: Nanos,
    down: Vec<Touch>,
}

struct Tap {
    frames: Producer<Seen>,
    thread: Thread,
}

/// Who is to be told of steps so that touches are sent on. The thread ends when that is dropped.
///
/// # Errors
/// The system gives no thread.
pub fn send_touches(tuio: Tuio) -> std::io::Result<Box<dyn Listener>> {
    let (frames_in, frames) = RingBuffer::new(FRAME_QUEUE);
    let thread = Builder::new()
        .name("tuio".to_owned())
        .spawn(move || send_all(tuio, frames))?
        .thread()
        .clone();
    Ok(Box::new(Tap {
        frames: frames_in,
        thread,
    }))
}

fn send_all(mut tuio: Tuio, mut frames: Consumer<Seen>) {
    let mut last_ns = 0;
    loop {
        match frames.pop() {
            Ok(seen) => {
                last_ns = seen.t_ns;
                tuio.frame(seen.t_ns, &seen.down);
            }
            Err(_) if frames.is_abandoned() && frames.is_empty() => break,
            Err(_) => std::thread::park_timeout(NAP),
        }
    }
    // The session is over: nobody is down, and whoever listens must know.
    tuio.end(last_ns);
}

impl Listener for Tap {
    fn step(&mut self, step: &Step<'_>) {
        let t_ns = match step.input {
            Input::Frame(frame) => frame.t_ns,
            Input::Rezero { t_ns } | Input::End { t_ns } => *t_ns,
            _ => return,
        };
        let _ = self.frames.push(Seen {
            t_ns,
            down: step.touches.to_vec(),
        });
        self.thread.unpark();
    }
}

impl Drop for Tap {
    fn drop(&mut self) {
        self.thread.unpark();
    }
}
