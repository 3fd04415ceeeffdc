//! Machine-readable results: JSON, and CSV by subject. Shares are 0 to 1; a cell without a number is empty.

use super::{Findings, Share, Spread};
use crate::study::StudyError;
use crate::study::report::Table;

impl Findings {
    /// All findings as JSON.
    ///
    /// # Errors
    /// A defect of gelpad.
    pub fn json(&self) -> Result<String, StudyError> {
        let mut text = serde_json::to_string_pretty(self).map_err(StudyError::internal)?;
        text.push('\n');
        Ok(text)
    }

    /// The tables that are written as CSV.
    pub(super) fn csvs(&self) -> Vec<Table> {
        vec![
            self.touches_csv(),
            self.pairs_csv(),
            self.shapes_csv(),
            self.bound_csv(),
            self.images_csv(),
        ]
    }

    fn touches_csv(&self) -> Table {
        let mut names = head(&["touches", "noise", "snr_db"]);
        names.extend(share_names("counted_right"));
        names.extend(head(&["drawn", "missed", "false_touches", "found"]));
        for (figure, unit) in [
            ("place_error", "_mm"),
            ("place_bound", "_mm"),
            ("force_error", ""),
            ("force_bound", ""),
        ] {
            names.extend(spread_names(figure, unit));
        }
        let rows = self.touches.iter().map(|found| {
            let mut row = vec![
                found.touches.to_string(),
                found.noise.name().to_owned(),
                cell(found.snr_db),
            ];
            row.extend(share_cells(&found.counted_right));
            let counts = [
                found.drawn,
                found.missed,
                found.false_touches,
                found.place_error_mm.n,
            ];
            row.extend(counts.map(|count| count.to_string()));
            for spread in [
                &found.place_error_mm,
                &found.place_bound_mm,
                &found.force_error,
                &found.force_bound,
            ] {
                row.extend(spread_cells(spread));
            }
            row
        });
        table("accuracy", names, rows)
    }

    fn pairs_csv(&self) -> Table {
        let mut names = head(&["distance_mm"]);
        names.extend(share_names("told_apart"));
        names.extend(head(&["counted_two", "counted_one"]));
        names.extend(spread_names("place_bound", "_mm"));
        let rows = self.discrimination.pairs.iter().map(|pair| {
            let mut row = vec![cell(pair.distance_mm)];
            row.extend(share_cells(&pair.told_apart));
            row.extend([pair.counted_two.hits, pair.counted_one.hits].map(|n| n.to_string()));
            row.extend(spread_cells(&pair.place_bound_mm));
            row
        });
        table("discrimination", names, rows)
    }

    fn shapes_csv(&self) -> Table {
        let mut names = head(&["shape"]);
        names.extend(share_names("split"));
        names.extend(head(&["missed"]));
        let rows = self.discrimination.single_shapes.iter().map(|single| {
            let mut row = vec![single.shape.name().to_owned()];
            row.extend(share_cells(&single.split));
            row.push(single.missed.hits.to_string());
            row
        });
        table("shapes", names, rows)
    }

    fn bound_csv(&self) -> Table {
        let names = head(&[
            "x_mm",
            "y_mm",
            "draws",
            "missed",
            "false_touches",
            "rmse_mm",
            "bound_mm",
            "ratio",
        ]);
        let rows = self.bound.places.iter().map(|place| {
            let mut row: Vec<String> = place.place_mm.map(cell).to_vec();
            row.extend([place.draws, place.missed, place.false_touches].map(|n| n.to_string()));
            row.extend([place.rmse_mm, place.bound_mm, place.ratio].map(cell));
            row
        });
        table("bound", names, rows)
    }

    fn images_csv(&self) -> Table {
        let names = head(&[
            "noise",
            "snr_db",
            "draws",
            "amplitude_response",
            "place_error_mm",
            "resolution",
            "shape_deformation",
            "ringing",
        ]);
        let rows = self.images.iter().map(|image| {
            let merit = &image.median;
            let mut row = vec![
                image.noise.name().to_owned(),
                cell(image.snr_db),
                image.n.to_string(),
            ];
            let figures = [
                merit.amplitude_response,
                merit.place_error_mm,
                merit.resolution,
                merit.shape_deformation,
                merit.ringing,
            ];
            row.extend(figures.map(cell));
            row
        });
        table("images", names, rows)
    }
}

fn head(names: &[&str]) -> Vec<String> {
    names.iter().map(|&name| name.to_owned()).collect()
}

fn table(title: &str, head: Vec<String>, rows: impl Iterator<Item = Vec<String>>) -> Table {
    Table {
        title: title.to_owned(),
        head,
        rows: rows.collect(),
    }
}

fn cell(value: f64) -> String {
    if value.is_finite() {
        value.to_string()
    } else {
        String::new()
    }
}

fn share_names(figure: &str) -> [String; 4] {
    [
        figure.to_owned(),
        "draws".to_owned(),
        format!("{figure}_low"),
        format!("{figure}_high"),
    ]
}

/// Cells of [`share_names`]: hits, draws, and the interval of the share.
fn share_cells(share: &Share) -> [String; 4] {
    [
        share.hits.to_string(),
        share.n.to_string(),
        cell(share.low),
        cell(share.high),
    ]
}

fn spread_names(figure: &str, unit: &str) -> [String; 4] {
    ["mean", "median", "p95", "rms"].map(|name| format!("{figure}_{name}{unit}"))
}

/// Cells of [`spread_names`].
fn spread_cells(spread: &Spread) -> [String; 4] {
    [spread.mean, spread.median, spread.p95, spread.rms].map(cell)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_in_the_order_of_their_names() {
        let share = Share::new(3, 4);
        assert_eq!(share_names("split")[..2], ["split", "draws"]);
        assert_eq!(share_cells(&share)[..2], ["3", "4"]);
        assert_eq!(
            spread_names("place_error", "_mm"),
            [
                "place_error_mean_mm",
                "place_error_median_mm",
                "place_error_p95_mm",
                "place_error_rms_mm"
            ]
        );
        assert_eq!(
            spread_cells(&Spread::new([2.0, 2.0]))[..],
            ["2", "2", "2", "2"]
        );
        assert_eq!(spread_cells(&Spread::new([]))[0], "", "no number");
    }
}
