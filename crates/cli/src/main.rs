//! The program `b2b`.

use std::process::ExitCode;

fn main() -> ExitCode {
    match std::env::current_exe() {
        Ok(program) => b2b_cli::run(b2b_cli::Program::new(program), std::env::args_os()).into(),
        Err(error) => {
            eprintln!("error: cannot determine the path of this program: {error}");
            ExitCode::FAILURE
        }
    }
}
