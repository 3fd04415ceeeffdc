//! The report of the protocol study.

use super::fewest::{Remainder, fewest, leave_out};
use super::information::PressInformation;
use super::order::{DriveOrder, OrderSearch};
use super::{ProtocolStudy, texts};
use crate::pad::{Channel, Protocol};
use crate::stats::quantile;
use crate::study::figure::{Chart, Series, short};
use crate::study::report::{Report, Table};
use crate::study::{CommandLine, StudyError};

/// Delays are given for a board of this many frames a second.
const FRAMES_PER_S: f64 = 10.0;
/// Rows of the tables of readings and drives.
const ROWS: usize = 12;
/// Share of the presses, or fingers, that the tables give beside the mean.
const MOST: f64 = 0.95;

/// What the search found.
struct Found {
    /// The drives one after another, as the pad's text lists them; by the best step; the best order.
    orders: Vec<(String, DriveOrder)>,
    /// Readings, and whole drives, left out one after another.
    readings: Vec<Remainder>,
    drives: Vec<Remainder>,
    /// The fewest readings, with their drives in their own best order; `None` if all miss the accuracy.
    fewest: Option<Protocol>,
}

impl ProtocolStudy {
    pub(super) fn build_report(&self, fingers: &[PressInformation]) -> Result<Report, StudyError> {
        let found = self.search(fingers)?;
        let command = self.command();
        Ok(Report {
            title: "Protocol study: which drives first, and which readings to leave out".to_owned(),
            version: self.settings.version.clone(),
            seed: Some(self.settings.seed),
            advice: self.advice(&found),
            method: vec![self.method(fingers.len())],
            tables: vec![
                order_table(&found),
                self.remainder_table("Fewest readings", &found.readings, "readings"),
                self.remainder_table("Fewest drives", &found.drives, "drives"),
            ],
            csvs: vec![
                order_table(&found).titled("order"),
                all_remainders("readings", &found.readings),
                all_remainders("drives", &found.drives),
            ],
            figures: vec![self.chart(&found).draw()?],
            files: self.files(&found, &command)?,
            command,
        })
    }

    fn search(&self, fingers: &[PressInformation]) -> Result<Found, StudyError> {
        let protocol = &self.pad.protocol;
        let prior = self.prior();
        let of_drives = channels_by_drive(protocol);
        let search = OrderSearch::new(fingers, prior, &of_drives);
        let strides = search.strides();
        let by_step =
            |a: &&(usize, DriveOrder), b: &&(usize, DriveOrder)| a.1.mean().total_cmp(&b.1.mean());
        let mut orders = Vec::new();
        if let (Some(first), Some((step, best))) = (strides.first(), strides.iter().min_by(by_step))
        {
            orders.push(("one after another".to_owned(), first.1.clone()));
            orders.push((format!("every {step}th, round and round"), best.clone()));
        }
        orders.push(("found".to_owned(), search.best()));

        let channels = fingers.first().map_or(0, PressInformation::channels);
        let single: Vec<Vec<usize>> = (0..channels).map(|channel| vec![channel]).collect();
        let readings = leave_out(fingers, &prior, &single);
        let kept = fewest(&readings, self.settings.keep_mm);
        let fewest = kept.map(|kept| {
            let of_drives = channels_by_drive(protocol)
                .into_iter()
                .map(|drive| {
                    drive
                        .into_iter()
                        .filter(|c| kept.groups.contains(c))
                        .collect()
                })
                .filter(|drive: &Vec<usize>| !drive.is_empty())
                .collect::<Vec<_>>();
            let order = OrderSearch::new(fingers, prior, &of_drives).best().order;
            let channels = order.iter().flat_map(|drive| &of_drives[*drive]);
            let channels: Vec<Channel> = channels.map(|c| protocol.channels[*c]).collect();
            Protocol::from_channels(protocol.electrodes, channels)
        });
        Ok(Found {
            orders,
            fewest: fewest.transpose().map_err(StudyError::internal)?,
            drives: leave_out(fingers, &prior, &of_drives),
            readings,
        })
    }

