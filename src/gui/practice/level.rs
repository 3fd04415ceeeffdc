//! The level: tiles, coins, an end; drawn as text, so that it can be changed with a text editor.

/// Edge of a tile, px.
pub const TILE: f64 = 16.0;
/// A fall ends this far below the level, px.
pub(super) const BOTTOM: f64 = -40.0;

/// `#` is ground, `=` a floating block, `o` a coin, `S` the start, `F` the flag at the end, `C` where one begins again after
/// a fall.
const TEXT: &str = "
..................................................................................................................
..................................................................................................................
..................................................................................................................
.................................................................oo...............................................
.................................................=======.................................o........................
...............................o................=========......====..............o.......=........................
.................................................................................=................................
.......................o.......=..........oo......................................................................
..............................................................#..............o.............ooo....................
...............o.......=.....................................##..............=................................F...
.S....o.o.o....#....C.......C......#.......C.o.#.o..C.......####...C..............C....................C..........
#####################..#################...############################...############....########....############
#####################..#################...############################...############....########....############
";

/// A way through the level with right held all the time: when to press jump, after right, and for how long, ms. It shows
/// that the level can be finished, and plays it in tests.
pub const A_WAY: &[(u64, u64)] = &[
    (100, 533),
    (1400, 533),
    (2600, 100),
    (3300, 333),
    (4100, 200),
    (4650, 200),
    (5567, 200),
    (6250, 533),
    (6917, 333),
    (7950, 200),
    (9033, 200),
    (9750, 100),
    (11683, 100),
    (12083, 200),
    (12733, 200),
    (13167, 333),
    (14100, 333),
    (15833, 200),
    (16417, 533),
    (18017, 100),
    (18683, 333),
    (19717, 100),
    (20583, 533),
];

/// What a place holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tile {
    /// Nothing.
    Air,
    /// Ground.
    Ground,
    /// A block in the air.
    Block,
}

/// A level.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    columns: usize,
    rows: usize,
    /// By rows from the bottom.
    tiles: Vec<Tile>,
    /// Middles of the coins, px.
    pub coins: Vec<[f64; 2]>,
    /// Where one begins: feet, px; the first is the start, the others follow a fall.
    pub starts: Vec<[f64; 2]>,
    /// Foot of the flag, px.
    pub flag: [f64; 2],
}

impl Level {
    /// The level that is played.
    #[must_use]
    pub fn ours() -> Self {
        Self::read(TEXT)
    }

    /// Level ground of so many tiles.
    #[cfg(test)]
    pub(super) fn flat(columns: usize) -> Self {
        let sky = format!("S{}F\n", ".".repeat(columns - 2));
        Self::read(&format!("{}{}", sky, "#".repeat(columns)))
    }

    /// Ground that ends.
    #[cfg(test)]
    pub(super) fn ledge() -> Self {
        Self::read("S..........................F\n########....................\n")
    }

    fn read(text: &str) -> Self {
        let lines: Vec<&str> = text.lines().filter(|line| !line.is_empty()).collect();
        let rows = lines.len();
        let columns = lines.iter().map(|line| line.len()).max().unwrap_or(0);
        let mut level = Self {
            columns,
            rows,
            tiles: vec![Tile::Air; columns * rows],
            coins: Vec::new(),
            starts: Vec::new(),
            flag: [0.0; 2],
        };
        let mut begin = [0.0; 2];
        for (line, row) in lines.iter().zip((0..rows).rev()) {
            for (column, sign) in line.bytes().enumerate() {
                let foot = [(column as f64 + 0.5) * TILE, row as f64 * TILE];
                match sign {
                    b'#' => level.tiles[row * columns + column] = Tile::Ground,
                    b'=' => level.tiles[row * columns + column] = Tile::Block,
                    b'o' => level.coins.push([foot[0], foot[1] + TILE / 2.0]),
                    b'S' => begin = foot,
                    b'C' => level.starts.push(foot),
                    b'F' => level.flag = foot,
                    _ => {}
                }
            }
        }
        level.coins.sort_by(|a, b| a[0].total_cmp(&b[0]));
        level.starts.sort_by(|a, b| a[0].total_cmp(&b[0]));
        level.starts.insert(0, begin);
        // What a player stands at stands on the ground.
        level.flag = level.lowered(level.flag);
        level.starts = level
            .starts
            .iter()
            .map(|foot| level.lowered(*foot))
            .collect();
        level
    }

