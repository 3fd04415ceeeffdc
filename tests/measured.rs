//! gelpad on published measurements: tanks and skins that it was not made for.
//!
//! The data has no licence, so it is not in the repository: it is read from `GELPAD_DATA`. If that is not set, the trials are
//! ignored, with the reason as their kind; with `GELPAD_TEST_ALL=1` they fail, unless it is set to an empty text.
//! `GELPAD_FULL=1` runs all five splits of the skins at all sizes instead of a sample (minutes;
//! `scripts/hydrogel-presses.sh` does the same through the command line).

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::sync::Arc;

use anyhow::{Context, Result, bail, ensure};
use gelpad::calibrate::{Press, Presses, Regression};
use gelpad::eit::order::{Layout, recognise_order};
use gelpad::eit::{Imager, Reconstruction};
use gelpad::pad::{Pad, TouchSign, shipped_pad};
use gelpad::source::eit_text::EitFrame;
use gelpad::source::{SourceReading, open_file};
use gelpad::types::{Frame, Image, Method};
use libtest_mimic::{Arguments, Failed, Trial};

const ELECTRODES: usize = 16;

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let trials = vec![
        trial("pyeidors_tank", "pyeidors-tank", pyeidors_tank),
        trial("sciospec_tank", "sciospec-tank", sciospec_tank),
        trial("sciospec_source", "sciospec-tank", sciospec_source),
        trial("pyeidors_source", "pyeidors-tank", pyeidors_source),
        trial("skin_without_pattern", "hydrogel-presses", |folder| {
            skin(folder, "noPattern", [4.2, 1.8, 1.25])
        }),
        trial("skin_of_parallel_channels", "hydrogel-presses", |folder| {
            skin(folder, "parallel", [5.0, 2.1, 1.4])
        }),
        trial("skins_play", "hydrogel-presses", skins_play),
    ];
    libtest_mimic::run(&arguments, trials).exit_code()
}

/// A trial on a folder of the data, or an ignored one where the data is absent.
fn trial(name: &str, folder: &'static str, run: fn(&Path) -> Result<()>) -> Trial {
    let data = env::var_os("GELPAD_DATA");
    let known_absent = data.as_ref().is_some_and(|data| data.is_empty());
    let found = data
        .filter(|data| !data.is_empty())
        .map(|data| PathBuf::from(data).join(folder))
        .filter(|path| path.is_dir());
    let all = env::var_os("GELPAD_TEST_ALL").is_some_and(|value| value == "1");
    match found {
        Some(path) => Trial::test(name, move || {
            run(&path).map_err(|error| Failed::from(format!("{error:#}")))
        }),
        None if all && !known_absent => Trial::test(name, move || {
            Err(Failed::from(format!("no {folder} in GELPAD_DATA")))
        }),
        None => Trial::test(name, || Ok(()))
            .with_kind(format!("no {folder} in GELPAD_DATA"))
            .with_ignored_flag(true),
    }
}

/// The round tank with an image of both signs: conductors rise where `touch_sign` is a rise.
fn tank(touch_sign: TouchSign) -> Result<(Pad, Imager)> {
    let shipped = shipped_pad("round-tank").context("no round tank")?;
    let pad = Pad {
        touch_sign,
        ..Pad::from_toml(shipped.name, shipped.toml)?
    };
    let matrix = Reconstruction::from_pad(&pad, Method::Smooth)?;
    Ok((pad, Imager::new(Arc::new(matrix))))
}

/// Frames of a file or folder, without any further information.
fn frames_of(path: &Path) -> Result<Vec<Frame>> {
    let (pad, _) = tank(TouchSign::Fall)?;
    let mut source = open_file(path, &pad)?;
    let mut frames = Vec::new();
    loop {
        match source.read()? {
            SourceReading::Frame(frame) => frames.push(frame),
            SourceReading::End => return Ok(frames),
            other => bail!("{other:?}"),
        }
    }
}

/// As sources: order, sign and frame rate are recognised, so readings agree with their reciprocal ones and those of an empty
/// tank are positive.
fn sciospec_source(folder: &Path) -> Result<()> {
    let frames = frames_of(folder)?;
    ensure!(frames.len() == 255, "{} frames", frames.len());
    ensure!(frames[254].t_ns == 254 * 50_000_000, "20 frames/s");
    is_in_order(&frames[0])
}

