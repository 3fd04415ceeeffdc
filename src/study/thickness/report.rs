//! What the thickness study tells.
