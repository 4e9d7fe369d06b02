//! A batch of environments that step together, each in its own worker process.
//!
//! `cargo run --release -p building2building --example vector_batch -- 4 01-01..01-07`

use building2building::{make, run_if_worker};

fn main() -> building2building::Result<()> {
    // A worker starts this program again.
    run_if_worker();
    let mut arguments = std::env::args().skip(1);
    let count = arguments.next().and_then(|count| count.parse().ok()).unwrap_or(2);
    let period = arguments.next().unwrap_or_else(|| "01-01..01-01".into());
    let mut envs = make("SingleFamilyHouse")?.task("constant").period(&period).build_batch(count)?;
    envs.reset(0)?;

    // Every actuator in the middle of its range.
    let mut actions = Vec::new();
    for env in 0..envs.len() {
        let Some(spaces) = envs.spaces(env) else { continue };
        actions.extend(spaces.action.middle());
    }
    while !envs.is_over(0) {
        envs.step(&actions)?;
    }
    for env in 0..envs.len() {
        if let Some(metrics) = envs.final_metrics(env) {
            println!("environment {env}: {} steps, return {:.1}", metrics.steps, metrics.episode_return);
        }
    }
    Ok(())
}
