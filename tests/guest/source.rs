//! A gamepad as gelpad's source: the test's gamepad drives the gelpad binary, whose trace is read.

use std::io::{BufRead as _, BufReader, Lines};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use anyhow::{Context as _, Result, bail, ensure};
use evdev::uinput::VirtualDevice;
use evdev::{
    AbsInfo, AbsoluteAxisCode, AttributeSet, BusType, Device, EventType, InputEvent, InputId,
    KeyCode, UinputAbsSetup,
};

use crate::as_evdev;

/// Well within and well beyond the profile's 1.5 s of bounce keys, even where a busy machine stops the guest for a
/// second.
const BOUNCE: Duration = Duration::from_millis(60);
const BEYOND_BOUNCES: Duration = Duration::from_millis(3000);
/// The library lists the devices, and only a moment later watches for their removal.
const LISTED: Duration = Duration::from_millis(500);
/// Longer than gelpad needs to distinguish a press from none.
const HELD: Duration = Duration::from_millis(100);

/// Path of the profile in the guest.
const PLAYED: &str = "/tmp/played.toml";

const PROFILE: &str = r#"
schema = 1
name = "by-gamepad"
bounce_keys_ms = 1500

[[binding]]
from = "pad:a"
output = "key:f"

[[binding]]
from = "pad:x"
mode = "toggle"
output = "key:g"

[[binding]]
from = "stick:left"
gesture = "dpad"
left = "key:left"
right = "key:right"

[[binding]]
from = "pad:up"
output = "key:up"
"#;

/// A gamepad of another maker, as the kernel sees it.
struct Pad(VirtualDevice);

impl Pad {
    fn plug_in(vendor: u16, product: u16) -> Result<Self> {
        // In the order of the kernel's driver, and no others: libraries count buttons and axes.
        let keys = [A, B, X, Y, 0x136, 0x137, 0x13a, 0x13b, 0x13c, 0x13d, 0x13e];
        let keys = AttributeSet::from_iter(keys.map(KeyCode));
        let stick = AbsInfo::new(0, -32768, 32767, 16, 128, 0);
        let trigger = AbsInfo::new(0, 0, 255, 0, 0, 0);
        let hat = AbsInfo::new(0, -1, 1, 0, 0, 0);
        let mut pad = VirtualDevice::builder()?
            .name("Microsoft X-Box 360 pad")
            .input_id(InputId::new(BusType::BUS_USB, vendor, product, 0x0114))
            .with_keys(&keys)?;
        let [x, y, z, rx, ry, rz] = [stick, stick, trigger, stick, stick, trigger];
        let axes = [
            (0, x),
            (1, y),
            (2, z),
            (3, rx),
            (4, ry),
            (5, rz),
            (16, hat),
            (17, hat),
        ];
        for (axis, range) in axes {
            let setup = UinputAbsSetup::new(AbsoluteAxisCode(axis), range);
            pad = pad.with_absolute_axis(&setup)?;
        }
        Ok(Self(pad.build()?))
    }

    fn key(&mut self, code: u16, is_down: bool) -> Result<()> {
        let event = InputEvent::new(EventType::KEY.0, code, i32::from(is_down));
        Ok(self.0.emit(&[event])?)
    }

    fn axis(&mut self, code: u16, value: i32) -> Result<()> {
        let event = InputEvent::new(EventType::ABSOLUTE.0, code, value);
        Ok(self.0.emit(&[event])?)
    }
}

/// An assistive switch box: buttons without a gamepad's layout.
pub struct SwitchBox(VirtualDevice);

impl SwitchBox {
    pub fn plug_in() -> Result<Self> {
        // BTN_0 and following. Two unused axes: without them gilrs does not accept the device as a gamepad.
        let keys = AttributeSet::from_iter((FIRST_SWITCH..FIRST_SWITCH + 4).map(KeyCode));
        let axis = AbsInfo::new(0, 0, 255, 0, 0, 0);
        let mut made = VirtualDevice::builder()?
            .name("Switch interface")
            .input_id(InputId::new(BusType::BUS_USB, 0x1234, 0x0001, 1))
            .with_keys(&keys)?;
        for code in [AbsoluteAxisCode::ABS_VOLUME, AbsoluteAxisCode::ABS_MISC] {
            made = made.with_absolute_axis(&UinputAbsSetup::new(code, axis))?;
        }
        Ok(Self(made.build()?))
    }

    /// Presses or releases a switch, counted from 0.
    pub fn set(&mut self, switch: u16, is_down: bool) -> Result<()> {
        let code = FIRST_SWITCH + switch;
        let event = InputEvent::new(EventType::KEY.0, code, i32::from(is_down));
        Ok(self.0.emit(&[event])?)
    }
}

/// A running gelpad.
pub struct Gelpad {
    child: Child,
    trace: Lines<BufReader<ChildStdout>>,
    said: Lines<BufReader<std::process::ChildStderr>>,
}

impl Gelpad {
    /// Plays a profile with any gamepad.
    pub fn start(profile: &str, arguments: &[&str]) -> Result<Self> {
        std::fs::write(PLAYED, profile)?;
        let mut child = Command::new(env!("CARGO_BIN_EXE_gelpad"))
            .args(["play", PLAYED, "--source", "gamepad"])
            .args(["--headless"])
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .context("gelpad does not start")?;
        let stdout = child.stdout.take().context("no trace")?;
        let stderr = child.stderr.take().context("no messages")?;
        Ok(Self {
            child,
            trace: BufReader::new(stdout).lines(),
            said: BufReader::new(stderr).lines(),
        })
    }

