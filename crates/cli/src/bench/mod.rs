//! `b2b bench`: the cost of environments and of training.

#[cfg(target_os = "linux")]
mod child;
#[cfg(target_os = "linux")]
mod graph;
#[cfg(target_os = "linux")]
mod process;
#[cfg(target_os = "linux")]
mod sb3;
#[cfg(target_os = "linux")]
mod soak;
mod speed;
mod statistics;
#[cfg(target_os = "linux")]
mod train;
#[cfg(target_os = "linux")]
mod vector;

use anyhow::Result;

/// Measure the cost of environments and of training
#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    benchmark: Benchmark,
}

#[derive(clap::Subcommand)]
enum Benchmark {
    Speed(speed::Arguments),
    #[cfg(target_os = "linux")]
    Vector(vector::Arguments),
    #[cfg(target_os = "linux")]
    Train(train::Arguments),
    #[cfg(target_os = "linux")]
    Graph(graph::Arguments),
    #[cfg(target_os = "linux")]
    Soak(soak::Arguments),
}

/// Runs the command.
pub fn bench(arguments: &Arguments) -> Result<()> {
    match &arguments.benchmark {
        Benchmark::Speed(arguments) => speed::bench(arguments),
        #[cfg(target_os = "linux")]
        Benchmark::Vector(arguments) => vector::bench(arguments),
        #[cfg(target_os = "linux")]
        Benchmark::Train(arguments) => train::bench(arguments),
        #[cfg(target_os = "linux")]
        Benchmark::Graph(arguments) => graph::bench(arguments),
        #[cfg(target_os = "linux")]
        Benchmark::Soak(arguments) => soak::bench(arguments),
    }
}
