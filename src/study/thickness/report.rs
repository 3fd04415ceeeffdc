//! What the thickness study tells: whether thickness matters, for each kind of touch, in numbers.

use super::{Case, Outcome, PLACES, Pressed, Thickness, Touch};
use crate::study::StudyError;
use crate::study::figure::{Chart, Figure, Series, short};
use crate::study::report::{Report, Table};

/// Over all thicknesses, a change by more than this factor matters: about what the place of a touch makes.
const MATTERS: f64 = 1.5;

/// A touch as the report groups it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Kind {
    touch: Touch,
    depth_mm: f64,
    share: Option<f64>,
}

impl Kind {
    fn of(case: &Case, pressed: &Pressed) -> Self {
        Self {
            touch: case.touch,
            // Presses by share of the thickness differ in depth.
            depth_mm: if pressed.share.is_some() {
                0.0
            } else {
                pressed.depth_mm
            },
            share: pressed.share,
        }
    }

    fn name(self) -> String {
        match (self.touch, self.share) {
            (Touch::Rise, _) => self.touch.name().to_owned(),
            (touch, Some(share)) => format!("{} %, {}", 100.0 * share, touch.name()),
            (touch, None) => format!("{} mm, {}", self.depth_mm, touch.name()),
        }
    }
}

/// All touches of one kind, by thickness, then by place.
struct Group<'a> {
    kind: Kind,
    found: Vec<(&'a Case, &'a Pressed)>,
}

impl Group<'_> {
    /// Mean, least and greatest of a figure over the places at one thickness; nothing if none was pressed there.
    fn at(&self, layer_mm: f64, figure: impl Fn(&Pressed) -> f64) -> Option<[f64; 3]> {
        let values: Vec<f64> = self
            .found
            .iter()
            .filter(|(case, _)| case.layer_mm == layer_mm)
            .map(|(_, pressed)| figure(pressed))
            .collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        (!values.is_empty()).then_some([mean, least, most])
    }

    /// The greatest over the least mean of all thicknesses.
    fn factor(&self, layers_mm: &[f64], figure: impl Fn(&Pressed) -> f64) -> f64 {
        let means = layers_mm
            .iter()
            .filter_map(|layer| self.at(*layer, &figure));
        let (least, most) = means.fold((f64::INFINITY, 0.0_f64), |(least, most), [mean, ..]| {
            (least.min(mean), most.max(mean))
        });
        most / least
    }

    /// The greatest over the least of all places, mean over the thicknesses.
    fn factor_of_place(&self, layers_mm: &[f64], figure: impl Fn(&Pressed) -> f64) -> f64 {
        let factors: Vec<f64> = layers_mm
            .iter()
            .filter_map(|layer| self.at(*layer, &figure))
            .map(|[_, least, most]| most / least)
            .collect();
        factors.iter().sum::<f64>() / factors.len() as f64
    }
}

