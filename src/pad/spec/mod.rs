//! A pad as written in TOML, and its checks.
//!
//! Two stages: serde reads the text into the structs below, with spans; [`read`] then turns them into a [`Pad`] or reports
//! why the pad cannot be built or measured.

mod electrodes;
mod found;
mod geometry;
mod learned;
mod protocol;

use std::sync::Arc;

use serde::Deserialize;
use toml::Spanned;

use super::{Deviations, Pad, TouchSign};
use crate::types::{Diagnostic, Method, SourceErrors};
use found::FoundSpec;
use learned::LearnedSpec;

/// The supported version of the format.
const SCHEMA: i64 = 1;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PadSpec {
    schema: Spanned<i64>,
    name: String,
    #[serde(default)]
    about: String,
    #[serde(default)]
    touch_sign: SignSpec,
    method: Option<Method>,
    outline: Spanned<OutlineSpec>,
    layer: LayerSpec,
    lattice: Option<LatticeSpec>,
    electrodes: ElectrodesSpec,
    protocol: Spanned<ProtocolSpec>,
    /// How the pad differs from all this.
    found: Option<FoundSpec>,
    /// Maps from presses that replace the drawing.
    learned: Option<LearnedSpec>,
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum SignSpec {
    /// A rise is expected until the first touch says otherwise.
    #[default]
    Either,
    Rise,
    Fall,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum ShapeSpec {
    Rectangle,
    Circle,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct OutlineSpec {
    shape: ShapeSpec,
    width_mm: Option<Spanned<f64>>,
    height_mm: Option<Spanned<f64>>,
    radius_mm: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LayerSpec {
    thickness_mm: Spanned<f64>,
    background_s_per_m: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LatticeSpec {
    width_mm: Spanned<f64>,
    x_lines: Spanned<i64>,
    y_lines: Spanned<i64>,
    margin_mm: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ElectrodesSpec {
    count: Spanned<i64>,
    width_mm: Spanned<f64>,
    first_mm: Option<Spanned<f64>>,
    first_deg: Option<Spanned<f64>>,
    at_mm: Option<Spanned<Vec<Spanned<[f64; 2]>>>>,
    first_electrode: Option<Spanned<i64>>,
    #[serde(default)]
    direction: DirectionSpec,
    contact_impedance_ohm_m2: Spanned<f64>,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum DirectionSpec {
    #[default]
    CounterClockwise,
    Clockwise,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ProtocolSpec {
    stimulation: Option<Spanned<String>>,
    measurement: Option<Spanned<String>>,
    #[serde(default)]
    readings: ReadingsSpec,
    drives: Option<Vec<[usize; 2]>>,
    measures: Option<Vec<[usize; 2]>>,
    channels: Option<Vec<[usize; 4]>>,
    /// The drives in the order in which they are read, numbered as listed.
    order: Option<Spanned<Vec<usize>>>,
}

#[derive(Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
enum ReadingsSpec {
    #[default]
    Full,
    Half,
}

/// Reads and checks a pad. See [`Pad::from_toml`].
pub(super) fn read(name: &str, text: &str) -> Result<Pad, SourceErrors> {
    let spec: PadSpec =
        toml::from_str(text).map_err(|e| SourceErrors::from_toml(name, text, &e))?;
    build(&spec).map_err(|error| SourceErrors::new(name, text, vec![error]))
}

fn build(spec: &PadSpec) -> Result<Pad, Diagnostic> {
    if *spec.schema.get_ref() != SCHEMA {
        return Err(Diagnostic::new(
            spec.schema.span(),
            format!("unknown schema {}", spec.schema.get_ref()),
            "here",
        )
        .help(format!("this version of gelpad reads schema = {SCHEMA}")));
    }
    let outline = geometry::outline(&spec.outline)?;
    let conductor = geometry::conductor(spec.lattice.as_ref(), &outline)?;
    let places = electrodes::electrodes(&spec.electrodes, &outline, &conductor)?;
    let numbering = geometry::numbering(&spec.electrodes, places.len())?;
    let electrodes: Vec<_> = (0..places.len())
        .map(|electrode| places[numbering.place(electrode, places.len())])
        .collect();
    let protocol = protocol::protocol(&spec.protocol, electrodes.len())?;
    let drawing = Pad {
        name: spec.name.clone(),
        about: spec.about.clone(),
        outline,
        conductor,
        thickness_mm: positive(&spec.layer.thickness_mm, "the layer's thickness")?,
        background_s_per_m: positive(&spec.layer.background_s_per_m, "the conductivity")?,
        deviations: Deviations::default(),
        learned: None,
        electrodes,
        numbering,
        contact_impedance_ohm_m2: positive(
            &spec.electrodes.contact_impedance_ohm_m2,
            "the contact impedance",
        )?,
        protocol,
        touch_sign: match spec.touch_sign {
            SignSpec::Either | SignSpec::Rise => TouchSign::Rise,
            SignSpec::Fall => TouchSign::Fall,
        },
        method: spec.method,
    };
    let pad = match &spec.found {
        Some(found) => found::applied(found, &drawing)?,
        None => drawing,
    };
    let learned = spec.learned.as_ref();
    let learned = learned.map(|learned| learned::checked(learned, &pad));
    Ok(Pad {
        learned: learned.transpose()?.map(Arc::new),
        ..pad
    })
}

fn positive(value: &Spanned<f64>, what: &str) -> Result<f64, Diagnostic> {
    let number = *value.get_ref();
    if number.is_finite() && number > 0.0 {
        Ok(number)
    } else {
        Err(Diagnostic::new(
            value.span(),
            format!("{what} must be a number above zero"),
            "not above zero",
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::{DEFAULT_PAD, Pair, shipped_pad};

    /// The default pad with one passage of its text replaced.
    fn edited(from: &str, to: &str) -> Result<Pad, SourceErrors> {
        let text = shipped_pad(DEFAULT_PAD).expect("shipped").toml;
        assert!(text.contains(from), "the pad contains `{from}`");
        Pad::from_toml("pad.toml", &text.replacen(from, to, 1))
    }

    fn refusal(from: &str, to: &str) -> (String, String) {
        let errors = edited(from, to).expect_err("refused");
        let first = &errors.diagnostics[0];
        (
            first.message.clone(),
            errors.text[first.span.clone()].to_owned(),
        )
    }

    #[test]
    fn the_papers_pad_has_four_electrodes_a_side() {
        let pad = edited("schema = 1", "schema = 1").expect("valid");
        let centres: Vec<_> = pad
            .electrodes
            .iter()
            .map(|electrode| electrode.centre_mm(&pad.outline))
            .collect();
        assert_eq!(centres[0], [12.5, 0.0]);
        assert_eq!(centres[4], [100.0, 12.5]);
        assert_eq!(centres[8], [87.5, 100.0]);
        assert_eq!(centres[15], [0.0, 12.5]);
        assert_eq!(pad.channels(), 208);
    }

    #[test]
    fn the_guide_shows_a_sound_pad_and_names_every_key() {
        const GUIDE: &str = include_str!("../../../docs/pads.md");
        let example = GUIDE
            .split("```toml\n")
            .nth(1)
            .and_then(|rest| rest.split("```").next())
            .expect("an example");
        let pad = Pad::from_toml("coaster", example).expect("sound");
        assert_eq!(pad.channels(), 40);
        let text = shipped_pad(DEFAULT_PAD).expect("shipped").toml;
        let tables = ["outline", "layer", "lattice", "electrodes", "protocol"];
        let written = ["found", "learned"];
        let of_written = written.map(|table| format!("{text}[{table}]\nodd_key = 1\n"));
        let with_odd_keys = tables.map(|table| {
            let head = format!("[{table}]\n");
            text.replacen(&head, &format!("{head}odd_key = 1\n"), 1)
        });
        let of_pad = format!("odd_key = 1\n{text}");
        for text in with_odd_keys.iter().chain([&of_pad]).chain(&of_written) {
            let error = Pad::from_toml("p", text)
                .expect_err("an unknown key")
                .to_string();
            let (_, keys) = error.split_once("expected ").expect(&error);
            let keys: Vec<&str> = keys.split('`').skip(1).step_by(2).collect();
            assert!(keys.len() > 1, "{error}");
            for key in keys {
                let is_table = tables.contains(&key) || written.contains(&key);
                let named = if is_table {
                    format!("{key}.")
                } else {
                    key.to_owned()
                };
                assert!(GUIDE.contains(&named), "docs/pads.md does not name `{key}`");
            }
        }
    }

    #[test]
    fn a_board_may_number_places_differently() {
        let pad = edited(
            "width_mm = 3.0",
            "width_mm = 3.0\nfirst_electrode = 4\ndirection = \"clockwise\"",
        )
        .expect("valid");
        let centre = |electrode: usize| pad.electrodes[electrode].centre_mm(&pad.outline);
        assert_eq!(centre(0), [100.0, 12.5]);
        assert_eq!(centre(1), [87.5, 0.0]);
        assert_eq!(centre(15), [100.0, 37.5]);
    }

    #[test]
    fn impossible_pads_are_refused_at_their_place_in_the_text() {
        let cases: &[(&str, &str, &str, &str)] = &[
            (
                "width_mm = 2.0\nx",
                "width_mm = 10.0\nx",
                "channels of 10 mm overlap: 11 lines on 100 mm are 9.00 mm apart",
                "10.0",
            ),
            (
                "margin_mm = 0.0",
                "margin_mm = 3.0",
                "electrode 2 at (37.5, 0.0) mm lies between channels: 0 % of it touches conductor",
                "16",
            ),
            (
                "width_mm = 3.0",
                "width_mm = 25.5",
                "electrodes 1 and 2 overlap by 0.50 mm",
                "25.5",
            ),
            (
                "count = 16",
                "count = 3",
                "a pad has 4 to 64 electrodes, not 3",
                "3",
            ),
            (
                "width_mm = 3.0",
                "width_mm = 3.0\nfirst_electrode = 16",
                "`first_electrode` is a place counted from 0: 0 to 15, not 16",
                "16",
            ),
            (
                "width_mm = 3.0",
                "width_mm = 3.0\nfirst_mm = 1.0",
                "electrode 1 would bend round the corner at (0, 0) mm",
                "16",
            ),
            (
                "thickness_mm = 2.0",
                "thickness_mm = -2.0",
                "the layer's thickness must be a number above zero",
                "-2.0",
            ),
            (
                "stimulation = \"adjacent\"",
                "stimulation = \"adjacant\"",
                "`adjacant` is not a stimulation pattern",
                "\"adjacant\"",
            ),
            (
                "count = 16",
                "count = 4\nat_mm = [[10, 0], [100, 10], [50, 50], [0, 10]]",
                "the electrode at (50, 50) mm is off the outline",
                "[50, 50]",
            ),
            (
                "height_mm",
                "heigth_mm",
                "unknown field `heigth_mm`, expected one of `shape`, `width_mm`, `height_mm`, `radius_mm`",
                "heigth_mm",
            ),
        ];
        for (from, to, message, place) in cases {
            assert_eq!(
                refusal(from, to),
                ((*message).to_owned(), (*place).to_owned()),
                "{to}"
            );
        }
    }

    #[test]
    fn pads_that_cannot_be_solved_are_refused_before_meshing() {
        let cases: &[(&str, &str, &str)] = &[
            (
                "height_mm = 100.0",
                "height_mm = 1e9",
                "a pad measures 5 to 2000 mm across",
            ),
            (
                "height_mm = 100.0",
                "height_mm = 9.0",
                "a pad is at most 10 times as long as wide",
            ),
            (
                "width_mm = 2.0",
                "width_mm = 0.01",
                "channels of 0.01 mm on 2200 mm of lines are too thin to be solved: at least 0.10 mm",
            ),
            (
                "width_mm = 3.0",
                "width_mm = 0.05",
                "electrodes are at least 0.2 mm wide",
            ),
            (
                "margin_mm = 0.0",
                "margin_mm = 60.0",
                "the lattice's margin is 0 to 48 mm on this pad",
            ),
            (
                "count = 16",
                "count = 4\nat_mm = [[10, 0], [60, 0], [11, 0], [100, 50]]",
                "electrodes are listed counter-clockwise, once round the pad",
            ),
            (
                "\"adjacent\"",
                "\"skip-18446744073709551615\"",
                "`skip-18446744073709551615` is not a stimulation pattern",
            ),
        ];
        for (from, to, message) in cases {
            assert_eq!(&refusal(from, to).0, message, "{to}");
        }
    }

    #[test]
    fn patterns_by_name_and_by_list() {
        let half = edited("readings = \"full\"", "readings = \"half\"").expect("104");
        assert_eq!(half.channels(), 104);
        let skip =
            edited("stimulation = \"adjacent\"", "stimulation = \"skip-2\"").expect("skip-2");
        assert_eq!(skip.protocol.channels[0].drive, Pair(0, 3));
        let listed = edited(
            "stimulation = \"adjacent\"\nmeasurement = \"adjacent\"",
            "channels = [[0, 1, 4, 5], [1, 2, 6, 7]]",
        )
        .expect("listed");
        assert_eq!(listed.channels(), 2);
    }
}
