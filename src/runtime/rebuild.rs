//! Builds another reconstruction matrix during play: when an electrode is lost or comes back, when the pad's response table
//! has been solved, or when the pad has been identified.
//!
//! The engine reports which channel noise it wants a matrix for. The thread here builds it, and the result goes back to the
//! engine as an input like any other.

use std::io;
use std::sync::Arc;
use std::thread::Thread;
use std::time::Duration;

use rtrb::{Consumer, Producer, RingBuffer};

use super::spawn;
use crate::eit::ResponseTable;
use crate::touch::{ChannelNoise, Sensing, SensingBuilder};

/// Longest sleep of the thread. A request wakes it earlier, and no shut-down waits for it.
const REBUILD_NAP: Duration = Duration::from_millis(500);

/// Requests that may wait: one for other weights, the response table, which comes once, and an identified pad.
const QUEUE: usize = 3;

/// What a matrix is built for.
enum Request {
    /// Other weights of the channels.
    Noise(ChannelNoise),
    /// The response table, with the weights of the last matrix.
    Table(Arc<ResponseTable>),
    /// The pad as identified, with the weights of the last matrix.
    Pad(Box<SensingBuilder>),
}

/// A finished matrix.
pub(super) struct Built {
    /// The matrix with its weights.
    pub(super) sensing: Arc<Sensing>,
    /// It locates touches otherwise than the one before, so it waits until nothing is down: a touch would be found again at a
    /// slightly different place.
    pub(super) relocates: bool,
}

/// The engine's side of the thread that builds matrices: one request for other weights at a time.
pub(super) struct Rebuilder {
    requests: Producer<Request>,
    /// One answer for each request; none if the build failed.
    built: Consumer<Option<Built>>,
    thread: Thread,
    /// The noise that is being built for, or for which the last build failed.
    requested: Option<ChannelNoise>,
    /// Requests without an answer.
    unanswered: usize,
}

impl Rebuilder {
    /// Starts the thread; it ends when the rebuilder is dropped. `engine` is woken by every answer.
    pub(super) fn start(builder: SensingBuilder, engine: Thread) -> io::Result<Self> {
        let (requests_in, requests) = RingBuffer::new(QUEUE);
        let (built_in, built) = RingBuffer::new(QUEUE);
        let thread = spawn("matrix", move || {
            build_all(builder, requests, built_in, &engine)
        })?;
        Ok(Self {
            requests: requests_in,
            built,
            thread: thread.thread().clone(),
            requested: None,
            unanswered: 0,
        })
    }

    /// Requests a matrix for this noise. Ignored while one is built, and for noise whose build failed.
    pub(super) fn request(&mut self, noise: &ChannelNoise) {
        if self.unanswered > 0 || self.requested.as_ref() == Some(noise) {
            return;
        }
        if self.push(Request::Noise(noise.clone())) {
            self.requested = Some(noise.clone());
        }
    }

    /// Requests a matrix that locates touches with a response table, as all later ones do.
    pub(super) fn add_table(&mut self, table: Arc<ResponseTable>) {
        if !self.push(Request::Table(table)) {
            tracing::error!("the response table is not used: too many requests are waiting");
        }
    }

    /// Requests a matrix of the pad as identified; later ones are built for it too.
    pub(super) fn change_pad(&mut self, builder: Box<SensingBuilder>) {
        if !self.push(Request::Pad(builder)) {
            tracing::error!("the identified pad is not used: too many requests are waiting");
        }
    }

    /// Returns whether the queue had room.
    fn push(&mut self, request: Request) -> bool {
        let was_sent = self.requests.push(request).is_ok();
        if was_sent {
            self.unanswered += 1;
            self.thread.unpark();
        }
        was_sent
    }

    /// A matrix that was finished since the last call.
    pub(super) fn take_built(&mut self) -> Option<Built> {
        let built = self.built.pop().ok()?;
        self.unanswered = self.unanswered.saturating_sub(1);
        if built.is_some() {
            self.requested = None;
        }
        built
    }
}

impl Drop for Rebuilder {
    fn drop(&mut self) {
        // The thread ends at its next look at the queue; nothing waits for it.
        self.thread.unpark();
    }
}

fn build_all(
    builder: SensingBuilder,
    mut requests: Consumer<Request>,
    mut built: Producer<Option<Built>>,
    engine: &Thread,
) {
    let mut builds = Builds {
        builder,
        last_noise: None,
        is_identified: false,
    };
    while !requests.is_abandoned() {
        let Ok(request) = requests.pop() else {
            std::thread::park_timeout(REBUILD_NAP);
            continue;
        };
        let _ = built.push(builds.answer(request));
        engine.unpark();
    }
}

/// What the next matrix is built from. Only a request that succeeded changes it.
struct Builds {
    builder: SensingBuilder,
    /// The weights of the last matrix; `None` for those at the start.
    last_noise: Option<ChannelNoise>,
    is_identified: bool,
}

impl Builds {
    /// The matrix of a request; `None`, after a message, if it cannot be built.
    fn answer(&mut self, request: Request) -> Option<Built> {
        let relocates = !matches!(request, Request::Noise(_));
        let what = match &request {
            Request::Noise(_) => "no matrix without the lost electrodes",
            Request::Table(_) => "the response table cannot be used",
            Request::Pad(_) => "the identified pad cannot be used",
        };
        let (noise, builder, is_identified) = match request {
            Request::Noise(noise) => (Some(noise), None, self.is_identified),
            // An identified pad has a table of its own.
            Request::Table(_) if self.is_identified => (self.last_noise.clone(), None, true),
            Request::Table(table) => {
                let builder = self.builder.clone().with_table(table);
                (self.last_noise.clone(), Some(builder), false)
            }
            Request::Pad(identified) => (self.last_noise.clone(), Some(*identified), true),
        };
        let used = builder.as_ref().unwrap_or(&self.builder);
        let sensing = match &noise {
            Some(noise) => used.build(noise),
            None => used.build_initial(),
        };
        let sensing = sensing
            .inspect_err(|error| tracing::error!("{what}: {error}; the present matrix is kept"))
            .ok()?;
        self.last_noise = noise;
        self.is_identified = is_identified;
        if let Some(builder) = builder {
            self.builder = builder;
        }
        Some(Built {
            sensing: Arc::new(sensing),
            relocates,
        })
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
            if built.is_some() || rebuilder.unanswered == 0 {
                return built.map(|built| built.sensing);
            }
            std::thread::park_timeout(Duration::from_millis(10));
        }
        None
    }

    #[test]
    fn a_pad_that_cannot_be_used_changes_nothing() {
        let text = shipped_pad(DEFAULT_PAD).expect("shipped").toml;
        let shipped = Pad::from_toml("p", text).expect("sound");
        let builder = SensingBuilder::new(&shipped, Method::default()).expect("solvable");
        let mut builds = Builds {
            builder: builder.clone(),
            last_noise: Some(vec![f64::INFINITY; shipped.channels()].into()),
            is_identified: false,
        };
        // Without any channel, no matrix can be built for the identified pad either.
        assert!(builds.answer(Request::Pad(Box::new(builder))).is_none());
        assert!(!builds.is_identified, "a later table must be used");
        let all = vec![1e-3; shipped.channels()];
        let built = builds.answer(Request::Noise(all.into())).expect("a matrix");
        assert!(!built.relocates);
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
        assert_eq!(rebuilder.unanswered, 0, "the same request would fail again");
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
