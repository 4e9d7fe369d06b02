//! Tests of tariffs from outside.

mod bills;
mod common;
mod docs;
mod files;
mod real_tariffs;
