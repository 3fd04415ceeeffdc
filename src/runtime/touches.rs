//! Sends touches as TUIO, on a thread of its own. If the queue is full, a frame is omitted: UDP may lose frames anyway.

use std::thread::JoinHandle;

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
    /// `None` only while the sender is dropped.
    frames: Option<Producer<TouchFrame>>,
    /// `None` only while the sender is dropped.
    thread: Option<JoinHandle<()>>,
    /// The touches of the last frame in the queue.
    last: Vec<Touch>,
}

/// A listener that sends the touches of every frame. When it is dropped, its thread has sent that no touch is down, and ended.
///
/// # Errors
/// The system cannot start a thread.
pub fn send_touches(tuio: Tuio) -> std::io::Result<Box<dyn StepListener>> {
    let (frames_in, frames) = RingBuffer::new(FRAME_QUEUE);
    let thread = spawn("tuio", move || send_all(tuio, frames))?;
    Ok(Box::new(TouchSender {
        frames: Some(frames_in),
        thread: Some(thread),
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
        let (Some(frames), Some(thread)) = (&mut self.frames, &self.thread) else {
            return;
        };
        let down = step.touches.to_vec();
        if frames.push(TouchFrame { t_ns, down }).is_ok() {
            self.last.clear();
            self.last.extend_from_slice(step.touches);
        }
        thread.thread().unpark();
    }
}

impl Drop for TouchSender {
    fn drop(&mut self) {
        // Abandoned before the thread wakes, so that it ends at once.
        self.frames = None;
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // A thread that panicked has said so.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::net::UdpSocket;

    use super::*;

    #[test]
    fn a_receiver_has_learned_that_no_touch_is_down_when_the_sender_is_dropped() {
        let receiver = UdpSocket::bind("127.0.0.1:0").expect("a socket");
        let address = receiver.local_addr().expect("bound").to_string();
        let tuio = Tuio::connect(&address, [100.0, 100.0]).expect("an address");
        drop(send_touches(tuio).expect("a thread"));
        receiver.set_nonblocking(true).expect("a socket");
        let length = receiver.recv(&mut [0; 2048]).expect("a last bundle");
        assert!(length > 0);
    }
}
