//! gelpad: play games on a soft sheet of hydrogel.
//!
//! Frames of voltages go in, key and gamepad events come out; every stage between is a function of the output of the
//! stage before. See ARCHITECTURE.md.

#![warn(missing_docs, unreachable_pub, clippy::print_stdout)]

pub mod app;
pub mod cache;
pub mod calibrate;
pub mod cli;
pub mod doctor;
pub mod eit;
pub mod engine;
pub mod files;
pub mod gesture;
#[cfg(feature = "gui")]
pub mod gui;
pub mod output;
pub mod pad;
pub mod platform;
pub mod profile;
pub mod runtime;
pub mod session;
pub mod source;
pub mod stats;
pub mod study;
pub mod tape;
pub mod touch;
pub mod types;
