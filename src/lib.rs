//! gelpad
