//! `b2b bench`: what the environments cost.

#[cfg(target_os = "linux")]
mod process;
#[cfg(target_os = "linux")]
mod soak;
mod speed;
#[cfg(target_os = "linux")]
mod vector;

use anyhow::Result;
use b2b_env::ActionSpace;

/// Measure what environments cost
#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    Speed(speed::Arguments),
    #[cfg(target_os = "linux")]
    Vector(vector::Arguments),
    #[cfg(target_os = "linux")]
    Soak(soak::Arguments),
}

/// Runs the command.
pub fn bench(arguments: &Arguments) -> Result<()> {
    match &arguments.what {
        What::Speed(arguments) => speed::bench(arguments),
        #[cfg(target_os = "linux")]
        What::Vector(arguments) => vector::bench(arguments),
        #[cfg(target_os = "linux")]
        What::Soak(arguments) => soak::bench(arguments),
    }
}

/// The value in the middle of some.
fn median(values: Vec<f64>) -> f64 {
    percentile(values, 50)
}

/// The value that so many per cent are under.
fn percentile(mut values: Vec<f64>, percent: usize) -> f64 {
    values.sort_by(f64::total_cmp);
    values[(values.len() * percent / 100).min(values.len() - 1)]
}

/// The middle of every bound.
fn middle(space: &ActionSpace) -> Vec<f64> {
    space.low().iter().zip(space.high()).map(|(low, high)| (low + high) / 2.0).collect()
}
