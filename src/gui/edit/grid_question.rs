//! Asks once before a grid is separated into regions: its cells have no place and size of their own to change.

use egui::{Context, Id, Modal, Ui};

use super::grid::grid_of_cell;
use super::{EditView, GameContext};
use crate::gui::theme;

impl EditView {
    /// The grid that a region is a cell of.
    fn grid_of(&self, region: &str) -> Option<String> {
        let chain = &self.profile()?.texts.chain;
        grid_of_cell(&self.opened.as_ref()?.document, chain, region)
    }

    /// Whether a region cannot be moved because it is a cell of a grid; then the player is asked.
    pub(super) fn ask_if_in_grid(&mut self, region: &str) -> bool {
        self.grid_question = self.grid_of(region);
        self.grid_question.is_some()
    }

    /// Says that the selected region is a cell of a grid.
    pub(super) fn draw_grid_hint(&mut self, ui: &mut Ui, region: &str) {
        let Some(grid) = self.grid_of(region) else {
            return;
        };
        ui.weak(format!("A cell of the grid `{grid}`."));
        if ui.button("Separate the cells").clicked() {
            self.grid_question = Some(grid);
        }
    }

    pub(super) fn ask_about_grid(&mut self, ctx: &Context, game: GameContext<'_>) {
        let Some(grid) = self.grid_question.clone() else {
            return;
        };
        let mut answer = None;
        let modal = Modal::new(Id::unique("separate grid")).show(ctx, |ui| {
            ui.set_max_width(360.0);
            ui.heading("Separate the cells?");
            ui.label(format!(
                "This region is a cell of the grid `{grid}`, whose cells share one place and size. As separate regions, each \
                 can be moved and resized. Undo joins them again."
            ));
            ui.add_space(6.0);
            ui.horizontal(|ui| {
                if theme::primary(ui, "Separate").clicked() {
                    answer = Some(true);
                }
                if ui.button("Keep the grid").clicked() {
                    answer = Some(false);
                }
            });
        });
        if answer.is_none() && !modal.should_close() {
            return;
        }
        self.grid_question = None;
        if answer == Some(true) {
            let regions = self.profile().map(|profile| profile.regions.clone());
            let regions = regions.unwrap_or_default();
            self.change(game, |document| document.separate_grid(&grid, &regions));
        }
    }
}
