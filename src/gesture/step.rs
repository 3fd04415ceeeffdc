//! One moment of playing: what holds in it, and where its events go.

use super::layout::Layout;
use crate::profile::Profile;
use crate::types::{Event, Nanos};

/// Handed down through everything that happens at one time.
#[derive(Debug)]
pub(super) struct Step<'a> {
    pub profile: &'a Profile,
    pub layout: &'a Layout,
    pub t_ns: Nanos,
    pub events: &'a mut Vec<Event>,
}
