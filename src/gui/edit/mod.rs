//! The view to edit in: regions are moved and resized on the live image, bound by pressing the pad and then the key, and
//! thresholds are set beside what the player does right now.
//!
//! The file on disk stays the truth: what is saved goes live by way of the file, and what is saved elsewhere comes in here.

mod canvas;
pub mod document;
pub mod keyboard;
pub mod shape;
mod side;

use std::path::{Path, PathBuf};

use egui::{Pos2, Rect, Ui};

use self::document::Document;
use self::shape::Grip;
use super::desk::{Choice, Desk};
use super::picture::Picture;
use super::play::{Wish, file_name};
use super::playing::Playing;
use crate::profile::{Checked, Profile, Shape, Source};
use crate::types::Faulty;

/// The file is looked at so often, s.
const LOOK_S: f64 = 0.5;
/// The side: its share of the width, and from where to where, points.
const SIDE: (f32, f32, f32) = (0.34, 270.0, 400.0);

/// What the next press on the pad or the keyboard means.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Learning {
    /// Nothing special.
    #[default]
    No,
    /// The region to bind.
    Region,
    /// The key that this region is to press.
    Key(String),
}

/// A region that is being dragged.
#[derive(Clone, Debug)]
struct Drag {
    region: String,
    grip: Grip,
    shape: Shape,
    from: Pos2,
}

/// A text that is open.
struct Opened {
    /// What `play` calls it.
    argument: String,
    document: Document,
    /// What the file holds, as far as we know.
    saved: String,
    checked: Result<Checked, Faulty>,
}

/// The view's state.
#[derive(Default)]
pub struct EditView {
    opened: Option<Opened>,
    /// Why nothing is open.
    failed: Option<String>,
    picture: Picture,
    /// The region that is chosen.
    pub chosen: Option<String>,
    /// What the next press means.
    pub learning: Learning,
    drag: Option<Drag>,
    output_text: String,
    output_error: Option<String>,
    notice: Option<String>,
    looked_s: f64,
}

impl EditView {
    /// Draws the view; returns what the player wants.
    pub fn ui(&mut self, ui: &mut Ui, playing: &mut Playing, desk: &dyn Desk) -> Option<Wish> {
        self.open(&playing.choice, desk);
        self.look_at_file(ui.ctx().time(), &playing.choice, desk);
        self.learn(ui, playing, desk);
        let room = ui.available_rect_before_wrap();
        let side = (room.width() * SIDE.0).clamp(SIDE.1, SIDE.2);
        let pad_room = Rect::from_min_max(
            room.min,
            Pos2::new(room.right() - side - 12.0, room.bottom()),
        );
        let side_room = Rect::from_min_max(Pos2::new(room.right() - side, room.top()), room.max);
        self.pad(ui, pad_room, playing, desk);
        let mut wish = None;
        ui.scope_builder(egui::UiBuilder::new().max_rect(side_room), |ui| {
            egui::ScrollArea::vertical()
                .id_salt("edit side")
                .auto_shrink(false)
                .show(ui, |ui| {
                    ui.set_width(side - 6.0);
                    wish = self.side(ui, playing, desk);
                });
        });
        ui.advance_cursor_after_rect(room);
        wish
    }

    /// The text as it is edited, if one is open.
    #[must_use]
    pub fn text(&self) -> Option<String> {
        self.opened.as_ref().map(|opened| opened.document.text())
    }

    /// Whether there are changes that are not in the file.
    #[must_use]
    pub fn is_unsaved(&self) -> bool {
        self.opened
            .as_ref()
            .is_some_and(|opened| opened.document.text() != opened.saved)
    }

    /// Opens the profile that is played, unless it is open.
    fn open(&mut self, choice: &Choice, desk: &dyn Desk) {
        let is_open = self
            .opened
            .as_ref()
            .is_some_and(|opened| opened.argument == choice.profile);
        if is_open || (self.failed.is_some() && self.opened.is_none()) {
            return;
        }
        match desk.profile_text(&choice.profile).and_then(|text| {
            Document::read(&text)
                .map_err(|error| error.to_string())
                .map(|d| (d, text))
        }) {
            Ok((document, saved)) => {
                let mut opened = Opened {
                    argument: choice.profile.clone(),
                    checked: check(desk, choice, &saved),
                    document,
                    saved,
                };
                if opened.checked.is_err() {
                    opened.document.settle();
                }
                self.opened = Some(opened);
                self.failed = None;
                self.chosen = None;
            }
            Err(why) => {
                self.opened = None;
                self.failed = Some(why);
            }
        }
    }

    /// Takes in what was saved elsewhere, unless there are changes here.
    fn look_at_file(&mut self, now_s: f64, choice: &Choice, desk: &dyn Desk) {
        if now_s - self.looked_s < LOOK_S {
            return;
        }
        self.looked_s = now_s;
        if self.opened.is_none() {
            // What was wrong may have been mended.
            self.failed = None;
            return;
        }
        let unsaved = self.is_unsaved();
        let Some(opened) = &mut self.opened else {
            return;
        };
        if !is_file(&opened.argument) {
            return;
        }
        let Ok(text) = desk.profile_text(&opened.argument) else {
            self.notice = Some("the file is gone: save writes it anew".to_owned());
            return;
        };
        if text == opened.saved {
            return;
        }
        if unsaved {
            self.notice = Some(
                "the file was changed elsewhere: undo your changes to see that, or save over it"
                    .to_owned(),
            );
            return;
        }
        match Document::read(&text) {
            Ok(document) => {
                opened.document = document;
                opened.checked = check(desk, choice, &text);
                opened.saved = text;
                self.notice = Some("read again: the file was changed elsewhere".to_owned());
            }
            Err(error) => self.notice = Some(format!("the file on disk: {error}")),
        }
    }

