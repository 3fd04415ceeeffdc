//! The script of a gamepad: its changes and their times.
//!
//! ```text
//! t:100 press pad:a
//! t:150 release pad:a
//! t:200 move stick:left 0.5 -1      right and up
//! t:300 move pad:left-trigger 0.4
//! t:400 unplug
//! t:500 plug
//! ```
//! It is plugged in from the start, and at rest.

use gelpad::types::{Buttons, Control, GamepadPart, nanos_from_ms};

/// The states of a script, in the order of their times.
pub fn states(script: &str) -> Result<Vec<Control>, String> {
    let mut now = Control {
        present: true,
        ..Control::default()
    };
    let mut states = vec![now];
    let lines = script
        .lines()
        .map(|line| line.split('#').next().unwrap_or_default().trim());
    for line in lines.filter(|line| !line.is_empty()) {
        step(&mut now, line).map_err(|problem| format!("{line}: {problem}"))?;
        states.push(now);
    }
    Ok(states)
}

fn step(now: &mut Control, line: &str) -> Result<(), String> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let time = words[0].strip_prefix("t:").and_then(|ms| ms.parse().ok());
    now.t_ns = nanos_from_ms(time.ok_or("begins with no time")?);
    let number = |index: usize| -> Result<f32, String> {
        let word = words.get(index).ok_or("too short")?;
        word.parse().map_err(|_| format!("{word} is not a number"))
    };
    let part = || -> Result<GamepadPart, String> {
        let word = words.get(2).ok_or("names no part")?;
        word.parse::<GamepadPart>()
            .map_err(|error| error.to_string())
    };
    match (words.get(1).copied(), words.len()) {
        (Some("unplug"), _) => {
            now.present = false;
            now.buttons = Buttons::default();
            now.axes = Default::default();
        }
        (Some("plug"), _) => now.present = true,
        (Some(word @ ("press" | "release")), _) => {
            let GamepadPart::Button(button) = part()? else {
                return Err("is not a button".to_owned());
            };
            now.buttons = match word {
                "press" => now.buttons.with(button),
                _ => now.buttons.without(button),
            };
        }
        (Some("move"), _) => match part()? {
            GamepadPart::Trigger(axis) => now.axes[axis as usize] = number(3)?,
            GamepadPart::Stick(x, y) => {
                now.axes[x as usize] = number(3)?;
                now.axes[y as usize] = number(4)?;
            }
            GamepadPart::Button(_) => return Err("does not move".to_owned()),
        },
        _ => return Err("press, release, move, unplug or plug".to_owned()),
    }
    Ok(())
}
