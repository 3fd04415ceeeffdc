//! Hands of `gelpad accuracy --real`: where fingers press, and what they do to the conductivity.

use crate::pad::Pad;
use crate::study::accuracy::draws::Draws;
use crate::study::{Press, StudyError};
use crate::types::PointMm;

/// Time between frames, ms.
const FRAME_MS: f64 = 10.0;
/// Radius of a finger, mm on a pad of 100 mm.
const RADIUS_MM: [f64; 2] = [5.0, 9.0];
/// Relative rise in the middle of a finger.
const RISE: [f64; 2] = [0.5, 2.0];
/// Fingers of [`Hand::Several`] are at least this far apart, mm.
const SEVERAL_APART_MM: f64 = 22.0;
/// Radius and half width of the ring of [`Hand::Annulus`], mm.
const RING_MM: (f64, f64) = (6.0, 3.0);

/// Frames of a press, ...
pub(super) const PRESS_FRAMES: usize = 10;
/// ... and of a short one.
const SHORT_PRESS_FRAMES: usize = 5;
/// Frames between presses, ...
const PAUSE_FRAMES: usize = 20;
/// ... and where it is looked at what is left after half a second.
const LONG_PAUSE_FRAMES: usize = 55;
/// [`Hand::Any`] presses this many times as often as others.
const ANY_TIMES: usize = 5;

/// What presses the pad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hand {
    /// Nothing.
    Untouched,
    /// One finger of 5 to 9 mm, 10 mm or more from the edge.
    Finger,
    /// The same on a pad exactly as the model takes it.
    FingerOnModel,
    /// A finger for 50 ms.
    ShortFinger,
    /// A finger that slides at this speed, mm/s.
    Slide(f64),
    /// A finger that lowers the conductivity.
    Falling,
    /// A finger, after another one that lay on the pad from the start and was lifted.
    FingerAfterLying,
    /// A finger whose centre is this far from the edge, mm.
    Edge(f64, f64),
    /// A finger within 4 mm of a corner.
    Corner,
    /// A finger over an electrode.
    Electrode,
    /// An ellipse with these half-axes, mm.
    Ellipse(f64, f64),
    /// A ring: a fingertip pressed so hard that its middle is lifted.
    Annulus,
    /// A finger of one radius, mm.
    Radius(f64),
    /// A finger of one rise.
    Rise(f64),
    /// Two fingers at a distance, mm.
    Pair(f64),
    /// Several fingers at least 22 mm apart.
    Several(usize),
    /// The same, after two minutes of such presses for 50 ms with rests of 50 ms.
    SeveralAfterDrumming(usize),
    /// Any of the above, one after the other at random, rising or falling.
    Any {
        /// Whether they lower the conductivity.
        falls: bool,
    },
}

/// What [`Hand::Any`] chooses from.
const KINDS: [Hand; 15] = [
    Hand::Finger,
    Hand::Edge(0.0, 2.0),
    Hand::Edge(2.0, 4.0),
    Hand::Corner,
    Hand::Electrode,
    Hand::Ellipse(12.0, 6.0),
    Hand::Ellipse(15.0, 6.0),
    Hand::Annulus,
    Hand::Radius(15.0),
    Hand::Rise(0.1),
    Hand::Radius(3.0),
    Hand::Radius(4.0),
    Hand::Pair(14.0),
    Hand::Several(5),
    Hand::Several(6),
];

/// What a hand presses at one moment.
pub(super) struct Drawn {
    /// Where its fingers are.
    pub centres_mm: Vec<PointMm>,
    /// The factor by which it multiplies the conductivity at a point.
    pub factor: Box<dyn Fn(PointMm) -> f64>,
    /// The fingers, if they are round and raise the conductivity; otherwise none.
    pub presses: Vec<Press>,
}

/// Presses for each one of another hand, the frames of each, and those between them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rhythm {
    pub presses: usize,
    pub press_frames: usize,
    pub pause_frames: usize,
}

