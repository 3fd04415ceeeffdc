//! The report of a study: `report.html` (self-contained), `report.md`, every number as CSV, every figure as SVG and PNG.

use std::fmt::Write as _;
use std::path::Path;

use super::StudyError;
use super::figure::Figure;
use super::folder::write_whole;

/// A table of texts.
#[derive(Clone, Debug)]
pub struct Table {
    /// Its title; for a CSV, the file's name without ending.
    pub title: String,
    /// Names of the columns.
    pub head: Vec<String>,
    /// Rows, each as long as `head`.
    pub rows: Vec<Vec<String>>,
}

/// A report. It opens with the advice; how the numbers were made comes last.
#[derive(Clone, Debug)]
pub struct Report {
    /// Its title.
    pub title: String,
    /// The shell command that repeats the study.
    pub command: String,
    /// Version of gelpad.
    pub version: String,
    /// Seed of everything random; `None` if nothing is.
    pub seed: Option<u64>,
    /// What to do, and why: one paragraph each.
    pub advice: Vec<String>,
    /// Method and assumptions: one paragraph each.
    pub method: Vec<String>,
    /// Tables of the report.
    pub tables: Vec<Table>,
    /// Tables that are written as CSV only.
    pub csvs: Vec<Table>,
    /// Figures.
    pub figures: Vec<Figure>,
    /// Texts beside the report: file name and content.
    pub files: Vec<(String, String)>,
}

impl Report {
    /// Writes all files into an existing folder.
    ///
    /// # Errors
    /// A disk that is full or read-only.
    pub fn write(&self, folder: &Path) -> Result<(), StudyError> {
        let write = |name: &str, bytes: &[u8]| write_whole(folder, name, bytes);
        for table in &self.csvs {
            write(&format!("{}.csv", table.title), &table.csv()?)?;
        }
        for figure in &self.figures {
            write(&format!("{}.svg", figure.name), figure.svg.as_bytes())?;
            write(&format!("{}.png", figure.name), &figure.png)?;
        }
        for (name, text) in &self.files {
            write(name, text.as_bytes())?;
        }
        write("report.md", self.markdown().as_bytes())?;
        write("report.html", self.html().as_bytes())
    }

    fn made_by(&self) -> String {
        match self.seed {
            Some(seed) => format!("gelpad {}, seed {seed}", self.version),
            None => format!("gelpad {}", self.version),
        }
    }

    fn markdown(&self) -> String {
        let mut text = format!("# {}\n", self.title);
        for paragraph in &self.advice {
            let _ = write!(text, "\n{paragraph}\n");
        }
        for table in &self.tables {
            let _ = write!(
                text,
                "\n## {}\n\n{}|{}\n",
                table.title,
                markdown_row(&table.head),
                " --- |".repeat(table.head.len())
            );
            text.extend(table.rows.iter().map(|row| markdown_row(row)));
        }
        for figure in &self.figures {
            let _ = write!(text, "\n![{}]({}.svg)\n", figure.caption, figure.name);
        }
        text.push_str("\n## Method\n");
        for paragraph in &self.method {
            let _ = write!(text, "\n{paragraph}\n");
        }
        let _ = write!(
            text,
            "\n```sh\n{}\n```\n\n{}\n",
            self.command,
            self.made_by()
        );
        text
    }

    fn html(&self) -> String {
        let mut text = format!(
            "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{title}</title>\n<style>\n\
             body {{ font: 16px/1.5 sans-serif; max-width: 72rem; margin: 2rem auto; padding: 0 1rem; color: #111; background: #fff }}\n\
             table {{ border-collapse: collapse }} td, th {{ border: 1px solid #bbb; padding: .3rem .6rem; text-align: right }}\n\
             td:first-child, th:first-child {{ text-align: left }} pre {{ background: #eee; padding: .6rem }}\n\
             figure {{ margin: 1.5rem 0 }} figure svg {{ max-width: 100%; height: auto }}\n\
             </style>\n<h1>{title}</h1>\n",
            title = escaped(&self.title),
        );
        push_paragraphs(&mut text, &self.advice);
        for table in &self.tables {
            let _ = write!(
                text,
                "<h2>{}</h2>\n<table>\n{}",
                escaped(&table.title),
                html_row(&table.head, "th")
            );
            text.extend(table.rows.iter().map(|row| html_row(row, "td")));
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
        text.push_str("<h2>Method</h2>\n");
        push_paragraphs(&mut text, &self.method);
        let _ = write!(
            text,
            "<pre>{}</pre>\n<p>{}</p>\n</html>\n",
            escaped(&self.command),
            escaped(&self.made_by())
        );
        text
    }
}

impl Table {
    /// A table from its parts.
    pub(super) fn new(
        title: impl Into<String>,
        head: &[&str],
        rows: impl IntoIterator<Item = Vec<String>>,
    ) -> Self {
        Self {
            title: title.into(),
            head: head.iter().map(|&name| name.to_owned()).collect(),
            rows: rows.into_iter().collect(),
        }
    }

    /// The same table under another title.
    pub(super) fn titled(self, title: &str) -> Self {
        Self {
            title: title.to_owned(),
            ..self
        }
    }

    fn csv(&self) -> Result<Vec<u8>, StudyError> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        for row in std::iter::once(&self.head).chain(&self.rows) {
            writer.write_record(row).map_err(StudyError::internal)?;
        }
        writer.into_inner().map_err(StudyError::internal)
    }
}

/// A row; a bar in a text would end its cell.
fn markdown_row(cells: &[String]) -> String {
    let cells: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
    format!("| {} |\n", cells.join(" | "))
}

fn html_row(cells: &[String], tag: &str) -> String {
    let cells: String = cells
        .iter()
        .map(|cell| format!("<{tag}>{}</{tag}>", escaped(cell)))
        .collect();
    format!("<tr>{cells}</tr>\n")
}

fn push_paragraphs(text: &mut String, paragraphs: &[String]) {
    for paragraph in paragraphs {
        let _ = writeln!(text, "<p>{}</p>", escaped(paragraph));
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
