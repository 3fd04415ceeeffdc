//! A source whose frames are disturbed by name, to try what a board would do to play. Disturbances are those of whole frames, so
//! frames are never handed on in parts.

use super::disturbance::Disturbance;
use super::disturber::Disturber;
use super::{Source, SourceError, SourcePace, SourceReading};
use crate::pad::Protocol;
use crate::types::Nanos;

/// A source with disturbances on its frames. Full scale and times count from the first frame.
pub struct DisturbedSource {
    source: Box<dyn Source>,
    disturbances: Vec<Disturbance>,
    protocol: Protocol,
    seed: u64,
    /// Made with the first frame, and its time.
    started: Option<(Disturber, Nanos)>,
}

impl DisturbedSource {
    /// Disturbs the frames of a source of a pad with this protocol; the seed fixes every random number.
    #[must_use]
    pub fn new(
        source: Box<dyn Source>,
        disturbances: Vec<Disturbance>,
        protocol: &Protocol,
        seed: u64,
    ) -> Self {
        Self {
            source,
            disturbances,
            protocol: protocol.clone(),
            seed,
            started: None,
        }
    }
}

impl Source for DisturbedSource {
    fn pace(&self) -> SourcePace {
        self.source.pace()
    }

    fn read(&mut self) -> Result<SourceReading, SourceError> {
        let mut reading = self.source.read()?;
        if let SourceReading::Frame(frame) = &mut reading {
            let mut volts: Vec<f64> = frame.volts.iter().map(|volt| f64::from(*volt)).collect();
            let (disturber, first_ns) = self.started.get_or_insert_with(|| {
                let disturber =
                    Disturber::new(&self.disturbances, &volts, &self.protocol, self.seed);
                (disturber, frame.t_ns)
            });
            let t_s = frame.t_ns.saturating_sub(*first_ns) as f64 * 1e-9;
            disturber.apply(t_s, &mut volts);
            frame.volts = volts.iter().map(|volt| *volt as f32).collect();
        }
        Ok(reading)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::{DEFAULT_PAD, Pad, shipped_pad};
    use crate::source::{Noise, Script, SimulatedSource};

    #[test]
    fn frames_of_a_simulated_pad_are_rounded_to_the_steps_of_a_converter() {
        let pad = Pad::from_toml("p", shipped_pad(DEFAULT_PAD).expect("shipped").toml);
        let pad = pad.expect("valid");
        let script =
            Script::parse("s", "t:10 down 1 50 50\nt:40 up 1\nt:100 end\n").expect("valid");
        let source = SimulatedSource::new(&pad, &script, Noise::new(70.0, 1)).expect("solvable");
        let adc = vec![Disturbance::Adc(10)];
        let mut source = DisturbedSource::new(Box::new(source), adc, &pad.protocol, 1);
        let mut frames = 0;
        let mut distinct = std::collections::BTreeSet::new();
        while let SourceReading::Frame(frame) = source.read().expect("a reading") {
            frames += 1;
            distinct.extend(frame.volts.iter().map(|volt| volt.to_bits()));
        }
        assert!(frames >= 5);
        assert!(
            distinct.len() < 200,
            "{} different readings",
            distinct.len()
        );
    }
}
