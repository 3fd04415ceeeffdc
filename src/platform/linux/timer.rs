//! Sleeps end on time here without more.

/// Fine sleeps for as long as it lives.
#[derive(Debug)]
pub struct FineTimer;

impl FineTimer {
    /// Requests fine sleeps.
    #[must_use]
    pub fn request() -> Self {
        Self
    }
}
