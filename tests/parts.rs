//! Boards that take long to send a frame: touches are seen, recorded and replayed while their frame is still being read.

mod parts {
    pub mod board;
    mod latency;
    mod play;
    mod recording;
    mod slide;
    mod wire;
}
