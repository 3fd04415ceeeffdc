//! A study's folder for people: `report.html` (pictures inside), `report.md`, every number as CSV, every figure as SVG
//! and PNG.

use std::fmt::Write as _;
use std::path::Path;

use super::StudyError;
use super::figure::Figure;
use super::job::write_whole;

/// A table of texts.
#[derive(Clone, Debug)]
pub struct Table {
    /// Its title; of a CSV, the file's name without ending.
    pub title: String,
    /// Names of the columns.
    pub head: Vec<String>,
    /// Rows.
    pub rows: Vec<Vec<String>>,
}

/// All that a study tells.
#[derive(Clone, Debug)]
pub struct Report {
    /// Its title.
    pub title: String,
    /// The command that makes it again.
    pub command: String,
    /// Version of gelpad.
    pub version: String,
    /// Seed.
    pub seed: u64,
    /// What was done and what it shows.
    pub paragraphs: Vec<String>,
    /// Tables of the report.
    pub tables: Vec<Table>,
    /// Tables that are written as CSV only.
    pub csvs: Vec<Table>,
    /// Figures.
    pub figures: Vec<Figure>,
}

impl Report {
    /// Writes all files into a folder that is there.
    ///
    /// # Errors
    /// The disk.
    pub fn write(&self, folder: &Path) -> Result<(), StudyError> {
        for table in &self.csvs {
            write_whole(
                folder,
                &format!("{}.csv", table.title),
                table.csv()?.as_slice(),
            )?;
        }
        for figure in &self.figures {
            write_whole(
                folder,
                &format!("{}.svg", figure.name),
                figure.svg.as_bytes(),
            )?;
            write_whole(folder, &format!("{}.png", figure.name), &figure.png)?;
        }
        write_whole(folder, "report.md", self.markdown().as_bytes())?;
        write_whole(folder, "report.html", self.html().as_bytes())
    }

    fn made_by(&self) -> String {
        format!("gelpad {}, seed {}", self.version, self.seed)
    }

    fn markdown(&self) -> String {
        let mut text = format!(
            "# {}\n\n```sh\n{}\n```\n\n{}\n",
            self.title,
            self.command,
            self.made_by()
        );
        for paragraph in &self.paragraphs {
            let _ = write!(text, "\n{paragraph}\n");
        }
        for table in &self.tables {
            let _ = write!(
                text,
                "\n## {}\n\n| {} |\n|{}\n",
                table.title,
                cells(&table.head),
                " --- |".repeat(table.head.len())
            );
            for row in &table.rows {
                let _ = writeln!(text, "| {} |", cells(row));
            }
        }
        for figure in &self.figures {
            let _ = write!(text, "\n![{}]({}.svg)\n", figure.caption, figure.name);
        }
        text
    }

    fn html(&self) -> String {
        let mut text = format!(
            "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{title}</title>\n<style>\n\
             body {{ font: 16px/1.5 sans-serif; max-width: 72rem; margin: 2rem auto; padding: 0 1rem; color: #111; background: #fff }}\n\
             table {{ border-collapse: collapse }} td, th {{ border: 1px solid #bbb; padding: .3rem .6rem; text-align: right }}\n\
             td:first-child, th:first-child {{ text-align: left }} pre {{ background: #eee; padding: .6rem }}\n\
             figure {{ margin: 1.5rem 0 }} figure svg {{ max-width: 100%; height: auto }}\n\
             </style>\n<h1>{title}</h1>\n<pre>{command}</pre>\n<p>{made_by}</p>\n",
            title = escaped(&self.title),
            command = escaped(&self.command),
            made_by = escaped(&self.made_by()),
        );
        for paragraph in &self.paragraphs {
            let _ = writeln!(text, "<p>{}</p>", escaped(paragraph));
        }
        for table in &self.tables {
            let row = |cells: &[String], tag: &str| -> String {
                cells
                    .iter()
                    .map(|cell| format!("<{tag}>{}</{tag}>", escaped(cell)))
                    .collect()
            };
            let _ = write!(
                text,
                "<h2>{}</h2>\n<table>\n<tr>{}</tr>\n",
                escaped(&table.title),
                row(&table.head, "th")
            );
            for cells in &table.rows {
                let _ = writeln!(text, "<tr>{}</tr>", row(cells, "td"));
            }
            text.push_str("</table>\n");
        }
        for figure in &self.figures {
            let _ = writeln!(
                text,
                "<figure role=\"img\" aria-label=\"{}\">\n{}\n</figure>",
                escaped(&figure.caption),
                figure.svg
            );
        }
        text.push_str("</html>\n");
        text
    }
}

impl Table {
    fn csv(&self) -> Result<Vec<u8>, StudyError> {
        let failed = |error: &dyn std::fmt::Display| StudyError::Internal(error.to_string());
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer
            .write_record(&self.head)
            .map_err(|error| failed(&error))?;
        for row in &self.rows {
            writer.write_record(row).map_err(|error| failed(&error))?;
        }
        writer.into_inner().map_err(|error| failed(&error))
    }
}

/// Cells of a markdown row; a bar in a text would end its cell.
fn cells(texts: &[String]) -> String {
    texts
        .iter()
        .map(|text| text.replace('|', "\\|"))
        .collect::<Vec<_>>()
        .join(" | ")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
