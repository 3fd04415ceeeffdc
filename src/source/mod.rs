//! Where frames come from: the simulated pad, frames from a file, a board on a serial port.

mod noise;

pub use noise::Noise;
