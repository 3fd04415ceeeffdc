//! Mouse, touch screen and keyboard input on the picture of the simulated pad.

use egui::{Event, Key, MouseWheelUnit, PointerButton, Response, TouchPhase, Ui};

use super::fingers::Holder;
use super::place::PadTransform;
use super::playing::Playing;
use crate::types::PointMm;

/// Points of a smooth wheel per notch.
const POINTS_PER_NOTCH: f64 = 40.0;

/// How long a button is held before it repeats, and how often it does, s. A slow click is shorter.
const REPEATS_AFTER_S: f64 = 1.5;
const REPEAT_S: f64 = 0.2;

/// Steps of a button in this pass: one for a click, or several while it is held.
pub fn button_steps(ui: &Ui, button: &Response) -> u32 {
    let id = button.id.with("repeats");
    let made: u32 = ui.data(|data| data.get_temp(id)).unwrap_or(0);
    let pressed_at_s = ui.input(|input| input.pointer.press_start_time());
    let Some(pressed_at_s) = pressed_at_s.filter(|_| button.is_pointer_button_down_on()) else {
        ui.data_mut(|data| data.remove::<u32>(id));
        return u32::from(button.clicked() && made == 0);
    };
    ui.ctx().request_repaint_after_secs(REPEAT_S as f32);
    let held_s = ui.input(|input| input.time) - pressed_at_s;
    let due = ((held_s - REPEATS_AFTER_S) / REPEAT_S + 1.0).max(0.0) as u32;
    ui.data_mut(|data| data.insert_temp(id, due));
    due.saturating_sub(made)
}

/// Turns input on the picture, whose response is `response`, into fingers on the simulated pad.
pub fn handle_input(ui: &Ui, response: &Response, place: &PadTransform, playing: &mut Playing) {
    if !playing.is_simulated() {
        return;
    }
    let events = ui.input(|input| input.events.clone());
    let over = response.contains_pointer();
    let mut changed = false;
    // egui also reports the first finger of a touch screen as a mouse.
    let by_screen = ui.input(egui::InputState::any_touches);
    for event in &events {
        let fingers = &mut playing.fingers;
        match event {
            Event::PointerButton {
                pos,
                button: PointerButton::Primary,
                pressed,
                ..
            } if !by_screen => {
                if !*pressed {
                    changed |= fingers.lift(Holder::Mouse);
                } else if over && place.rect.contains(*pos) {
                    response.request_focus();
                    changed |= fingers.press(Holder::Mouse, place.pad_from_screen(*pos));
                }
            }
            Event::PointerButton {
                pos,
                button: PointerButton::Secondary,
                pressed: true,
                ..
            } if over && place.rect.contains(*pos) => {
                changed |= fingers.toggle_pin(place.pad_from_screen(*pos));
            }
            Event::PointerMoved(pos) if fingers.mouse_is_down() => {
                changed |= fingers.slide(
                    Holder::Mouse,
                    clamp_to_pad(place, place.pad_from_screen(*pos)),
                );
            }
            Event::Touch { id, phase, pos, .. } => {
                let holder = Holder::Screen(id.0);
                changed |= match phase {
                    TouchPhase::Start if place.rect.contains(*pos) => {
                        fingers.press(holder, place.pad_from_screen(*pos))
                    }
                    TouchPhase::Move => {
                        fingers.slide(holder, clamp_to_pad(place, place.pad_from_screen(*pos)))
                    }
                    TouchPhase::End | TouchPhase::Cancel => fingers.lift(holder),
                    TouchPhase::Start => false,
                };
            }
            Event::MouseWheel { unit, delta, .. } if over => {
                changed |= fingers.change_force(notches(*unit, delta.y));
            }
            Event::Key {
                key,
                pressed,
                repeat: false,
                ..
            } if response.has_focus() => changed |= handle_key(*key, *pressed, place, playing),
            _ => {}
        }
    }
    if changed {
        playing.send_fingers();
        ui.ctx().request_repaint();
    }
}

/// Lifts all fingers on Escape, if any is pinned, wherever the focus is; nothing else then acts on the key.
pub fn lift_pinned_on_escape(ui: &Ui, playing: &mut Playing) {
    if playing.fingers.pinned_mm().next().is_some()
        && ui.input_mut(|input| input.consume_key(egui::Modifiers::NONE, Key::Escape))
    {
        playing.fingers.lift_all();
        playing.send_fingers();
        ui.ctx().request_repaint();
    }
}

/// Notches of a turn of the wheel.
pub(super) fn notches(unit: MouseWheelUnit, delta: f32) -> f64 {
    match unit {
        MouseWheelUnit::Line | MouseWheelUnit::Page => f64::from(delta),
        MouseWheelUnit::Point => f64::from(delta) / POINTS_PER_NOTCH,
    }
}

/// Space pins the newest finger of the mouse or of a digit, Escape lifts all, digits press regions. Returns whether anything changed.
fn handle_key(key: Key, pressed: bool, place: &PadTransform, playing: &mut Playing) -> bool {
    match key {
        Key::Space if pressed => playing.fingers.pin(),
        Key::Escape if pressed => playing.fingers.lift_all(),
        _ => {
            let Some(digit) = digit(key) else {
                return false;
            };
            let holder = Holder::Digit(digit);
            if !pressed {
                return playing.fingers.lift(holder);
            }
            let profile = &playing.view.profile;
            let Some(region) = profile.regions.get(usize::from(digit - 1)) else {
                return false;
            };
            let placed = region.placed(place.seen_mm, &profile.settings.area);
            let at = place.pad_from_screen(place.screen_from_seen(placed.centre_mm()));
            playing.fingers.press(holder, at)
        }
    }
}

fn digit(key: Key) -> Option<u8> {
    let digit = key.name().parse().ok()?;
    (1..=9).contains(&digit).then_some(digit)
}

/// A finger that leaves the pad stays at its edge.
fn clamp_to_pad(place: &PadTransform, [x, y]: PointMm) -> PointMm {
    let [width, height] = place.pad_mm;
    [x.clamp(0.0, width), y.clamp(0.0, height)]
}
