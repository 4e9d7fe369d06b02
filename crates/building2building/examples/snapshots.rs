//! Snapshots and branches of an episode, which runs in a worker process.
//!
//! `cargo run --release -p building2building --example snapshots`

use building2building::{Environment, Episode, Result, make, run_if_worker};

/// Steps of each continuation.
const STEPS: usize = 12;

fn main() -> Result<()> {
    // A worker starts this program again.
    run_if_worker();
    let mut episode = make("SingleFamilyHouse")?.task("constant").period("01-01..01-01").build_in_worker()?;
    let space = &episode.spaces().action;
    let (low, high) = (space.low().to_vec(), space.high().to_vec());
    episode.reset()?;
    advance(&mut episode, &low)?;

    let snapshot = episode.snapshot()?;
    let minimum = advance(&mut episode, &low)?;
    episode.restore(&snapshot)?;
    let again = advance(&mut episode, &low)?;
    println!("return over {STEPS} steps at minimum: {minimum:.3}");
    println!("after a restore: {}", if again == minimum { "the same bits" } else { "other numbers" });

    // Branches continue side by side from the current point.
    for (branch, action) in episode.branch(2)?.iter_mut().zip([&low, &high]) {
        println!("branch: {:.3}", advance(branch, action)?);
    }
    Ok(())
}

/// Takes steps under one action and returns the sum of their rewards.
fn advance(episode: &mut Episode, action: &[f64]) -> Result<f64> {
    let mut sum = 0.0;
    for _ in 0..STEPS {
        sum += episode.step(action)?.reward.total();
    }
    Ok(sum)
}