fn pyeidors_source(folder: &Path) -> Result<()> {
    let frames = frames_of(&folder.join("electrode01_metal.csv"))?;
    ensure!(
        frames.len() == 2,
        "{} frames: real parts of reference and target",
        frames.len()
    );
    is_in_order(&frames[0])
}

fn is_in_order(frame: &Frame) -> Result<()> {
    let volts: Vec<f64> = frame.volts.iter().map(|volt| f64::from(*volt)).collect();
    let order = recognise_order(&volts, ELECTRODES)?;
    ensure!(
        !order.rotated && !order.flipped && order.layout == Layout::Adjacent,
        "{order:?}"
    );
    let error = order.error.context("208 readings show reciprocity")?;
    ensure!(error < 0.05, "reciprocity error {error}");
    Ok(())
}

fn changes(volts: &[f64], reference: &[f64]) -> Vec<f32> {
    volts
        .iter()
        .zip(reference)
        .map(|(v, v0)| ((v - v0) / v0) as f32)
        .collect()
}

/// Metal and plastic in a tank, in files of unknown order: each is found next to the electrode in the file's name, metal as a
/// rise and plastic as a fall of the same image.
fn pyeidors_tank(folder: &Path) -> Result<()> {
    let (pad, mut imager) = tank(TouchSign::Rise)?;
    let mut files: Vec<PathBuf> = fs::read_dir(folder)?
        .map(|entry| Ok(entry?.path()))
        .collect::<Result<Vec<_>>>()?
        .into_iter()
        .filter(|path| path.extension().is_some_and(|extension| extension == "csv"))
        .collect();
    files.sort();
    ensure!(files.len() == 4, "{} files", files.len());
    for path in files {
        let name = path
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let mut columns = [Vec::new(), Vec::new()];
        for row in csv::ReaderBuilder::new()
            .has_headers(false)
            .from_path(&path)?
            .deserialize()
        {
            let [reference, _, target, _]: [f64; 4] = row?;
            columns[0].push(reference);
            columns[1].push(target);
        }
        let order = recognise_order(&columns[0], ELECTRODES)?;
        let error = order.error.context("208 readings show reciprocity")?;
        ensure!(
            order.rotated && order.layout == Layout::Adjacent,
            "{name}: {order:?}"
        );
        ensure!(error < 0.05, "{name}: reciprocity error {error}");
        let [reference, target] = columns.map(|volts| order.apply(&volts));
        let mut image = Image::blank(imager.reconstruction().grid);
        imager.signed_image(&changes(&target, &reference), 0.0, &mut image);
        let expected = |material: &str| -> Vec<usize> {
            let words: Vec<&str> = name.split('_').collect();
            let mut electrodes: Vec<usize> = words
                .chunks(2)
                .filter(|pair| pair[1] == material)
                .filter_map(|pair| pair[0].strip_prefix("electrode")?.parse().ok())
                .collect();
            electrodes.sort_unstable();
            electrodes
        };
        for (material, sign) in [("metal", 1.0), ("plastic", -1.0)] {
            let wanted = expected(material);
            let mut found = nearest_electrodes(&pad, &image, sign, wanted.len());
            found.sort_unstable();
            println!(
                "{name}: reciprocity error {:.1} %, {material} at {found:?}",
                error * 100.0
            );
            ensure!(
                found == wanted,
                "{name}: {material} at {found:?} instead of {wanted:?}"
            );
        }
    }
    Ok(())
}

/// The electrodes (from 1) next to separate maxima of an image, or minima for a sign of -1.
fn nearest_electrodes(pad: &Pad, image: &Image, sign: f32, count: usize) -> Vec<usize> {
    const APART_MM: f64 = 50.0;
    let mut values: Vec<f32> = image.values.iter().map(|value| sign * value).collect();
    (0..count)
        .filter_map(|_| {
            let peak = (0..values.len()).max_by(|a, b| values[*a].total_cmp(&values[*b]))?;
            let [x, y] = image.grid.centre_mm(peak);
            for (pixel, value) in values.iter_mut().enumerate() {
                let [px, py] = image.grid.centre_mm(pixel);
                if (px - x).hypot(py - y) < APART_MM {
                    *value = f32::NEG_INFINITY;
                }
            }
            (0..ELECTRODES)
                .min_by(|a, b| {
                    let distance = |electrode: &usize| {
                        let [ex, ey] = pad.electrodes[*electrode].centre_mm(&pad.outline);
                        (ex - x).hypot(ey - y)
                    };
                    distance(a).total_cmp(&distance(b))
                })
                .map(|electrode| electrode + 1)
        })
        .collect()
}

