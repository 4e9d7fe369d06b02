//! `b2b bench`: the cost of environments and of training.

mod child;
mod graph;
mod process;
mod sb3;
mod speed;
mod statistics;
mod train;
mod vector;

use anyhow::Result;

pub(crate) use speed::speed_json;
pub(crate) use vector::{SINGLE, serve_single};

/// Measure the cost of environments and of training
#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    benchmark: Benchmark,
}

#[derive(clap::Subcommand)]
enum Benchmark {
    Speed(speed::Arguments),
    Vector(vector::Arguments),
    Train(train::Arguments),
    Graph(graph::Arguments),
}

/// Runs the command.
pub fn bench(arguments: &Arguments) -> Result<()> {
    match &arguments.benchmark {
        Benchmark::Speed(arguments) => speed::bench(arguments),
        Benchmark::Vector(arguments) => vector::bench(arguments),
        Benchmark::Train(arguments) => train::bench(arguments),
        Benchmark::Graph(arguments) => graph::bench(arguments),
    }
}
