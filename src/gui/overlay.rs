//! Drawn on the picture of the pad: edge, electrodes, regions, touches and their paths.

use egui::epaint::{PathShape, PathStroke};
use egui::{Align2, Color32, FontId, Pos2, Rect, Stroke, Ui, Vec2};

use super::history::Stroke as TouchStroke;
use super::place::PadTransform;
use super::playing::Playing;
use super::regions::{RegionState, region_title};
use super::theme;
use crate::pad::Outline;
use crate::profile::Profile;
use crate::runtime::View;
use crate::types::{NANOS_PER_MS, Nanos, Touch};

/// How long the path of a touch stays visible.
const TRAIL_NS: Nanos = 600 * NANOS_PER_MS;
/// Smallest text on the pad, points.
const MIN_TEXT: f32 = 10.0;

/// The elapsed share of the time before a touch counts (slow keys, dwell); none without such a time.
pub(super) fn wait_share(view: &View, touch: &Touch) -> Option<f32> {
    let settings = &view.profile.settings;
    let wait_ns = settings.dwell_ns.max(settings.slow_keys_ns);
    if wait_ns == 0 {
        return None;
    }
    let age_ns = view.t_ns.saturating_sub(touch.since_ns);
    Some((age_ns as f32 / wait_ns as f32).min(1.0))
}

/// The edge of the pad.
pub(super) fn outline(painter: &egui::Painter, place: &PadTransform, outline: &Outline, ui: &Ui) {
    let line = Stroke::new(1.5, theme::palette_of(ui).line);
    match outline {
        Outline::Rectangle { .. } => {
            painter.rect_stroke(place.rect, 4.0, line, egui::StrokeKind::Outside);
        }
        Outline::Circle { .. } => {
            painter.circle_stroke(place.rect.center(), place.rect.width() / 2.0, line);
        }
    }
}

/// Electrodes as bars at the edge, numbered from 1; lost ones are crossed out.
pub(super) fn electrodes(
    painter: &egui::Painter,
    place: &PadTransform,
    playing: &Playing,
    ui: &Ui,
) {
    let palette = theme::palette_of(ui);
    let outline = &playing.pad.outline;
    let [w, h] = outline.size_mm();
    for (index, electrode) in playing.pad.electrodes.iter().enumerate() {
        let lost = playing.view.lost_electrodes.contains(&index);
        let colour = if lost { palette.bad } else { palette.weak };
        let ends = [electrode.start_mm, electrode.end_mm()]
            .map(|s| place.screen_from_pad(outline.point_at(s)));
        painter.line_segment(ends, Stroke::new(4.0, colour));
        let middle = outline.point_at((electrode.start_mm + electrode.end_mm()) / 2.0);
        let out = [middle[0] - w / 2.0, middle[1] - h / 2.0];
        let length = out[0].hypot(out[1]).max(1e-9);
        let beyond = 4.5 * 3.0 / f64::from(place.points_per_mm());
        let at = place.screen_from_pad([
            middle[0] + out[0] / length * beyond,
            middle[1] + out[1] / length * beyond,
        ]);
        let label = if lost {
            format!("{}✖", index + 1)
        } else {
            (index + 1).to_string()
        };
        theme::centred_text(painter, at, label, 11.0, colour);
    }
}

/// A region with its name and outputs; filled while one of these is held.
pub(super) fn region(
    painter: &egui::Painter,
    place: &PadTransform,
    profile: &Profile,
    index: usize,
    state: &RegionState,
) {
    let region = &profile.regions[index];
    let placed = region.placed(place.seen_mm, &profile.settings.area);
    let corners: Vec<Pos2> = placed
        .corners_mm()
        .into_iter()
        .map(|corner| place.screen_from_seen(corner))
        .collect();
    let (low, high) = placed.bounds_mm();
    let bounds = Rect::from_two_pos(place.screen_from_seen(low), place.screen_from_seen(high));
    let accent = theme::palette(true).accent;
    let (line, fill) = if state.held {
        (Stroke::new(3.0, accent), accent.gamma_multiply(0.28))
    } else {
        let white = Color32::from_white_alpha(if region.rest { 70 } else { 130 });
        (Stroke::new(1.2, white), Color32::from_white_alpha(9))
    };
    if corners.len() == 4 || corners.len() > 16 {
        let inset = bounds.shrink(1.5);
        if corners.len() == 4 && is_box(&corners) {
            painter.rect(inset, 5.0, fill, line, egui::StrokeKind::Inside);
        } else {
            painter.add(PathShape::convex_polygon(corners, fill, line));
        }
    } else {
        painter.add(PathShape::closed_line(corners, PathStroke::from(line)));
    }
    region_label(painter, bounds, &region_title(profile, index), state);
}