impl Thickness {
    /// The report of all jobs' results, in the order of the cases.
    pub(super) fn told(&self, outcomes: &[Outcome]) -> Result<Report, StudyError> {
        let usual = self.cases.iter().filter(|case| case.finer == 1.0);
        let mut layers_mm: Vec<f64> = usual.map(|case| case.layer_mm).collect();
        layers_mm.dedup();
        let groups = self.groups(outcomes);
        let relative = |pressed: &Pressed| 100.0 * pressed.relative;
        let figures = vec![
            self.chart(
                "relative-change",
                "Mean |dV/V|, %",
                &groups,
                &layers_mm,
                relative,
            )?,
            self.chart(
                "change",
                "Mean |dV|, mV/A",
                &groups,
                &layers_mm,
                |pressed| 1e3 * pressed.change,
            )?,
            self.chart(
                "signed-change",
                "Mean dV/V, %",
                &groups,
                &layers_mm,
                |pressed| 100.0 * pressed.signed,
            )?,
        ];
        let mut tables = vec![
            by_layer(
                "Mean |dV/V|, % (over the places: least to greatest)",
                &groups,
                &layers_mm,
                relative,
            ),
            by_layer("Mean |dV|, mV/A", &groups, &layers_mm, |p| 1e3 * p.change),
            by_layer(
                "Mean dV/V, %: above zero, the layer conducts worse",
                &groups,
                &layers_mm,
                |p| 100.0 * p.signed,
            ),
            by_layer("Readings that rose, %", &groups, &layers_mm, |p| {
                100.0 * p.rose_fell[0] as f64 / (p.rose_fell[0] + p.rose_fell[1]) as f64
            }),
            by_layer(
                "Height of the layer under the touch, % of its height at rest",
                &groups,
                &layers_mm,
                |p| 100.0 * p.height_share,
            ),
            by_layer("Force, N", &groups, &layers_mm, |p| p.force_n),
        ];
        if layers_mm.len() > 1 {
            tables.insert(0, self.verdicts(&groups, &layers_mm));
        }
        tables.extend((!self.settings.quick).then(|| self.refinement(outcomes)));
        Ok(Report {
            title: "Does the thickness of the layer matter?".to_owned(),
            command: self.command(),
            version: self.settings.version.clone(),
            seed: 0,
            paragraphs: self.paragraphs(&groups, &layers_mm, outcomes),
            tables,
            csvs: vec![self.csv(outcomes)],
            figures,
        })
    }

    fn groups<'a>(&'a self, outcomes: &'a [Outcome]) -> Vec<Group<'a>> {
        let mut groups: Vec<Group<'a>> = Vec::new();
        let usual = |(case, _): &(&Case, &Outcome)| case.finer == 1.0;
        for (case, outcome) in self.cases.iter().zip(outcomes).filter(usual) {
            for pressed in &outcome.pressed {
                let kind = Kind::of(case, pressed);
                match groups.iter_mut().find(|group| group.kind == kind) {
                    Some(group) => group.found.push((case, pressed)),
                    None => groups.push(Group {
                        kind,
                        found: vec![(case, pressed)],
                    }),
                }
            }
        }
        groups.sort_by_key(|group| {
            Touch::ALL
                .iter()
                .position(|touch| *touch == group.kind.touch)
        });
        groups
    }

    fn command(&self) -> String {
        let quick = if self.settings.quick { " --quick" } else { "" };
        format!(
            "gelpad study thickness --pad {}{quick} --out DIR",
            self.settings.pad
        )
    }

