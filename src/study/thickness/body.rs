//! The mechanics of the whole sensor: silicone with the lattice of hydrogel inside, held in one of three ways and pressed by
//! a flat round indenter to which its surface sticks.

use super::super::solid::{
    Bricks, Constraint, Elastic, ElasticError, Gradient, Lines, Rubber, Size, bricks::Point,
    growing_lines,
};
use super::{ThicknessParameters, Touch, under_indenter};
use crate::pad::Pad;
use crate::types::PointMm;

/// Distance of grid lines under the indenter, in full and in quick studies, mm.
const STEP_MM: (f64, f64) = (1.0, 1.25);
/// The distance stays the same up to here beyond its rim, mm ...
const EVEN_BEYOND_MM: f64 = 1.5;
/// ... and then grows by this factor, in full and in quick studies, ...
const GROWTH: (f64, f64) = (1.034, 1.5);
/// ... up to this distance, mm.
const MOST_MM: f64 = 8.0;
/// On a foundation there are more bricks over the height, so lines grow apart faster.
const FOUNDATION_GROWTH: (f64, f64) = (1.075, 1.7);
/// Bricks over the height of the lower silicone, the layer and the upper silicone, in full and in quick studies.
const HEIGHTS: [(usize, usize); 3] = [(1, 1), (3, 2), (1, 1)];
/// Grid lines of the foundation, as shares of its depth.
const FOUNDATION_LINES: [f64; 5] = [1.0, 0.6, 0.3, 0.1, 0.0];
/// Poisson's ratio of the foundation: soft foams are compressible.
const FOUNDATION_POISSON: f64 = 0.3;
/// The first step of a press, mm.
const FIRST_STEP_MM: f64 = 0.4;
/// Points along each side by which a brick's share of hydrogel is counted.
const SHARE_POINTS: usize = 4;

/// A sensor and its touch.
pub(super) struct Plan<'a> {
    pub pad: &'a Pad,
    pub parameters: &'a ThicknessParameters,
    pub layer_mm: f64,
    pub centre_mm: PointMm,
    pub touch: Touch,
    pub quick: bool,
    /// Factor by which the bricks are finer than usual.
    pub finer: f64,
}

/// A sensor that is being pressed.
pub(super) struct Pressing {
    body: Elastic,
    /// Nodes under the indenter.
    held: Vec<usize>,
    deepest_mm: f64,
    centre_mm: PointMm,
    layer_mm: f64,
}

/// Cost of one iteration of the mechanics.
pub(super) fn size(plan: &Plan<'_>) -> Result<Size, ElasticError> {
    Ok(Pressing::new(plan, FIRST_STEP_MM)?.body.size())
}

impl Pressing {
    /// A sensor at rest that will be pressed to `deepest_mm` at most.
    pub(super) fn new(plan: &Plan<'_>, deepest_mm: f64) -> Result<Self, ElasticError> {
        let bricks = Bricks::new(lines(plan), |_| true);
        let held = under_indenter(&bricks, plan.centre_mm, plan.parameters.indenter_mm);
        let constrain = |node: usize, by_mm: [f64; 3]| {
            [0, 1, 2].map(|axis| Constraint {
                node,
                axis,
                by_mm: by_mm[axis],
            })
        };
        let pressed = held
            .iter()
            .map(|node| constrain(*node, [0.0, 0.0, -deepest_mm]));
        let places = bricks.nodes_mm.iter().enumerate();
        let still = places.filter(|(_, place)| is_still(plan, place));
        let still = still.map(|(node, _)| constrain(node, [0.0; 3]));
        let constraints: Vec<Constraint> = pressed.chain(still).flatten().collect();
        let rubbers = rubbers(plan, &bricks);
        let first = (FIRST_STEP_MM / deepest_mm).min(1.0);
        Ok(Self {
            body: Elastic::new(bricks, rubbers, constraints, first)?,
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

    /// The deformation gradient at a place of the layer at rest.
    pub(super) fn gradient_at(&self, place: Point) -> Gradient {
        self.body
            .gradient_at(place)
            .unwrap_or_else(Gradient::identity)
    }

    /// Places of the nodes of the conducting layer in the deformed sensor, mm.
    pub(super) fn moved_layer(&self, layer: &Bricks) -> Vec<Point> {
        let places = layer.nodes_mm.iter();
        places.map(|place| self.moved(*place)).collect()
    }

    /// The place in the deformed sensor of a point at rest, mm.
    fn moved(&self, place: Point) -> Point {
        let bricks = self.body.bricks();
        let by = bricks
            .interpolate(self.body.moved_mm(), place)
            .unwrap_or_default();
        std::array::from_fn(|axis| place[axis] + by[axis])
    }

    /// Height of the layer under the centre of the indenter, mm.
    pub(super) fn layer_height_mm(&self) -> f64 {
        let [x, y] = self.centre_mm;
        let [low, high] = [0.0, self.layer_mm].map(|z| self.moved([x, y, z])[2]);
        high - low
    }
}

/// Grid lines. The layer begins at z = 0, as in the model of the current.
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

/// Whether a node is held in place.
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

/// Material of each brick; a brick across the edge of a channel is mixed.
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
            let gel = bricks.lines().share_of_plan(*cell, SHARE_POINTS, is_gel);
            silicone.mixed(hydrogel, gel)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::{DEFAULT_PAD, shipped_pad};
    use crate::study::thickness::PLACES;

    /// Promised for every touch at every place.
    const FEWEST_NODES: usize = 25_000;

    #[test]
    fn every_full_case_has_the_promised_number_of_nodes() {
        let shipped = shipped_pad(DEFAULT_PAD).expect("shipped");
        let pad = Pad::from_toml(shipped.name, shipped.toml).expect("sound");
        let parameters = ThicknessParameters::default();
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
