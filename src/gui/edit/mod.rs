//! The editor: regions are moved and resized on the live image and bound by pressing the pad and then a key; timing
//! settings stand beside what the player does right now. Gestures, modes and layers are chosen in fields that follow from the keys
//! of profiles; everything else is written in the text.
//!
//! The file on disk is the truth: saved changes reach the game through the file, and changes saved by other programs
//! are loaded here.

mod binding;
mod binding_card;
mod canvas;
mod diagrams;
pub mod document;
mod document_bindings;
mod drafts;
mod file;
pub mod grid;
mod grid_question;
pub mod keyboard;
mod output_chooser;
mod own_profile;
mod region_card;
pub mod shape;
mod side;
mod text_draft;
mod text_editor;
mod timing;

pub(super) use file::write_atomically;

use egui::{Pos2, Rect, Ui, Vec2};

pub use self::binding::BindStep;
use self::document::{Document, EditError};
use self::document_bindings::BindingKey;
use self::drafts::Drafts;
use self::file::OpenProfile;
use self::shape::Grip;
use self::text_draft::TextDraft;
use super::file_dialog::FileDialog;
use super::focus_ring::follow_focus;
use super::picture::Picture;
use super::play::UiAction;
use super::playing::Playing;
use super::request::GameContext;
use super::theme;
use crate::app::file_watch::FileWatcher;
use crate::app::services::AppServices;
use crate::profile::{Binding, Gesture, Profile, Shape};

/// Width of the side panel: share of the window, minimum and maximum in points.
const SIDE: (f32, f32, f32) = (0.34, 270.0, 400.0);
/// Share of the height for the pad in a narrow window.
const PAD_SHARE: f32 = 0.75;

/// A region that is being dragged.
#[derive(Clone, Debug)]
struct Drag {
    region: String,
    grip: Grip,
    /// Shape when the drag started.
    shape: Shape,
    from: Pos2,
}

/// The editor's state.
#[derive(Default)]
pub struct EditView {
    /// Profile of the play request when it was looked at last.
    requested: String,
    /// The profile that is open, loading or failed to open.
    argument: String,
    opened: Option<OpenProfile>,
    /// Why nothing is open.
    failed: Option<String>,
    /// Watches the profile's file; none for shipped profiles.
    watcher: Option<FileWatcher>,
    picture: Picture,
    /// Name of the selected region.
    pub selected: Option<String>,
    /// Progress of binding a region to a key.
    pub bind_step: BindStep,
    drag: Option<Drag>,
    output_text: String,
    output_error: Option<String>,
    notice: Option<String>,
    /// The file that the shown profile was saved in.
    saved_as: Option<String>,
    /// Profiles with unsaved changes that are not shown now.
    drafts: Drafts,
    /// The grid that the player is asked to separate.
    grid_question: Option<String>,
    /// Whether the outputs to click are shown.
    chooses_output: bool,
    /// The text, while it is shown instead of the pad.
    text_editor: Option<TextDraft>,
    dialog: FileDialog,
}

impl EditView {
    /// Draws the view; returns what the application should do.
    pub fn ui(
        &mut self,
        ui: &mut Ui,
        playing: &mut Playing,
        services: &dyn AppServices,
    ) -> Option<UiAction> {
        let game = GameContext { playing, services };
        self.open(ui.ctx(), game);
        self.load_changes(game);
        self.update_binding(ui, game);
        let room = ui.available_rect_before_wrap();
        let mut wish = match room.width() < theme::COLUMN {
            true => self.draw_column(ui, room, playing, services),
            false => self.draw_wide(ui, room, playing, services),
        };
        let game = GameContext { playing, services };
        self.ask_about_grid(ui.ctx(), game);
        self.draw_chooser(ui.ctx(), game);
        wish = self.finish_file_dialog(ui.ctx(), game).or(wish);
        ui.advance_cursor_after_rect(room);
        wish
    }

    /// The pad and the cards beside each other.
    fn draw_wide(
        &mut self,
        ui: &mut Ui,
        room: Rect,
        playing: &mut Playing,
        services: &dyn AppServices,
    ) -> Option<UiAction> {
        let side = (room.width() * SIDE.0).clamp(SIDE.1, SIDE.2);
        let pad_room = room.with_max_x(room.right() - side - 12.0);
        let side_room = room.with_min_x(room.right() - side);
        self.draw_pad_or_text(ui, pad_room, playing, services);
        let game = GameContext { playing, services };
        let mut side_ui = ui.new_child(egui::UiBuilder::new().max_rect(side_room));
        let cards = egui::ScrollArea::vertical().id_salt("edit side");
        let shown = cards.auto_shrink(false).show(&mut side_ui, |ui| {
            ui.set_width(side - 6.0);
            let wish = self.draw_side(ui, game);
            follow_focus(ui);
            wish
        });
        shown.inner
    }