fn is_box(corners: &[Pos2]) -> bool {
    let bounds = Rect::from_points(corners);
    corners.iter().all(|corner| {
        (corner.x == bounds.left() || corner.x == bounds.right())
            && (corner.y == bounds.top() || corner.y == bounds.bottom())
    })
}

/// The title of a region, and below it its outputs where they are not the title: as large as the region allows.
fn region_label(painter: &egui::Painter, bounds: Rect, title: &str, state: &RegionState) {
    let letters = title.chars().count().max(1) as f32;
    let one_line = (bounds.width() / letters * 1.6)
        .min(bounds.height() * 0.4)
        .min(17.0);
    let has_outputs = !state.outputs.is_empty() && state.outputs != title;
    // Both lines, with half a line of room above and below.
    let shared = one_line.min(bounds.height() / 3.2);
    let two_lines = has_outputs && shared >= MIN_TEXT;
    let size = if two_lines { shared } else { one_line };
    if size < MIN_TEXT {
        return;
    }
    let colour = if state.held {
        Color32::WHITE
    } else {
        Color32::from_white_alpha(215)
    };
    let at = bounds.center() - Vec2::new(0.0, if two_lines { size * 0.6 } else { 0.0 });
    let text = if state.held {
        format!("▼ {title}")
    } else {
        title.to_owned()
    };
    theme::centred_text(painter, at, text, size, colour);
    if two_lines {
        let below = bounds.center() + Vec2::new(0.0, size * 0.65);
        let font = FontId::monospace((size * 0.8).max(MIN_TEXT));
        painter.text(
            below,
            Align2::CENTER_CENTER,
            &state.outputs,
            font,
            Color32::from_white_alpha(if state.held { 255 } else { 165 }),
        );
    }
}

/// The recent path of a touch, fading.
pub(super) fn trail(
    painter: &egui::Painter,
    place: &PadTransform,
    stroke: &TouchStroke,
    now_ns: Nanos,
) {
    let colour = theme::touch(stroke.id);
    let recent = |t_ns: Nanos| now_ns.saturating_sub(t_ns) < TRAIL_NS;
    let moments = stroke.moments.iter().filter(|m| recent(m.t_ns));
    let mut last: Option<Pos2> = None;
    for moment in moments {
        let at = place.screen_from_pad(moment.place_mm);
        if let Some(from) = last {
            let age = now_ns.saturating_sub(moment.t_ns) as f32 / TRAIL_NS as f32;
            let width = 1.0 + 5.0 * moment.force * (1.0 - age);
            let line = Stroke::new(width, colour.gamma_multiply(0.8 * (1.0 - age)));
            painter.line_segment([from, at], line);
        }
        last = Some(at);
    }
}

/// A touch: its area, its force as an arc, its id. A white arc shows `wait_share`.
pub(super) fn touch(
    painter: &egui::Painter,
    place: &PadTransform,
    touch: &Touch,
    wait_share: Option<f32>,
) {
    let colour = theme::touch(touch.id.0);
    let at = place.screen_from_pad(touch.contact.centre_mm);
    let radius_mm = (touch.contact.area_mm2 / std::f64::consts::PI)
        .max(0.0)
        .sqrt() as f32;
    let radius = (radius_mm * place.points_per_mm()).clamp(9.0, 60.0);
    painter.circle(
        at,
        radius,
        colour.gamma_multiply(0.25),
        Stroke::new(1.5, colour),
    );
    let force = touch.contact.force.clamp(0.0, 1.0) as f32;
    arc(painter, at, radius + 5.0, force, Stroke::new(3.5, colour));
    if let Some(share) = wait_share {
        let line = Stroke::new(3.0, Color32::WHITE);
        arc(painter, at, radius + 10.0, share, line);
    }
    painter.circle_filled(at, 8.5, Color32::from_black_alpha(190));
    theme::centred_text(
        painter,
        at,
        (touch.id.0 % 100).to_string(),
        12.0,
        Color32::WHITE,
    );
}

/// A share of a circle, clockwise from the top.
fn arc(painter: &egui::Painter, centre: Pos2, radius: f32, share: f32, line: Stroke) {
    const STEPS: f32 = 40.0;
    let steps = (share * STEPS).ceil() as usize;
    if steps == 0 {
        return;
    }
    let points = (0..=steps)
        .map(|step| {
            let angle = std::f32::consts::TAU * share * step as f32 / steps as f32;
            centre + radius * Vec2::new(angle.sin(), -angle.cos())
        })
        .collect();
    painter.add(PathShape::line(points, PathStroke::from(line)));
}
