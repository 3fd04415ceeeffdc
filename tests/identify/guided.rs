//! `gelpad pad identify --points N` shows places on a board's pad and finds the pad from the presses.

use std::fmt::Write as _;

use gelpad::pad::Pad;

use super::in_play::{Board, bench};
use crate::{errors, gelpad};

/// Places that are shown.
const POINTS: usize = 14;

/// The places that the command shows, mm.
fn places(said: &str) -> Vec<[f64; 2]> {
    let shown = said
        .lines()
        .filter_map(|line| line.split_once("press ✕ at ("));
    shown
        .map(|(_, rest)| {
            let (place, _) = rest.split_once(')').expect("a place");
            let (x, y) = place.split_once(", ").expect("two coordinates");
            [x, y].map(|number| number.parse().expect("a number"))
        })
        .collect()
}

#[test]
fn presses_at_shown_places_of_a_board_find_its_pad() {
    let (folder, truth) = bench();
    let points = POINTS.to_string();
    // A robot presses the simulated pad: this tells the places.
    let robot = [
        "pad",
        "identify",
        "--points",
        &points,
        "--presses",
        "robot.csv",
    ];
    let (is_done, said) = gelpad(folder.path(), &robot);
    assert!(is_done && said.contains("all explained"), "{said}");
    let places = places(&said);
    assert_eq!(places.len(), POINTS, "{said}");
    let (is_done, said) = gelpad(folder.path(), &robot);
    assert!(!is_done && said.contains("robot.csv exists"), "{said}");

    let mut script = String::new();
    for (index, [x, y]) in places.iter().enumerate() {
        // Nobody presses before the first place is shown.
        let down = 6000 + 700 * index;
        let _ = writeln!(script, "t:{down} down 1 {x} {y}\nt:{} up 1", down + 350);
    }
    script.push_str("t:60000 end");
    let _board = Board::start(folder.path(), "./built.toml", &script);
    let command = [
        "pad",
        "identify",
        "--source",
        "serial:board",
        "--points",
        &points,
        "--presses",
        "presses.csv",
        "-o",
        "found.toml",
    ];
    let (is_done, said) = gelpad(folder.path(), &command);
    assert!(is_done && said.contains("14, all explained"), "{said}");
    let text = std::fs::read_to_string(folder.path().join("found.toml")).expect("a pad");
    let found = Pad::from_toml("found.toml", &text).expect("sound");
    let [cells, shifts] = errors(&found, &truth);
    println!("{cells:.4} {shifts:.3} mm");
    assert!(cells < 0.07 && shifts < 0.3, "{cells} {shifts}");
    let presses = std::fs::read_to_string(folder.path().join("presses.csv")).expect("presses");
    assert_eq!(presses.lines().count(), 1 + POINTS);
}
