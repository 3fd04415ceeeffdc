//! The regions of a profile as they lie on the pad, and which of them a touch counts for.

use crate::profile::{Area, Placed, Profile, Region, Settings, Slide};
use crate::types::PointMm;

/// A touch counts for so many regions at once at most.
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

    /// The one place that a part of a gamepad is.
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

/// Regions on a pad of a size.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    /// As it is wired, (width, height).
    pad_mm: [f64; 2],
    settings: Settings,
    spots: Vec<Spot>,
    /// Whether any touch can leave or enter a region by moving.
    slides: bool,
}

#[derive(Clone, Debug)]
struct Spot {
    placed: Placed,
    /// Corners of the box around it, reach included: most places are outside it, and quickly known to be.
    low_mm: PointMm,
    high_mm: PointMm,
    reach: f64,
    held_reach: f64,
    exclusive: bool,
    slide: Slide,
    footprint: f64,
    rest: bool,
}

impl Spot {
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

    /// Whether it takes a touch that goes down at a place.
    fn takes(&self, [x, y]: PointMm) -> bool {
        x >= self.low_mm[0]
            && x <= self.high_mm[0]
            && y >= self.low_mm[1]
            && y <= self.high_mm[1]
            && self.placed.holds([x, y], self.reach)
    }

    /// Whether a footprint reaches it.
    fn is_stepped_on(&self, at_mm: PointMm, radius_mm: f64) -> bool {
        self.footprint > 0.0 && self.placed.distance_mm(at_mm) <= self.footprint * radius_mm
    }
}

impl Layout {
    pub(super) fn new(profile: &Profile, pad_mm: [f64; 2]) -> Self {
        let settings = profile.settings.clone();
        let seen_mm = settings.seen_size_mm(pad_mm);
        let spots: Vec<Spot> = profile
            .regions
            .iter()
            .map(|region| Spot::new(region, seen_mm, &settings.area))
            .collect();
        Self {
            pad_mm,
            settings,
            slides: spots
                .iter()
                .any(|spot| spot.slide != Slide::Keep || spot.footprint > 0.0),
            spots,
        }
    }

    /// A place on the pad, where the player sees it.
    pub(super) fn seen(&self, point: PointMm) -> PointMm {
        self.settings.seen(point, self.pad_mm)
    }

    /// The topmost region of a place.
    pub(super) fn topmost(&self, at_mm: PointMm) -> Option<usize> {
        self.spots.iter().position(|spot| spot.takes(at_mm))
    }

    /// Whether touches that begin in a region give nothing.
    pub(super) fn is_for_rest(&self, region: usize) -> bool {
        self.spots[region].rest
    }

    /// Middle and radius of a region, or of the pad, mm; of a part of a gamepad, in shares of its way.
    pub(super) fn middle(&self, region: Option<usize>) -> (PointMm, f64) {
        match region {
            Some(place) => self.spots.get(place).map_or(([0.0; 2], 1.0), |spot| {
                (spot.placed.centre_mm(), spot.placed.radius_mm())
            }),
            None => {
                let [width, height] = self.settings.seen_size_mm(self.pad_mm);
                ([width / 2.0, height / 2.0], width.min(height) / 2.0)
            }
        }
    }

    /// The regions that a touch counts for where it goes down.
    pub(super) fn covered(&self, at_mm: PointMm, radius_mm: f64) -> Covered {
        let mut covered = Covered::default();
        let mut taken = false;
        for (region, spot) in self.spots.iter().enumerate() {
            if spot.is_stepped_on(at_mm, radius_mm) {
                covered.push(region);
            }
            if !taken && spot.takes(at_mm) {
                covered.push(region);
                taken = spot.exclusive;
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
        let mut taken = false;
        for region in before.iter() {
            let spot = &self.spots[region];
            let held =
                spot.placed.holds(at_mm, spot.held_reach) || spot.is_stepped_on(at_mm, radius_mm);
            if held || (spot.slide == Slide::Keep && spot.footprint == 0.0) {
                covered.push(region);
                taken |= spot.exclusive && spot.footprint == 0.0;
            }
        }
        for (region, spot) in self.spots.iter().enumerate() {
            if spot.is_stepped_on(at_mm, radius_mm) {
                covered.push(region);
            }
            if spot.slide == Slide::Across && !taken && spot.takes(at_mm) {
                covered.push(region);
                taken = spot.exclusive;
            }
        }
        covered
    }
}