    /// The pad, and the cards below it.
    fn draw_column(
        &mut self,
        ui: &mut Ui,
        room: Rect,
        playing: &mut Playing,
        services: &dyn AppServices,
    ) -> Option<UiAction> {
        let column = egui::ScrollArea::vertical().id_salt("edit column");
        let shown = column.auto_shrink(false).show(ui, |ui| {
            let size = Vec2::new(ui.available_width(), room.height() * PAD_SHARE);
            let (pad_room, _) = ui.allocate_exact_size(size, egui::Sense::hover());
            let mut pad_ui = ui.new_child(egui::UiBuilder::new().max_rect(pad_room));
            self.draw_pad_or_text(&mut pad_ui, pad_room, playing, services);
            let wish = self.draw_side(ui, GameContext { playing, services });
            follow_focus(ui);
            wish
        });
        shown.inner
    }

    fn draw_pad_or_text(
        &mut self,
        ui: &mut Ui,
        room: Rect,
        playing: &mut Playing,
        services: &dyn AppServices,
    ) {
        if self.text_editor.is_some() {
            self.draw_text(ui, room, GameContext { playing, services });
        } else {
            self.draw_canvas(ui, room, playing, services);
        }
    }

    /// The edited text, if a profile is open.
    #[must_use]
    pub fn text(&self) -> Option<String> {
        self.opened.as_ref().map(|opened| opened.document.text())
    }

    /// Whether some changes are not in the file.
    #[must_use]
    pub fn is_unsaved(&self) -> bool {
        self.opened.as_ref().is_some_and(OpenProfile::is_unsaved)
    }

    /// Names or paths of all profiles with unsaved changes, the one that is shown first.
    #[must_use]
    pub fn unsaved(&self) -> Vec<String> {
        let shown = self.opened.iter().filter(|opened| opened.is_unsaved());
        let shown = shown.map(|opened| opened.argument.as_str());
        shown
            .chain(self.drafts.arguments())
            .map(str::to_owned)
            .collect()
    }

    /// Edits the text and checks it.
    fn change(
        &mut self,
        game: GameContext<'_>,
        change: impl FnOnce(&mut Document) -> Result<(), EditError>,
    ) {
        let Some(opened) = &mut self.opened else {
            return;
        };
        match change(&mut opened.document) {
            Ok(()) => {
                opened.check(game);
                self.notice = None;
            }
            Err(error) => self.notice = Some(error.to_string()),
        }
    }

    /// Ends a change made of many steps, such as a drag: further changes are undone separately.
    fn end_change(&mut self) {
        if let Some(opened) = &mut self.opened {
            opened.document.end_change();
        }
    }

    /// The profile that the edited text defines, if it has no mistakes.
    fn profile(&self) -> Option<&Profile> {
        let opened = self.opened.as_ref()?;
        opened.checked.as_ref().ok().map(|checked| &checked.profile)
    }

    /// Selects a region and shows its output in the text field.
    pub fn select_region(&mut self, region: &str) {
        self.selected = Some(region.to_owned());
        self.output_error = None;
        self.output_text = self
            .profile()
            .and_then(|profile| {
                let binding = shown_binding(profile, region)?;
                super::regions::outputs_of_binding(profile, binding).next()
            })
            .map(|output| output.to_string())
            .unwrap_or_default();
    }

    /// Gives the shown binding of a region another output, or adds a press.
    fn bind(&mut self, game: GameContext<'_>, region: &str, output: &str) {
        let of_profile = self.profile().and_then(|profile| {
            let shown = shown_binding(profile, region)?;
            Some(BindingKey::of_binding(profile, region, shown))
        });
        let key = of_profile.unwrap_or_else(|| BindingKey::press(region));
        self.change(game, |document| document.bind(&key, output));
    }
}

/// The binding whose output the card of a region shows: its press, else the first that has one output for one region; those
/// that work always before those of a layer.
fn shown_binding<'a>(profile: &'a Profile, region: &str) -> Option<&'a Binding> {
    let index = profile.regions.iter().position(|r| r.name == region)?;
    let of_region = |binding: &&Binding| binding.regions == [index];
    let bindings = profile.bindings.iter().filter(of_region);
    let moves = |binding: &&Binding| {
        matches!(
            binding.gesture,
            Gesture::Dpad(_) | Gesture::Stick(_) | Gesture::Trigger(_) | Gesture::Pointer(_)
        )
    };
    let with_output = bindings.filter(|binding| !moves(binding));
    with_output.min_by_key(|binding| (binding.layer.is_some(), !is_press(binding)))
}

fn is_press(binding: &Binding) -> bool {
    matches!(binding.gesture, Gesture::Press(_))
}
