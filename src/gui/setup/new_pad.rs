//! The form that makes a new pad: size, lattice, electrodes, drive. Writes `pads/NAME.toml` and plays it.

use egui::{DragValue, Grid, Ui};

use super::pad_form::{DRIVES, Outline, PadForm};
use super::{draw_notice, paragraph};
use crate::app::own_files::name_problem;
use crate::app::services::{AppServices, PlayRequest};
use crate::gui::choice;
use crate::gui::edit::write_atomically;
use crate::gui::play::UiAction;
use crate::gui::request::GameContext;
use crate::gui::theme;
use crate::gui::timing_settings::clicked_steps;

/// State of the form.
#[derive(Default)]
pub(super) struct NewPad {
    form: PadForm,
    notice: Option<String>,
}

impl NewPad {
    /// Draws the form; returns the game on the new pad when it is saved.
    pub(super) fn ui(&mut self, ui: &mut Ui, game: GameContext<'_>) -> Option<UiAction> {
        let GameContext { playing, services } = game;
        paragraph(
            ui,
            "Measure your pad; the numbers need not be exact. Calibration corrects what differs.",
        );
        Grid::new("new pad")
            .num_columns(2)
            .spacing([12.0, 6.0])
            .show(ui, |ui| self.fields(ui));
        let form = &self.form;
        let mistake = name_problem(&form.name).or_else(|| {
            let error = form.pad().err()?;
            let first = error.diagnostics.first();
            Some(first.map_or(error.to_string(), |fault| fault.message.clone()))
        });
        match (&mistake, form.pad()) {
            (None, Ok(pad)) => drop(ui.weak(format!("{} readings per frame", pad.channels()))),
            (mistake, _) => {
                let mistake = mistake.clone().unwrap_or_default();
                ui.colored_label(theme::palette_of(ui).bad, format!("✖ {mistake}"));
            }
        }
        let save = ui.add_enabled(
            mistake.is_none(),
            egui::Button::new("Save and use this pad"),
        );
        draw_notice(ui, &self.notice);
        if !save.clicked() {
            return None;
        }
        match save_pad(&self.form, services) {
            Ok(path) => Some(UiAction::Play(PlayRequest {
                pad: path,
                calibration: None,
                ..playing.request.clone()
            })),
            Err(why) => {
                self.notice = Some(why);
                None
            }
        }
    }

    /// Fills in the number of electrodes.
    pub(super) fn set_electrodes(&mut self, electrodes: usize) {
        self.form.electrodes = electrodes as u32;
    }

    fn fields(&mut self, ui: &mut Ui) {
        let form = &mut self.form;
        let label = ui.label("Name");
        ui.add(egui::TextEdit::singleline(&mut form.name).desired_width(140.0))
            .labelled_by(label.id);
        ui.end_row();
        ui.label("Outline");
        ui.horizontal(|ui| {
            ui.radio_value(&mut form.outline, Outline::Rectangle, "rectangle");
            ui.radio_value(&mut form.outline, Outline::Circle, "circle");
        });
        ui.end_row();
        match form.outline {
            Outline::Rectangle => {
                number(ui, "Width", &mut form.width_mm, 10.0..=1000.0);
                number(ui, "Height", &mut form.height_mm, 10.0..=1000.0);
                ui.label("Layer");
                ui.checkbox(&mut form.is_lattice, "channels (a lattice)");
                ui.end_row();
            }
            Outline::Circle => number(ui, "Diameter", &mut form.width_mm, 10.0..=1000.0),
        }
        if form.has_lattice() {
            count(ui, "Channels each way", &mut form.lines, 2..=60);
            number(ui, "Channel width", &mut form.channel_mm, 0.2..=50.0);
        }
        count(ui, "Electrodes", &mut form.electrodes, 4..=64);
        number(ui, "Electrode width", &mut form.electrode_mm, 0.2..=50.0);
        ui.label("Drive");
        let combo = egui::ComboBox::from_id_salt("drive").selected_text(form.drive);
        let drives = DRIVES.map(|drive| (drive, drive.to_owned()));
        if let Some(drive) = choice::list(ui, combo, None, &form.drive, drives.into()) {
            form.drive = drive;
        }
        ui.end_row();
        ui.label("Readings");
        ui.checkbox(&mut form.is_full, "each pair in both directions");
        ui.end_row();
    }
}

fn number(ui: &mut Ui, name: &str, value: &mut f64, range: std::ops::RangeInclusive<f64>) {
    let label = ui.label(name);
    ui.horizontal(|ui| {
        let field = DragValue::new(&mut *value)
            .range(range.clone())
            .suffix(" mm");
        ui.add(field.max_decimals(1)).labelled_by(label.id);
        let wanted = *value + clicked_steps(ui, name);
        *value = wanted.clamp(*range.start(), *range.end());
    });
    ui.end_row();
}

fn count(ui: &mut Ui, name: &str, value: &mut u32, range: std::ops::RangeInclusive<u32>) {
    let label = ui.label(name);
    ui.horizontal(|ui| {
        ui.add(DragValue::new(&mut *value).range(range.clone()))
            .labelled_by(label.id);
        let wanted = i64::from(*value) + clicked_steps(ui, name) as i64;
        let wanted = u32::try_from(wanted).unwrap_or(0);
        *value = wanted.clamp(*range.start(), *range.end());
    });
    ui.end_row();
}

/// Writes the pad beside the player's other ones; replaces none.
fn save_pad(form: &PadForm, services: &dyn AppServices) -> Result<String, String> {
    let folder = services.own_folder();
    let folder = folder.ok_or("no folder for your own settings: set HOME")?;
    let name = form.name.trim();
    let path = folder.join("pads").join(format!("{name}.toml"));
    if path.exists() {
        return Err(format!(
            "there is already a pad named {name}: choose another name"
        ));
    }
    write_atomically(&path, &form.to_toml()).map_err(|error| error.to_string())?;
    Ok(path.display().to_string())
}
