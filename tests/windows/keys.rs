//! Every key, its length and its delay, as the window sees them.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, ensure};
use gelpad::output::OutputDevice;
use gelpad::platform::outputs::keyboards;
use gelpad::types::{Action, Event, Key, Output};

use crate::codes::{ABSENT, CODES, WITHOUT_VIRTUAL_KEY};
use crate::logger::Logger;

/// Presses whose delay is measured.
const PRESSES: usize = 300;
/// Longest median delay from gelpad's call to the window's message.
const SOON: Duration = Duration::from_millis(20);

/// The keyboard of this session.
fn keyboard() -> Result<Box<dyn OutputDevice>> {
    let candidate = keyboards().into_iter().next().context("no output")?;
    Ok((candidate.open)()?)
}

fn send(device: &mut dyn OutputDevice, action: Action) -> Result<()> {
    device.send(&Event { t_ns: 0, action })?;
    Ok(device.flush()?)
}

/// Presses each key and compares what arrives.
pub fn table() -> Result<()> {
    let logger = Logger::open()?;
    let mut device = keyboard()?;
    let mut text = String::from("name scan extended vk\n");
    let mut wrong = Vec::new();
    for key in Key::all() {
        let name = key.to_string();
        let output = Output::Key(key);
        let known = CODES.iter().find(|(known, _)| *known == name);
        let Some((_, code)) = known else {
            ensure!(ABSENT.contains(&name.as_str()), "{name} is not listed");
            ensure!(!device.supports(output), "{name} should be refused");
            continue;
        };
        send(&mut *device, Action::Press(output))?;
        let down = logger.next().with_context(|| format!("press {name}"))?;
        send(&mut *device, Action::Release(output))?;
        let up = logger.next().with_context(|| format!("release {name}"))?;
        let expected = (code & 0xff, code >> 8 == 0xe0);
        let found = [down, up].map(|one| (one.scan_code, one.is_extended));
        let lacks_virtual_key =
            down.virtual_key == 0 && !WITHOUT_VIRTUAL_KEY.contains(&name.as_str());
        if found != [expected; 2] || !down.is_down || up.is_down || lacks_virtual_key {
            wrong.push(format!("{name}: {down:?} {up:?}"));
        }
        let (scan, is_extended) = found[0];
        writeln!(
            text,
            "{name} {scan:#04x} {} {:#04x}",
            u8::from(is_extended),
            down.virtual_key
        )?;
    }
    if let Some(path) = std::env::var_os("GELPAD_KEY_TABLE") {
        std::fs::write(path, text)?;
    }
    ensure!(wrong.is_empty(), "{}", wrong.join("\n"));
    Ok(())
}

/// A press that was as long as `sleep` arrives as long as that.
pub fn lengths() -> Result<()> {
    let logger = Logger::open()?;
    let mut device = keyboard()?;
    let key = Output::Key("f".parse()?);
    let length = Duration::from_millis(60);
    for _ in 0..10 {
        let pressed = Instant::now();
        send(&mut *device, Action::Press(key))?;
        std::thread::sleep(length);
        send(&mut *device, Action::Release(key))?;
        let sent = pressed.elapsed();
        let [down, up] = [logger.next()?, logger.next()?];
        let arrived = up.at.saturating_duration_since(down.at);
        ensure!(
            down.is_down && !up.is_down && arrived.abs_diff(sent) < Duration::from_millis(250),
            "{arrived:?} instead of {sent:?}"
        );
    }
    Ok(())
}

/// From gelpad's call to the window's message; prints the figures.
pub fn latency() -> Result<()> {
    let logger = Logger::open()?;
    let mut device = keyboard()?;
    let key = Output::Key("f".parse()?);
    let mut delays = Vec::new();
    for index in 0..PRESSES {
        let action = match index % 2 {
            0 => Action::Press(key),
            _ => Action::Release(key),
        };
        let sent = Instant::now();
        send(&mut *device, action)?;
        delays.push(logger.next()?.at.saturating_duration_since(sent));
        std::thread::sleep(Duration::from_millis(5));
    }
    delays.sort_unstable();
    let us = |share: usize| delays[(PRESSES - 1) * share / 100].as_micros();
    println!(
        "delay of {PRESSES} events to the window: median {} us, 99th percentile {} us",
        us(50),
        us(99)
    );
    ensure!(
        delays[PRESSES / 2] < SOON,
        "median {:?}",
        delays[PRESSES / 2]
    );
    Ok(())
}
