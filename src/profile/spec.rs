//! A profile as written: the TOML, and its checks.
//!
//! serde reads the text into flat structs that keep the place of every word; [`read`] then checks them all, so
//! that a player sees every mistake at once.

use std::collections::BTreeMap;

use serde::Deserialize;
use toml::Spanned;

use super::{Binding, Latch, Mode, Profile, Region, Shape};
use crate::types::{Fault, Faulty, Method, Nanos, Output, nanos_from_ms, nearest};

/// The version of the format that this reads.
const SCHEMA: i64 = 1;
/// Two frames of a game at 60 frames/s: a shorter press can fall between two polls.
const MIN_HOLD_MS: f64 = 34.0;
/// Parts a short press from a long one.
const LONG_MS: f64 = 200.0;
/// Frames a second of the NES (NTSC).
const NES_FRAMES_PER_S: f64 = 60.0988;
/// A short jump of Super Mario Bros, in frames.
const SHORT_FRAMES: f64 = 5.0;
/// The highest jump of Super Mario Bros, in frames.
const LONG_FRAMES: f64 = 32.0;
/// What keys and buttons are called.
const NAMES: &str = "keys are named like a, 7, f5, space, enter, escape, up, left-shift, right-ctrl, keypad-4, comma, page-up; \
                     buttons like pad:a, pad:start, pad:left-shoulder, pad:up";
