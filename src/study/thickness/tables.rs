//! The tables of the thickness study.

use super::group::Group;
use super::report::{change_milli, relative_percent, signed_percent};
use super::{Case, PLACES, REFINED, Thickness, ThicknessOutcome, TouchResult};
use crate::study::figure::short;
use crate::study::report::Table;

impl Thickness {
    pub(super) fn tables(
        &self,
        groups: &[Group<'_>],
        layers_mm: &[f64],
        outcomes: &[ThicknessOutcome],
    ) -> Vec<Table> {
        let by_layer =
            |title, figure: fn(&TouchResult) -> f64| by_layer(title, groups, layers_mm, figure);
        let mut tables = Vec::new();
        if layers_mm.len() > 1 {
            tables.push(factors(groups, layers_mm));
        }
        tables.extend([
            by_layer("Mean |dV/V|, % (range over the places)", relative_percent),
            by_layer("Mean |dV|, mV/A", change_milli),
            by_layer(
                "Mean dV/V, %: positive if the layer conducts worse",
                signed_percent,
            ),
            by_layer("Readings that rose, %", |result| {
                let [rose, fell] = result.rose_fell;
                100.0 * rose as f64 / (rose + fell) as f64
            }),
            by_layer(
                "Height of the layer under the touch, % of its height at rest",
                |result| 100.0 * result.height_share,
            ),
            by_layer("Force, N", |result| result.force_n),
        ]);
        if !self.settings.quick {
            tables.push(self.refinement(outcomes));
        }
        tables
    }

    /// One case on meshes of several sizes.
    fn refinement(&self, outcomes: &[ThicknessOutcome]) -> Table {
        let same = |case: &Case| {
            let key = |case: &Case| (case.layer_mm, case.place, case.touch);
            let mut refined = self.cases.iter().filter(|case| case.finer != 1.0);
            refined.any(|refined| key(refined) == key(case))
        };
        let solved = self.cases.iter().zip(outcomes);
        let mut shown: Vec<(&Case, &ThicknessOutcome)> =
            solved.filter(|(case, _)| same(case)).collect();
        shown.sort_by(|(a, _), (b, _)| a.finer.total_cmp(&b.finer));
        let rows = shown.into_iter().flat_map(|(case, outcome)| {
            let [mechanics, current] = outcome.nodes;
            outcome.pressed.iter().map(move |result| {
                vec![
                    format!("{} mm", result.depth_mm),
                    case.finer.to_string(),
                    mechanics.to_string(),
                    current.to_string(),
                    format!("{:.4}", result.force_n),
                    format!("{:.2}", 100.0 * result.height_share),
                    format!("{:.4}", relative_percent(result)),
                    format!("{:+.4}", signed_percent(result)),
                ]
            })
        });
        let (place, _) = PLACES[0];
        let layers = &self.settings.parameters.layers_mm;
        let layer_mm = layers[layers.len() / 2];
        Table::new(
            format!(
                "Refinement: {}, {place}, {layer_mm} mm layer",
                REFINED.name()
            ),
            &[
                "depth",
                "finer by",
                "mechanics nodes",
                "current nodes",
                "force, N",
                "height, %",
                "|dV/V|, %",
                "dV/V, %",
            ],
            rows,
        )
    }

    pub(super) fn csv(&self, outcomes: &[ThicknessOutcome]) -> Table {
        let rows = self.cases.iter().zip(outcomes).flat_map(|(case, outcome)| {
            outcome
                .pressed
                .iter()
                .map(move |result| csv_row(case, outcome, result))
        });
        Table::new(
            "touches",
            &[
                "layer_mm",
                "finer",
                "place",
                "x_share",
                "y_share",
                "touch",
                "depth_mm",
                "share_of_thickness",
                "force_n",
                "height_share",
                "mean_change_v_per_a",
                "mean_relative",
                "mean_signed",
                "rose",
                "fell",
                "at_rest_v_per_a",
                "mechanics_nodes",
                "current_nodes",
            ],
            rows,
        )
    }
}

fn csv_row(case: &Case, outcome: &ThicknessOutcome, result: &TouchResult) -> Vec<String> {
    let (place, at) = PLACES[case.place];
    vec![
        case.layer_mm.to_string(),
        case.finer.to_string(),
        place.to_owned(),
        at[0].to_string(),
        at[1].to_string(),
        case.touch.name().to_owned(),
        result.depth_mm.to_string(),
        result
            .share
            .map(|share| share.to_string())
            .unwrap_or_default(),
        result.force_n.to_string(),
        result.height_share.to_string(),
        result.change.to_string(),
        result.relative.to_string(),
        result.signed.to_string(),
        result.rose_fell[0].to_string(),
        result.rose_fell[1].to_string(),
        outcome.at_rest.to_string(),
        outcome.nodes[0].to_string(),
        outcome.nodes[1].to_string(),
    ]
}

fn factors(groups: &[Group<'_>], layers_mm: &[f64]) -> Table {
    let rows = groups.iter().map(|group| {
        vec![
            group.kind.name(),
            short(group.factor(layers_mm, |result| result.relative)),
            short(group.factor(layers_mm, |result| result.change)),
            short(group.factor_of_place(layers_mm, |result| result.relative)),
        ]
    });
    Table::new(
        "Greatest over least",
        &[
            "touch",
            "|dV/V| by thickness",
            "|dV| by thickness",
            "|dV/V| by place",
        ],
        rows,
    )
}

/// A table of one figure: a row for each kind of touch, a column for each thickness.
fn by_layer(
    title: &str,
    groups: &[Group<'_>],
    layers_mm: &[f64],
    figure: impl Fn(&TouchResult) -> f64,
) -> Table {
    let cell = |values: Option<[f64; 3]>| match values {
        Some([mean, least, most]) if least < most => {
            format!("{} ({} to {})", short(mean), short(least), short(most))
        }
        Some([mean, ..]) => short(mean),
        None => "not pressed".to_owned(),
    };
    let rows = groups.iter().map(|group| {
        let cells = layers_mm
            .iter()
            .map(|layer| cell(group.at(*layer, &figure)));
        std::iter::once(group.kind.name()).chain(cells).collect()
    });
    let layers = layers_mm.iter().map(|layer| format!("{layer} mm"));
    Table {
        title: title.to_owned(),
        head: std::iter::once("touch".to_owned()).chain(layers).collect(),
        rows: rows.collect(),
    }
}
