//! The order of elimination: nested dissection of a grid.
//!
//! A plane of nodes separates a grid of bricks, since a brick joins neighbouring planes only. The two parts come first, each
//! dissected in turn, and the plane last, so that fill stays within the planes. Of all planes near the middle the one with
//! the fewest nodes is taken, so that a lattice is cut across its channels. (George, SIAM J. Numer. Anal. 10, 1973.)

/// Parts of at most this many nodes are not dissected.
const LEAF: usize = 48;
/// Least share of the nodes in the smaller part and the separating plane together.
const LEAST_SHARE: f64 = 0.3;

/// The nodes in the order of elimination, from their grid indices.
pub(super) fn nested_dissection(at: &[[u32; 3]]) -> Vec<usize> {
    let mut nodes: Vec<usize> = (0..at.len()).collect();
    let mut order = Vec::with_capacity(at.len());
    dissect(at, &mut nodes, &mut order);
    order
}

fn dissect(at: &[[u32; 3]], nodes: &mut [usize], order: &mut Vec<usize>) {
    let Some((axis, plane)) = separator(at, nodes) else {
        order.extend_from_slice(nodes);
        return;
    };
    nodes.sort_by_key(|node| match at[*node][axis].cmp(&plane) {
        std::cmp::Ordering::Less => 0,
        std::cmp::Ordering::Greater => 1,
        std::cmp::Ordering::Equal => 2,
    });
    let below = nodes.partition_point(|node| at[*node][axis] < plane);
    let beyond = nodes[below..].partition_point(|node| at[*node][axis] > plane);
    let (first, rest) = nodes.split_at_mut(below);
    let (second, between) = rest.split_at_mut(beyond);
    dissect(at, first, order);
    dissect(at, second, order);
    order.extend_from_slice(between);
}

/// Axis and plane of the best separator; `None` if the part is small or cannot be separated.
fn separator(at: &[[u32; 3]], nodes: &[usize]) -> Option<(usize, u32)> {
    if nodes.len() <= LEAF {
        return None;
    }
    let least = LEAST_SHARE * nodes.len() as f64;
    // Fewest nodes first, then nearest to the middle.
    let mut best: Option<([usize; 2], usize, u32)> = None;
    for axis in [0, 1, 2] {
        let planes = nodes.iter().map(|node| at[*node][axis]);
        let (first, last) = (planes.clone().min()?, planes.clone().max()?);
        let mut counts = vec![0_usize; (last - first + 1) as usize];
        for plane in planes {
            counts[(plane - first) as usize] += 1;
        }
        let mut below = 0;
        for (index, count) in counts.iter().enumerate() {
            let beyond = nodes.len() - below - count;
            let even = (below.min(beyond) + count) as f64 >= least && below.min(beyond) > 0;
            let merit = [*count, below.abs_diff(beyond)];
            if even && best.is_none_or(|(least, ..)| merit < least) {
                best = Some((merit, axis, first + index as u32));
            }
            below += count;
        }
    }
    best.map(|(_, axis, plane)| (axis, plane))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(size: [u32; 3]) -> Vec<[u32; 3]> {
        let [columns, rows, layers] = size;
        (0..columns * rows * layers)
            .map(|i| [i % columns, i / columns % rows, i / columns / rows])
            .collect()
    }

    #[test]
    fn every_node_is_eliminated_once() {
        let at = block([17, 9, 5]);
        let mut order = nested_dissection(&at);
        order.sort_unstable();
        assert!(order.iter().copied().eq(0..at.len()));
    }

    #[test]
    fn the_last_nodes_separate_the_rest() {
        let at = block([40, 11, 4]);
        let order = nested_dissection(&at);
        let last = at[order[order.len() - 1]];
        let plane: Vec<usize> = (0..at.len())
            .filter(|node| at[*node][0] == last[0])
            .collect();
        let mut end: Vec<usize> = order[order.len() - plane.len()..].to_vec();
        end.sort_unstable();
        assert_eq!(end, plane, "a plane across the longest side");
        assert!((19..=20).contains(&last[0]), "{last:?} is near the middle");
    }
}
