//! Any touch.

use super::definition::{BindingReader, GestureDefinition};

/// Any touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Press;

impl GestureDefinition for Press {
    fn read(_binding: &mut BindingReader<'_>) -> Option<Self> {
        Some(Self)
    }

    fn describe(&self) -> String {
        "touch".to_owned()
    }
}
