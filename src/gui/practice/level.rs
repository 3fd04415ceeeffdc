//! The level: tiles, coins, start, flag. Written as text, to be changed with a text editor.

/// Side of a tile, px.
pub(super) const TILE: f64 = 16.0;
/// Height at which a falling player starts again, px.
pub(super) const BOTTOM: f64 = -40.0;

/// `#` ground, `=` floating block, `o` coin, `S` start, `F` flag, `C` checkpoint after a fall.
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

/// A solution of the level with right held all the time: for each jump, when to press it after right, and how long, ms.
pub const SOLUTION: &[(u64, u64)] = &[
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

/// The contents of one cell of the level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Tile {
    /// Free.
    Air,
    /// Ground.
    Ground,
    /// Floating block.
    Block,
}

/// A level.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Level {
    columns: usize,
    rows: usize,
    /// Row by row from the bottom.
    tiles: Vec<Tile>,
    /// Centres of the coins, px.
    pub(super) coins: Vec<[f64; 2]>,
    /// Start, then checkpoints: position of the feet, px.
    pub(super) starts: Vec<[f64; 2]>,
    /// Foot of the flag, px.
    pub(super) flag: [f64; 2],
}

impl Level {
    /// The only level.
    pub(super) fn built_in() -> Self {
        Self::parse(TEXT)
    }

    /// Flat ground.
    #[cfg(test)]
    pub(super) fn flat(columns: usize) -> Self {
        let sky = format!("S{}F\n", ".".repeat(columns - 2));
        Self::parse(&format!("{}{}", sky, "#".repeat(columns)))
    }

    /// Ground with an edge.
    #[cfg(test)]
    pub(super) fn ledge() -> Self {
        Self::parse("S..........................F\n########....................\n")
    }

    fn parse(text: &str) -> Self {
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
        let mut start = [0.0; 2];
        for (line, row) in lines.iter().zip((0..rows).rev()) {
            for (column, sign) in line.bytes().enumerate() {
                let foot = [(column as f64 + 0.5) * TILE, row as f64 * TILE];
                match sign {
                    b'#' => level.tiles[row * columns + column] = Tile::Ground,
                    b'=' => level.tiles[row * columns + column] = Tile::Block,
                    b'o' => level.coins.push([foot[0], foot[1] + TILE / 2.0]),
                    b'S' => start = foot,
                    b'C' => level.starts.push(foot),
                    b'F' => level.flag = foot,
                    _ => {}
                }
            }
        }
        level.coins.sort_by(|a, b| a[0].total_cmp(&b[0]));
        level.starts.sort_by(|a, b| a[0].total_cmp(&b[0]));
        level.starts.insert(0, start);
        level.flag = level.lowered(level.flag);
        level.starts = level
            .starts
            .iter()
            .map(|foot| level.lowered(*foot))
            .collect();
        level
    }

    /// The first point straight below with solid ground under it.
    fn lowered(&self, [x, mut y]: [f64; 2]) -> [f64; 2] {
        while y > 0.0 && !self.is_solid(x, y - 1.0) {
            y -= TILE;
        }
        [x, y]
    }

    /// Width, px.
    pub(super) fn width(&self) -> f64 {
        self.columns as f64 * TILE
    }

    /// Height, px.
    pub(super) fn height(&self) -> f64 {
        self.rows as f64 * TILE
    }

    /// The tile at a column and row; air outside the level.
    pub(super) fn tile(&self, column: i64, row: i64) -> Tile {
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

    /// Whether a body of this height meets something solid at the x coordinate of its edge.
    pub(super) fn blocks_side(&self, edge: f64, feet: f64, size: f64) -> bool {
        [feet + 0.5, feet + size / 2.0, feet + size - 0.5]
            .into_iter()
            .any(|y| self.is_solid(edge, y))
    }

    /// The near side of the tile that an edge has entered, px.
    pub(super) fn wall(&self, edge: f64, rightwards: bool) -> f64 {
        let tile = libm::floor(edge / TILE) * TILE;
        if rightwards { tile } else { tile + TILE }
    }

    /// The lower side of the tile that a head meets on its way up, px.
    pub(super) fn ceiling(&self, x: f64, half: f64, from: f64, to: f64) -> Option<f64> {
        let row = libm::floor(to / TILE);
        let entered = row * TILE >= from - 1e-9;
        let met = [x - half + 0.5, x + half - 0.5]
            .into_iter()
            .any(|x| self.is_solid(x, to));
        (entered && met).then_some(row * TILE)
    }

    /// The upper side of the tile that feet meet on their way down, px.
    pub(super) fn ground(&self, x: f64, half: f64, from: f64, to: f64) -> Option<f64> {
        // Feet exactly on the upper side of a tile count as in the tile above.
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
    fn coins_are_free_and_starts_and_flag_stand_on_ground() {
        let level = Level::built_in();
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
    fn all_lines_have_the_same_length() {
        let lengths: Vec<usize> = TEXT.lines().skip(1).map(str::len).collect();
        assert!(
            lengths.iter().all(|length| *length == lengths[0]),
            "{lengths:?}"
        );
    }
}
