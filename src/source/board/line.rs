//! The serial line of a simulated board: when each byte has been sent.
//!
//! A byte takes ten bits. It leaves when it is ready and those before it have left; without a speed, as soon as it is ready.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Bytes that leave together: the buffer of a serial chip.
const CHUNK_BYTES: usize = 16;
/// Bits of a byte, with start and stop bit.
const BYTE_BITS: u32 = 10;

/// Bytes on their way.
#[derive(Debug)]
pub(super) struct Outgoing {
    baud: Option<u32>,
    /// When the line is free again.
    free: Instant,
    chunks: VecDeque<(Instant, Vec<u8>)>,
}

impl Outgoing {
    pub(super) fn new(baud: Option<u32>, now: Instant) -> Self {
        Self {
            baud,
            free: now,
            chunks: VecDeque::new(),
        }
    }

    /// When the bytes so far have been sent.
    pub(super) fn busy_until(&self) -> Instant {
        self.free
    }

    /// How long bytes take.
    pub(super) fn time_of(&self, bytes: usize) -> Duration {
        let bits = BYTE_BITS * bytes as u32;
        self.baud.map_or(Duration::ZERO, |baud| {
            Duration::from_secs_f64(f64::from(bits) / f64::from(baud))
        })
    }

    /// Adds bytes, of which the first and the last are ready at these times.
    pub(super) fn add(&mut self, bytes: Vec<u8>, ready: [Instant; 2]) {
        let count = bytes.len().max(1) as f64;
        let takes = ready[1].saturating_duration_since(ready[0]);
        let is_at_once = takes.is_zero() && self.baud.is_none();
        let size = if is_at_once {
            bytes.len().max(1)
        } else {
            CHUNK_BYTES
        };
        let mut sent = 0;
        for chunk in bytes.chunks(size) {
            sent += chunk.len();
            let is_ready = ready[0] + takes.mul_f64(sent as f64 / count);
            let is_free = self.free + self.time_of(chunk.len());
            let at = is_ready.max(is_free);
            self.free = at;
            self.chunks.push_back((at, chunk.to_vec()));
        }
    }

    /// Bytes that have been sent by now.
    pub(super) fn take_due(&mut self, now: Instant) -> Option<Vec<u8>> {
        let mut due = Vec::new();
        while self.chunks.front().is_some_and(|(at, _)| *at <= now) {
            if let Some((_, chunk)) = self.chunks.pop_front() {
                due.extend(chunk);
            }
        }
        (!due.is_empty()).then_some(due)
    }

    /// When the next bytes have been sent.
    pub(super) fn next_due(&self) -> Option<Instant> {
        self.chunks.front().map(|(at, _)| *at)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.chunks.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::clock::now;

    #[test]
    fn bytes_leave_when_they_are_ready_and_the_line_is_free() {
        let start = now();
        let ms = |ms: u64| start + Duration::from_millis(ms);
        let sent_by = |line: &mut Outgoing, at: Instant| line.take_due(at).map_or(0, |b| b.len());
        // 16 bytes take 16 ms.
        let mut line = Outgoing::new(Some(10_000), start);
        line.add(vec![1; 32], [start; 2]);
        line.add(vec![2; 16], [ms(100); 2]);
        assert_eq!(line.next_due(), Some(ms(16)));
        assert_eq!(sent_by(&mut line, ms(15)), 0);
        assert_eq!(sent_by(&mut line, ms(16)), 16);
        assert_eq!(sent_by(&mut line, ms(90)), 16);
        assert_eq!(sent_by(&mut line, ms(99)), 0);
        assert_eq!(sent_by(&mut line, ms(100)), 16);
        assert!(line.is_empty());
        // Without a speed, text leaves while it is printed, a packet at once.
        let mut line = Outgoing::new(None, start);
        line.add(vec![1; 64], [start, ms(40)]);
        line.add(vec![2; 64], [ms(50); 2]);
        assert_eq!(sent_by(&mut line, ms(25)), 32);
        assert_eq!(sent_by(&mut line, ms(49)), 32);
        assert_eq!(sent_by(&mut line, ms(50)), 64);
    }
}
