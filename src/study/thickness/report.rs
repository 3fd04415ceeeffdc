//! The report of the thickness study: whether thickness matters, for each kind of touch.

use super::group::Group;
use super::{Thickness, ThicknessOutcome, ThicknessParameters, TouchResult};
use crate::stats::range;
use crate::study::figure::{Chart, Figure, Series, short};
use crate::study::report::Report;
use crate::study::{CommandLine, StudyError};

/// Thickness matters where it changes a figure by more than this factor: about the effect of the place of a touch.
const MATTERS: f64 = 1.5;

pub(super) fn relative_percent(result: &TouchResult) -> f64 {
    100.0 * result.relative
}

pub(super) fn signed_percent(result: &TouchResult) -> f64 {
    100.0 * result.signed
}

pub(super) fn change_milli(result: &TouchResult) -> f64 {
    1e3 * result.change
}

impl Thickness {
    pub(super) fn build_report(&self, outcomes: &[ThicknessOutcome]) -> Result<Report, StudyError> {
        let groups = self.groups(outcomes);
        let layers_mm = self.layers_mm();
        let charts = [
            (
                "relative-change",
                "Mean |dV/V|, %",
                relative_percent as fn(&TouchResult) -> f64,
            ),
            ("change", "Mean |dV|, mV/A", change_milli),
            ("signed-change", "Mean dV/V, %", signed_percent),
        ];
        let figures = charts
            .into_iter()
            .map(|(name, label, figure)| chart(name, label, &groups, &layers_mm, figure));
        Ok(Report {
            title: "Does the thickness of the layer matter?".to_owned(),
            command: self.command(),
            version: self.settings.version.clone(),
            seed: None,
            advice: advice(&groups, &layers_mm),
            method: self.method(&layers_mm, outcomes),
            tables: self.tables(&groups, &layers_mm, outcomes),
            csvs: vec![self.csv(outcomes)],
            figures: figures.collect::<Result<_, _>>()?,
            files: Vec::new(),
        })
    }

    /// The shell command that repeats the study: options with default values are left out.
    #[must_use]
    pub fn command(&self) -> String {
        let settings = &self.settings;
        let defaults = ThicknessParameters::default().options();
        let options = settings.parameters.options().into_iter().zip(defaults);
        options
            .filter(|(option, default)| option != default)
            .fold(
                CommandLine::new("study thickness", &settings.pad),
                |line, ((name, value), _)| line.option(name, value),
            )
            .flag("quick", settings.quick)
            .finish()
    }

    /// The thicknesses of the layer that were studied, mm.
    fn layers_mm(&self) -> Vec<f64> {
        let usual = self.cases.iter().filter(|case| case.finer == 1.0);
        let mut layers_mm: Vec<f64> = usual.map(|case| case.layer_mm).collect();
        layers_mm.dedup();
        layers_mm
    }

    fn method(&self, layers_mm: &[f64], outcomes: &[ThicknessOutcome]) -> Vec<String> {
        let p = &self.settings.parameters;
        let layers: Vec<String> = layers_mm.iter().map(f64::to_string).collect();
        let mut texts = vec![
            format!(
                "The pad {} in three dimensions: a conducting layer of {} mm with {} mm of silicone below and above it and {} mm \
                 around it, electrodes on its underside. At {} places it is pressed by a flat round indenter of {} mm radius to \
                 which its surface sticks, or its conductivity is raised to {} S/m within that radius.",
                self.settings.pad,
                layers.join(", "),
                p.cover_mm,
                p.rim_mm,
                self.cases.iter().map(|case| case.place).max().unwrap_or(0) + 1,
                p.indenter_mm,
                p.rise_s_per_m,
            ),
            format!(
                "Rubber is neo-Hookean with large deformation (no linearisation): silicone of {} kPa (data sheet of Ecoflex 00-30: \
                 69 kPa at 100 % strain), hydrogel of {} kPa, Poisson's ratio {}, a foundation of {} mm and {} kPa. The paper \
                 gives none of these; each is an option of the command.",
                p.silicone_kpa, p.hydrogel_kpa, p.poisson, p.foundation_mm, p.foundation_kpa
            ),
        ];
        let nodes = |which: usize| {
            let cases = self.cases.iter().zip(outcomes);
            let usual = cases.filter(|(case, _)| case.finer == 1.0);
            usual
                .map(|(_, one)| one.nodes[which])
                .filter(|nodes| *nodes > 0)
                .min()
        };
        if let (Some(mechanics), Some(current)) = (nodes(0), nodes(1)) {
            texts.push(format!(
                "Nodes: at least {mechanics} for mechanics and {current} for the current."
            ));
        }
        let mut refused: Vec<&str> = outcomes
            .iter()
            .flat_map(|one| one.refused.iter().map(String::as_str))
            .collect();
        refused.sort_unstable();
        refused.dedup();
        if !refused.is_empty() {
            texts.push(format!("Not pressed: {}.", refused.join("; ")));
        }
        texts
    }
}

