//! gelpad: play games on a soft sheet of hydrogel.
//!
//! Frames of voltages go in, key and gamepad events come out; every stage between is a function of the output of the
//! stage before. See ARCHITECTURE.md.

#![warn(missing_docs, unreachable_pub, clippy::print_stdout)]

/// Temporary.
pub fn knob(name: &str, default: f64) -> f64 {
    use std::collections::BTreeMap;
    use std::sync::{Mutex, OnceLock};
    static KNOBS: OnceLock<Mutex<BTreeMap<String, f64>>> = OnceLock::new();
    let mut all = KNOBS.get_or_init(Mutex::default).lock().unwrap_or_else(|e| e.into_inner());
    if let Some(v) = all.get(name) { return *v; }
    let v = std::env::var(name).ok().and_then(|t| t.parse().ok()).unwrap_or(default);
    all.insert(name.to_owned(), v);
    v
}

pub mod app;
pub mod cache;
pub mod calibrate;
pub mod cli;
#[cfg(target_os = "linux")]
pub mod doctor;
pub mod eit;
pub mod engine;
pub mod gesture;
#[cfg(feature = "gui")]
pub mod gui;
pub mod output;
pub mod pad;
pub mod profile;
pub mod runtime;
pub mod session;
pub mod source;
pub mod stats;
pub mod study;
pub mod tape;
pub mod touch;
pub mod types;
