//! The worker's side of a job: an order that it carries out and then ends.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;

use b2b_energyplus::snapshot::leave;
use b2b_energyplus::{Library, Run, confine, confine_with};
use b2b_env::authority;
use serde::Serialize;

use super::owner::Owner;
use super::panic_text;
use crate::order::{AuthorityOrder, Convert, Failure, Order, Reply, Simulate, reply_file};

/// Carries out the job in the file `order`, writes the reply, and ends this process.
pub(crate) fn carry_out(job: Order, order: &Path, owner: &Owner) -> ! {
    // The model is untrusted.
    match &job {
        Order::Simulate(Simulate { output, .. }) => confine_with(output),
        _ => confine(),
    };
    let folder = order.parent().unwrap_or(Path::new("")).to_owned();
    // Ends with this process.
    let _watch = owner.watch(folder);
    let done = catch_unwind(AssertUnwindSafe(|| match job {
        Order::Convert(job) => reply(order, convert(&job)),
        Order::Simulate(job) => reply(order, simulate(job)),
        Order::Authority(job) => reply(order, authority(*job)),
        Order::Episode(_) | Order::Fragment(_) | Order::Action(_) => {
            reply::<()>(order, Err(Failure::Other(format!("the order `{}` is not a job", job.name()))))
        }
    }));
    match done {
        Ok(code) => leave(code),
        Err(panic) => refuse(panic_text(&*panic), order),
    }
}

/// Refuses the order in the file `order`, and ends this process.
pub(crate) fn refuse(why: String, order: &Path) -> ! {
    // A template sends no reply; its owner reads this from the log.
    eprintln!("{why}");
    reply::<()>(order, Err(Failure::Other(why)));
    leave(1)
}

/// Writes a reply. Returns the exit code.
pub(super) fn reply<T: Serialize>(order: &Path, outcome: Result<T, Failure>) -> u8 {
    let reply = outcome.map_or_else(Reply::Failed, Reply::Done);
    let text = serde_json::to_vec(&reply).expect("a reply is plain data");
    match std::fs::write(reply_file(order), text) {
        Ok(()) => 0,
        Err(error) => {
            eprintln!("cannot write the reply: {error}");
            1
        }
    }
}

fn convert(Convert { library, idf }: &Convert) -> Result<String, Failure> {
    Ok(Library::load(library)?.convert_idf(idf)?)
}

fn simulate(job: Simulate) -> Result<b2b_energyplus::Messages, Failure> {
    let Simulate { library, model, weather, output } = job;
    Ok(Run::new(model, weather).output(output).to_end(&Library::load(&library)?)?)
}

fn authority(job: AuthorityOrder) -> Result<authority::Report, Failure> {
    let AuthorityOrder { library, building, weather } = job;
    Ok(authority::measure(&Library::load(&library)?, &Arc::new(building), &weather)?)
}
