//! The whole sensor as a body of rubber: silicone with the lattice of hydrogel in it, held in one of three ways, pressed by a flat
//! round indenter to which its skin sticks.

use super::super::solid::{
    Bricks, Elastic, ElasticError, Gradient, Lines, Prescribed, Rubber, Size, bricks::Point,
    growing_lines,
};
use super::{Parameters, Touch, under_indenter};
use crate::pad::Pad;
use crate::types::PointMm;

/// Lines are this far apart under the indenter, mm: in full and in quick studies.
const STEP_MM: (f64, f64) = (1.0, 1.25);
/// They stay so near this far beyond its rim, mm ...
const EVEN_BEYOND_MM: f64 = 1.5;
/// ... and then grow apart by this factor, to this distance at most, mm.
const GROWTH: (f64, f64) = (1.034, 1.5);
const MOST_MM: f64 = 8.0;
/// On a foundation there are more bricks over the height, and lines may grow apart faster.
const FOUNDATION_GROWTH: (f64, f64) = (1.075, 1.7);
/// Bricks over the height of the lower silicone, the layer, the upper silicone.
const HEIGHTS: [(usize, usize); 3] = [(1, 1), (3, 2), (1, 1)];
/// Lines of the foundation, as shares of its depth.
const FOUNDATION_LINES: [f64; 5] = [1.0, 0.6, 0.3, 0.1, 0.0];
/// Poisson's ratio of the foundation: soft foams are compressible.
const FOUNDATION_POISSON: f64 = 0.3;
/// The first step of a press, mm.
const FIRST_STEP_MM: f64 = 0.4;
/// Points a side over which a brick's share of hydrogel is counted.
const SHARE_POINTS: usize = 4;

/// What is built and pressed.
pub(super) struct Plan<'a> {
    pub pad: &'a Pad,
    pub parameters: &'a Parameters,
    pub layer_mm: f64,
    pub centre_mm: PointMm,
    pub touch: Touch,
    pub quick: bool,
    /// How much finer than usual the bricks are.
    pub finer: f64,
}

/// A sensor that is being pressed.
pub(super) struct Pressing {
    body: Elastic,
    held: Vec<usize>,
    deepest_mm: f64,
    centre_mm: PointMm,
    layer_mm: f64,
}

/// What one iteration of a plan's mechanics takes.
pub(super) fn size(plan: &Plan<'_>) -> Result<Size, ElasticError> {
    Ok(Pressing::new(plan, FIRST_STEP_MM)?.body.size())
}

impl Pressing {
    /// A sensor at rest, to be pressed so deep at most.
    pub(super) fn new(plan: &Plan<'_>, deepest_mm: f64) -> Result<Self, ElasticError> {
        let bricks = Bricks::new(lines(plan), |_| true);
        let held = under_indenter(&bricks, plan.centre_mm, plan.parameters.indenter_mm);
        let mut told: Vec<Prescribed> = held
            .iter()
            .flat_map(|node| {
                [0.0, 0.0, -deepest_mm]
                    .into_iter()
                    .enumerate()
                    .map(|(axis, by_mm)| Prescribed {
                        node: *node,
                        axis,
                        by_mm,
                    })
            })
            .collect();
        let still = |place: &Point| is_still(plan, place);
        told.extend(
            bricks
                .nodes_mm
                .iter()
                .enumerate()
                .filter(|(_, place)| still(place))
                .flat_map(|(node, _)| {
                    (0..3).map(move |axis| Prescribed {
                        node,
                        axis,
                        by_mm: 0.0,
                    })
                }),
        );
        let rubbers = rubbers(plan, &bricks);
        let first = (FIRST_STEP_MM / deepest_mm).min(1.0);
        Ok(Self {
            body: Elastic::new(bricks, rubbers, told, first)?,
            held,
            deepest_mm,
            centre_mm: plan.centre_mm,
            layer_mm: plan.layer_mm,
        })
    }

    pub(super) fn nodes(&self) -> usize {
        self.body.bricks().nodes_mm.len()
    }

    pub(super) fn press_to(&mut self, depth_mm: f64) -> Result<(), ElasticError> {
        self.body.load_to(depth_mm / self.deepest_mm)
    }

    /// Force on the indenter, N.
    pub(super) fn force_n(&self) -> f64 {
        -self.body.holding_force_n(&self.held)[2]
    }

    /// How the layer is stretched and turned about a place of it at rest.
    pub(super) fn gradient_at(&self, place: Point) -> Gradient {
        const STILL: Gradient = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        self.body.gradient_at(place).unwrap_or(STILL)
    }

    /// Where the nodes of the conducting layer are now.
    pub(super) fn moved_layer(&self, layer: &Bricks) -> Vec<Point> {
        layer
            .nodes_mm
            .iter()
            .map(|place| {
                let by = self
                    .body
                    .bricks()
                    .interpolate(self.body.moved_mm(), *place)
                    .unwrap_or_default();
                std::array::from_fn(|axis| place[axis] + by[axis])
            })
            .collect()
    }

    /// Height of the layer under the middle of the indenter, mm.
    pub(super) fn layer_height_mm(&self) -> f64 {
        let [x, y] = self.centre_mm;
        let [low, high] = [0.0, self.layer_mm].map(|z| {
            let by = self
                .body
                .bricks()
                .interpolate(self.body.moved_mm(), [x, y, z]);
            z + by.unwrap_or_default()[2]
        });
        high - low
    }
}