    /// The place below a place that has something solid under it.
    fn lowered(&self, [x, mut y]: [f64; 2]) -> [f64; 2] {
        while y > 0.0 && !self.is_solid(x, y - 1.0) {
            y -= TILE;
        }
        [x, y]
    }

    /// Its length, px.
    #[must_use]
    pub fn width(&self) -> f64 {
        self.columns as f64 * TILE
    }

    /// Its height, px.
    #[must_use]
    pub fn height(&self) -> f64 {
        self.rows as f64 * TILE
    }

    /// Where the start stands, px.
    #[must_use]
    pub fn floor(&self) -> f64 {
        self.starts[0][1]
    }

    /// What a place holds, in tiles; beyond the level, nothing.
    #[must_use]
    pub fn tile(&self, column: i64, row: i64) -> Tile {
        let inside =
            (0..self.columns as i64).contains(&column) && (0..self.rows as i64).contains(&row);
        if inside {
            self.tiles[row as usize * self.columns + column as usize]
        } else {
            Tile::Air
        }
    }

    fn is_solid(&self, x: f64, y: f64) -> bool {
        let tile = |value: f64| libm::floor(value / TILE) as i64;
        self.tile(tile(x), tile(y)) != Tile::Air
    }

    /// Whether a body whose feet are at a height meets something at its edge.
    pub(super) fn blocks_side(&self, edge: f64, feet: f64, size: f64) -> bool {
        [feet + 0.5, feet + size / 2.0, feet + size - 0.5]
            .into_iter()
            .any(|y| self.is_solid(edge, y))
    }

    /// Where the tile that an edge has entered begins.
    pub(super) fn wall(&self, edge: f64, rightwards: bool) -> f64 {
        let tile = libm::floor(edge / TILE) * TILE;
        if rightwards { tile } else { tile + TILE }
    }

    /// The lower side of what a head meets on its way up.
    pub(super) fn ceiling(&self, x: f64, half: f64, from: f64, to: f64) -> Option<f64> {
        let row = libm::floor(to / TILE);
        let entered = row * TILE >= from - 1e-9;
        let met = [x - half + 0.5, x + half - 0.5]
            .into_iter()
            .any(|x| self.is_solid(x, to));
        (entered && met).then_some(row * TILE)
    }

    /// The upper side of what feet meet on their way down.
    pub(super) fn ground(&self, x: f64, half: f64, from: f64, to: f64) -> Option<f64> {
        // Feet that stand exactly on a tile's upper side are in the tile above.
        let row = libm::floor(to / TILE);
        let top = (row + 1.0) * TILE;
        let entered = top <= from + 1e-9;
        let met = [x - half + 0.5, x + half - 0.5]
            .into_iter()
            .any(|x| self.is_solid(x, to));
        (entered && met).then_some(top)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_level_has_a_start_an_end_and_coins_in_the_air() {
        let level = Level::ours();
        assert!(level.flag[0] > level.width() - 6.0 * TILE);
        assert!(level.coins.len() >= 15, "{}", level.coins.len());
        for coin in &level.coins {
            assert!(!level.is_solid(coin[0], coin[1]), "{coin:?}");
        }
        for start in level.starts.iter().chain([&level.flag]) {
            assert!(level.is_solid(start[0], start[1] - 1.0), "{start:?} stands");
            assert!(
                !level.is_solid(start[0], start[1] + 1.0),
                "{start:?} is free"
            );
        }
    }

    #[test]
    fn every_line_of_the_level_is_as_long() {
        let lengths: Vec<usize> = TEXT.lines().skip(1).map(str::len).collect();
        assert!(
            lengths.iter().all(|length| *length == lengths[0]),
            "{lengths:?}"
        );
    }
}
