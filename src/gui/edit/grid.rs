//! Separates a grid into one rectangular region per cell, so that each can be moved.
//!
//! A grid is written once, and its cells are named `NAME-1`, `NAME-2`, ...: a cell has no table of its own to change.

use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, value};

use super::document::{Document, EditError, number_item, rounded};
use crate::profile::{Region, Shape, Source};

/// The list of regions in a profile.
const LIST: &str = "region";
/// Keys of a grid that its cells do not take over.
const GRID_KEYS: [&str; 8] = ["name", "shape", "x", "y", "w", "h", "columns", "rows"];

/// The grid that a region is a cell of, in the edited text or in one of the texts that it extends.
#[must_use]
pub fn grid_of_cell(document: &Document, chain: &[Source], region: &str) -> Option<String> {
    let (grid, number) = region.rsplit_once('-')?;
    number.parse::<u32>().ok()?;
    let own = &document.document;
    if let Some(table) = own_table(own, grid) {
        return is_grid(table).then(|| grid.to_owned());
    }
    // A cell that the edited text overrides is a region already.
    if own_table(own, region).is_some() {
        return None;
    }
    let has_grid = |source: &Source| {
        let text = source.toml.parse::<DocumentMut>();
        text.is_ok_and(|text| own_table(&text, grid).is_some_and(is_grid))
    };
    let (_, bases) = chain.split_last()?;
    bases.iter().any(has_grid).then(|| grid.to_owned())
}

impl Document {
    /// Replaces a grid by one rectangle per cell. A grid of a base is switched off here. `regions` are those of the checked
    /// profile.
    ///
    /// # Errors
    /// `region` is not a list of tables.
    pub fn separate_grid(&mut self, grid: &str, regions: &[Region]) -> Result<(), EditError> {
        self.record_undo(&format!("separate {grid}"));
        self.end_change();
        let list = self.array_of_tables(LIST)?;
        let index = list.iter().position(|table| has_name(table, grid));
        let model = match index.and_then(|index| list.get(index)) {
            Some(table) => table.clone(),
            None => {
                let mut off = Table::new();
                off.insert("name", value(grid));
                off.insert("off", value(true));
                list.push(off);
                Table::new()
            }
        };
        let is_cell = |region: &&Region| {
            let number = region.name.strip_prefix(grid);
            number.is_some_and(|rest| rest.starts_with('-'))
        };
        let cells = regions.iter().filter(is_cell);
        let mut cells: Vec<Table> = cells.filter_map(|cell| cell_table(cell, &model)).collect();
        if let (Some(first), Some(_)) = (cells.first_mut(), index) {
            first.decor_mut().clone_from(model.decor());
        }
        let tables: Vec<Table> = list.iter().cloned().collect();
        let mut separated = ArrayOfTables::new();
        for (at, table) in tables.into_iter().enumerate() {
            if Some(at) == index {
                place_tables(&mut cells, &table);
                cells.drain(..).for_each(|cell| separated.push(cell));
            } else {
                separated.push(table);
            }
        }
        cells.into_iter().for_each(|cell| separated.push(cell));
        *list = separated;
        Ok(())
    }
}

/// Tables stand in a text where the table that they replace stood.
fn place_tables(cells: &mut [Table], replaced: &Table) {
    for cell in cells {
        cell.set_position(replaced.position());
    }
}

fn own_table<'a>(document: &'a DocumentMut, name: &str) -> Option<&'a Table> {
    let list = document.get(LIST)?.as_array_of_tables()?;
    list.iter().find(|table| has_name(table, name))
}

fn has_name(table: &Table, name: &str) -> bool {
    table.get("name").and_then(Item::as_str) == Some(name)
}

fn is_grid(table: &Table) -> bool {
    table.get("shape").and_then(Item::as_str) == Some("grid")
}

/// A cell as a rectangle with the other keys of its grid. Both edges are rounded, so that neighbours still touch.
fn cell_table(cell: &Region, grid: &Table) -> Option<Table> {
    let Shape::Rect { x, y, w, h } = cell.shape else {
        return None;
    };
    let mut table = Table::new();
    table.insert("name", value(&cell.name));
    table.insert("shape", value("rect"));
    let (left, low) = (rounded(x), rounded(y));
    let (width, height) = (rounded(x + w) - left, rounded(y + h) - low);
    for (key, number) in [("x", left), ("y", low), ("w", width), ("h", height)] {
        table.insert(key, number_item(rounded(number)));
    }
    for (key, item) in grid.iter().filter(|(key, _)| !GRID_KEYS.contains(key)) {
        table.insert(key, item.clone());
    }
    Some(table)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::{Profile, find_shipped, read, shipped_profile};

    fn shapes(profile: &Profile) -> Vec<(String, Shape)> {
        let regions = profile.regions.iter();
        regions
            .map(|region| (region.name.clone(), region.shape.clone()))
            .collect()
    }

    #[test]
    fn a_separated_grid_has_the_same_regions_and_comments() {
        let text = shipped_profile("large-buttons").expect("shipped").toml;
        let before = Profile::from_toml("p", text).expect("valid");
        let mut document = Document::parse(text).expect("TOML");
        let grid = grid_of_cell(&document, &before.texts.chain, "buttons-3");
        assert_eq!(grid.as_deref(), Some("buttons"));
        document
            .separate_grid("buttons", &before.regions)
            .expect("separated");
        let after = Profile::from_toml("p", &document.text()).expect("valid");
        assert_eq!(shapes(&after), shapes(&before));
        assert_eq!(after.bindings, before.bindings);
        assert!(document.text().contains("# Cells are numbered"));
        let chain = &after.texts.chain;
        assert_eq!(grid_of_cell(&document, chain, "buttons-3"), None);
        document.undo();
        assert_eq!(document.text(), text, "one step of undo");
    }

    #[test]
    fn sixteen_cells_in_a_row_stay_on_the_pad_and_keep_the_grids_keys() {
        let text = "schema = 1\nname = \"p\"\n[[region]]\nname = \"keys\"\nshape = \"grid\"\nx = 0\ny = 0\nw = 1\nh = 1\n\
                    columns = 16\nrows = 1\nslide = \"across\"\n[[binding]]\nregion = \"keys-16\"\noutput = \"key:a\"\n";
        let before = Profile::from_toml("p", text).expect("valid");
        let mut document = Document::parse(text).expect("TOML");
        document
            .separate_grid("keys", &before.regions)
            .expect("separated");
        let after = Profile::from_toml("p", &document.text()).expect("valid");
        assert_eq!(after.regions.len(), 16);
        for (old, new) in before.regions.iter().zip(&after.regions) {
            assert_eq!(old.slide, new.slide);
        }
    }

    #[test]
    fn a_grid_of_a_base_is_switched_off() {
        let text = "schema = 1\nname = \"mine\"\nextends = \"large-buttons\"\n";
        let checked = |toml: String| {
            let name = "mine".to_owned();
            read(Source { name, toml }, None, &find_shipped)
                .expect("valid")
                .profile
        };
        let before = checked(text.to_owned());
        let mut document = Document::parse(text).expect("TOML");
        let grid = grid_of_cell(&document, &before.texts.chain, "buttons-1");
        assert_eq!(grid.as_deref(), Some("buttons"));
        document
            .separate_grid("buttons", &before.regions)
            .expect("separated");
        let after = checked(document.text());
        assert_eq!(shapes(&after), shapes(&before));
        let chain = &after.texts.chain;
        assert_eq!(grid_of_cell(&document, chain, "buttons-1"), None);
    }
}
