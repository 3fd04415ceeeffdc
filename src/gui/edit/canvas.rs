//! The live image with the regions, to drag: what is under the mouse, what is dragged, the handles of what is chosen.

use egui::{Color32, CursorIcon, Pos2, Rect, Sense, Stroke, Ui, Vec2};

use super::shape::{Grip, dragged, grip_at};
use super::{Drag, EditView, Learning};
use crate::gui::desk::Desk;
use crate::gui::picture::Shown;
use crate::gui::place::Place;
use crate::gui::playing::Playing;
use crate::gui::press::press;
use crate::gui::theme;
use crate::profile::Profile;

/// An edge is taken hold of from so near, points.
const NEAR: f32 = 9.0;

impl EditView {
    /// The live image with the regions, to drag.
    pub(super) fn pad(&mut self, ui: &mut Ui, room: Rect, playing: &mut Playing, desk: &dyn Desk) {
        let shown = Shown {
            regions: true,
            electrodes: false,
            scale: false,
        };
        let profile = self
            .profile()
            .cloned()
            .unwrap_or_else(|| (*playing.view.profile).clone());
        let place = self.picture.draw(ui, room, playing, &profile, shown);
        let id = ui.scope_id().with("edit pad");
        let response = ui.interact(place.rect, id, Sense::click_and_drag());
        response.widget_info(|| {
            egui::WidgetInfo::labeled(
                egui::Role::Canvas,
                true,
                "Regions on the pad: drag to move, drag an edge to resize",
            )
        });
        if self.learning != Learning::No {
            // Whoever is asked to press here presses the simulated pad.
            press(ui, &response, &place, playing);
            self.mark(ui, &place, &profile);
            return;
        }
        let share = |at: Pos2| {
            let [x, y] = place.to_seen(at);
            [x / place.seen_mm[0], y / place.seen_mm[1]]
        };
        let near = [0, 1].map(|i| f64::from(NEAR / place.points_per_mm()) / place.seen_mm[i]);
        let under = |at: Pos2| -> Option<(usize, Grip)> {
            profile
                .regions
                .iter()
                .enumerate()
                .find_map(|(index, region)| {
                    let placed = region.placed(place.seen_mm, &profile.settings.area);
                    let (low, high) = placed.bounds_mm();
                    let shares = |p: [f64; 2]| [p[0] / place.seen_mm[0], p[1] / place.seen_mm[1]];
                    Some((index, grip_at(share(at), shares(low), shares(high), near)?))
                })
        };
        if let Some((_, grip)) = response.hover_pos().and_then(under) {
            ui.ctx().set_cursor_icon(cursor(grip));
        }
        let pressed_at = ui.input(|input| input.pointer.press_origin());
        if response.clicked() || response.drag_started() {
            let hit = pressed_at
                .or(response.interact_pointer_pos())
                .and_then(under);
            match hit {
                Some((index, grip)) => {
                    let region = &profile.regions[index];
                    self.choose(&region.name);
                    self.drag = response.drag_started().then(|| Drag {
                        region: region.name.clone(),
                        grip,
                        shape: region.shape.clone(),
                        from: pressed_at.unwrap_or_default(),
                    });
                }
                None => self.chosen = None,
            }
        }
        if let (Some(drag), Some(at)) = (self.drag.clone(), response.interact_pointer_pos())
            && response.dragged()
        {
            let area = &profile.settings.area;
            let [x0, y0] = share(drag.from);
            let [x1, y1] = share(at);
            let by = [(x1 - x0) / area.w, (y1 - y0) / area.h];
            match dragged(&drag.shape, drag.grip, by) {
                Some(numbers) => self.change(&playing.choice, desk, |document| {
                    document.set_region(&drag.region, &numbers)
                }),
                None => {
                    self.notice =
                        Some("a polygon is moved in its text: its corners are `points`".to_owned());
                }
            }
        }
        if response.drag_stopped() {
            self.drag = None;
            if let Some(opened) = &mut self.opened {
                opened.document.settle();
            }
        }
        self.mark(ui, &place, &profile);
    }

    /// The chosen region's handles.
    fn mark(&self, ui: &Ui, place: &Place, profile: &Profile) {
        let Some(region) = profile
            .regions
            .iter()
            .find(|region| Some(&region.name) == self.chosen.as_ref())
        else {
            return;
        };
        let placed = region.placed(place.seen_mm, &profile.settings.area);
        let (low, high) = placed.bounds_mm();
        let bounds = Rect::from_two_pos(place.of_seen(low), place.of_seen(high));
        let accent = theme::palette(true).accent;
        let line = Stroke::new(2.0, accent);
        ui.painter()
            .rect_stroke(bounds, 2.0, line, egui::StrokeKind::Middle);
        for at in [
            bounds.left_top(),
            bounds.center_top(),
            bounds.right_top(),
            bounds.left_center(),
            bounds.right_center(),
            bounds.left_bottom(),
            bounds.center_bottom(),
            bounds.right_bottom(),
        ] {
            let handle = Rect::from_center_size(at, Vec2::splat(8.0));
            ui.painter().rect(
                handle,
                2.0,
                Color32::WHITE,
                Stroke::new(1.0, accent),
                egui::StrokeKind::Middle,
            );
        }
    }
}

fn cursor(grip: Grip) -> CursorIcon {
    match grip {
        Grip::Whole => CursorIcon::Grab,
        Grip::Edge(0, _) => CursorIcon::ResizeVertical,
        Grip::Edge(_, 0) => CursorIcon::ResizeHorizontal,
        Grip::Edge(x, y) if x == y => CursorIcon::ResizeNeSw,
        Grip::Edge(..) => CursorIcon::ResizeNwSe,
    }
}