/// The layer lies from z = 0 up, so that the bricks of the current lie in it as they are.
fn lines(plan: &Plan<'_>) -> Lines {
    let parameters = plan.parameters;
    let either = |both: (f64, f64)| if plan.quick { both.1 } else { both.0 };
    let size = plan.pad.outline.size_mm();
    let growth = match plan.touch {
        Touch::Foundation => FOUNDATION_GROWTH,
        _ => GROWTH,
    };
    let [x, y] = [0, 1].map(|axis| {
        growing_lines(
            [-parameters.rim_mm, size[axis] + parameters.rim_mm],
            plan.centre_mm[axis],
            parameters.indenter_mm + EVEN_BEYOND_MM,
            [either(STEP_MM), MOST_MM].map(|mm| mm / plan.finer),
            1.0 + (either(growth) - 1.0) / plan.finer,
        )
    });
    let mut z = Vec::new();
    let bottom = -parameters.cover_mm;
    if plan.touch == Touch::Foundation {
        let deep = FOUNDATION_LINES.iter().filter(|share| **share > 0.0);
        z.extend(deep.map(|share| bottom - share * parameters.foundation_mm));
    }
    z.push(bottom);
    let tops = [0.0, plan.layer_mm, plan.layer_mm + parameters.cover_mm];
    for (top, bricks) in tops.into_iter().zip(HEIGHTS) {
        let low = z[z.len() - 1];
        let bricks = if plan.quick { bricks.1 } else { bricks.0 };
        let bricks = ((bricks as f64 * plan.finer).round() as usize).max(1);
        z.extend((1..=bricks).map(|line| low + (top - low) * line as f64 / bricks as f64));
    }
    Lines([x, y, z])
}

/// Whether a node is held where it is.
fn is_still(plan: &Plan<'_>, place: &Point) -> bool {
    let parameters = plan.parameters;
    let on = |a: f64, b: f64| (a - b).abs() < 1e-9;
    match plan.touch {
        Touch::Edge => {
            let size = plan.pad.outline.size_mm();
            [0, 1].into_iter().any(|axis| {
                on(place[axis], -parameters.rim_mm)
                    || on(place[axis], size[axis] + parameters.rim_mm)
            })
        }
        Touch::Foundation => on(place[2], -parameters.cover_mm - parameters.foundation_mm),
        Touch::Table | Touch::Rise => on(place[2], -parameters.cover_mm),
    }
}

/// What each brick is made of: a brick across the edge of a channel is mixed.
fn rubbers(plan: &Plan<'_>, bricks: &Bricks) -> Vec<Rubber> {
    let parameters = plan.parameters;
    let silicone = Rubber::from_young(parameters.silicone_kpa, parameters.poisson);
    let hydrogel = Rubber::from_young(parameters.hydrogel_kpa, parameters.poisson);
    let foam = Rubber::from_young(parameters.foundation_kpa, FOUNDATION_POISSON);
    let size = plan.pad.outline.size_mm();
    let is_gel = |[x, y]: PointMm| {
        (0.0..=size[0]).contains(&x)
            && (0.0..=size[1]).contains(&y)
            && plan.pad.conductor.contains([x, y])
    };
    bricks
        .cells
        .iter()
        .map(|cell| {
            let [_, _, z] = bricks.lines().middle_mm(*cell);
            if z < -parameters.cover_mm {
                return foam;
            }
            if !(0.0..plan.layer_mm).contains(&z) {
                return silicone;
            }
            let at = |axis: usize, step: usize| {
                let lines = &bricks.lines().0[axis];
                let (low, high) = (lines[cell[axis]], lines[cell[axis] + 1]);
                low + (high - low) * (step as f64 + 0.5) / SHARE_POINTS as f64
            };
            let points = SHARE_POINTS * SHARE_POINTS;
            let gel = (0..points)
                .filter(|point| is_gel([at(0, point % SHARE_POINTS), at(1, point / SHARE_POINTS)]))
                .count();
            silicone.mixed(hydrogel, gel as f64 / points as f64)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::{DEFAULT_PAD, shipped_pad};
    use crate::study::thickness::PLACES;

    /// Promised for every touch, wherever it is.
    const FEWEST_NODES: usize = 25_000;

    #[test]
    fn every_full_case_has_as_many_nodes_as_promised() {
        let shipped = shipped_pad(DEFAULT_PAD).expect("shipped");
        let pad = Pad::from_toml(shipped.name, shipped.toml).expect("sound");
        let parameters = Parameters::default();
        for (name, place) in PLACES {
            for touch in [Touch::Edge, Touch::Foundation, Touch::Table] {
                let plan = Plan {
                    pad: &pad,
                    parameters: &parameters,
                    layer_mm: 3.0,
                    centre_mm: place.map(|share| 100.0 * share),
                    touch,
                    quick: false,
                    finer: 1.0,
                };
                let nodes: usize = lines(&plan).0.iter().map(Vec::len).product();
                assert!(nodes >= FEWEST_NODES, "{name}, {touch:?}: {nodes} nodes");
            }
        }
    }
}
