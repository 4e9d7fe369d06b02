//! A worker process, for tests that cannot act as their own workers.

fn main() {
    b2b_workers::run_if_worker();
    eprintln!("b2b-serve-worker is started automatically by tests, not by hand");
    std::process::exit(2);
}
