//! A new pad from a few numbers: its text, checked as every pad is. No drawing.

use crate::pad::Pad;
use crate::types::SourceErrors;

/// Outline of a pad.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outline {
    /// A rectangle with a size.
    Rectangle,
    /// A circle; its diameter is the width.
    Circle,
}

/// What the player says about a pad.
#[derive(Clone, Debug, PartialEq)]
pub struct PadForm {
    /// Its name, and that of its file.
    pub name: String,
    /// Its outline.
    pub outline: Outline,
    /// Width, or diameter of a circle, mm.
    pub width_mm: f64,
    /// Height of a rectangle, mm.
    pub height_mm: f64,
    /// Channels in both directions, or a solid layer. Rectangles only.
    pub is_lattice: bool,
    /// Channels in each direction.
    pub lines: u32,
    /// Width of the channels, mm.
    pub channel_mm: f64,
    /// Number of electrodes at the edge.
    pub electrodes: u32,
    /// Width of an electrode, mm.
    pub electrode_mm: f64,
    /// Drive: `adjacent`, `opposite` or `skip-K`.
    pub drive: &'static str,
    /// Whether the board sends each pair of channels in both directions.
    pub is_full: bool,
}

/// Drives to choose from.
pub const DRIVES: [&str; 4] = ["adjacent", "opposite", "skip-1", "skip-2"];

impl Default for PadForm {
    fn default() -> Self {
        Self {
            name: "my-pad".to_owned(),
            outline: Outline::Rectangle,
            width_mm: 100.0,
            height_mm: 100.0,
            is_lattice: true,
            lines: 11,
            channel_mm: 2.0,
            electrodes: 16,
            electrode_mm: 3.0,
            drive: DRIVES[0],
            is_full: true,
        }
    }
}

impl PadForm {
    /// The text of the pad, to be edited further.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let outline = match self.outline {
            Outline::Rectangle => format!(
                "shape = \"rectangle\"\nwidth_mm = {:?}\nheight_mm = {:?}",
                self.width_mm, self.height_mm
            ),
            Outline::Circle => {
                format!("shape = \"circle\"\nradius_mm = {:?}", self.width_mm / 2.0)
            }
        };
        let lattice = if self.has_lattice() {
            format!(
                "\n[lattice]\nwidth_mm = {:?}\nx_lines = {lines}\ny_lines = {lines}\nmargin_mm = 0.0\n",
                self.channel_mm,
                lines = self.lines
            )
        } else {
            String::new()
        };
        let name = toml_edit::Value::from(self.name.trim());
        format!(
            "# Lengths in millimetres. `gelpad pad show` and docs/pads.md explain the rest.\n\
             schema = 1\nname ={name}\nabout = \"{count} electrodes, {drive} drive\"\n\n\
             touch_sign = \"rise\"\n\n[outline]\n{outline}\n\n\
             [layer]\nthickness_mm = 2.0\nbackground_s_per_m = 1.0\n{lattice}\n\
             [electrodes]\ncount = {count}\nwidth_mm = {width:?}\ncontact_impedance_ohm_m2 = 1e-6\n\n\
             [protocol]\nstimulation = \"{drive}\"\nmeasurement = \"adjacent\"\nreadings = \"{readings}\"\n",
            name = name.decorated(" ", ""),
            count = self.electrodes,
            width = self.electrode_mm,
            drive = self.drive,
            readings = if self.is_full { "full" } else { "half" },
        )
    }

    /// The pad that the text describes.
    ///
    /// # Errors
    /// What is wrong with the numbers.
    pub fn pad(&self) -> Result<Pad, SourceErrors> {
        Pad::from_toml(&self.name, &self.to_toml())
    }

    /// Whether channels are written: circles are solid.
    #[must_use]
    pub fn has_lattice(&self) -> bool {
        self.is_lattice && self.outline == Outline::Rectangle
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pads_of_every_outline_and_drive_are_valid() {
        for outline in [Outline::Rectangle, Outline::Circle] {
            for electrodes in [8, 16, 32] {
                for drive in DRIVES {
                    let form = PadForm {
                        name: "a \"pad\"".to_owned(),
                        outline,
                        electrodes,
                        drive,
                        ..PadForm::default()
                    };
                    let pad = form
                        .pad()
                        .unwrap_or_else(|error| panic!("{form:?}: {error}"));
                    assert_eq!(pad.name, "a \"pad\"");
                    assert_eq!(pad.electrodes.len(), electrodes as usize);
                }
            }
        }
    }

    #[test]
    fn a_square_pad_with_32_electrodes_sends_928_readings() {
        let form = PadForm {
            electrodes: 32,
            ..PadForm::default()
        };
        assert_eq!(form.pad().expect("valid").channels(), 928);
    }

    #[test]
    fn electrodes_that_do_not_fit_are_a_mistake() {
        let form = PadForm {
            electrodes: 64,
            electrode_mm: 30.0,
            ..PadForm::default()
        };
        assert!(form.pad().is_err());
    }
}
