//! Sizes and materials of the sensor and its presses that the paper does not give.

use serde::{Deserialize, Serialize};

/// Deepest press on a rigid table, as a share of the sensor's thickness.
pub(super) const MOST_ON_TABLE: f64 = 0.5;

/// Sizes and materials, with defaults.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ThicknessParameters {
    /// Thicknesses of the conducting layer, mm.
    pub layers_mm: Vec<f64>,
    /// Silicone below and above the layer, mm.
    pub cover_mm: f64,
    /// Silicone around the pad, mm.
    pub rim_mm: f64,
    /// Depths of the presses, mm.
    pub depths_mm: Vec<f64>,
    /// Further depths on a table, as shares of the sensor's thickness.
    pub table_shares: Vec<f64>,
    /// Radius of the flat indenter and of the local rise, mm.
    pub indenter_mm: f64,
    /// Young's modulus of the silicone, kPa.
    pub silicone_kpa: f64,
    /// Young's modulus of the hydrogel, kPa.
    pub hydrogel_kpa: f64,
    /// Poisson's ratio of silicone and hydrogel.
    pub poisson: f64,
    /// Young's modulus of the soft foundation, kPa; its Poisson's ratio is 0.3.
    pub foundation_kpa: f64,
    /// Thickness of the soft foundation, mm.
    pub foundation_mm: f64,
    /// Conductivity of the local rise, S/m.
    pub rise_s_per_m: f64,
}

impl Default for ThicknessParameters {
    fn default() -> Self {
        Self {
            layers_mm: vec![1.0, 2.0, 3.0, 4.0, 5.0],
            cover_mm: 1.0,
            rim_mm: 5.0,
            depths_mm: vec![2.0, 5.0],
            table_shares: vec![0.25, 0.5],
            indenter_mm: 5.0,
            // Data sheet of Ecoflex 00-30: 69 kPa at 100 % strain, which is 1.75 shear moduli of neo-Hookean rubber.
            silicone_kpa: 118.0,
            hydrogel_kpa: 20.0,
            poisson: 0.4999,
            foundation_kpa: 20.0,
            foundation_mm: 20.0,
            rise_s_per_m: 5.0,
        }
    }
}

impl ThicknessParameters {
    /// The options of `gelpad study thickness` and their values.
    pub(super) fn options(&self) -> [(&'static str, String); 11] {
        let list = |values: &[f64]| {
            let texts: Vec<String> = values.iter().map(f64::to_string).collect();
            texts.join(",")
        };
        [
            ("layers", list(&self.layers_mm)),
            ("depths", list(&self.depths_mm)),
            ("table-shares", list(&self.table_shares)),
            ("indenter-mm", self.indenter_mm.to_string()),
            ("cover-mm", self.cover_mm.to_string()),
            ("silicone-kpa", self.silicone_kpa.to_string()),
            ("hydrogel-kpa", self.hydrogel_kpa.to_string()),
            ("poisson", self.poisson.to_string()),
            ("foundation-kpa", self.foundation_kpa.to_string()),
            ("foundation-mm", self.foundation_mm.to_string()),
            ("rise", self.rise_s_per_m.to_string()),
        ]
    }

    /// Returns why the parameters are invalid, if they are.
    pub(super) fn check(&self) -> Result<(), String> {
        let positive = |name: &str, values: &[f64]| {
            let is_wrong = |value: &&f64| !(value.is_finite() && **value > 0.0);
            match values.iter().find(is_wrong) {
                _ if values.is_empty() => Err(format!("{name}: give at least one")),
                Some(wrong) => Err(format!("{name}: {wrong} is not above zero")),
                None => Ok(()),
            }
        };
        positive("layers", &self.layers_mm)?;
        positive("depths", &self.depths_mm)?;
        positive("table shares", &self.table_shares)?;
        positive(
            "sizes and moduli",
            &[
                self.cover_mm,
                self.rim_mm,
                self.indenter_mm,
                self.silicone_kpa,
                self.hydrogel_kpa,
                self.foundation_kpa,
                self.foundation_mm,
                self.rise_s_per_m,
            ],
        )?;
        if let Some(deep) = self
            .table_shares
            .iter()
            .find(|share| **share > MOST_ON_TABLE)
        {
            return Err(format!(
                "table shares: {deep} is more than the {MOST_ON_TABLE} that a rigid table leaves room for"
            ));
        }
        if !(0.0..0.5).contains(&self.poisson) {
            let ratio = self.poisson;
            return Err(format!("Poisson's ratio {ratio} is not within 0 and 0.5"));
        }
        Ok(())
    }
}
