//! A requested press, and what the pad detected of it.

use crate::types::{NANOS_PER_MS, Nanos, Phase, Touch};

/// Least time between two moves of a thinned trial.
const THINNED_NS: Nanos = 40 * NANOS_PER_MS;

/// The kind of a requested press.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PressLength {
    /// A short press.
    Short,
    /// A held press.
    Long,
    /// Two short presses in quick succession.
    Twice,
}

/// A requested press.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PressRequest {
    /// Name of the region.
    pub region: String,
    /// How to press it.
    pub length: PressLength,
}

impl std::fmt::Display for PressRequest {
    /// The instruction to the player.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let region = &self.region;
        match self.length {
            PressLength::Short => write!(f, "tap {region}, briefly"),
            PressLength::Long => write!(f, "press {region} and hold it a second"),
            PressLength::Twice => write!(f, "tap {region} twice, quickly"),
        }
    }
}

/// One request, and all touches until the next.
#[derive(Clone, Debug, PartialEq)]
pub struct PressTrial {
    /// The request; `None` if the player was asked not to press.
    pub request: Option<PressRequest>,
    /// Touches that went down, moved or up, each with its time, in order.
    pub touches: Vec<(Nanos, Touch)>,
}

impl PressTrial {
    /// The same with fewer moves: equivalent for choosing settings, and several times faster to play.
    #[must_use]
    pub fn thinned(&self) -> Self {
        let mut kept_ns: Nanos = 0;
        let mut touches = self.touches.clone();
        touches.retain(|(t_ns, touch)| {
            let keep = touch.phase != Phase::Move || t_ns.saturating_sub(kept_ns) >= THINNED_NS;
            if keep {
                kept_ns = *t_ns;
            }
            keep
        });
        Self {
            request: self.request.clone(),
            touches,
        }
    }
}
