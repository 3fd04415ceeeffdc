//! Frames, events and gamepad states in the JSON of a recording.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD_NO_PAD as BASE64;
use serde::{Deserialize, Serialize};

use super::volts::{self, MOST_FRAMES, VoltsDecoder, VoltsEncoder};
use crate::types::{Action, Axis, Buttons, Control, Event, Frame, Nanos, Output};

/// A later time, thirty years, is damage.
pub(super) const LATEST_NS: Nanos = 1_000_000_000_000_000_000;

/// Consecutive frames.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FrameBlock {
    /// Time of the first frame.
    t_ns: Nanos,
    /// Time from each frame to the next.
    dt_ns: Vec<Nanos>,
    /// Base64 of a block of [`volts`].
    volts: String,
}

impl FrameBlock {
    pub(super) fn new(frames: &[Frame], encoder: Option<&mut VoltsEncoder>) -> Self {
        let volts: Vec<&[f32]> = frames.iter().map(|frame| frame.volts.as_slice()).collect();
        let bytes = match encoder {
            Some(encoder) => encoder.encode(&volts),
            None => volts::plain(&volts),
        };
        Self {
            t_ns: frames.first().map_or(0, |frame| frame.t_ns),
            dt_ns: frames
                .windows(2)
                .map(|pair| pair[1].t_ns.wrapping_sub(pair[0].t_ns))
                .collect(),
            volts: BASE64.encode(bytes),
        }
    }

    pub(super) fn into_frames(self, decoder: &mut VoltsDecoder) -> Result<Vec<Frame>, String> {
        if self.dt_ns.len() >= MOST_FRAMES {
            return Err(format!("more than {MOST_FRAMES} frames in a block"));
        }
        let bytes = BASE64
            .decode(&self.volts)
            .map_err(|error| error.to_string())?;
        let volts = decoder
            .decode(self.dt_ns.len() + 1, &bytes)
            .map_err(|error| error.to_string())?;
        let mut t_ns = self.t_ns;
        let mut dt_ns = self.dt_ns.into_iter();
        let frame = |volts| {
            let frame = Frame { t_ns, volts };
            t_ns = t_ns.wrapping_add(dt_ns.next().unwrap_or(0));
            frame
        };
        let frames: Vec<Frame> = volts.into_iter().map(frame).collect();
        if frames.iter().any(|frame| frame.t_ns > LATEST_NS) {
            return Err("a time out of range".to_owned());
        }
        Ok(frames)
    }
}

/// An event, each value in a field of its own so that tools can plot it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EventLine {
    t_ns: Nanos,
    action: String,
    /// As in traces: `key:space`, `pad:left-x`, `mouse`.
    target: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    value: Option<f32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    dx: Option<i32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    dy: Option<i32>,
}

impl From<&Event> for EventLine {
    fn from(event: &Event) -> Self {
        let (action, target, value, moved) = match event.action {
            Action::Press(output) => ("press", output.to_string(), None, None),
            Action::Release(output) => ("release", output.to_string(), None, None),
            Action::Axis(axis, value) => ("axis", format!("pad:{axis}"), Some(value), None),
            Action::Motion { dx, dy } => ("motion", "mouse".to_owned(), None, Some([dx, dy])),
            Action::Wheel { dx, dy } => ("wheel", "mouse".to_owned(), None, Some([dx, dy])),
        };
        Self {
            t_ns: event.t_ns,
            action: action.to_owned(),
            target,
            value,
            dx: moved.map(|[dx, _]| dx),
            dy: moved.map(|[_, dy]| dy),
        }
    }
}

impl EventLine {
    pub(super) fn into_event(self) -> Result<Event, String> {
        let output = || {
            self.target
                .parse::<Output>()
                .map_err(|error| error.to_string())
        };
        let (dx, dy) = (self.dx.unwrap_or(0), self.dy.unwrap_or(0));
        let action = match self.action.as_str() {
            "press" => Action::Press(output()?),
            "release" => Action::Release(output()?),
            "axis" => {
                let name = self.target.strip_prefix("pad:").unwrap_or_default();
                let axis = name
                    .parse()
                    .map_err(|error: crate::types::UnknownName| error.to_string())?;
                Action::Axis(axis, self.value.unwrap_or(0.0))
            }
            "motion" => Action::Motion { dx, dy },
            "wheel" => Action::Wheel { dx, dy },
            other => return Err(format!("unknown action `{other}`")),
        };
        Ok(Event {
            t_ns: self.t_ns,
            action,
        })
    }
}

/// The whole state of a gamepad.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GamepadLine {
    t_ns: Nanos,
    present: bool,
    /// One bit for each button, in the order of `Button::ALL`.
    buttons: u16,
    /// In the order of `Axis::ALL`.
    axes: [f32; Axis::ALL.len()],
}

impl From<&Control> for GamepadLine {
    fn from(control: &Control) -> Self {
        Self {
            t_ns: control.t_ns,
            present: control.present,
            buttons: control.buttons.bits(),
            axes: control.axes,
        }
    }
}

impl GamepadLine {
    pub(super) fn into_control(self) -> Result<Control, String> {
        if self.axes.iter().any(|value| !(-1.0..=1.0).contains(value)) {
            return Err("an axis out of range".to_owned());
        }
        Ok(Control {
            t_ns: self.t_ns,
            present: self.present,
            buttons: Buttons::from_bits(self.buttons),
            axes: self.axes,
        })
    }
}
