//! One moment of playing.

use super::layout::Layout;
use crate::profile::Profile;
use crate::types::{Event, Nanos};

/// What everything that happens at one time needs: the profile, the time, and where events go.
#[derive(Debug)]
pub(super) struct Moment<'a> {
    pub profile: &'a Profile,
    pub layout: &'a Layout,
    pub t_ns: Nanos,
    pub events: &'a mut Vec<Event>,
}
