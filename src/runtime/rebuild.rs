//! Builds another reconstruction matrix during play, when an electrode is lost or comes back.
//!
//! The engine reports which channel deviations it wants a matrix for. The thread here builds it, and the result goes
//! back to the engine as an input like any other.

use std::io;
use std::sync::Arc;
use std::thread::Thread;
use std::time::Duration;

use rtrb::{Consumer, Producer, RingBuffer};

use super::spawn;
use crate::touch::{ChannelNoise, Sensing, SensingBuilder};

/// Longest sleep of the thread; a request wakes it earlier.
const NAP: Duration = Duration::from_millis(500);

/// The engine's side of the thread that builds matrices: one request at a time.
pub(super) struct Rebuilder {
    requests: Producer<ChannelNoise>,
    /// One answer for each request; none if the build failed.
    built: Consumer<Option<Arc<Sensing>>>,
    thread: Thread,
    /// The noise that is being built for, or for which the last build failed.
    requested: Option<ChannelNoise>,
    is_building: bool,
}

impl Rebuilder {
    /// Starts the thread; it ends when the rebuilder is dropped. `engine` is woken by every answer.
    pub(super) fn start(builder: SensingBuilder, engine: Thread) -> io::Result<Self> {
        let (requests_in, requests) = RingBuffer::new(1);
        let (built_in, built) = RingBuffer::new(1);
        let thread = spawn("matrix", move || {
            build_all(&builder, requests, built_in, &engine)
        })?;
        Ok(Self {
            requests: requests_in,
            built,
            thread: thread.thread().clone(),
            requested: None,
            is_building: false,
        })
    }

    /// Requests a matrix for this noise. Ignored while one is built, and for noise whose build failed.
    pub(super) fn request(&mut self, noise: &ChannelNoise) {
        if self.is_building || self.requested.as_ref() == Some(noise) {
            return;
        }
        if self.requests.push(noise.clone()).is_ok() {
            self.requested = Some(noise.clone());
            self.is_building = true;
            self.thread.unpark();
        }
    }

    /// A matrix that was finished since the last call.
    pub(super) fn take_built(&mut self) -> Option<Arc<Sensing>> {
        let built = self.built.pop().ok()?;
        self.is_building = false;
        if built.is_some() {
            self.requested = None;
        }
        built
    }
}

impl Drop for Rebuilder {
    fn drop(&mut self) {
        // The thread notices the abandoned queue when it wakes.
        self.thread.unpark();
    }
}

fn build_all(
    builder: &SensingBuilder,
    mut requests: Consumer<ChannelNoise>,
    mut built: Producer<Option<Arc<Sensing>>>,
    engine: &Thread,
) {
    while !requests.is_abandoned() {
        let Ok(noise) = requests.pop() else {
            std::thread::park_timeout(NAP);
            continue;
        };
        let sensing = builder
            .build(&noise)
            .inspect_err(|error| {
                tracing::error!(
                    "no matrix without the lost electrodes: {error}; the present one is kept"
                );
            })
            .ok();
        let _ = built.push(sensing.map(Arc::new));
        engine.unpark();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::{DEFAULT_PAD, Pad, shipped_pad};
    use crate::types::Method;

    /// Requests deviations and waits for the answer, for at most 20 s.
    fn build(rebuilder: &mut Rebuilder, deviations: &[f64]) -> Option<Arc<Sensing>> {
        let noise = deviations.to_vec().into();
        rebuilder.request(&noise);
        for _ in 0..2000 {
            let built = rebuilder.take_built();
            if built.is_some() || !rebuilder.is_building {
                return built;
            }
            std::thread::park_timeout(Duration::from_millis(10));
        }
        None
    }

    #[test]
    fn an_electrode_is_excluded_after_a_build_that_failed() {
        let pad =
            Pad::from_toml("p", shipped_pad(DEFAULT_PAD).expect("shipped").toml).expect("sound");
        let builder = SensingBuilder::new(&pad, Method::default()).expect("solvable");
        let mut rebuilder = Rebuilder::start(builder, std::thread::current()).expect("a thread");
        // The pad is unplugged at the start: no channel is left to build from.
        let unplugged = vec![f64::INFINITY; pad.channels()];
        assert!(build(&mut rebuilder, &unplugged).is_none());
        rebuilder.request(&unplugged.into());
        assert!(!rebuilder.is_building, "the same request would fail again");
        // It is plugged in, and electrode 1 is loose.
        let mut loose = vec![1e-3; pad.channels()];
        for (channel, deviation) in pad.protocol.channels.iter().zip(&mut loose) {
            let pairs = [channel.drive, channel.measure];
            if pairs.iter().any(|pair| pair.0 == 0 || pair.1 == 0) {
                *deviation = f64::INFINITY;
            }
        }
        let sensing = build(&mut rebuilder, &loose).expect("a matrix without electrode 1");
        for (channel, deviation) in loose.iter().enumerate() {
            assert_eq!(
                sensing.uses_channel(channel),
                deviation.is_finite(),
                "{channel}"
            );
        }
    }
}
