//! Time from an event to the client that reads it, on the bench's own X11 display without a screen.
//!
//! `cargo bench --bench x11 [EVENTS]`: cost of sending an event, and time until a client has read it, with
//! the watcher (as in play) and without. Needs the Debian package xvfb.

#![allow(
    clippy::disallowed_methods,
    clippy::print_stdout,
    reason = "it measures and prints"
)]

#[path = "../tests/game/process.rs"]
#[allow(dead_code, reason = "what a bench does not wait for")]
mod process;
#[path = "../tests/game/server.rs"]
mod server;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use gelpad::output::OutputDevice;
use gelpad::platform::linux::x11::X11;
use gelpad::platform::watch::WatchedDevice;
use gelpad::types::{Action, Event};
use x11rb::connection::Connection as _;
use x11rb::protocol::Event as ServerEvent;
use x11rb::protocol::xproto::{
    ConnectionExt as _, CreateWindowAux, EventMask, InputFocus, WindowClass,
};
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

/// Number of events without an argument.
const EVENTS: usize = 4000;
/// Time between two events.
const PAUSE: Duration = Duration::from_millis(2);

fn main() -> Result<()> {
    let count = std::env::args().filter_map(|text| text.parse().ok()).next();
    let count = count.unwrap_or(EVENTS);
    let folder = tempfile::tempdir()?;
    let (_server, display) = server::start_server(Path::new("Xvfb"), folder.path())?;
    let display = display.to_string_lossy().into_owned();
    let reader = reader(&display)?;
    let bare = X11::connect_to(&display)?;
    measure("XTEST alone", &reader, Box::new(bare), count)?;
    let program = PathBuf::from(env!("CARGO_BIN_EXE_gelpad"));
    let watched = WatchedDevice::new(X11::connect_to(&display)?, program);
    measure("with the watcher", &reader, Box::new(watched), count)
}

/// A client whose window has the keyboard focus.
fn reader(display: &str) -> Result<RustConnection> {
    let (connection, screen) = x11rb::connect(Some(display))?;
    let root = connection.setup().roots[screen].root;
    let window = connection.generate_id()?;
    let events = EventMask::KEY_PRESS | EventMask::KEY_RELEASE | EventMask::STRUCTURE_NOTIFY;
    connection.create_window(
        x11rb::COPY_DEPTH_FROM_PARENT,
        window,
        root,
        0,
        0,
        100,
        100,
        0,
        WindowClass::INPUT_OUTPUT,
        x11rb::COPY_FROM_PARENT,
        &CreateWindowAux::new().event_mask(events),
    )?;
    connection.map_window(window)?;
    connection.flush()?;
    while !matches!(connection.wait_for_event()?, ServerEvent::MapNotify(_)) {}
    connection.set_input_focus(InputFocus::PARENT, window, x11rb::CURRENT_TIME)?;
    connection.sync()?;
    Ok(connection)
}

fn measure(
    name: &str,
    reader: &RustConnection,
    mut device: Box<dyn OutputDevice>,
    count: usize,
) -> Result<()> {
    let key = "key:f".parse().context("a key")?;
    let mut sent_us = Vec::with_capacity(count);
    let mut read_us = Vec::with_capacity(count);
    for index in 0..count {
        let action = if index % 2 == 0 {
            Action::Press(key)
        } else {
            Action::Release(key)
        };
        std::thread::sleep(PAUSE);
        device.idle()?;
        let start = Instant::now();
        device.send(&Event { t_ns: 0, action })?;
        device.flush()?;
        sent_us.push(start.elapsed().as_secs_f64() * 1e6);
        while !matches!(
            reader.wait_for_event()?,
            ServerEvent::KeyPress(_) | ServerEvent::KeyRelease(_)
        ) {}
        read_us.push(start.elapsed().as_secs_f64() * 1e6);
    }
    println!("{name}: {count} events");
    for (what, times) in [("sent", &mut sent_us), ("read by a client", &mut read_us)] {
        times.sort_by(f64::total_cmp);
        let at = |part: f64| times[((times.len() - 1) as f64 * part) as usize];
        println!(
            "  {what:16}  median {:6.0} us, p99 {:6.0} us, worst {:6.0} us",
            at(0.5),
            at(0.99),
            at(1.0)
        );
    }
    Ok(())
}
