//! What a recognizer is, what it sees, and what it can do.

use crate::gesture::driver::{Driver, TargetSet};
use crate::gesture::fingers::{Fingers, TouchSample};
use crate::gesture::moment::Moment;
use crate::profile::Target;
use crate::types::{Action, Axis, Event, Nanos, TouchId};

/// The state machine of one gesture, for one binding and one touch or group of touches.
pub(super) trait Recognizer: Copy {
    /// How the gesture is written.
    type Gesture;
    /// Whether further touches are ignored while one plays the binding.
    const ONE_TOUCH: bool = false;

    /// Whether several touches make it together: it then sees their centroid.
    fn is_group(_own: &Self::Gesture) -> bool {
        false
    }

    /// Whether a group of touches makes it.
    fn is_complete(_own: &Self::Gesture, _group: &TouchGroup<'_>) -> bool {
        false
    }

    /// The touch goes down or slides in, or the group is complete.
    fn down(own: &Self::Gesture, touch: &TouchSample, playing: &mut Playing<'_, '_>) -> Self;

    /// The touch moves or changes its force.
    fn moved(
        &mut self,
        _own: &Self::Gesture,
        _touch: &TouchSample,
        _playing: &mut Playing<'_, '_>,
    ) {
    }

    /// The touch lifts or leaves the region, or the group is no longer complete. What is still pressed is released next.
    fn up(&mut self, _own: &Self::Gesture, _playing: &mut Playing<'_, '_>) {}

    /// Time has come to [`Self::next_due`], or to anything else.
    fn tick(&mut self, _own: &Self::Gesture, _playing: &mut Playing<'_, '_>) {}

    /// When it wants a tick.
    fn next_due(&self) -> Option<Nanos> {
        None
    }

    /// Another touch goes down.
    fn other_down(&mut self, _own: &Self::Gesture, _id: TouchId, _playing: &mut Playing<'_, '_>) {}

    /// Another touch lifts.
    fn other_up(&mut self, _own: &Self::Gesture, _id: TouchId, _playing: &mut Playing<'_, '_>) {}
}

/// The touches that may make a gesture together.
#[derive(Debug)]
pub(in crate::gesture) struct TouchGroup<'a> {
    pub fingers: &'a Fingers,
    /// Regions and parts of gamepads of the binding.
    pub places: &'a [usize],
    /// Regions of the binding; empty for the whole pad.
    pub regions: &'a [usize],
    /// Whether it plays the binding already.
    pub is_played: bool,
}

/// The taps of one binding.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::gesture) struct TapMemory {
    /// Taps in a row.
    pub count: u32,
    /// When the last one lifted.
    pub last_ns: Option<Nanos>,
}

impl TapMemory {
    /// Forgets the taps; returns how many a touch at a time follows sooner than a gap.
    pub(super) fn take(&mut self, t_ns: Nanos, gap_ns: Nanos) -> u32 {
        let taps = std::mem::take(self);
        match taps.last_ns {
            Some(last_ns) if t_ns < last_ns + gap_ns => taps.count,
            _ => 0,
        }
    }
}

/// What a recognizer can do at one moment.
pub(in crate::gesture) struct Playing<'a, 'm> {
    pub moment: &'a mut Moment<'m>,
    pub driver: &'a mut Driver,
    pub taps: &'a mut TapMemory,
    pub last_press_ns: &'a mut Option<Nanos>,
    pub binding: usize,
    pub touch: TouchId,
}

impl Playing<'_, '_> {
    pub(super) fn t_ns(&self) -> Nanos {
        self.moment.t_ns
    }

    /// Presses targets of the binding, until [`Self::release`].
    pub(super) fn press(&mut self, targets: TargetSet) {
        self.driver
            .begin(self.moment, self.binding, self.touch, targets);
        *self.last_press_ns = Some(self.moment.t_ns);
    }

    /// Releases what was pressed.
    pub(in crate::gesture) fn release(&mut self) {
        self.driver.end(self.moment, self.binding, self.touch);
    }

    /// Holds a target besides the binding's own.
    pub(super) fn hold(&mut self, target: Target) {
        self.driver.hold(self.moment, target);
    }

    /// Lets go of a target that [`Self::hold`] held.
    pub(super) fn let_go(&mut self, target: Target) {
        self.driver.let_go(self.moment, target);
    }

    /// Moves an axis.
    pub(super) fn set_axis(&mut self, axis: Axis, value: f32) {
        let Moment { t_ns, events, .. } = self.moment;
        self.driver.outputs.set_axis(axis, value, *t_ns, events);
    }

    /// Moves the mouse.
    pub(super) fn send(&mut self, action: Action) {
        let t_ns = self.moment.t_ns;
        self.moment.events.push(Event { t_ns, action });
    }
}
