//! The worker's side of an action: work of a crate above this one.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use b2b_energyplus::snapshot::leave;

use super::job::reply;
use super::panic_text;
use crate::order::{ActionOrder, Failure};

/// Carries out an action: takes its order as JSON, and returns its result as text.
pub type Act = fn(&str) -> Result<String, String>;

/// The actions that a program carries out, by name.
#[derive(Clone, Copy, Debug, Default)]
pub struct Actions(pub &'static [(&'static str, Act)]);

impl Actions {
    fn act(self, order: &ActionOrder) -> Result<String, String> {
        match self.0.iter().find(|(known, _)| *known == order.action) {
            Some((_, act)) => act(order.order.get()),
            None => {
                let known: Vec<&str> = self.0.iter().map(|(known, _)| *known).collect();
                Err(format!("unknown action `{}`; the program has {known:?}", order.action))
            }
        }
    }

    /// Carries out the order in the file `path`, writes the reply, and ends this process.
    pub(crate) fn carry_out(self, order: &ActionOrder, path: &Path) -> ! {
        let done = catch_unwind(AssertUnwindSafe(|| self.act(order)));
        let done = done.unwrap_or_else(|panic| Err(panic_text(&*panic)));
        if let Err(why) = &done {
            eprintln!("error: {why}");
        }
        leave(reply(path, done.map_err(Failure::Other)))
    }
}