/// What to build, and how to set `touch_sign`.
fn advice(groups: &[Group<'_>], layers_mm: &[f64]) -> Vec<String> {
    let mut texts = Vec::new();
    if layers_mm.len() > 1 {
        let factor = |group: &Group| group.factor(layers_mm, |result| result.relative);
        let (matters, free): (Vec<&Group>, Vec<&Group>) =
            groups.iter().partition(|group| factor(group) > MATTERS);
        texts.push(if matters.is_empty() {
            "Choose the thickness of the layer freely: it matters little for every touch.".to_owned()
        } else if free.is_empty() {
            "Choose the thickness of the layer with care: it matters for every touch.".to_owned()
        } else {
            let names: Vec<String> = matters.iter().map(|group| group.kind.name()).collect();
            format!(
                "Choose the thickness of the layer with care only for these touches, for the others it matters little: {}.",
                names.join("; ")
            )
        });
        texts.extend(groups.iter().map(|group| verdict(group, layers_mm)));
    }
    texts.push(
        "Set touch_sign = \"fall\" in the text of a pad that is pressed, and \"rise\" for a pad whose touches raise the conductivity: a \
         press thins an incompressible channel, which then conducts worse, and readings rise; a local rise of the conductivity \
         lets them fall."
            .to_owned(),
    );
    texts
}

fn verdict(group: &Group<'_>, layers_mm: &[f64]) -> String {
    let relative = group.factor(layers_mm, |result| result.relative);
    let change = group.factor(layers_mm, |result| result.change);
    let place = group.factor_of_place(layers_mm, |result| result.relative);
    let verdict = if relative > MATTERS {
        "matters"
    } else {
        "matters little"
    };
    format!(
        "{}: thickness {verdict}. Between thicknesses |dV/V| differs by a factor of {}, |dV| at constant current by {}; between \
         places |dV/V| differs by {}. {}.",
        group.kind.name(),
        short(relative),
        short(change),
        short(place),
        direction(group, layers_mm)
    )
}

/// Whether the readings rise or fall.
fn direction(group: &Group<'_>, layers_mm: &[f64]) -> String {
    let layers = layers_mm
        .iter()
        .filter_map(|layer| group.at(*layer, signed_percent));
    let [least, most] = range(layers.flat_map(|[_, low, high]| [low, high]));
    let way = if least > 0.0 {
        "Readings rise (the layer conducts worse)"
    } else if most < 0.0 {
        "Readings fall (the layer conducts better)"
    } else {
        "Readings rise at some places and fall at others"
    };
    format!("{way}: mean dV/V {least:+.3} to {most:+.3} %")
}

fn chart(
    name: &str,
    y_label: &str,
    groups: &[Group<'_>],
    layers_mm: &[f64],
    figure: impl Fn(&TouchResult) -> f64,
) -> Result<Figure, StudyError> {
    // A line has no point at a thickness without touches of its kind.
    let point = |group: &Group, layer: &f64| group.at(*layer, &figure).unwrap_or([f64::NAN; 3]);
    let series = groups.iter().map(|group| Series {
        name: group.kind.name(),
        points: layers_mm.iter().map(|layer| point(group, layer)).collect(),
        ..Series::default()
    });
    Chart {
        name: name.to_owned(),
        title: format!("{y_label}, by thickness of the layer"),
        x_label: "thickness of the layer, mm".to_owned(),
        y_label: y_label.to_owned(),
        places: layers_mm.iter().map(f64::to_string).collect(),
        series: series.collect(),
        ..Chart::default()
    }
    .draw()
}
