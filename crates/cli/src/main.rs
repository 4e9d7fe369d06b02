//! The `b2b` command.
fn main() {}