/// No time in a profile is longer.
const LONGEST_MS: f64 = 60_000.0;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ProfileSpec {
    schema: Spanned<i64>,
    name: String,
    #[serde(default)]
    about: String,
    method: Option<Method>,
    min_hold_ms: Option<Spanned<f64>>,
    min_gap_ms: Option<Spanned<f64>>,
    long_ms: Option<Spanned<f64>>,
    short_frames: Option<Spanned<f64>>,
    long_frames: Option<Spanned<f64>>,
    #[serde(default)]
    region: Vec<Spanned<RegionSpec>>,
    #[serde(default)]
    binding: Vec<BindingSpec>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum ShapeSpec {
    Rect,
    Circle,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RegionSpec {
    name: Spanned<String>,
    shape: ShapeSpec,
    x: Spanned<f64>,
    y: Spanned<f64>,
    w: Option<Spanned<f64>>,
    h: Option<Spanned<f64>>,
    r: Option<Spanned<f64>>,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum ModeSpec {
    #[default]
    Direct,
    Classified,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BindingSpec {
    region: Spanned<String>,
    #[serde(default)]
    mode: ModeSpec,
    output: Spanned<String>,
}

/// Reads and checks a profile. See [`Profile::from_toml`].
pub(super) fn read(name: &str, text: &str) -> Result<Profile, Faulty> {
    let spec: ProfileSpec = toml::from_str(text).map_err(|e| Faulty::from_toml(name, text, &e))?;
    let mut check = Check::default();
    let profile = check.profile(&spec);
    if check.faults.is_empty() {
        Ok(profile)
    } else {
        Err(Faulty::new(name, text, check.faults))
    }
}

/// Gathers faults; where a value is wrong it goes on with a stand-in.
#[derive(Default)]
struct Check {
    faults: Vec<Fault>,
}

impl Check {
    fn profile(&mut self, spec: &ProfileSpec) -> Profile {
        if *spec.schema.get_ref() != SCHEMA {
            self.faults.push(
                Fault::new(
                    spec.schema.span(),
                    format!("schema {} is not known", spec.schema.get_ref()),
                    "here",
                )
                .help(format!("this gelpad reads schema = {SCHEMA}")),
            );
        }
        let regions = self.regions(&spec.region);
        let latch = self.latch(spec);
        let mut outputs = Vec::new();
        let bindings = spec
            .binding
            .iter()
            .filter_map(|binding| self.binding(binding, &regions, latch, &mut outputs))
            .collect();
        if spec.binding.is_empty() {
            self.faults.push(
                Fault::new(spec.schema.span(), "the profile binds nothing: no touch would do anything", "in this file")
                    .help("add a [[region]] and a [[binding]]; `gelpad profile show --toml` prints one to copy"),
            );
        }
        Profile {
            name: spec.name.clone(),
            about: spec.about.clone(),
            method: spec.method,
            min_hold_ns: self.time(&spec.min_hold_ms, MIN_HOLD_MS),
            min_gap_ns: self.time(&spec.min_gap_ms, 0.0),
            regions,
            outputs,
            bindings,
        }
    }

    fn regions(&mut self, specs: &[Spanned<RegionSpec>]) -> Vec<Region> {
        let mut seen = BTreeMap::new();
        for spec in specs {
            let name = &spec.get_ref().name;
            if seen.insert(name.get_ref().as_str(), ()).is_some() {
                self.faults.push(Fault::new(
                    name.span(),
                    format!("two regions are named `{}`", name.get_ref()),
                    "the second one",
                ));
            }
        }
        specs
            .iter()
            .map(|spec| Region {
                name: spec.get_ref().name.get_ref().clone(),
                shape: self.shape(spec),
            })
            .collect()
    }

    fn shape(&mut self, spec: &Spanned<RegionSpec>) -> Shape {
        let region = spec.get_ref();
        let (x, y) = (self.share(&region.x), self.share(&region.y));
        match region.shape {
            ShapeSpec::Rect => {
                self.refuse(&region.r, "r", "rect");
                let w = self.extent(spec, &region.w, "w");
                let h = self.extent(spec, &region.h, "h");
                self.stays_on_pad(&region.w, x + w, "right");
                self.stays_on_pad(&region.h, y + h, "top");
                Shape::Rect { x, y, w, h }
            }
            ShapeSpec::Circle => {
                self.refuse(&region.w, "w", "circle");
                self.refuse(&region.h, "h", "circle");
                let r = self.extent(spec, &region.r, "r");
                self.stays_on_pad(&region.r, (x + r).max(1.0 - (x - r)), "left or right");
                self.stays_on_pad(&region.r, (y + r).max(1.0 - (y - r)), "top or bottom");
                Shape::Circle { x, y, r }
            }
        }
    }

    /// A coordinate, 0..1 of the pad.
    fn share(&mut self, value: &Spanned<f64>) -> f64 {
        let number = *value.get_ref();
        if !(0.0..=1.0).contains(&number) {
            self.faults.push(
                Fault::new(
                    value.span(),
                    format!("{number} lies off the pad"),
                    "off the pad",
                )
                .help("places are shares of the pad: 0 is left or bottom, 1 is right or top"),
            );
        }
        number
    }

    /// A width, height or radius above zero.
    fn extent(
        &mut self,
        region: &Spanned<RegionSpec>,
        value: &Option<Spanned<f64>>,
        key: &str,
    ) -> f64 {
        let Some(value) = value else {
            let name = &region.get_ref().name;
            self.faults.push(Fault::new(
                name.span(),
                format!("the region `{}` needs `{key}`", name.get_ref()),
                "this region",
            ));
            return 1.0;
        };
        let number = *value.get_ref();
        if !(number > 0.0 && number <= 1.0) {
            self.faults.push(Fault::new(
                value.span(),
                format!("`{key}` must be above 0 and at most 1, the whole pad"),
                "here",
            ));
        }
        number
    }

    fn stays_on_pad(&mut self, value: &Option<Spanned<f64>>, end: f64, side: &str) {
        if let Some(value) = value
            && end > 1.0 + 1e-9
        {
            self.faults.push(
                Fault::new(
                    value.span(),
                    format!("the region ends at {end:.3}, off the pad on the {side}"),
                    "reaches off the pad",
                )
                .help("places are shares of the pad: 0 is left or bottom, 1 is right or top"),
            );
        }
    }

    fn refuse(&mut self, value: &Option<Spanned<f64>>, key: &str, shape: &str) {
        if let Some(value) = value {
            self.faults.push(Fault::new(
                value.span(),
                format!("a {shape} has no `{key}`"),
                "take this out",
            ));
        }
    }

    fn latch(&mut self, spec: &ProfileSpec) -> Latch {
        let mut frames = |value: &Option<Spanned<f64>>, default: f64| -> Nanos {
            let count = value.as_ref().map_or(default, |value| *value.get_ref());
            if !(1.0..=600.0).contains(&count) {
                let span = value.as_ref().map_or(0..0, Spanned::span);
                self.faults.push(Fault::new(
                    span,
                    format!("{count} is no length of a press: 1 to 600 frames"),
                    "here",
                ));
            }
            nanos_from_ms(count * 1000.0 / NES_FRAMES_PER_S)
        };
        Latch {
            short_ns: frames(&spec.short_frames, SHORT_FRAMES),
            long_ns: frames(&spec.long_frames, LONG_FRAMES),
            long_after_ns: self.time(&spec.long_ms, LONG_MS),
        }
    }

    fn time(&mut self, value: &Option<Spanned<f64>>, default_ms: f64) -> Nanos {
        let Some(value) = value else {
            return nanos_from_ms(default_ms);
        };
        let ms = *value.get_ref();
        if !(0.0..=LONGEST_MS).contains(&ms) {
            self.faults.push(Fault::new(
                value.span(),
                format!("{ms} ms is no time here: 0 to {LONGEST_MS} ms"),
                "here",
            ));
        }
        nanos_from_ms(ms)
    }

    fn binding(
        &mut self,
        spec: &BindingSpec,
        regions: &[Region],
        latch: Latch,
        outputs: &mut Vec<Output>,
    ) -> Option<Binding> {
        let wanted = spec.region.get_ref();
        let region = regions.iter().position(|region| region.name == *wanted);
        if region.is_none() {
            let fault = Fault::new(
                spec.region.span(),
                format!("no region is named `{wanted}`"),
                "not a region of this profile",
            );
            self.faults.push(with_suggestion(
                fault,
                nearest(wanted, regions.iter().map(|region| region.name.as_str())),
            ));
        }
        let output = match spec.output.get_ref().parse::<Output>() {
            Ok(output) => Some(output),
            Err(unknown) => {
                let fault = Fault::new(spec.output.span(), unknown.to_string(), "not known");
                let fault = match unknown.suggestion {
                    Some(name) => fault.help(format!("did you mean `{name}`?")),
                    None => fault.help(NAMES),
                };
                self.faults.push(fault);
                None
            }
        };
        let output = output?;
        let index = outputs
            .iter()
            .position(|known| *known == output)
            .unwrap_or_else(|| {
                outputs.push(output);
                outputs.len() - 1
            });
        Some(Binding {
            region: region?,
            mode: match spec.mode {
                ModeSpec::Direct => Mode::Direct,
                ModeSpec::Classified => Mode::Classified(latch),
            },
            output: index,
        })
    }
}

fn with_suggestion(fault: Fault, suggestion: Option<String>) -> Fault {
    match suggestion {
        Some(name) => fault.help(format!("did you mean `{name}`?")),
        None => fault,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::{DEFAULT_PROFILE, shipped_profile};

    /// What is said of the default profile with one passage replaced: `line:column: message` a fault.
    fn said_of(from: &str, to: &str) -> String {
        let text = shipped_profile(DEFAULT_PROFILE).expect("shipped").toml;
        assert!(text.contains(from), "the profile's text holds `{from}`");
        let faulty =
            Profile::from_toml("p.toml", &text.replacen(from, to, 1)).expect_err("refused");
        let fault = &faulty.faults[0];
        format!("{} <{}>", fault.message, &faulty.text[fault.span.clone()])
    }

    #[test]
    fn mistakes_point_at_their_word() {
        let cases: &[(&str, &str, &str)] = &[
            ("schema = 1", "schema = 7", "schema 7 is not known <7>"),
            (
                "min_hold_ms",
                "min_hold",
                "unknown field `min_hold`, expected one of `schema`, `name`, `about`, `method`, `min_hold_ms`, `min_gap_ms`, `long_ms`, `short_frames`, `long_frames`, `region`, `binding` <min_hold>",
            ),
            ("x = 0.02", "x = 1.02", "1.02 lies off the pad <1.02>"),
            (
                "w = 0.22",
                "w = 0.99",
                "the region ends at 1.010, off the pad on the right <0.99>",
            ),
            (
                "w = 0.22",
                "r = 0.22",
                "the region `left` needs `w` <\"left\">",
            ),
            (
                "region = \"jump\"",
                "region = \"jmup\"",
                "no region is named `jmup` <\"jmup\">",
            ),
            (
                "output = \"key:f\"",
                "output = \"key:ff\"",
                "no key is named `ff` <\"key:ff\">",
            ),
            (
                "output = \"key:f\"",
                "output = \"f\"",
                "`f` names no device: write `key:NAME` for a key or `pad:NAME` for a gamepad button <\"f\">",
            ),
            (
                "mode = \"direct\"\noutput",
                "mode = \"drect\"\noutput",
                "unknown variant `drect`, expected `direct` or `classified` <\"drect\">",
            ),
            (
                "min_hold_ms = 34",
                "min_hold_ms = -1",
                "-1 ms is no time here: 0 to 60000 ms <-1>",
            ),
            (
                "name = \"right\"",
                "name = \"left\"",
                "two regions are named `left` <\"left\">",
            ),
        ];
        for (from, to, said) in cases {
            assert_eq!(&said_of(from, to), said, "{to}");
        }
    }

    #[test]
    fn every_mistake_is_told_at_once() {
        let text = "schema = 1\nname = \"x\"\n[[binding]]\nregion = \"a\"\noutput = \"key:b1\"\n";
        let faulty = Profile::from_toml("x.toml", text).expect_err("two mistakes");
        assert_eq!(
            faulty.to_string(),
            "x.toml:4:10: no region is named `a`\nx.toml:5:10: no key is named `b1`"
        );
    }
}
