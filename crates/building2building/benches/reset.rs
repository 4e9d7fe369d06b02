//! The start of an episode: a copy of a warmed-up process, and a start of the engine.
//!
//! `cargo bench -p building2building --bench reset`

use building2building::{EnvBuilder, Environment, make, run_if_worker};
use criterion::{Criterion, criterion_group};

fn house() -> EnvBuilder {
    make("SingleFamilyHouse").expect("a building").task("constant").period("01-01..01-01")
}

fn reset(criterion: &mut Criterion) {
    let mut episode = house().build_in_worker().expect("an environment");
    criterion.bench_function("reset by a copy of a process", |bench| {
        bench.iter(|| episode.reset().expect("an episode").len());
    });
    criterion.bench_function("snapshot", |bench| bench.iter(|| episode.snapshot().expect("a snapshot")));
    drop(episode);
    let mut env = house().build().expect("an environment");
    criterion.bench_function("reset by a start of the engine", |bench| {
        bench.iter(|| env.reset().expect("an episode").len());
    });
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10);
    targets = reset
}

fn main() {
    // A worker starts this program again.
    run_if_worker();
    benches();
    Criterion::default().configure_from_args().final_summary();
}