impl Hand {
    pub(super) fn is_untouched(self) -> bool {
        self == Self::Untouched
    }

    pub(super) fn rhythm(self) -> Rhythm {
        let usual = Rhythm {
            presses: 1,
            press_frames: PRESS_FRAMES,
            pause_frames: PAUSE_FRAMES,
        };
        match self {
            Self::Any { .. } => Rhythm {
                presses: ANY_TIMES,
                pause_frames: LONG_PAUSE_FRAMES,
                ..usual
            },
            Self::ShortFinger => Rhythm {
                press_frames: SHORT_PRESS_FRAMES,
                ..usual
            },
            _ => usual,
        }
    }

    /// Whether the hand moves while it presses.
    pub(super) fn is_moving(self) -> bool {
        matches!(self, Self::Slide(_))
    }

    pub(super) fn is_on_model(self) -> bool {
        self == Self::FingerOnModel
    }

    /// One press of the hand: a single stage, or one for each frame if it moves.
    pub(super) fn draw(
        self,
        pad: &Pad,
        scale: f64,
        draws: &mut Draws,
    ) -> Result<Vec<Drawn>, StudyError> {
        let Self::Slide(mm_per_s) = self else {
            return Ok(vec![self.draw_still(pad, scale, draws)?]);
        };
        let path_mm = 1e-3 * mm_per_s * FRAME_MS * (PRESS_FRAMES - 1) as f64;
        let ends = draws.pair(path_mm)?;
        let radius_mm = scale * draws.between(RADIUS_MM[0], RADIUS_MM[1]);
        let rise = draws.between(RISE[0], RISE[1]);
        let stage = |frame: usize| {
            let share = frame as f64 / (PRESS_FRAMES - 1) as f64;
            let [from, to] = [0, 1].map(|end| ends[end].centre_mm);
            let at_mm = [0, 1].map(|k| from[k] + share * (to[k] - from[k]));
            finger(at_mm, radius_mm, rise)
        };
        Ok((0..PRESS_FRAMES).map(stage).collect())
    }

    /// One press of a hand that does not move. Lengths shrink with `scale` on small pads.
    fn draw_still(self, pad: &Pad, scale: f64, draws: &mut Draws) -> Result<Drawn, StudyError> {
        let radius_mm = scale * draws.between(RADIUS_MM[0], RADIUS_MM[1]);
        let rise = draws.between(RISE[0], RISE[1]);
        let inner = draws.presses(1)?[0].centre_mm;
        Ok(match self {
            Self::Untouched
            | Self::Finger
            | Self::FingerOnModel
            | Self::FingerAfterLying
            | Self::ShortFinger
            | Self::Slide(_) => finger(inner, radius_mm, rise),
            Self::Falling => finger(inner, radius_mm, rise).falling(),
            Self::Edge(near, far) => {
                let depth_mm = scale * draws.between(near, far);
                finger(at_edge(pad, depth_mm, draws), radius_mm, rise)
            }
            Self::Corner => finger(at_corner(pad, 4.0 * scale, draws), radius_mm, rise),
            Self::Electrode => finger(over_electrode(pad, scale, draws), radius_mm, rise),
            Self::Ellipse(a, b) => ellipse(inner, [scale * a, scale * b], draws.angle()),
            Self::Annulus => ring(inner, scale * RING_MM.0, scale * RING_MM.1),
            Self::Radius(radius_mm) => finger(inner, scale * radius_mm, rise),
            Self::Rise(rise) => finger(inner, radius_mm, rise),
            Self::Pair(distance_mm) => fingers(draws.pair(distance_mm)?),
            Self::Several(count) | Self::SeveralAfterDrumming(count) => {
                fingers(draws.presses_apart(count, SEVERAL_APART_MM)?)
            }
            Self::Any { falls } => {
                let index = draws.between(0.0, KINDS.len() as f64) as usize;
                let drawn = KINDS[index.min(KINDS.len() - 1)].draw_still(pad, scale, draws)?;
                if falls { drawn.falling() } else { drawn }
            }
        })
    }
}

