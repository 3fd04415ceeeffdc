//! Behaviour tests as texts: each file under `tests/scenarios` holds a profile, a touch script and the expected events.
//!
//! ```text
//! --- profile            a profile's TOML, or `shipped: NAME`
//! --- user               (optional) user settings as TOML, or `shipped: NAME`
//! --- switch T           (optional) another profile's TOML, saved at T ms
//! --- script             a touch script; times are exact, not rounded to frames
//! --- gamepad            the script of a gamepad, with or without a touch script (see scenario/gamepad.rs)
//! --- events             the expected events, one on each line
//! ```
//! A finger's area follows from its radius (7 mm: 154 mm2), its force is its rise / 2.4 (1.2: 0.5). Each file is one test.
//! The examples of docs/profiles.md are tests too: each `toml` block must be valid, and a `scenario` block below it is
//! played with it. To add a scenario, leave the events empty, run it, and copy the output if it is right.

#[path = "scenario/gamepad.rs"]
mod gamepad;
mod support;

use std::fs;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;

use gelpad::gesture::Gestures;
use gelpad::profile::{self, Profile, Source, shipped_profile, shipped_user};
use gelpad::source::{FingerAction, Script, ScriptStep};
use gelpad::types::{
    Contact, Control, Event, NANOS_PER_MS, Nanos, Phase, Touch, TouchId, nanos_from_ms,
};
use libtest_mimic::{Arguments, Failed, Trial};

const PAD_MM: [f64; 2] = [100.0, 100.0];
/// The source ends this long after the last step.
const AFTER_NS: Nanos = 500 * NANOS_PER_MS;
const GUIDE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/profiles.md");

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenarios");
    let files = support::files(&root, "txt");
    assert!(!files.is_empty(), "no scenario under {}", root.display());
    let examples = examples(&fs::read_to_string(GUIDE).expect("the guide"));
    assert!(examples.len() > 10, "no examples in {GUIDE}");
    let scenarios = files.into_iter().map(|path| {
        let name = path.strip_prefix(&root).expect("inside").with_extension("");
        Trial::test(name.display().to_string(), move || {
            let text = fs::read_to_string(&path).map_err(|error| error.to_string())?;
            run(&text).map_err(Failed::from)
        })
    });
    let guide = examples.into_iter().map(|(line, text)| {
        Trial::test(format!("docs/profiles.md:{line}"), move || {
            run(&text).map_err(Failed::from)
        })
    });
    libtest_mimic::run(&arguments, scenarios.chain(guide).collect()).exit_code()
}

/// The guide's examples as scenarios, each with its line. An example without a head, regions or bindings gets those of the
/// first example.
fn examples(guide: &str) -> Vec<(usize, String)> {
    let mut examples: Vec<(usize, String)> = Vec::new();
    let mut lines = guide.lines().enumerate();
    while let Some((number, line)) = lines.next() {
        let kind = match line.trim() {
            "```toml" => "toml",
            "```scenario" => "scenario",
            _ => continue,
        };
        let block: String = lines
            .by_ref()
            .map(|(_, line)| line)
            .take_while(|line| line.trim() != "```")
            .map(|line| format!("{line}\n"))
            .collect();
        match (kind, examples.last_mut()) {
            ("scenario", Some((_, text))) => {
                let profile = text.split("--- script").next().unwrap_or_default();
                *text = format!("{profile}{block}");
            }
            _ => examples.push((
                number + 1,
                format!(
                    "--- profile\n{}--- script\nt:0 down 1 0 99\nt:50 up 1\n--- events\n",
                    whole(&block)
                ),
            )),
        }
    }
    examples
}

fn whole(block: &str) -> String {
    let head = if block.contains("schema =") {
        ""
    } else {
        "schema = 1\nname = \"example\"\n"
    };
    let regions = if block.contains("[[region]]") || block.contains("extends") {
        ""
    } else {
        "[[region]]\nname = \"left\"\nx = 0\ny = 0\nw = 0.48\nh = 0.98\n[[region]]\nname = \"jump\"\nx = 0.5\ny = 0\nw = 0.5\nh = 0.98\n"
    };
    format!("{head}{block}{regions}")
}

