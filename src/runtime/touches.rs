//! Sends touches as TUIO, on a thread of its own. If the queue is full, a frame is omitted, as UDP may lose one too.

use std::thread::Thread;

use rtrb::{Consumer, Producer, RingBuffer};

use super::listen::{EngineStep, StepListener};
use super::{NAP, spawn};
use crate::engine::Input;
use crate::output::Tuio;
use crate::types::{Nanos, Touch};

/// Frames that may wait to be sent.
const FRAME_QUEUE: usize = 64;

struct TouchFrame {
    t_ns: Nanos,
    down: Vec<Touch>,
}

struct TouchSender {
    frames: Producer<TouchFrame>,
    thread: Thread,
    /// The touches that were sent last.
    last: Vec<Touch>,
}

/// A listener that sends the touches of every frame. Its thread ends when it is dropped.
///
/// # Errors
/// The system cannot start a thread.
pub fn send_touches(tuio: Tuio) -> std::io::Result<Box<dyn StepListener>> {
    let (frames_in, frames) = RingBuffer::new(FRAME_QUEUE);
    let thread = spawn("tuio", move || send_all(tuio, frames))?;
    Ok(Box::new(TouchSender {
        frames: frames_in,
        thread: thread.thread().clone(),
        last: Vec::new(),
    }))
}

fn send_all(mut tuio: Tuio, mut frames: Consumer<TouchFrame>) {
    let mut last_ns = 0;
    loop {
        match frames.pop() {
            Ok(frame) => {
                last_ns = frame.t_ns;
                tuio.frame(frame.t_ns, &frame.down);
            }
            Err(_) if frames.is_abandoned() && frames.is_empty() => break,
            Err(_) => std::thread::park_timeout(NAP),
        }
    }
    // The session has ended: the receiver must learn that no touch is down.
    tuio.end(last_ns);
}

impl StepListener for TouchSender {
    fn on_step(&mut self, step: &EngineStep<'_>) {
        let t_ns = match step.input {
            Input::Frame(frame) => frame.t_ns,
            // Most parts change nothing.
            Input::Part(part) if step.touches != self.last => part.t_ns,
            Input::Rezero { t_ns } | Input::End { t_ns } => *t_ns,
            _ => return,
        };
        self.last.clear();
        self.last.extend_from_slice(step.touches);
        let _ = self.frames.push(TouchFrame {
            t_ns,
            down: step.touches.to_vec(),
        });
        self.thread.unpark();
    }
}

impl Drop for TouchSender {
    fn drop(&mut self) {
        self.thread.unpark();
    }
}
