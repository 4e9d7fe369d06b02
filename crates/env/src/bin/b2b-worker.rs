//! A process of a pool, for programs that cannot be one themselves.

fn main() {
    b2b_env::vector::run_if_worker();
    eprintln!("b2b-worker is started by a pool of environments, not by hand");
    std::process::exit(2);
}