/// A glass cup is moved in a tank by hand: its track is smooth, i.e. each place lies near the middle of the places one frame
/// before and after. A hand hardly changes its speed in 50 ms; noise and wrong peaks do.
fn sciospec_tank(folder: &Path) -> Result<()> {
    const EMPTY_FRAMES: usize = 20;
    /// Least ratio of the image's peak with an object to that of the empty tank.
    const THERE: f32 = 10.0;
    let (pad, mut imager) = tank(TouchSign::Fall)?;
    let radius_mm = pad.outline.size_mm()[0] / 2.0;
    let mut files: Vec<PathBuf> = fs::read_dir(folder)?
        .map(|entry| Ok(entry?.path()))
        .collect::<Result<Vec<_>>>()?
        .into_iter()
        .filter(|path| path.extension().is_some_and(|extension| extension == "eit"))
        .collect();
    files.sort();
    let frames: Vec<Vec<f64>> = files
        .iter()
        .map(|path| Ok(EitFrame::open(path)?.adjacent()))
        .collect::<Result<_>>()?;
    ensure!(frames.len() == 255, "{} frames", frames.len());
    let order = recognise_order(&frames[0], ELECTRODES)?;
    let error = order.error.context("208 readings show reciprocity")?;
    ensure!(!order.rotated && error < 0.05, "{order:?}");
    let frames: Vec<Vec<f64>> = frames.iter().map(|frame| order.apply(frame)).collect();
    let reference: Vec<f64> = (0..frames[0].len())
        .map(|channel| {
            frames[..EMPTY_FRAMES]
                .iter()
                .map(|frame| frame[channel])
                .sum::<f64>()
                / EMPTY_FRAMES as f64
        })
        .collect();
    let mut image = Image::blank(imager.reconstruction().grid);
    let mut empty_peak = 0.0_f32;
    let mut track: Vec<Option<[f64; 2]>> = Vec::new();
    for (index, frame) in frames.iter().enumerate() {
        imager.image(&changes(frame, &reference), 0.0, &mut image);
        if index < EMPTY_FRAMES {
            empty_peak = empty_peak.max(image.peak());
        }
        let there = index >= EMPTY_FRAMES && image.peak() > THERE * empty_peak;
        track.push(there.then(|| centroid(&image)));
    }
    let seen = track.iter().flatten().count();
    let mut bends: Vec<f64> = track
        .windows(3)
        .filter_map(|places| {
            let [a, b, c] = [places[0]?, places[1]?, places[2]?];
            let [x, y] = [0, 1].map(|axis| b[axis] - 0.5 * (a[axis] + c[axis]));
            Some(x.hypot(y) / radius_mm)
        })
        .collect();
    bends.sort_by(f64::total_cmp);
    ensure!(
        !bends.is_empty(),
        "no object seen in {} frames",
        frames.len()
    );
    let [median, p95, worst] =
        [0.5, 0.95, 1.0].map(|share| bends[((bends.len() - 1) as f64 * share) as usize]);
    let reach = |axis: usize| {
        let values = || track.iter().flatten().map(|place| place[axis]);
        values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min)
    };
    let travelled = reach(0).max(reach(1)) / radius_mm;
    println!(
        "sciospec-tank: reciprocity error {:.1} %; object in {seen} of {} frames, travels {travelled:.2} radii; off the middle of its neighbours by {median:.4} radii (median), {p95:.4} (p95), {worst:.4} (worst)",
        error * 100.0,
        frames.len() - EMPTY_FRAMES
    );
    ensure!(seen >= 150, "seen in {seen} frames");
    ensure!(travelled > 0.5, "travels {travelled} radii");
    ensure!(
        median < 0.005 && p95 < 0.02,
        "a rough track: {median} {p95} {worst}"
    );
    Ok(())
}

