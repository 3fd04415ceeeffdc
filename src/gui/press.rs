//! What mouse, touch screen and keyboard do on the picture of the simulated pad: fingers on it.

use egui::{Event, Key, MouseWheelUnit, PointerButton, Response, TouchPhase, Ui};

use super::fingers::Holder;
use super::place::Place;
use super::playing::Playing;
use crate::types::PointMm;

/// Points of a smooth wheel for a notch.
const POINTS_PER_NOTCH: f64 = 40.0;

/// Lets the player press the pad where it is drawn; `response` is the picture's.
pub fn press(ui: &Ui, response: &Response, place: &Place, playing: &mut Playing) {
    if !playing.has_hand() {
        return;
    }
    let events = ui.input(|input| input.events.clone());
    let over = response.contains_pointer();
    let mut changed = false;
    // A touch screen's first finger comes as a mouse too.
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
                    changed |= fingers.press(Holder::Mouse, place.to_pad(*pos));
                }
            }
            Event::PointerMoved(pos) if fingers.mouse_is_down() => {
                changed |= fingers.slide(Holder::Mouse, within(place, place.to_pad(*pos)));
            }
            Event::Touch { id, phase, pos, .. } => {
                let holder = Holder::Screen(id.0);
                changed |= match phase {
                    TouchPhase::Start if place.rect.contains(*pos) => {
                        fingers.press(holder, place.to_pad(*pos))
                    }
                    TouchPhase::Move => fingers.slide(holder, within(place, place.to_pad(*pos))),
                    TouchPhase::End | TouchPhase::Cancel => fingers.lift(holder),
                    TouchPhase::Start => false,
                };
            }
            Event::MouseWheel { unit, delta, .. } if over => {
                let notches = match unit {
                    MouseWheelUnit::Line | MouseWheelUnit::Page => f64::from(delta.y),
                    MouseWheelUnit::Point => f64::from(delta.y) / POINTS_PER_NOTCH,
                };
                changed |= fingers.harder(notches);
            }
            Event::Key {
                key,
                pressed,
                repeat: false,
                ..
            } if response.has_focus() => changed |= by_key(*key, *pressed, place, playing),
            _ => {}
        }
    }
    if changed {
        playing.press();
        ui.ctx().request_repaint();
    }
}

/// Space pins, Escape lifts all, digits press regions.
fn by_key(key: Key, pressed: bool, place: &Place, playing: &mut Playing) -> bool {
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
            let at = place.to_pad(place.of_seen(placed.centre_mm()));
            playing.fingers.press(holder, at)
        }
    }
}

fn digit(key: Key) -> Option<u8> {
    const DIGITS: [Key; 9] = [
        Key::Num1,
        Key::Num2,
        Key::Num3,
        Key::Num4,
        Key::Num5,
        Key::Num6,
        Key::Num7,
        Key::Num8,
        Key::Num9,
    ];
    let index = DIGITS.iter().position(|known| *known == key)?;
    u8::try_from(index + 1).ok()
}

/// A finger that slides off the pad stays at its edge.
fn within(place: &Place, [x, y]: PointMm) -> PointMm {
    let [width, height] = place.pad_mm;
    [x.clamp(0.0, width), y.clamp(0.0, height)]
}