fn run(text: &str) -> Result<(), String> {
    let section = |name: &str| -> Result<&str, String> {
        let head = format!("--- {name}\n");
        let (_, rest) = text
            .split_once(&head)
            .ok_or(format!("no section `{name}`"))?;
        Ok(rest.split("\n--- ").next().unwrap_or(rest))
    };
    let own = |name: &str| section(name).ok().map(source).transpose();
    let profile = profile(source(section("profile")?)?, own("user")?)?;
    let switch = match text.split_once("--- switch ") {
        Some((_, rest)) => {
            let (ms, toml) = rest.split_once('\n').ok_or("a time and a profile")?;
            let ms: f64 = ms.trim().parse().map_err(|_| "no time to switch")?;
            let toml = toml.split("\n--- ").next().unwrap_or(toml);
            Some((
                nanos_from_ms(ms),
                self::profile(source(toml)?, own("user")?)?,
            ))
        }
        None => None,
    };
    let timeline = Timeline::from_scripts(section("script").ok(), section("gamepad").ok())?;
    let expected: Vec<&str> = section("events")?
        .lines()
        .map(|line| line.split('#').next().unwrap_or_default().trim())
        .filter(|line| !line.is_empty())
        .collect();
    let got: Vec<String> = play(profile, switch, timeline)
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

/// The text of a section, or the shipped text that it names.
fn source(text: &str) -> Result<Source, String> {
    let Some(name) = text.trim().strip_prefix("shipped:") else {
        return Ok(Source {
            name: "profile".to_owned(),
            toml: text.to_owned(),
        });
    };
    let name = name.trim();
    let shipped = shipped_profile(name).or_else(|| shipped_user(name));
    let toml = shipped.ok_or("no such shipped text")?.toml;
    Ok(Source {
        name: name.to_owned(),
        toml: toml.to_owned(),
    })
}

fn profile(profile: Source, user: Option<Source>) -> Result<Arc<Profile>, String> {
    profile::read(profile, user, &profile::find_shipped)
        .map(|checked| Arc::new(checked.profile))
        .map_err(|error| error.to_string())
}

/// The steps of fingers and gamepads in the order of their times; at the same time the gamepad comes first.
struct Timeline {
    moments: Vec<(Nanos, Moment)>,
    end_ns: Nanos,
}

enum Moment {
    Finger(ScriptStep),
    Gamepad(Control),
}

impl Timeline {
    fn from_scripts(script: Option<&str>, gamepad: Option<&str>) -> Result<Self, String> {
        let mut moments = Vec::new();
        let mut end_ns = 0;
        if let Some(gamepad) = gamepad {
            let states = gamepad::states(gamepad)?;
            end_ns = states.last().map_or(0, |state| state.t_ns + AFTER_NS);
            moments.extend(states.into_iter().map(|at| (at.t_ns, Moment::Gamepad(at))));
        }
        if let Some(script) = script {
            let script = Script::parse("script", script).map_err(|error| error.to_string())?;
            end_ns = end_ns.max(script.end_ns());
            let steps = script.steps().iter().cloned();
            moments.extend(steps.map(|step| (step.t_ns, Moment::Finger(step))));
        }
        if moments.is_empty() {
            return Err("neither a section `script` nor `gamepad`".to_owned());
        }
        moments.sort_by_key(|(t_ns, _)| *t_ns);
        Ok(Self { moments, end_ns })
    }
}

/// Plays a timeline, with every tick at its due time; the source ends with the timeline.
fn play(
    profile: Arc<Profile>,
    mut switch: Option<(Nanos, Arc<Profile>)>,
    timeline: Timeline,
) -> Vec<Event> {
    let mut gestures = Gestures::new(profile, PAD_MM);
    let mut down: Vec<Touch> = Vec::new();
    let mut events = Vec::new();
    for (t_ns, moment) in timeline.moments {
        if let Some((at, next)) = switch.take_if(|(at, _)| *at <= t_ns) {
            gestures.replace(next, at, &mut events);
        }
        match moment {
            Moment::Finger(step) => {
                let changed = touch(&mut down, &step);
                gestures.touches(t_ns, &[changed], &mut events);
            }
            Moment::Gamepad(control) => gestures.control(&control, &mut events),
        }
    }
    if let Some((at, next)) = switch {
        gestures.replace(next, at, &mut events);
    }
    gestures.tick(timeline.end_ns, &mut events);
    gestures.release_all(timeline.end_ns, &mut events);
    events
}

/// Applies a step of the script to the touches that are down.
fn touch(down: &mut Vec<Touch>, step: &ScriptStep) -> Touch {
    match step.kind {
        FingerAction::Down(finger) => {
            let touch = Touch {
                id: TouchId(finger.id),
                phase: Phase::Down,
                since_ns: step.t_ns,
                contact: Contact {
                    centre_mm: finger.press.centre_mm,
                    area_mm2: area_mm2(finger.press.radius_mm),
                    force: force(finger.press.rise),
                    confidence: 1.0,
                },
            };
            down.push(touch);
            touch
        }
        FingerAction::Move {
            id,
            centre_mm,
            radius_mm,
            rise,
        } => {
            let touch = down
                .iter_mut()
                .find(|touch| touch.id.0 == id)
                .expect("checked by the script");
            touch.phase = Phase::Move;
            let contact = &mut touch.contact;
            contact.centre_mm = centre_mm;
            contact.area_mm2 = radius_mm.map_or(contact.area_mm2, area_mm2);
            contact.force = rise.map_or(contact.force, force);
            *touch
        }
        FingerAction::Up { id } => {
            let index = down
                .iter()
                .position(|touch| touch.id.0 == id)
                .expect("checked by the script");
            Touch {
                phase: Phase::Up,
                ..down.remove(index)
            }
        }
    }
}

fn area_mm2(radius_mm: f64) -> f64 {
    std::f64::consts::PI * radius_mm * radius_mm
}

/// Full force is a rise of 2.4.
fn force(rise: f64) -> f64 {
    (rise / 2.4).min(1.0)
}
