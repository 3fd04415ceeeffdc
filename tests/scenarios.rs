//! Behaviours as texts: each file under `tests/scenarios` holds a profile, a touch script and the events that follow.
//!
//! ```text
//! --- profile            a profile's TOML, or `shipped: NAME`
//! --- script             a touch script; times are exact, no frame rounds them
//! --- events             what must come out, a line an event
//! ```
//! A trial a file, named after it. To write a new one, leave the events empty, run, and copy what was got if it is right.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use gelpad::gesture::Gestures;
use gelpad::profile::{Profile, shipped_profile};
use gelpad::source::{Script, StepKind};
use gelpad::types::{Contact, Event, Phase, PointMm, Touch, TouchId};
use libtest_mimic::{Arguments, Failed, Trial};

const PAD_MM: [f64; 2] = [100.0, 100.0];

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenarios");
    let mut files = Vec::new();
    texts(&root, &mut files);
    assert!(!files.is_empty(), "no scenario under {}", root.display());
    let trials = files
        .into_iter()
        .map(|path| {
            let name = path.strip_prefix(&root).expect("inside").with_extension("");
            Trial::test(name.display().to_string(), move || {
                run(&path).map_err(Failed::from)
            })
        })
        .collect();
    libtest_mimic::run(&arguments, trials).exit_code()
}

fn texts(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path())
        .collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            texts(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "txt") {
            found.push(path);
        }
    }
}

fn run(path: &Path) -> Result<(), String> {
    let text = fs::read_to_string(path).map_err(|error| error.to_string())?;
    let section = |name: &str| -> Result<&str, String> {
        let head = format!("--- {name}\n");
        let (_, rest) = text
            .split_once(&head)
            .ok_or(format!("no section `{name}`"))?;
        Ok(rest.split("\n--- ").next().unwrap_or(rest))
    };
    let profile = profile(section("profile")?)?;
    let script = Script::parse("script", section("script")?).map_err(|error| error.to_string())?;
    let expected: Vec<&str> = section("events")?
        .lines()
        .map(|line| line.split('#').next().unwrap_or_default().trim())
        .filter(|line| !line.is_empty())
        .collect();
    let got: Vec<String> = play(profile, &script)
        .iter()
        .map(Event::to_string)
        .collect();
    if got == expected {
        Ok(())
    } else {
        Err(format!(
            "expected\n  {}\ngot\n  {}",
            expected.join("\n  "),
            got.join("\n  ")
        ))
    }
}

fn profile(text: &str) -> Result<Arc<Profile>, String> {
    let toml = match text.trim().strip_prefix("shipped:") {
        Some(name) => {
            shipped_profile(name.trim())
                .ok_or("no such shipped profile")?
                .toml
        }
        None => text,
    };
    Profile::from_toml("profile", toml)
        .map(Arc::new)
        .map_err(|error| error.to_string())
}

/// Touches exactly as the script says, with every tick at its time; the source ends with the script.
fn play(profile: Arc<Profile>, script: &Script) -> Vec<Event> {
    let mut gestures = Gestures::new(profile, PAD_MM);
    let mut down: Vec<Touch> = Vec::new();
    let mut events = Vec::new();
    for step in script.steps() {
        let touch = |id: u64, centre_mm: PointMm, phase| Touch {
            id: TouchId(id),
            phase,
            since_ns: step.t_ns,
            contact: Contact {
                centre_mm,
                area_mm2: 150.0,
                force: 0.5,
                confidence: 1.0,
            },
        };
        let changed = match step.kind {
            StepKind::Down(finger) => {
                let new = touch(finger.id, finger.centre_mm, Phase::Down);
                down.push(new);
                new
            }
            StepKind::Move { id, centre_mm } => touch(id, centre_mm, Phase::Move),
            StepKind::Up { id } => {
                let index = down
                    .iter()
                    .position(|t| t.id.0 == id)
                    .expect("checked by the script");
                Touch {
                    phase: Phase::Up,
                    ..down.remove(index)
                }
            }
        };
        gestures.touches(step.t_ns, &[changed], &mut events);
    }
    gestures.tick(script.end_ns(), &mut events);
    gestures.release_all(script.end_ns(), &mut events);
    events
}
