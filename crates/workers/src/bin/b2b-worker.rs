//! A worker process, for programs that cannot act as their own workers.

fn main() {
    b2b_workers::run_if_worker();
    eprintln!("b2b-worker is started automatically by programs that use worker processes, not by hand");
    std::process::exit(2);
}
