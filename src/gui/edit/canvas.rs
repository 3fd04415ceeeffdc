//! The live image with the regions: select, drag and resize them.

use egui::{Color32, CursorIcon, Pos2, Rect, Response, Sense, Stroke, Ui, Vec2};

use super::shape::{Grip, dragged, grip_at};
use super::{BindStep, Drag, EditView, GameContext};
use crate::app::services::AppServices;
use crate::gui::picture::PictureLayers;
use crate::gui::place::PadTransform;
use crate::gui::playing::Playing;
use crate::gui::press::handle_input;
use crate::gui::theme;
use crate::profile::Profile;

/// Distance at which an edge can be grabbed, points.
const GRAB_POINTS: f32 = 9.0;
/// Size of the handles of the selected region, points.
const HANDLE_POINTS: f32 = 8.0;

impl EditView {
    pub(super) fn draw_canvas(
        &mut self,
        ui: &mut Ui,
        room: Rect,
        playing: &mut Playing,
        services: &dyn AppServices,
    ) {
        let shown = PictureLayers {
            image: true,
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
        if self.bind_step == BindStep::No {
            let (place, profile) = (&place, &profile);
            let canvas = Canvas { place, profile };
            self.handle_pointer(ui, &response, canvas, GameContext { playing, services });
        } else {
            // While binding, the mouse presses the simulated pad.
            handle_input(ui, &response, &place, playing);
        }
        self.draw_handles(ui, &place, &profile);
    }

    fn handle_pointer(
        &mut self,
        ui: &Ui,
        response: &Response,
        canvas: Canvas<'_>,
        game: GameContext<'_>,
    ) {
        if let Some((_, grip)) = response.hover_pos().and_then(|at| canvas.grip_at(at)) {
            ui.ctx().set_cursor_icon(cursor(grip));
        }
        if response.clicked() || response.drag_started() {
            let pressed_at = ui
                .input(|input| input.pointer.press_origin())
                .or(response.interact_pointer_pos());
            match pressed_at.and_then(|at| Some((at, canvas.grip_at(at)?))) {
                Some((from, (index, grip))) => {
                    let region = &canvas.profile.regions[index];
                    self.select_region(&region.name);
                    self.drag = response.drag_started().then(|| Drag {
                        region: region.name.clone(),
                        grip,
                        shape: region.shape.clone(),
                        from,
                    });
                }
                None => self.selected = None,
            }
        }
        if let (Some(drag), Some(at)) = (self.drag.clone(), response.interact_pointer_pos())
            && response.dragged()
        {
            if self.ask_if_in_grid(&drag.region) {
                self.drag = None;
                return;
            }
            match dragged(&drag.shape, drag.grip, canvas.offset(drag.from, at)) {
                Some(numbers) => {
                    self.change(game, |document| document.set_region(&drag.region, &numbers))
                }
                None => {
                    self.notice =
                        Some("to move a polygon, edit its `points` in the file".to_owned());
                }
            }
        }
        if response.drag_stopped() {
            self.drag = None;
            self.end_change();
        }
    }

    /// Outline and handles of the selected region.
    fn draw_handles(&self, ui: &Ui, place: &PadTransform, profile: &Profile) {
        let Some(region) = profile
            .regions
            .iter()
            .find(|region| Some(&region.name) == self.selected.as_ref())
        else {
            return;
        };
        let placed = region.placed(place.seen_mm, &profile.settings.area);
        let (low, high) = placed.bounds_mm();
        let bounds = Rect::from_two_pos(place.screen_from_seen(low), place.screen_from_seen(high));
        let accent = theme::palette(true).accent;
        let line = Stroke::new(2.0, accent);
        ui.painter()
            .rect_stroke(bounds, 2.0, line, egui::StrokeKind::Middle);
        let sides = [-1.0, 0.0, 1.0];
        let offsets = sides.map(|x| sides.map(|y| Vec2::new(x, y)));
        for offset in offsets.into_iter().flatten().filter(|o| *o != Vec2::ZERO) {
            let at = bounds.center() + offset * bounds.size() / 2.0;
            ui.painter().rect(
                Rect::from_center_size(at, Vec2::splat(HANDLE_POINTS)),
                2.0,
                Color32::WHITE,
                Stroke::new(1.0, accent),
                egui::StrokeKind::Middle,
            );
        }
    }
}

/// The regions of a profile where they are drawn.
#[derive(Clone, Copy)]
struct Canvas<'a> {
    place: &'a PadTransform,
    profile: &'a Profile,
}

impl Canvas<'_> {
    /// A point of the pad as fractions of its size.
    fn fractions(&self, [x_mm, y_mm]: [f64; 2]) -> [f64; 2] {
        [x_mm / self.place.seen_mm[0], y_mm / self.place.seen_mm[1]]
    }

    /// Index of the topmost region at a point of the window, and which part of it is there.
    fn grip_at(&self, at: Pos2) -> Option<(usize, Grip)> {
        let grab_mm = f64::from(GRAB_POINTS / self.place.points_per_mm());
        let point = self.fractions(self.place.seen_from_screen(at));
        let area = &self.profile.settings.area;
        let mut regions = self.profile.regions.iter().enumerate();
        regions.find_map(|(index, region)| {
            let placed = region.placed(self.place.seen_mm, area);
            let (low, high) = placed.bounds_mm();
            let near = self.fractions([grab_mm, grab_mm]);
            let grip = grip_at(point, self.fractions(low), self.fractions(high), near)?;
            Some((index, grip))
        })
    }

    /// From one point of the window to another, in fractions of the area that regions refer to.
    fn offset(&self, from: Pos2, to: Pos2) -> [f64; 2] {
        let area = &self.profile.settings.area;
        let [x0, y0] = self.fractions(self.place.seen_from_screen(from));
        let [x1, y1] = self.fractions(self.place.seen_from_screen(to));
        [(x1 - x0) / area.w, (y1 - y0) / area.h]
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