    /// The shell command that repeats the study.
    #[must_use]
    pub fn command(&self) -> String {
        let settings = &self.settings;
        CommandLine::new("study protocol", &settings.pad)
            .option("seed", settings.seed)
            .option("snr", settings.snr_db)
            .option("keep", settings.keep_mm)
            .flag("quick", settings.quick)
            .finish()
    }

    fn advice(&self, found: &Found) -> Vec<String> {
        let mut advice = Vec::new();
        if let [(_, first), .., (_, best)] = found.orders.as_slice() {
            let numbers: Vec<String> = best.order.iter().map(usize::to_string).collect();
            let ms = |order: &DriveOrder| short(milliseconds(order.mean(), order.order.len()));
            advice.push(format!(
                "Read the drives in the order {}: a press is placed after {} drives on average ({:.0} % of presses after {}), instead of {} \
                 ({}) when they are read one after another. At {FRAMES_PER_S} frames/s that is {} ms instead of {} ms. pad-order.toml is \
                 the pad with this order, readings.h the table for the board's firmware.",
                numbers.join(", "),
                short(best.mean()),
                100.0 * MOST,
                short(best.quantile(MOST)),
                short(first.mean()),
                short(first.quantile(MOST)),
                ms(best),
                ms(first),
            ));
        }
        let settings = &self.settings;
        let all = found
            .readings
            .first()
            .map_or((0, f64::NAN), |all| (all.readings, all.mean_mm()));
        advice.push(match &found.fewest {
            Some(protocol) => format!(
                "{} of {} readings keep a mean error of {} mm at {} dB ({} mm with all of them): such a frame takes {:.0} % of the time on a \
                 board that takes one reading after another. pad-fewest.toml lists them, readings-fewest.h is the table. These are bounds \
                 for a pad that equals its model: check with `gelpad accuracy --pad DIR/pad-fewest.toml --snr {} --out DIR/check`.",
                protocol.channels.len(),
                all.0,
                settings.keep_mm,
                settings.snr_db,
                short(all.1),
                100.0 * protocol.channels.len() as f64 / all.0 as f64,
                settings.snr_db,
            ),
            None => format!(
                "All {} readings together give a mean error of {} mm at {} dB: no choice of them keeps {} mm.",
                all.0,
                short(all.1),
                settings.snr_db,
                settings.keep_mm
            ),
        });
        advice
    }

    fn method(&self, fingers: usize) -> String {
        format!(
            "{fingers} random fingers (radius 5 to 9 mm, rise 50 to 200 %) on the pad as its text describes it, noise proportional to each \
             reading. Fisher information of place, radius and rise, with the spread of the drawn fingers as prior knowledge; errors are the \
             Cramer-Rao bound of the place. A press is placed when its readings differ from the untouched pad by more than noise does \
             and its place is known to 2.5 mm (root mean square); it may begin before any drive, and drives count from its begin. Orders \
             are improved by exchanging two drives, readings are left out one after another, each time the one that costs least: neither is \
             proven to be the very best. An order in the pad's text is ignored."
        )
    }

    fn remainder_table(&self, title: &str, remainders: &[Remainder], unit: &str) -> Table {
        let kept = fewest(remainders, self.settings.keep_mm);
        let count = remainders.len();
        let step = count.div_ceil(ROWS).max(1);
        let rows = remainders.iter().enumerate().filter(|(index, remainder)| {
            index.is_multiple_of(step) || Some(*remainder) == kept || index + 1 == count
        });
        Table::new(
            title,
            &[
                unit,
                "of a frame, %",
                "mean error, mm",
                "95 % of fingers, mm",
                "",
            ],
            rows.map(|(_, remainder)| {
                let note = if Some(remainder) == kept {
                    format!("fewest with {} mm", self.settings.keep_mm)
                } else {
                    String::new()
                };
                let share = remainder.readings as f64 / remainders[0].readings as f64;
                let bounds = remainder.bounds_mm.iter().copied();
                vec![
                    remainder.groups.len().to_string(),
                    format!("{:.0}", 100.0 * share),
                    format!("{:.2}", remainder.mean_mm()),
                    format!("{:.2}", quantile(bounds, MOST).unwrap_or(f64::NAN)),
                    note,
                ]
            }),
        )
    }

