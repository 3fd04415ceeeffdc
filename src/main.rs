//! gelpad
fn main(){}
