//! The owner's side of actions: work defined by the crates above this one, each in its own process.

use std::io;
use std::path::PathBuf;
use std::process::{Child, Command};

use b2b_base::scratch::temporary_folder;
use serde::Serialize;
use serde_json::value::to_raw_value;
use tempfile::TempDir;

use super::order::{ActionOrder, Failure, Order, Reply, reply_file};
use super::process::{Process, describe};
use super::workers::launcher::Launcher;

/// A process that carries out an action of its program. It is killed on drop.
#[derive(Debug)]
pub struct ActionProcess {
    process: Process,
    /// The file of the order.
    order: PathBuf,
    /// Its temporary files.
    _folder: TempDir,
}

/// How an action ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ActionEnd {
    /// With its result.
    Done(String),
    /// With an error or a crash.
    Failed(String),
    /// After an interrupt, which was passed on to it.
    Interrupted,
}

impl ActionProcess {
    /// Starts a program that carries out an action with this order. `set_up` sets the standard streams and the folder
    /// of the process.
    ///
    /// # Errors
    /// Errors of the operating system.
    pub fn start(
        launcher: &Launcher,
        action: &str,
        order: &impl Serialize,
        set_up: impl FnOnce(&mut Command),
    ) -> io::Result<Self> {
        let folder = temporary_folder("b2b-action-").map_err(io::Error::other)?;
        let path = folder.path().join("order.json");
        let order = ActionOrder { action: action.to_owned(), order: to_raw_value(order)? };
        std::fs::write(&path, Order::Action(order).to_json()?)?;
        let mut command = launcher.command(&path, folder.path());
        set_up(&mut command);
        Ok(Self { process: Process::new(command.spawn()?), order: path, _folder: folder })
    }

    /// The process, for its standard streams.
    pub fn child(&mut self) -> &mut Child {
        &mut self.process.child
    }

    /// Waits for the end, checking for an interrupt several times a second. An interrupt is passed on once; the process
    /// then has no time limit.
    ///
    /// # Errors
    /// Errors of the operating system.
    pub fn wait(mut self, mut interrupted: impl FnMut() -> bool) -> io::Result<ActionEnd> {
        let mut told = false;
        let status = loop {
            if let Some(status) = self.process.wait_briefly()? {
                break status;
            }
            if !told && interrupted() {
                told = true;
                self.process.terminate();
            }
        };
        if told {
            return Ok(ActionEnd::Interrupted);
        }
        let reply = std::fs::read(reply_file(&self.order)).map(|text| serde_json::from_slice(&text));
        Ok(match reply {
            Ok(Ok(Reply::Done(result))) => ActionEnd::Done(result),
            Ok(Ok(Reply::Failed(Failure::Other(why)))) => ActionEnd::Failed(why),
            _ => ActionEnd::Failed(format!("its process {}", describe(status))),
        })
    }
}
