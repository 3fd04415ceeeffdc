//! What the window and the terminal show of a running game; they always get the newest view.

use std::collections::VecDeque;
use std::sync::Arc;

use super::StageLatencies;
use crate::profile::Profile;
use crate::types::{Contact, Event, Image, Nanos, Output, Touch};

/// The state of play after one frame.
#[derive(Clone, Debug)]
pub struct View {
    /// Time of the newest frame.
    pub t_ns: Nanos,
    /// The profile in force.
    pub profile: Arc<Profile>,
    /// Whether play is paused.
    pub paused: bool,
    /// The newest image.
    pub image: Image,
    /// Touches that are down.
    pub touches: Vec<Touch>,
    /// Outputs that are down.
    pub held: Vec<Output>,
    /// The last events, oldest first.
    pub events: VecDeque<Event>,
    /// Events since the start: their difference between two views tells how many in `events` are new.
    pub events_so_far: u64,
    /// Voltages of the newest frame, and what was made of them.
    pub signals: Signals,
    /// Frames since the start.
    pub frames: u64,
    /// Frames that were lost or garbled.
    pub lost_frames: u64,
    /// Electrodes that are excluded, counted from 0.
    pub lost_electrodes: Vec<usize>,
    /// Frames a second, over about the last second.
    pub frames_per_s: f64,
    /// From a frame's arrival to its events, median since the start, us.
    pub latency_us: u64,
    /// Latency of each stage since the start.
    pub stages: StageLatencies,
    /// Events that were sent late since the start.
    pub late_events: u64,
    /// Rumble that the game requests: strong and weak motor, 0..1.
    pub rumble: [f32; 2],
}

/// The measurement of one frame, channel by channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Signals {
    /// The measured voltages.
    pub volts: Vec<f32>,
    /// Whether the board was plugged in again, turned: its voltages are then in another order than everything else here.
    pub is_turned: bool,
    /// Their relative change against the reference; empty before there is one.
    pub changes: Vec<f32>,
    /// The part of the change that the touches explain; the rest is the residual of the fit.
    pub explained: Vec<f32>,
    /// Contacts that are down, before a calibration corrects their places.
    pub contacts: Vec<Contact>,
    /// Voltages of the untouched pad, at most half a second old.
    pub reference: Vec<f32>,
    /// Relative standard deviation from frame to frame; infinite for an excluded channel.
    pub noise: Vec<f32>,
}

impl View {
    /// The view before the first frame.
    #[must_use]
    pub fn blank(profile: Arc<Profile>, image: Image) -> Self {
        Self {
            t_ns: 0,
            profile,
            paused: false,
            image,
            touches: Vec::new(),
            held: Vec::new(),
            events: VecDeque::new(),
            events_so_far: 0,
            signals: Signals::default(),
            frames: 0,
            lost_frames: 0,
            lost_electrodes: Vec::new(),
            frames_per_s: 0.0,
            latency_us: 0,
            stages: StageLatencies::default(),
            late_events: 0,
            rumble: [0.0; 2],
        }
    }
}