    fn paragraphs(
        &self,
        groups: &[Group<'_>],
        layers_mm: &[f64],
        outcomes: &[Outcome],
    ) -> Vec<String> {
        let p = &self.settings.parameters;
        let mut texts = vec![
            format!(
                "The pad {} in three dimensions: a conducting layer of {} mm with {} mm of silicone below and above it and {} mm \
                 around it, electrodes on its underside. It is touched at {} places by a flat round indenter of {} mm radius to \
                 which the skin sticks, or made to conduct {} S/m within that radius.",
                self.settings.pad,
                layers_mm
                    .iter()
                    .map(f64::to_string)
                    .collect::<Vec<_>>()
                    .join(", "),
                p.cover_mm,
                p.rim_mm,
                self.cases.iter().map(|case| case.place).max().unwrap_or(0) + 1,
                p.indenter_mm,
                p.rise_s_per_m,
            ),
            format!(
                "Rubber is neo-Hookean and deforms as far as it is pressed (no linearisation): silicone of {} kPa (Ecoflex 00-30's \
                 data sheet: 69 kPa at 100 % strain), hydrogel of {} kPa, Poisson's ratio {}, a foundation of {} mm and {} kPa. \
                 The paper gives none of these; each is an option of the command.",
                p.silicone_kpa, p.hydrogel_kpa, p.poisson, p.foundation_mm, p.foundation_kpa
            ),
        ];
        if layers_mm.len() > 1 {
            texts.extend(groups.iter().map(|group| self.answer(group, layers_mm)));
        }
        texts.push(
            "A press thins an incompressible channel: it conducts worse, and readings rise where a local rise of the \
             conductivity lets them fall. A pad's text says which of the two play looks for: touch_sign = \"rise\" or \"fall\"."
                .to_owned(),
        );
        let nodes = |which: usize| {
            let cases = self.cases.iter().zip(outcomes);
            cases
                .filter(|(case, _)| case.finer == 1.0)
                .map(move |(_, outcome)| outcome.nodes[which])
                .filter(|n| *n > 0)
        };
        if let (Some(mechanics), Some(current)) = (nodes(0).min(), nodes(1).min()) {
            texts.push(format!(
                "Nodes: {mechanics} and more for mechanics, {current} and more for the current."
            ));
        }
        let mut refused: Vec<&String> = outcomes.iter().flat_map(|o| &o.refused).collect();
        refused.sort();
        refused.dedup();
        if !refused.is_empty() {
            let list: Vec<&str> = refused.iter().map(|text| text.as_str()).collect();
            texts.push(format!("Not pressed: {}.", list.join("; ")));
        }
        texts
    }

    fn answer(&self, group: &Group<'_>, layers_mm: &[f64]) -> String {
        let relative = group.factor(layers_mm, |p| p.relative);
        let change = group.factor(layers_mm, |p| p.change);
        let place = group.factor_of_place(layers_mm, |p| p.relative);
        let verdict = if relative > MATTERS {
            "matters"
        } else {
            "matters little"
        };
        format!(
            "{}: thickness {verdict}: over all thicknesses |dV/V| changes by a factor of {}, |dV| at constant current by {}; \
             over the places |dV/V| changes by {}. {}.",
            group.kind.name(),
            short(relative),
            short(change),
            short(place),
            sign(group, layers_mm)
        )
    }

    /// One case on meshes of several finenesses.
    fn refinement(&self, outcomes: &[Outcome]) -> Table {
        let solved = self.cases.iter().zip(outcomes);
        let refined: Vec<&Case> = self.cases.iter().filter(|c| c.finer != 1.0).collect();
        let same = |case: &Case| {
            refined.iter().any(|refined| {
                (refined.layer_mm, refined.place, refined.touch)
                    == (case.layer_mm, case.place, case.touch)
            })
        };
        let mut shown: Vec<(&Case, &Outcome)> = solved.filter(|(case, _)| same(case)).collect();
        shown.sort_by(|(a, _), (b, _)| a.finer.total_cmp(&b.finer));
        let rows = shown.iter().flat_map(|(case, outcome)| {
            let [mechanics, current] = outcome.nodes;
            outcome.pressed.iter().map(move |p| {
                vec![
                    format!("{} mm, {} mm layer", p.depth_mm, case.layer_mm),
                    format!("{}", case.finer),
                    mechanics.to_string(),
                    current.to_string(),
                    format!("{:.4}", p.force_n),
                    format!("{:.2}", 100.0 * p.height_share),
                    format!("{:.4}", 100.0 * p.relative),
                    format!("{:+.4}", 100.0 * p.signed),
                ]
            })
        });
        let (place, _) = PLACES[0];
        Table {
            title: format!("Refinement: {}, {place}", super::REFINED.name()),
            head: [
                "pressed",
                "finer by",
                "mechanics nodes",
                "current nodes",
                "force, N",
                "layer's height, %",
                "mean |dV/V|, %",
                "mean dV/V, %",
            ]
            .map(str::to_owned)
            .into(),
            rows: rows.collect(),
        }
    }

    fn verdicts(&self, groups: &[Group<'_>], layers_mm: &[f64]) -> Table {
        Table {
            title: "Greatest over least".to_owned(),
            head: [
                "touch",
                "|dV/V| over thicknesses",
                "|dV| over thicknesses",
                "|dV/V| over places",
            ]
            .map(str::to_owned)
            .into(),
            rows: groups
                .iter()
                .map(|group| {
                    vec![
                        group.kind.name(),
                        short(group.factor(layers_mm, |p| p.relative)),
                        short(group.factor(layers_mm, |p| p.change)),
                        short(group.factor_of_place(layers_mm, |p| p.relative)),
                    ]
                })
                .collect(),
        }
    }

    fn chart(
        &self,
        name: &str,
        y_label: &str,
        groups: &[Group<'_>],
        layers_mm: &[f64],
        figure: impl Fn(&Pressed) -> f64,
    ) -> Result<Figure, StudyError> {
        // Where a layer was not pressed so far, its line has no point.
        let series = groups.iter().map(|group| Series {
            name: group.kind.name(),
            points: layers_mm
                .iter()
                .map(|layer| group.at(*layer, &figure).unwrap_or([f64::NAN; 3]))
                .collect(),
            ..Series::default()
        });
        Chart {
            name: name.to_owned(),
            title: format!("{y_label}, against the thickness of the layer"),
            x_label: "thickness of the layer, mm".to_owned(),
            y_label: y_label.to_owned(),
            places: layers_mm.iter().map(f64::to_string).collect(),
            series: series.collect(),
            ..Chart::default()
        }
        .draw()
    }

    fn csv(&self, outcomes: &[Outcome]) -> Table {
        let head = [
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
        ];
        let rows = self.cases.iter().zip(outcomes).flat_map(|(case, outcome)| {
            outcome.pressed.iter().map(move |p| {
                let (place, at) = PLACES[case.place];
                vec![
                    case.layer_mm.to_string(),
                    case.finer.to_string(),
                    place.to_owned(),
                    at[0].to_string(),
                    at[1].to_string(),
                    case.touch.name().to_owned(),
                    p.depth_mm.to_string(),
                    p.share.map(|share| share.to_string()).unwrap_or_default(),
                    p.force_n.to_string(),
                    p.height_share.to_string(),
                    p.change.to_string(),
                    p.relative.to_string(),
                    p.signed.to_string(),
                    p.rose_fell[0].to_string(),
                    p.rose_fell[1].to_string(),
                    outcome.at_rest.to_string(),
                    outcome.nodes[0].to_string(),
                    outcome.nodes[1].to_string(),
                ]
            })
        });
        Table {
            title: "touches".to_owned(),
            head: head.map(str::to_owned).into(),
            rows: rows.collect(),
        }
    }
}

/// Which way the readings go.
fn sign(group: &Group<'_>, layers_mm: &[f64]) -> String {
    let means = layers_mm
        .iter()
        .filter_map(|layer| group.at(*layer, |p| 100.0 * p.signed));
    let (least, most) = means.fold(
        (f64::INFINITY, f64::NEG_INFINITY),
        |(least, most), [_, low, high]| (least.min(low), most.max(high)),
    );
    let way = if least > 0.0 {
        "Readings rise (the layer conducts worse)"
    } else if most < 0.0 {
        "Readings fall (the layer conducts better)"
    } else {
        "Readings rise at some places and fall at others"
    };
    format!("{way}: mean dV/V {least:+.3} to {most:+.3} %")
}

/// A table of one figure: a row a kind of touch, a column a thickness.
fn by_layer(
    title: &str,
    groups: &[Group<'_>],
    layers_mm: &[f64],
    figure: impl Fn(&Pressed) -> f64,
) -> Table {
    let head = std::iter::once("touch".to_owned());
    Table {
        title: title.to_owned(),
        head: head
            .chain(layers_mm.iter().map(|layer| format!("{layer} mm")))
            .collect(),
        rows: groups
            .iter()
            .map(|group| {
                let cells = layers_mm
                    .iter()
                    .map(|layer| match group.at(*layer, &figure) {
                        Some([mean, least, most]) if least < most => {
                            format!("{} ({} to {})", short(mean), short(least), short(most))
                        }
                        Some([mean, ..]) => short(mean),
                        None => "not pressed".to_owned(),
                    });
                std::iter::once(group.kind.name()).chain(cells).collect()
            })
            .collect(),
    }
}
