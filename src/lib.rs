//! gelpad: play games on a soft sheet of hydrogel.
//!
//! A frame of voltages goes in at the bottom, key and gamepad events come out at the top, and every stage
//! between is a plain function of what the stage below hands up. See ARCHITECTURE.md.

#![warn(missing_docs, unreachable_pub)]

pub mod eit;
pub mod pad;
pub mod source;
pub mod touch;
pub mod types;
