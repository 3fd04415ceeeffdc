//! The indenter.

use super::super::solid::Bricks;
use crate::types::PointMm;

/// Nodes whose distances from the centre differ by less belong to one ring, mm.
const RING_MM: f64 = 1e-6;

/// The nodes on the upper surface under a round flat indenter. On a grid its rim is jagged: rings of nodes are taken from the
/// centre outwards as long as that brings their area nearer to the indenter's.
#[must_use]
pub fn under_indenter(bricks: &Bricks, centre_mm: PointMm, radius_mm: f64) -> Vec<usize> {
    let lines = &bricks.lines().0;
    let top = lines[2].len() as u32 - 1;
    let reach = |axis: usize, line: u32| {
        let (lines, line) = (&lines[axis], line as usize);
        let low = lines[line.saturating_sub(1)];
        let high = lines[(line + 1).min(lines.len() - 1)];
        (high - low) / 2.0
    };
    let mut nodes: Vec<(f64, f64, usize)> = bricks
        .at
        .iter()
        .enumerate()
        .filter(|(_, at)| at[2] == top)
        .map(|(node, at)| {
            let [x, y, _] = bricks.nodes_mm[node];
            let away = libm::hypot(x - centre_mm[0], y - centre_mm[1]);
            (away, reach(0, at[0]) * reach(1, at[1]), node)
        })
        .collect();
    nodes.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));
    let wanted_mm2 = std::f64::consts::PI * radius_mm * radius_mm;
    let mut held = Vec::new();
    let mut area_mm2 = 0.0;
    for ring in nodes.chunk_by(|a, b| b.0 - a.0 < RING_MM) {
        let wider = area_mm2 + ring.iter().map(|(_, area, _)| area).sum::<f64>();
        if (wider - wanted_mm2).abs() > (area_mm2 - wanted_mm2).abs() {
            break;
        }
        area_mm2 = wider;
        held.extend(ring.iter().map(|(_, _, node)| *node));
    }
    held
}
