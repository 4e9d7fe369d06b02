//! The entry point of a worker process.

use std::ffi::OsString;
use std::path::PathBuf;

use b2b_energyplus::snapshot::leave;

use super::action::Actions;
use super::job;
use super::owner::Owner;
use crate::fragment::Runners;
use crate::order::Order;

/// The argument that makes a program a worker: see [`run_if_worker`].
pub(crate) const FLAG: &str = "--b2b-worker";

/// Runs this process as a worker if it was started as one, and then never returns. A program that uses
/// [`Launcher::this_program`](crate::Launcher::this_program) calls it first in `main`, before it starts a thread.
pub fn run_if_worker() {
    run_if_worker_with(Runners::default(), Actions::default());
}

/// Like [`run_if_worker`], for a program whose workers can also run fragments (see [`Runner`](crate::Runner)) and carry
/// out actions (see [`ActionProcess`](crate::ActionProcess)).
pub fn run_if_worker_with(runners: Runners, actions: Actions) {
    let arguments: Vec<OsString> = std::env::args_os().collect();
    if let Some(flag) = arguments.iter().position(|argument| argument == FLAG) {
        run(&arguments[flag + 1..], runners, actions);
    }
}

/// Parses the owner's arguments: the id of its process and the path of the order.
fn parse(arguments: &[OsString]) -> Option<(i32, PathBuf)> {
    let [owner, order] = arguments else { return None };
    Some((owner.to_str()?.parse().ok()?, order.into()))
}

fn run(arguments: &[OsString], runners: Runners, actions: Actions) -> ! {
    let Some((owner, path)) = parse(arguments) else {
        eprintln!("{FLAG} is for worker processes, which are started automatically");
        leave(2)
    };
    let Some(owner) = Owner::find(owner) else { leave(1) };
    let order = std::fs::read(&path).map_err(|error| format!("{}: {error}", path.display()));
    match order.and_then(|text| Order::parse(&text)) {
        Ok(Order::Episode(episode)) => super::serve(*episode, &path, owner, runners),
        Ok(Order::Action(action)) => actions.carry_out(&action, &path),
        Ok(job) => job::carry_out(job, &path, &owner),
        Err(why) => job::refuse(why, &path),
    }
}
