//! What a binding remembers from one gesture to the next.

use super::macro_runner::MacroRunner;

/// The memory of one binding.
#[derive(Clone, Debug, Default)]
pub(super) struct BindingMemory {
    pub is_toggled: bool,
    pub sticky: StickyState,
    pub runner: Option<MacroRunner>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum StickyState {
    #[default]
    Off,
    /// Down until another press is over.
    Latched { is_used: bool },
    /// Down until the next gesture.
    Locked,
}
