//! Models on the real engine.

mod air_loop;
mod external;
mod import;
mod kinds;
mod room;
mod sizing;
