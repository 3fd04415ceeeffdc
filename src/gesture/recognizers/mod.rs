//! Recognizers: the state machine of each gesture, one file each. `profile/gestures/mod.rs` holds the list.

mod curve;
mod recognizer;

pub(super) use recognizer::{Playing, TapMemory, TouchGroup};

use super::fingers::TouchSample;
use crate::profile::Gesture;
use crate::profile::gestures::for_each_gesture;
use crate::types::{Nanos, TouchId};
use recognizer::Recognizer;

macro_rules! define_recognizers {
    ($($word:literal $module:ident $Type:ident $Recognizer:ident,)+) => {
        $(mod $module;)+

        /// The recognizer of any gesture.
        #[derive(Clone, Copy, Debug)]
        pub(super) enum ActiveRecognizer {
            $($Type($module::$Recognizer),)+
        }

        impl ActiveRecognizer {
            pub(super) fn down(gesture: &Gesture, touch: &TouchSample, playing: &mut Playing<'_, '_>) -> Self {
                match gesture {
                    $(Gesture::$Type(own) => Self::$Type($module::$Recognizer::down(own, touch, playing)),)+
                }
            }

            pub(super) fn moved(&mut self, gesture: &Gesture, touch: &TouchSample, playing: &mut Playing<'_, '_>) {
                match (self, gesture) {
                    $((Self::$Type(one), Gesture::$Type(own)) => one.moved(own, touch, playing),)+
                    _ => {}
                }
            }

            pub(super) fn up(&mut self, gesture: &Gesture, playing: &mut Playing<'_, '_>) {
                match (self, gesture) {
                    $((Self::$Type(one), Gesture::$Type(own)) => one.up(own, playing),)+
                    _ => {}
                }
            }

            pub(super) fn tick(&mut self, gesture: &Gesture, playing: &mut Playing<'_, '_>) {
                match (self, gesture) {
                    $((Self::$Type(one), Gesture::$Type(own)) => one.tick(own, playing),)+
                    _ => {}
                }
            }

            pub(super) fn next_due(&self) -> Option<Nanos> {
                match self { $(Self::$Type(one) => one.next_due(),)+ }
            }

            pub(super) fn other_down(&mut self, gesture: &Gesture, id: TouchId, playing: &mut Playing<'_, '_>) {
                match (self, gesture) {
                    $((Self::$Type(one), Gesture::$Type(own)) => one.other_down(own, id, playing),)+
                    _ => {}
                }
            }

            pub(super) fn other_up(&mut self, gesture: &Gesture, id: TouchId, playing: &mut Playing<'_, '_>) {
                match (self, gesture) {
                    $((Self::$Type(one), Gesture::$Type(own)) => one.other_up(own, id, playing),)+
                    _ => {}
                }
            }
        }

        /// Whether several touches make a gesture together.
        pub(super) fn is_group(gesture: &Gesture) -> bool {
            match gesture { $(Gesture::$Type(own) => $module::$Recognizer::is_group(own),)+ }
        }

        /// Whether a group of touches makes a gesture.
        pub(super) fn is_complete(gesture: &Gesture, group: &TouchGroup<'_>) -> bool {
            match gesture { $(Gesture::$Type(own) => $module::$Recognizer::is_complete(own, group),)+ }
        }

        /// Whether only one touch at a time plays a gesture.
        pub(super) fn takes_one_touch(gesture: &Gesture) -> bool {
            match gesture { $(Gesture::$Type(_) => $module::$Recognizer::ONE_TOUCH,)+ }
        }
    };
}

for_each_gesture!(define_recognizers);
