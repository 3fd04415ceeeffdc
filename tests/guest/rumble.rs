//! Rumble of a game: its effects are accepted and reported.

use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use evdev::{FFEffectData, FFEffectKind, FFReplay, FFTrigger};
use gelpad::output::OutputDevice as _;
use gelpad::platform::linux::uinput::{PAD_NAME, Uinput};

/// The guest is slow.
const PATIENCE: Duration = Duration::from_secs(20);
/// Length of the effect with a limited length, ms.
const LENGTH_MS: u16 = 300;

#[allow(
    clippy::disallowed_methods,
    reason = "a deadline of a test reads the clock"
)]
pub fn shake() -> Result<()> {
    let pad = Uinput::create()?;
    let mut devices = evdev::enumerate().map(|(_, device)| device);
    let mut game = devices
        .find(|device| device.name() == Some(PAD_NAME))
        .context("no pad")?;
    let effect = |length| FFEffectData {
        direction: 0,
        trigger: FFTrigger::default(),
        replay: FFReplay { length, delay: 0 },
        kind: FFEffectKind::Rumble {
            strong_magnitude: 0x8000,
            weak_magnitude: 0x4000,
        },
    };
    let becomes = |shaken: bool| {
        let start = Instant::now();
        while (pad.rumble() != [0.0; 2]) != shaken {
            ensure!(start.elapsed() < PATIENCE, "it stays {:?}", pad.rumble());
            std::thread::sleep(Duration::from_millis(2));
        }
        Ok(pad.rumble())
    };
    let mut endless = game.upload_ff_effect(effect(0))?;
    endless.play(1)?;
    let [strong, weak] = becomes(true)?;
    ensure!(
        (strong - 0.5).abs() < 0.01 && (weak - 0.25).abs() < 0.01,
        "{strong} {weak}"
    );
    endless.stop()?;
    becomes(false)?;
    let mut short = game.upload_ff_effect(effect(LENGTH_MS))?;
    short.play(1)?;
    becomes(true)?;
    becomes(false)?;
    println!("shaken: strong {strong:.2}, weak {weak:.2}, and at rest again");
    Ok(())
}
