//! The regions of a profile on the pad, and which of them a touch counts for.

use crate::profile::{Area, PlacedRegion, Profile, Region, Settings, Slide};
use crate::types::PointMm;

/// Most regions that one touch counts for.
const MOST_COVERED: usize = 4;

/// The regions that a touch counts for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Covered {
    regions: [u16; MOST_COVERED],
    count: usize,
}

impl Covered {
    pub(super) fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        self.regions[..self.count]
            .iter()
            .map(|region| usize::from(*region))
    }

    pub(super) fn contains(&self, region: usize) -> bool {
        self.iter().any(|other| other == region)
    }

    /// A single place: that of a part of a gamepad.
    pub(super) fn only(place: usize) -> Self {
        let mut covered = Self::default();
        covered.push(place);
        covered
    }

    fn push(&mut self, region: usize) {
        if self.count < MOST_COVERED && !self.contains(region) {
            self.regions[self.count] = region as u16;
            self.count += 1;
        }
    }
}

/// The regions of a profile on a pad of a known size.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    /// (Width, height), without mirror and rotation.
    pad_mm: [f64; 2],
    settings: Settings,
    regions: Vec<RegionOnPad>,
    /// Whether any touch can leave or enter a region by moving.
    slides: bool,
}

#[derive(Clone, Debug)]
struct RegionOnPad {
    placed: PlacedRegion,
    /// Corners of its bounding box including its reach, for a quick test.
    low_mm: PointMm,
    high_mm: PointMm,
    reach: f64,
    held_reach: f64,
    exclusive: bool,
    slide: Slide,
    footprint: f64,
    rest: bool,
}

impl RegionOnPad {
    fn new(region: &Region, seen_mm: [f64; 2], area: &Area) -> Self {
        let placed = region.placed(seen_mm, area);
        let (low, high) = placed.bounds_mm();
        let reach_mm = placed.reach_mm(region.reach);
        Self {
            placed,
            low_mm: low.map(|mm| mm - reach_mm),
            high_mm: high.map(|mm| mm + reach_mm),
            reach: region.reach,
            held_reach: region.held_reach,
            exclusive: region.exclusive,
            slide: region.slide,
            footprint: region.footprint,
            rest: region.rest,
        }
    }

    /// Whether a touch at a place goes down in it.
    fn takes(&self, [x, y]: PointMm) -> bool {
        x >= self.low_mm[0]
            && x <= self.high_mm[0]
            && y >= self.low_mm[1]
            && y <= self.high_mm[1]
            && self.placed.contains([x, y], self.reach)
    }

    /// Whether the footprint of a touch reaches it.
    fn is_reached_by(&self, at_mm: PointMm, radius_mm: f64) -> bool {
        self.footprint > 0.0 && self.placed.distance_mm(at_mm) <= self.footprint * radius_mm
    }
}

impl Layout {
    pub(super) fn new(profile: &Profile, pad_mm: [f64; 2]) -> Self {
        let settings = profile.settings.clone();
        let seen_mm = settings.size_as_player_sees_mm(pad_mm);
        let regions: Vec<RegionOnPad> = profile
            .regions
            .iter()
            .map(|region| RegionOnPad::new(region, seen_mm, &settings.area))
            .collect();
        Self {
            pad_mm,
            settings,
            slides: regions
                .iter()
                .any(|region| region.slide != Slide::Keep || region.footprint > 0.0),
            regions,
        }
    }

    /// A place on the pad, as the player sees it.
    pub(super) fn as_seen(&self, point: PointMm) -> PointMm {
        self.settings.as_player_sees(point, self.pad_mm)
    }

    /// The topmost region at a place.
    pub(super) fn topmost(&self, at_mm: PointMm) -> Option<usize> {
        self.regions.iter().position(|region| region.takes(at_mm))
    }

    /// Whether touches that begin in a region are ignored.
    pub(super) fn ignores_touches(&self, region: usize) -> bool {
        self.regions[region].rest
    }

    /// Centre and radius of a region, or of the pad, mm; of a part of a gamepad, in shares of its travel.
    pub(super) fn centre_and_radius(&self, region: Option<usize>) -> (PointMm, f64) {
        match region {
            Some(place) => self.regions.get(place).map_or(([0.0; 2], 1.0), |region| {
                (region.placed.centre_mm(), region.placed.radius_mm())
            }),
            None => {
                let [width, height] = self.settings.size_as_player_sees_mm(self.pad_mm);
                ([width / 2.0, height / 2.0], width.min(height) / 2.0)
            }
        }
    }

    /// The regions that a touch counts for where it goes down.
    pub(super) fn covered(&self, at_mm: PointMm, radius_mm: f64) -> Covered {
        let mut covered = Covered::default();
        let mut is_taken = false;
        for (index, region) in self.regions.iter().enumerate() {
            if region.is_reached_by(at_mm, radius_mm) {
                covered.push(index);
            }
            if !is_taken && region.takes(at_mm) {
                covered.push(index);
                is_taken = region.exclusive;
            }
        }
        covered
    }

    /// The regions that a touch counts for after a move.
    pub(super) fn moved(&self, before: Covered, at_mm: PointMm, radius_mm: f64) -> Covered {
        if !self.slides {
            return before;
        }
        let mut covered = Covered::default();
        let mut is_taken = false;
        for index in before.iter() {
            let region = &self.regions[index];
            let held = region.placed.contains(at_mm, region.held_reach)
                || region.is_reached_by(at_mm, radius_mm);
            if held || (region.slide == Slide::Keep && region.footprint == 0.0) {
                covered.push(index);
                is_taken |= region.exclusive && region.footprint == 0.0;
            }
        }
        for (index, region) in self.regions.iter().enumerate() {
            if region.is_reached_by(at_mm, radius_mm) {
                covered.push(index);
            }
            if region.slide == Slide::Across && !is_taken && region.takes(at_mm) {
                covered.push(index);
                is_taken = region.exclusive;
            }
        }
        covered
    }
}
