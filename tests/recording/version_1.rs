//! A recording of version 1 replays for ever: `tests/data/recordings/version-1.mcap` is never written again.
//!
//! It was made by `cargo test --test recording -- --ignored write_version_1`, of a small strip of a pad: its matrix and table are
//! small, and honest.

use std::fs::{self, File};
use std::io::BufWriter;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Result, ensure};
use gelpad::cache;
use gelpad::engine::{Engine, Input};
use gelpad::pad::Pad;
use gelpad::profile::Profile;
use gelpad::source::{Finger, Noise, SimulatedPad};
use gelpad::tape::{Kit, Scribe};
use gelpad::touch::SensingBuilder;
use gelpad::types::{Frame, Method};

use crate::sessions::step;
use crate::{gelpad_ends, said};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/recordings");

pub fn replays() -> Result<()> {
    let folder = Path::new(FOLDER);
    let output = gelpad_ends(
        folder,
        &["replay", "version-1.mcap", "--expect", "version-1.mcap"],
        0,
    )?;
    ensure!(said(&output).contains("to the bit"), "{}", said(&output));
    gelpad_ends(
        folder,
        &["replay", "version-1.mcap", "--expect", "version-1.events"],
        0,
    )?;
    let events = fs::read_to_string(folder.join("version-1.events"))?;
    for what in [
        "press key:space",
        "press key:left",
        "press key:x",
        "axis pad:left-x",
    ] {
        ensure!(events.contains(what), "the session has `{what}`");
    }
    Ok(())
}

const PAD: &str = r#"schema = 1
name = "strip"
about = "A strip of 100 x 12 mm"
touch_sign = "rise"

[outline]
shape = "rectangle"
width_mm = 100.0
height_mm = 12.0

[layer]
thickness_mm = 2.0
background_s_per_m = 1.0

[electrodes]
count = 8
width_mm = 3.0
contact_impedance_ohm_m2 = 1e-6

[protocol]
stimulation = "adjacent"
measurement = "adjacent"
readings = "full"
"#;

const PROFILE: &str = r#"schema = 1
name = "strip"
[[region]]
name = "left"
x = 0.0
y = 0.0
w = 0.4
h = 1.0
[[region]]
name = "right"
x = 0.6
y = 0.0
w = 0.4
h = 1.0
[[binding]]
region = "right"
output = "key:space"
[[binding]]
region = "left"
output = "key:left"
"#;

const OTHER: &str = r#"schema = 1
name = "strip-other"
[[region]]
name = "left"
x = 0.0
y = 0.0
w = 0.4
h = 1.0
[[region]]
name = "right"
x = 0.6
y = 0.0
w = 0.4
h = 1.0
[[binding]]
region = "right"
output = "key:x"
[[binding]]
region = "left"
gesture = "stick"
axis_x = "pad:left-x"
axis_y = "pad:left-y"
"#;

/// Writes the recording anew: only ever for a next version, beside the old one.
pub fn write() -> Result<()> {
    let path = Path::new(FOLDER).join("version-1.mcap");
    ensure!(
        !path.exists(),
        "{} is there: it stays as it is",
        path.display()
    );
    let pad = Pad::from_toml("strip", PAD)?;
    let table = Arc::new(cache::solve(&pad, |_, _| ())?);
    let builder = SensingBuilder::new(&pad, Method::default())?.with_table(Arc::clone(&table));
    let kit = Kit {
        pad_toml: PAD.to_owned(),
        profile: Arc::new(Profile::from_toml("strip.toml", PROFILE)?),
        correction: None,
        sensing: Arc::new(builder.first()?),
        table: Some(table),
        pad,
    };
    let simulated = SimulatedPad::new(&kit.pad)?;
    let finger = |id, x: f64| Finger {
        id,
        centre_mm: [x, 6.0],
        radius_mm: 6.0,
        rise: 1.2,
    };
    let (left, right) = (finger(1, 20.0), finger(2, 80.0));
    let states: Vec<Vec<f64>> = [vec![], vec![right], vec![left], vec![left, right]]
        .iter()
        .map(|fingers| simulated.volts(fingers))
        .collect::<Result<_, _>>()?;
    let other = Arc::new(Profile::from_toml("other.toml", OTHER)?);
    let mut noise = Noise::new(60.0, 11);
    let mut engine = kit.engine();
    let mut scribe = Scribe::packed(BufWriter::new(File::create(&path)?), &kit.to_setup())?;
    let wild =
        |frame: u64, channel: u64| ((frame * 7919 + channel * 104_729) % 1000) as f32 / 500.0;
    for frame in 0..700u64 {
        let t_ns = frame * 10_000_000;
        while let Some(due_ns) = engine.next_due().filter(|due| *due <= t_ns) {
            step(&mut engine, &Input::Tick { due_ns }, &mut scribe)?;
        }
        let state = if frame < 30 {
            0
        } else {
            [0, 1, 0, 2, 0, 3][frame as usize / 15 % 6]
        };
        let mut volts = noise.read(&states[state]);
        // An electrode comes loose late in the session.
        if frame >= 500 {
            for (channel, volt) in kit.pad.protocol.channels.iter().zip(&mut volts) {
                if [channel.drive, channel.measure]
                    .iter()
                    .any(|pair| pair.0 == 2 || pair.1 == 2)
                {
                    *volt *= wild(frame, channel.drive.0 as u64 * 8 + channel.measure.0 as u64);
                }
            }
        }
        take(
            &mut engine,
            &Input::Frame(Frame { t_ns, volts }),
            &mut scribe,
            &builder,
        )?;
        match frame {
            200 => take(
                &mut engine,
                &Input::Profile {
                    t_ns,
                    profile: Arc::clone(&other),
                },
                &mut scribe,
                &builder,
            )?,
            350 => take(&mut engine, &Input::Rezero { t_ns }, &mut scribe, &builder)?,
            400 | 410 => take(&mut engine, &Input::Pause { t_ns }, &mut scribe, &builder)?,
            450 => take(
                &mut engine,
                &Input::Lost { frames: 3 },
                &mut scribe,
                &builder,
            )?,
            _ => {}
        }
    }
    let end = Input::End {
        t_ns: 7_000_000_000,
    };
    take(&mut engine, &end, &mut scribe, &builder)?;
    scribe.finish()?;
    gelpad_ends(
        Path::new(FOLDER),
        &["replay", "version-1.mcap", "--update", "version-1.events"],
        0,
    )?;
    println!("{} bytes", fs::metadata(&path)?.len());
    Ok(())
}

fn take(
    engine: &mut Engine,
    input: &Input,
    scribe: &mut Scribe<BufWriter<File>>,
    builder: &SensingBuilder,
) -> Result<()> {
    step(engine, input, scribe)?;
    if let Some(deviations) = engine.wanted() {
        let sensing = Arc::new(builder.build(deviations)?);
        step(engine, &Input::Matrix(sensing), scribe)?;
    }
    Ok(())
}