/// Centre of the pixels above half of the peak.
fn centroid(image: &Image) -> [f64; 2] {
    let floor = 0.5 * image.peak();
    let mut sums = [0.0; 3];
    for (pixel, value) in image
        .values
        .iter()
        .enumerate()
        .filter(|(_, value)| **value > floor)
    {
        let [x, y] = image.grid.centre_mm(pixel);
        let weight = f64::from(*value);
        sums = [sums[0] + weight, sums[1] + weight * x, sums[2] + weight * y];
    }
    [sums[1] / sums[0], sums[2] / sums[0]]
}

/// Training presses of a skin.
const TRAINED: [usize; 3] = [50, 500, 2000];

/// A measured skin with other electrodes, drive and unit: over random splits, the mean error of unseen presses, mm, stays below
/// the limit for each of [`TRAINED`].
fn skin(folder: &Path, name: &str, goals_mm: [f64; 3]) -> Result<()> {
    let full = env::var_os("GELPAD_FULL").is_some_and(|value| value == "1");
    let all = skin_presses(folder, name)?;
    for (count, goal_mm) in TRAINED.into_iter().zip(goals_mm) {
        // 2000 presses take half a minute for a split; 50 scatter most and are quick.
        let splits = match (full, count) {
            (true, _) | (_, 50) => 5,
            (false, 500) => 1,
            (false, _) => 0,
        };
        let mut errors = Vec::new();
        for seed in 1..=splits {
            let (train, test) = split(&all, count, seed)?;
            let regression = Regression::fit(&train, &mut |_| {})?;
            errors.push(regression.evaluate(&test).mean_mm);
        }
        if splits > 0 {
            let mean = errors.iter().sum::<f64>() / errors.len() as f64;
            println!("{name}, {count} presses: mean error {mean:.2} mm of {errors:.2?}");
            // A single split scatters around the mean of five.
            let allowed = if splits == 5 { 1.0 } else { 1.05 };
            ensure!(
                mean <= allowed * goal_mm,
                "{name} with {count} presses: {mean:.3} mm, wanted {goal_mm}"
            );
        }
    }
    Ok(())
}

fn skin_presses(folder: &Path, name: &str) -> Result<Vec<Press>> {
    let rows = |kind: &str| -> Result<Vec<Vec<f64>>> {
        csv::ReaderBuilder::new()
            .has_headers(false)
            .from_path(folder.join(format!("{kind}_{name}.csv")))?
            .deserialize()
            .map(|row| Ok(row?))
            .collect()
    };
    Ok(rows("inp")?
        .into_iter()
        .zip(rows("out")?)
        .map(|(changes, place_m)| Press {
            place_mm: [place_m[0] * 1000.0, place_m[1] * 1000.0],
            modelled: None,
            changes,
        })
        .collect())
}

/// Shuffles and splits presses: the same seed gives the same split.
fn split(all: &[Press], count: usize, seed: u64) -> Result<(Presses, Presses)> {
    let mut presses = all.to_vec();
    let mut state = seed;
    for last in (1..presses.len()).rev() {
        // Knuth's MMIX generator; its high bits suffice for shuffling.
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        presses.swap(last, (state >> 33) as usize % (last + 1));
    }
    let test = presses.split_off(count);
    Ok((Presses::new("train", presses)?, Presses::new("test", test)?))
}

/// Super Mario on both skins as 500 presses describe them, without a model: `scripts/hydrogel-play.py`.
fn skins_play(folder: &Path) -> Result<()> {
    let data = folder.parent().context("a folder of data")?;
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/scripts/hydrogel-play.py");
    let output = Command::new(script)
        .args(["6", "500"])
        .env("GELPAD", env!("CARGO_BIN_EXE_gelpad"))
        .env("GELPAD_DATA", data)
        .output()?;
    ensure!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let printed = String::from_utf8(output.stdout)?;
    print!("{printed}");
    for run in printed.lines().filter(|line| line.starts_with('{')) {
        let run: serde_json::Value = serde_json::from_str(run)?;
        let count = |name: &str| run[name].as_u64().context("a number");
        ensure!(count("presses")? == 60, "{run}");
        ensure!(count("right")? >= 56 && count("false")? <= 1, "{run}");
    }
    Ok(())
}
