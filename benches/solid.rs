//! The current in three dimensions: one solve of 16 patterns on more than 200,000 nodes, from conductivities to potentials.

use criterion::{Criterion, criterion_group, criterion_main};
use gelpad::eit::MeshSize;
use gelpad::pad::{DEFAULT_PAD, Pad, shipped_pad};
use gelpad::study::thickness::{Placement, conductor};

const LAYER_MM: f64 = 3.0;
/// Edges of the bricks as multiples of those of images, as in the study, with more bricks over the height.
const SCALE: f64 = 1.15;
const LAYERS: usize = 12;

fn solve(criterion: &mut Criterion) {
    let shipped = shipped_pad(DEFAULT_PAD).expect("shipped");
    let pad = Pad::from_toml(shipped.name, shipped.toml).expect("sound");
    let size = MeshSize::relative(&pad, SCALE, false);
    let model = conductor(&pad, LAYER_MM, size, LAYERS, Placement::Underside).expect("a conductor");
    let bricks = model.bricks();
    let even = vec![pad.background_s_per_m; bricks.corners.len()];
    let nodes = bricks.nodes_mm.len();
    assert!(nodes >= 200_000, "{nodes} nodes");
    criterion.bench_function(
        &format!("current in {nodes} nodes, 16 patterns"),
        |bencher| {
            bencher.iter(|| model.solve(&bricks.nodes_mm, &even).expect("solved"));
        },
    );
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10);
    targets = solve
}
criterion_main!(benches);
