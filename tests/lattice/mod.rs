//! The frames of an independent simulator (tests/data/lattice-presses) and the pad to read them with.

// Each test uses a part of this module.
#![allow(dead_code)]

use std::fs;
use std::path::PathBuf;
use std::sync::OnceLock;

use gelpad::cache;
use gelpad::pad::{DEFAULT_PAD, Pad, shipped_pad};
use gelpad::touch::SensingBuilder;
use gelpad::types::Method;
use serde::Deserialize;

/// The pad of the frames.
pub fn pad() -> Pad {
    let shipped = shipped_pad(DEFAULT_PAD).expect("shipped");
    Pad::from_toml(shipped.name, shipped.toml).expect("valid")
}

/// The pad's sensing builder; its response table is solved once and cached.
pub fn builder() -> &'static SensingBuilder {
    static BUILDER: OnceLock<SensingBuilder> = OnceLock::new();
    BUILDER.get_or_init(|| {
        cache::sensing_builder(&pad(), Method::Tikhonov, |_, _| ()).expect("solvable")
    })
}

pub fn data(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/lattice-presses")
        .join(name)
}

/// A line of `static.truth.jsonl`.
#[derive(Deserialize)]
pub struct Truth {
    pub touches: Vec<TrueTouch>,
}

#[derive(Deserialize)]
pub struct TrueTouch {
    pub x_mm: f64,
    pub y_mm: f64,
}

/// `static.csv`: the untouched pad, then a hundred frames each of one, two and three touches, without noise.
pub fn static_frames() -> Vec<Vec<f64>> {
    csv::Reader::from_path(data("static.csv"))
        .expect("static.csv")
        .deserialize()
        .map(|row| {
            let row: Vec<f64> = row.expect("numbers");
            row[1..].to_vec()
        })
        .collect()
}

pub fn static_truths() -> Vec<Truth> {
    lines("static.truth.jsonl")
}

/// A press of the session, s and mm.
#[derive(Clone, Deserialize)]
pub struct Press {
    pub t0: f64,
    pub t1: f64,
    pub x: f64,
    pub y: f64,
    pub kind: String,
}

pub fn session_presses() -> Vec<Press> {
    lines("session.truth.jsonl")
}

fn lines<T: for<'a> Deserialize<'a>>(name: &str) -> Vec<T> {
    fs::read_to_string(data(name))
        .expect("the truth")
        .lines()
        .map(|line| serde_json::from_str(line).expect("one truth per line"))
        .collect()
}
