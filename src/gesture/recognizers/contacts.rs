//! A number of touches at once.

use super::recognizer::{Playing, Recognizer, TouchGroup};
use crate::gesture::driver::TargetSet;
use crate::gesture::fingers::TouchSample;
use crate::profile::Contacts;

#[derive(Clone, Copy, Debug)]
pub(in crate::gesture) struct ContactsRecognizer;

impl Recognizer for ContactsRecognizer {
    type Gesture = Contacts;

    fn is_group(_own: &Contacts) -> bool {
        true
    }

    fn is_complete(own: &Contacts, group: &TouchGroup<'_>) -> bool {
        group.fingers.count(group.regions) >= own.count
    }

    fn down(_own: &Contacts, _touch: &TouchSample, playing: &mut Playing<'_, '_>) -> Self {
        playing.press(TargetSet::Main);
        Self
    }
}