    fn chart(&self, found: &Found) -> Chart {
        let line = |name: &str, remainders: &[Remainder]| {
            let all = remainders.first().map_or(1, |all| all.readings) as f64;
            // Percent of the frame from 0 to 100 along x; each place takes the fewest readings that are not below it.
            let points = (1..=20).map(|twentieth| {
                let share = f64::from(twentieth) / 20.0;
                let at_least = |r: &&Remainder| r.readings as f64 >= share * all;
                let value = remainders
                    .iter()
                    .take_while(at_least)
                    .last()
                    .map_or(f64::NAN, Remainder::mean_mm);
                [value; 3]
            });
            Series {
                name: name.to_owned(),
                points: points.collect(),
                ..Series::default()
            }
        };
        Chart {
            name: "readings".to_owned(),
            title: format!("Readings left out ({} dB)", self.settings.snr_db),
            x_label: "share of a frame's readings, %".to_owned(),
            y_label: "mean bound of place, mm".to_owned(),
            places: (1..=20).map(|share| (5 * share).to_string()).collect(),
            series: vec![
                line("single readings", &found.readings),
                line("whole drives", &found.drives),
            ],
            ..Chart::default()
        }
    }

    fn files(&self, found: &Found, command: &str) -> Result<Vec<(String, String)>, StudyError> {
        let text = &self.text;
        let name = |suffix: &str| format!("{}-{suffix}", self.pad.name);
        let mut files = Vec::new();
        if let Some((_, best)) = found.orders.last() {
            let ordered = self.pad.protocol.with_drive_order(&best.order);
            let ordered = ordered.map_err(StudyError::internal)?;
            files.push((
                "pad-order.toml".to_owned(),
                texts::pad_with_order(text, &name("order"), &best.order)?,
            ));
            files.push((
                "readings.h".to_owned(),
                texts::firmware_table(&ordered, command),
            ));
        }
        if let Some(protocol) = &found.fewest {
            files.push((
                "pad-fewest.toml".to_owned(),
                texts::pad_with_channels(text, &name("fewest"), &protocol.channels)?,
            ));
            files.push((
                "readings-fewest.h".to_owned(),
                texts::firmware_table(protocol, command),
            ));
        }
        Ok(files)
    }
}

/// The channels of each drive, in the order of a frame.
fn channels_by_drive(protocol: &Protocol) -> Vec<Vec<usize>> {
    let drive_of = protocol.drives();
    let drives = drive_of.iter().max().map_or(0, |last| last + 1);
    let of_drive = |drive| {
        let channels = drive_of.iter().enumerate();
        channels
            .filter_map(move |(channel, of)| (*of == drive).then_some(channel))
            .collect()
    };
    (0..drives).map(of_drive).collect()
}

/// The time of a number of drives at [`FRAMES_PER_S`].
fn milliseconds(drives: f64, of: usize) -> f64 {
    1e3 / FRAMES_PER_S * drives / of as f64
}

fn order_table(found: &Found) -> Table {
    let at = format!("at {FRAMES_PER_S} frames/s: mean / 95 %, ms");
    Table::new(
        "Order of drives",
        &[
            "order",
            "drives until a press is placed: mean",
            "95 %",
            &at,
            "drives",
        ],
        found.orders.iter().map(|(name, order)| {
            let count = order.order.len();
            let most = order.quantile(MOST);
            let numbers: Vec<String> = order.order.iter().map(usize::to_string).collect();
            vec![
                name.clone(),
                format!("{:.2}", order.mean()),
                format!("{most:.0}"),
                format!(
                    "{:.1} / {:.1}",
                    milliseconds(order.mean(), count),
                    milliseconds(most, count)
                ),
                numbers.join(" "),
            ]
        }),
    )
}

/// Every step, for the CSV.
fn all_remainders(title: &str, remainders: &[Remainder]) -> Table {
    let rows = remainders.iter().map(|remainder| {
        let bounds = remainder.bounds_mm.iter().copied();
        vec![
            remainder.groups.len().to_string(),
            remainder.readings.to_string(),
            remainder.mean_mm().to_string(),
            quantile(bounds, MOST).unwrap_or(f64::NAN).to_string(),
        ]
    });
    Table::new(title, &[title, "values", "mean_mm", "p95_mm"], rows)
}