impl Drawn {
    /// The same hand on a pad whose conductivity falls under it.
    fn falling(self) -> Self {
        let rising = self.factor;
        Self {
            centres_mm: self.centres_mm,
            factor: Box::new(move |point| 1.0 / rising(point)),
            presses: Vec::new(),
        }
    }

    /// One finger that is not round.
    fn odd(centre_mm: PointMm, factor: impl Fn(PointMm) -> f64 + 'static) -> Self {
        Self {
            centres_mm: vec![centre_mm],
            factor: Box::new(factor),
            presses: Vec::new(),
        }
    }
}

fn finger(centre_mm: PointMm, radius_mm: f64, rise: f64) -> Drawn {
    fingers(vec![Press {
        centre_mm,
        radius_mm,
        rise,
    }])
}

fn fingers(presses: Vec<Press>) -> Drawn {
    let under = presses.clone();
    Drawn {
        centres_mm: presses.iter().map(|press| press.centre_mm).collect(),
        factor: Box::new(move |point| under.iter().map(|press| press.factor(point)).product()),
        presses,
    }
}

/// A place at a depth from one of the four sides.
fn at_edge(pad: &Pad, depth_mm: f64, draws: &mut Draws) -> PointMm {
    let [width, height] = pad.outline.size_mm();
    let along = draws.between(0.12, 0.88);
    match draws.between(0.0, 4.0) as usize {
        0 => [along * width, depth_mm],
        1 => [width - depth_mm, along * height],
        2 => [along * width, height - depth_mm],
        _ => [depth_mm, along * height],
    }
}

/// A place within a distance of both sides of a corner.
fn at_corner(pad: &Pad, within_mm: f64, draws: &mut Draws) -> PointMm {
    pad.outline.size_mm().map(|side| {
        let depth_mm = draws.between(0.0, within_mm);
        if draws.between(0.0, 1.0) < 0.5 {
            depth_mm
        } else {
            side - depth_mm
        }
    })
}

/// A place 2 to 5 mm inside an electrode.
fn over_electrode(pad: &Pad, scale: f64, draws: &mut Draws) -> PointMm {
    let count = pad.electrodes.len();
    let index = (draws.between(0.0, count as f64) as usize).min(count - 1);
    let [x, y] = pad.electrodes[index].centre_mm(&pad.outline);
    let inward_mm = scale * draws.between(2.0, 5.0);
    let [width, height] = pad.outline.size_mm();
    let (dx, dy) = (width / 2.0 - x, height / 2.0 - y);
    let length = libm::hypot(dx, dy).max(1e-9);
    [x + inward_mm * dx / length, y + inward_mm * dy / length]
}

/// A flat finger with a relative rise of 1.
fn ellipse(centre_mm: PointMm, half_axes_mm: [f64; 2], angle: f64) -> Drawn {
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    Drawn::odd(centre_mm, move |[x, y]: PointMm| {
        let (dx, dy) = (x - centre_mm[0], y - centre_mm[1]);
        let u = (dx * cos + dy * sin) / half_axes_mm[0];
        let v = (dy * cos - dx * sin) / half_axes_mm[1];
        1.0 + (1.0 - u * u - v * v).max(0.0)
    })
}

/// A fingertip whose middle presses less, with a relative rise of 1 on its ring.
fn ring(centre_mm: PointMm, radius_mm: f64, half_width_mm: f64) -> Drawn {
    Drawn::odd(centre_mm, move |[x, y]: PointMm| {
        let off_mm = libm::hypot(x - centre_mm[0], y - centre_mm[1]) - radius_mm;
        let share = off_mm / half_width_mm;
        1.0 + (1.0 - share * share).max(0.0)
    })
}
