//! Actions: work of a program in its own process.

use std::process::Stdio;

use b2b_workers::{ActionEnd, ActionProcess, Launcher};

fn start(program: &str) -> ActionProcess {
    let silent = |command: &mut std::process::Command| {
        command.stderr(Stdio::null());
    };
    ActionProcess::start(&Launcher::new(program), "dance", &["waltz"], silent).unwrap()
}

#[test]
fn an_action_that_the_program_does_not_have_is_an_error_that_names_it() {
    let ActionEnd::Failed(why) = start(env!("CARGO_BIN_EXE_b2b-worker")).wait(|| false).unwrap() else {
        panic!("it cannot dance")
    };
    assert!(why.contains("unknown action `dance`"), "{why}");
}

#[test]
fn a_process_that_ends_without_a_reply_is_an_error_and_an_interrupt_is_passed_on() {
    let end = start("/bin/false").wait(|| false).unwrap();
    assert_eq!(end, ActionEnd::Failed("its process ended without a reply (exit status: 1)".into()));
    let sleeping = Launcher::new("/bin/sh").argument("-c").argument("exec sleep 60");
    let sleeping = ActionProcess::start(&sleeping, "dance", &(), |_| {}).unwrap();
    assert_eq!(sleeping.wait(|| true).unwrap(), ActionEnd::Interrupted);
}