    /// Waits for a message that contains these words.
    pub fn says(&mut self, words: &str) -> Result<()> {
        for line in self.said.by_ref() {
            let line = line?;
            eprintln!("gelpad: {line}");
            if line.contains(words) {
                return Ok(());
            }
        }
        bail!("gelpad ended before it said: {words}")
    }

    /// The next events of the trace, without their times.
    fn sends(&mut self, expected: &[&str]) -> Result<()> {
        for event in expected {
            let Some(line) = self.trace.next() else {
                bail!("gelpad ended before {event}");
            };
            let line = line?;
            eprintln!("gelpad sends: {line}");
            let (_, what) = line.split_once(' ').context("an event")?;
            ensure!(what == *event, "{line} instead of {event}");
        }
        Ok(())
    }

    /// The next two events of the trace, in either order.
    fn sends_in_any_order(&mut self, expected: [&str; 2]) -> Result<()> {
        let mut sent = Vec::new();
        for _ in expected {
            let line = self.trace.next().context("gelpad ended")??;
            eprintln!("gelpad sends: {line}");
            let (_, what) = line.split_once(' ').context("an event")?;
            sent.push(what.to_owned());
        }
        sent.sort();
        ensure!(sent == expected, "{sent:?} instead of {expected:?}");
        Ok(())
    }

    fn end(mut self) -> Result<Vec<String>> {
        let pid = rustix::process::Pid::from_child(&self.child);
        rustix::process::kill_process(pid, rustix::process::Signal::TERM)?;
        let rest = self.trace.by_ref().collect::<Result<_, _>>()?;
        let status = self.child.wait()?;
        ensure!(status.code() == Some(143), "gelpad ended: {status}");
        Ok(rest)
    }
}

/// `BTN_0`.
const FIRST_SWITCH: u16 = 0x100;
const A: u16 = 0x130;
const B: u16 = 0x131;
const X: u16 = 0x133;
const Y: u16 = 0x134;

pub fn play() -> Result<()> {
    let mut pad = Pad::plug_in(0x045e, 0x028e)?;
    let mut gelpad = Gelpad::start(PROFILE, &["--output", "trace"])?;
    gelpad.says("gamepad: ")?;

    pad.key(A, true)?;
    gelpad.sends(&["press key:f"])?;
    sleep(HELD);
    pad.key(A, false)?;
    gelpad.sends(&["release key:f"])?;
    // A bounce: it must have no effect.
    sleep(BOUNCE);
    pad.key(A, true)?;
    sleep(HELD);
    pad.key(A, false)?;
    sleep(BEYOND_BOUNCES);

    pad.axis(0, 32767)?;
    gelpad.sends(&["press key:right"])?;
    sleep(HELD);
    pad.axis(0, -32768)?;
    gelpad.sends(&["release key:right", "press key:left"])?;
    sleep(HELD);
    pad.axis(0, 0)?;
    gelpad.sends(&["release key:left"])?;
    pad.axis(17, -1)?;
    gelpad.sends(&["press key:up"])?;
    sleep(HELD);
    pad.axis(17, 0)?;
    gelpad.sends(&["release key:up"])?;

    // Unplugged with a button held and another toggled: both are released.
    pad.key(X, true)?;
    pad.key(X, false)?;
    pad.key(A, true)?;
    gelpad.sends(&["press key:g", "press key:f"])?;
    drop(pad);
    // The kernel releases a button of a device that goes; gelpad may see the device gone first.
    gelpad.sends_in_any_order(["release key:f", "release key:g"])?;
    gelpad.says("gamepad disconnected")?;
    let rest = gelpad.end()?;
    ensure!(rest.is_empty(), "unexpected events: {rest:?}");
    println!("played, and unplugged");
    Ok(())
}

/// After being unplugged and plugged in again, the gamepad plays.
pub fn replug() -> Result<()> {
    let pad = Pad::plug_in(0x045e, 0x028e)?;
    let mut gelpad = Gelpad::start(PROFILE, &["--output", "trace"])?;
    gelpad.says("gamepad: ")?;
    sleep(LISTED);
    drop(pad);
    gelpad.says("gamepad disconnected")?;
    let mut pad = Pad::plug_in(0x045e, 0x028e)?;
    gelpad.says("gamepad: ")?;
    pad.key(A, true)?;
    gelpad.sends(&["press key:f"])?;
    pad.key(A, false)?;
    gelpad.sends(&["release key:f"])?;
    let rest = gelpad.end()?;
    ensure!(rest.is_empty(), "unexpected events: {rest:?}");
    println!("unplugged, plugged in again");
    Ok(())
}

/// A gamepad plays gelpad's own pad, which looks like it: the events of that pad must not come back in.
pub fn play_beside_own() -> Result<()> {
    let mut pad = Pad::plug_in(0x045e, 0x028e)?;
    let mut gelpad = Gelpad::start(PROFILE, &["--output", "gamepad"])?;
    gelpad.says("gamepad: ")?;
    let mut own = own_keyboard()?;
    sleep(LISTED);
    pad.key(A, true)?;
    ensure!(as_evdev::report(&mut own)? == [(1, 33, 1)], "f goes down");
    pad.key(A, false)?;
    ensure!(as_evdev::report(&mut own)? == [(1, 33, 0)], "f comes up");
    // The gamepad is unplugged while gelpad's own pad remains: no gamepad plays any more.
    drop(pad);
    gelpad.says("gamepad disconnected")?;
    gelpad.end()?;
    Ok(())
}

fn own_keyboard() -> Result<Device> {
    for _ in 0..100 {
        let found = evdev::enumerate().find(|(_, device)| device.name() == Some("gelpad keyboard"));
        if let Some((_, device)) = found {
            return Ok(device);
        }
        sleep(HELD);
    }
    bail!("gelpad makes no keyboard")
}
