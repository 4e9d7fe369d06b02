//! A worker process with runners of fragments, for programs that cannot be one themselves.

fn main() {
    b2b_learn::fragments::run_if_worker();
    eprintln!("b2b-learn-worker is started automatically by programs that use worker processes, not by hand");
    std::process::exit(2);
}
