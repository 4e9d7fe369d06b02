//! The `b2b` program from the outside, on the real engine. One program, so that its tests fill all cores to the end.

mod agents;
mod buildings;
mod command;
mod contributing;
mod current_folder;
mod gate;
mod golden;
mod pages;
mod policies;
mod program;
mod readme;
mod seasons;
mod serve;
mod terminal;
mod trust;
