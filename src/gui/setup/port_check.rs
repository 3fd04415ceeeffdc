//! What a port sends, in the window: the report of `gelpad listen`, the first bytes, and a button that plays it.
//!
//! The game stops first: a port has one reader.

use std::sync::Arc;
use std::time::Duration;

use egui::Ui;

use super::{draw_notice, paragraph};
use crate::app::services::{AppServices, BoardLine, PlayRequest, PortDiagnosis, SourceChoice};
use crate::gui::background::{Background, take_result};
use crate::gui::play::UiAction;
use crate::gui::playing::Playing;
use crate::gui::theme;
use crate::source::wire::FormatChoice;

/// How often the window looks whether the diagnosis is ready.
const POLL: Duration = Duration::from_millis(100);

/// State of the diagnosis.
#[derive(Default)]
pub(super) struct PortCheck {
    running: Option<Background<Result<PortDiagnosis, String>>>,
    /// The port, and what it sent.
    done: Option<(String, PortDiagnosis)>,
    port: String,
    failed: Option<String>,
    /// Number of electrodes of a pad that the player wants to describe.
    wanted_pad: Option<usize>,
}

impl PortCheck {
    /// Draws the button and the last diagnosis of the port that is played.
    pub(super) fn ui(
        &mut self,
        ui: &mut Ui,
        playing: &mut Playing,
        services: &Arc<dyn AppServices>,
    ) -> Option<UiAction> {
        self.poll(ui);
        let SourceChoice::Serial(port) = playing.request.source.clone() else {
            return None;
        };
        if self.running.is_some() {
            ui.horizontal(|ui| {
                ui.spinner();
                ui.label(format!("listening to {} …", self.port));
            });
            return None;
        }
        let button = ui.button("Diagnose this port");
        if button
            .on_hover_text(
                "Stops the game and listens for 10 s at most: format, values, rate, order",
            )
            .clicked()
        {
            self.start(&port, playing, services);
        }
        draw_notice(ui, &self.failed);
        let (_, diagnosis) = self.done.as_ref().filter(|(of, _)| *of == port)?;
        match draw_diagnosis(ui, diagnosis, playing)? {
            Choice::Play(request) => Some(UiAction::Play(*request)),
            Choice::MakePad { electrodes } => {
                self.wanted_pad = Some(electrodes);
                None
            }
        }
    }

    /// The number of electrodes of a pad that the player wants to describe since the last call.
    pub(super) fn take_wanted_pad(&mut self) -> Option<usize> {
        self.wanted_pad.take()
    }

    fn start(&mut self, port: &str, playing: &mut Playing, services: &Arc<dyn AppServices>) {
        playing.stop();
        port.clone_into(&mut self.port);
        (self.done, self.failed) = (None, None);
        // Another board may be at the same port by now: its format is found again.
        let board = BoardLine {
            format: FormatChoice::default(),
            ..playing.request.board
        };
        let services = Arc::clone(services);
        let listened = self.port.clone();
        let started = Background::start("listen", move || services.diagnose_port(&listened, board));
        match started {
            Ok(running) => self.running = Some(running),
            Err(error) => self.failed = Some(format!("the port cannot be read: {error}")),
        }
    }

    fn poll(&mut self, ui: &Ui) {
        let died = || Err("the diagnosis failed because of a bug in gelpad".to_owned());
        match take_result(&mut self.running, died) {
            Some(Ok(diagnosis)) => self.done = Some((self.port.clone(), diagnosis)),
            Some(Err(why)) => self.failed = Some(why),
            None if self.running.is_some() => ui.ctx().request_repaint_after(POLL),
            None => {}
        }
    }
}

/// What the player does with a board that sends frames.
enum Choice {
    Play(Box<PlayRequest>),
    MakePad { electrodes: usize },
}

/// Draws what was heard, and the button for it.
fn draw_diagnosis(ui: &mut Ui, diagnosis: &PortDiagnosis, playing: &Playing) -> Option<Choice> {
    let request = &playing.request;
    let palette = theme::palette_of(ui);
    match diagnosis.advice {
        Some(advice) => {
            ui.colored_label(palette.bad, "✖ no frame arrived");
            paragraph(ui, advice);
        }
        None => {
            ui.colored_label(palette.good, "✔ frames arrive");
        }
    }
    ui.add(
        egui::Label::new(
            egui::RichText::new(&diagnosis.report)
                .monospace()
                .size(11.5),
        )
        .wrap(),
    );
    if !diagnosis.first_bytes.is_empty() {
        ui.collapsing("First bytes", |ui| {
            let dump = egui::RichText::new(&diagnosis.first_bytes).monospace();
            ui.add(egui::Label::new(dump.size(10.5)).extend());
        });
    }
    if diagnosis.advice.is_some() {
        return None;
    }
    let is_played = diagnosis.readings == Some(playing.pad.channels());
    if diagnosis.pad.is_none() && !is_played {
        paragraph(ui, "No shipped pad has so many readings: describe yours.");
        let electrodes = diagnosis.electrodes?;
        let label = format!("Make a pad with {electrodes} electrodes");
        let clicked = theme::primary(ui, &label).clicked();
        return clicked.then_some(Choice::MakePad { electrodes });
    }
    let mut wanted = request.clone();
    wanted.board.format = diagnosis.format.unwrap_or(request.board.format);
    let mut label = "Play it".to_owned();
    if let Some(pad) = &diagnosis.pad
        && request.pad == crate::pad::DEFAULT_PAD
        && *pad != request.pad
    {
        wanted.pad.clone_from(pad);
        wanted.calibration = None;
        label = format!("Play it with the pad {pad}");
    }
    theme::primary(ui, &label)
        .clicked()
        .then_some(Choice::Play(Box::new(wanted)))
}
