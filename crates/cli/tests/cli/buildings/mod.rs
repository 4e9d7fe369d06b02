//! Commands about buildings and models.

mod calibrate;
mod dataset;
mod edit;
mod import;
mod show;