    /// Changes the text and checks it.
    fn change(
        &mut self,
        choice: &Choice,
        desk: &dyn Desk,
        change: impl FnOnce(&mut Document) -> Result<(), document::EditError>,
    ) {
        let Some(opened) = &mut self.opened else {
            return;
        };
        match change(&mut opened.document) {
            Ok(()) => {
                opened.checked = check(desk, choice, &opened.document.text());
                self.notice = None;
            }
            Err(error) => self.notice = Some(error.to_string()),
        }
    }

    /// Writes the text: over its file, or for a shipped profile into a file of one's own.
    fn save(&mut self, choice: &Choice, desk: &dyn Desk) -> Option<Wish> {
        let opened = self.opened.as_mut()?;
        let text = opened.document.text();
        let path = if is_file(&opened.argument) {
            PathBuf::from(&opened.argument)
        } else {
            let Some(folder) = desk.own_folder() else {
                self.notice =
                    Some("there is no folder for settings of your own: set HOME".to_owned());
                return None;
            };
            folder
                .join("profiles")
                .join(format!("{}.toml", file_name(&opened.argument)))
        };
        if let Err(error) = write_beside(&path, &text) {
            self.notice = Some(format!("{}: {error}", path.display()));
            return None;
        }
        opened.saved = text;
        let argument = path.display().to_string();
        self.notice = Some(format!("saved: {argument}"));
        if argument == opened.argument {
            // It goes live by way of the file.
            return None;
        }
        opened.argument.clone_from(&argument);
        Some(Wish::Play(Choice {
            profile: argument,
            ..choice.clone()
        }))
    }

    /// "Press here, then press the key."
    fn learn(&mut self, ui: &Ui, playing: &Playing, desk: &dyn Desk) {
        match self.learning.clone() {
            Learning::No => {}
            Learning::Region => {
                let Some(touch) = playing.view.touches.first() else {
                    return;
                };
                let Some(profile) = self.profile() else {
                    return;
                };
                let pad_mm = playing.pad.outline.size_mm();
                let seen = profile.settings.seen(touch.contact.centre_mm, pad_mm);
                let seen_mm = profile.settings.seen_size_mm(pad_mm);
                if let Some(index) = profile.region_at(seen, seen_mm) {
                    let name = profile.regions[index].name.clone();
                    self.choose(&name);
                    self.learning = Learning::Key(name);
                }
            }
            Learning::Key(region) => {
                let pressed = ui.input_mut(|input| {
                    let key = input.events.iter().find_map(|event| match event {
                        egui::Event::Key {
                            key, pressed: true, ..
                        } => Some(*key),
                        _ => None,
                    })?;
                    // It is an answer, not a command to this window.
                    input.consume_key(egui::Modifiers::NONE, key);
                    Some(key)
                });
                let Some(output) = pressed.and_then(keyboard::output) else {
                    return;
                };
                self.learning = Learning::No;
                let output = output.to_string();
                self.change(&playing.choice, desk, |document| {
                    document.bind(&region, &output)
                });
                self.choose(&region);
            }
        }
    }

    /// The profile as it would be played now.
    fn profile(&self) -> Option<&Profile> {
        let opened = self.opened.as_ref()?;
        opened.checked.as_ref().ok().map(|checked| &checked.profile)
    }

    /// Chooses a region.
    pub fn choose(&mut self, region: &str) {
        self.chosen = Some(region.to_owned());
        self.output_error = None;
        self.output_text = self
            .profile()
            .and_then(|profile| {
                let index = profile.regions.iter().position(|r| r.name == region)?;
                let binding = profile
                    .bindings
                    .iter()
                    .find(|binding| binding.regions.contains(&index))?;
                super::regions::outputs(profile, binding).next()
            })
            .map(|output| output.to_string())
            .unwrap_or_default();
    }
}

fn is_file(argument: &str) -> bool {
    argument.contains('/') || argument.ends_with(".toml")
}

fn check(desk: &dyn Desk, choice: &Choice, text: &str) -> Result<Checked, Faulty> {
    let source = Source {
        name: choice.profile.clone(),
        toml: text.to_owned(),
    };
    desk.check(source, choice.user.as_deref())
}

/// Writes a text beside a file and renames it: nobody reads half of it.
pub(super) fn write_beside(path: &Path, text: &str) -> std::io::Result<()> {
    use std::io::Write as _;

    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)?;
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    file.write_all(text.as_bytes())?;
    file.as_file().sync_all()?;
    if let Ok(old) = std::fs::metadata(path) {
        file.as_file().set_permissions(old.permissions())?;
    }
    file.persist(path)?;
    Ok(())
}
