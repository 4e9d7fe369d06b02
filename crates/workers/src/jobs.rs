//! The owner's side of jobs: orders that are each carried out by a separate worker process.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::process::{ExitStatus, Stdio};

use b2b_base::scratch::temporary_folder;
use b2b_building::PreparedBuilding;
use b2b_energyplus::{Error, Host, Messages, Result};
use b2b_env::authority;
use serde::de::DeserializeOwned;

use super::order::{AuthorityOrder, Convert, Failure, Order, Reply, Simulate, reply_file};
use super::process::{Process, describe};
use super::time_limit::TimeLimit;
use super::workers::worker_options::WorkerOptions;

/// Number of lines of the engine's error file that are quoted after a crash.
const LAST_LINES: usize = 5;
/// Number of bytes at the end of a file in which to look for them.
const LAST_BYTES: u64 = 4000;

/// Jobs for EnergyPlus, each in its own worker process: conversions, whole runs and response checks.
///
/// A crash, or a job beyond the [time limit of preparations](WorkerOptions::preparation_time_limit), is an error that
/// names the model. As the [`Host`] of a catalog's library, jobs keep users' models out of this process. Several
/// threads may use them.
#[derive(Clone, Debug)]
pub struct Jobs(WorkerOptions);

impl Jobs {
    /// Creates jobs whose processes are started like workers.
    pub fn new(options: WorkerOptions) -> Self {
        Self(options)
    }

    /// Checks the response of a building to its actuators: see [`authority::measure`].
    ///
    /// # Errors
    /// Errors from the engine; [`Error::Process`]; [`Error::Interrupted`].
    pub fn authority(&self, building: &PreparedBuilding, weather: &Path) -> Result<authority::Report> {
        let doing = format!("checking the actuators of {}", building.name);
        let (library, building, weather) = (self.library(), building.clone(), absolute(weather)?);
        let order = Order::Authority(Box::new(AuthorityOrder { library, building, weather }));
        self.run(&doing, &order, None)
    }

    fn library(&self) -> PathBuf {
        self.0.library.clone()
    }

    /// Carries out an order in a new process. `output` is the engine's output folder, by default a temporary one.
    fn run<T: DeserializeOwned>(&self, doing: &str, order: &Order, output: Option<&Path>) -> Result<T> {
        let folder = temporary_folder("b2b-job-")?;
        let [path, log] = ["order.json", "worker.log"].map(|name| folder.path().join(name));
        order.to_json().and_then(|text| std::fs::write(&path, text)).map_err(at(&path))?;
        let words = File::create(&log).map_err(at(&log))?;
        let WorkerOptions { launcher, .. } = &self.0;
        let child = launcher.start(Stdio::null(), &path, folder.path(), words);
        let end = match self.wait(Process::new(child.map_err(at(launcher.program()))?))? {
            Some(status) => match std::fs::read(reply_file(&path)) {
                Ok(text) => return read_reply(doing, &text),
                Err(_) => describe(status),
            },
            None => format!("took longer than {:?} and was stopped", self.0.preparation_time_limit),
        };
        let last_messages = last_messages(output.unwrap_or(folder.path()), &log);
        Err(Error::Process { doing: doing.to_owned(), end, last_messages })
    }

    /// Waits for a process and returns how it ended; `None` at the time limit.
    fn wait(&self, mut process: Process) -> Result<Option<ExitStatus>> {
        let mut limit = TimeLimit::new(self.0.preparation_time_limit);
        loop {
            if let Some(status) = process.wait_briefly().map_err(at(self.0.launcher.program()))? {
                return Ok(Some(status));
            }
            if (self.0.interrupted)() {
                return Err(Error::Interrupted);
            }
            if limit.is_exceeded() {
                return Ok(None);
            }
        }
    }
}

impl Host for Jobs {
    fn convert_idf(&self, idf: &Path) -> Result<String> {
        let doing = format!("converting {}", idf.display());
        let order = Convert { library: self.library(), idf: absolute(idf)? };
        self.run(&doing, &Order::Convert(order), None).map_err(|error| named(error, idf))
    }

    fn run_to_end(&self, model: &Path, weather: &Path, output: &Path) -> Result<Messages> {
        let doing = format!("simulating {}", model.display());
        let order = Simulate {
            library: self.library(),
            model: absolute(model)?,
            weather: absolute(weather)?,
            output: absolute(output)?,
        };
        self.run(&doing, &Order::Simulate(order), Some(output))
    }
}

/// Puts the caller's path of the model into an error.
fn named(error: Error, path: &Path) -> Error {
    match error {
        Error::Engine { code, messages, .. } => Error::Engine { code, model: path.to_owned(), messages },
        other => other,
    }
}

fn read_reply<T: DeserializeOwned>(doing: &str, text: &[u8]) -> Result<T> {
    let failed = |why: String| Error::Process {
        doing: doing.to_owned(),
        end: format!("failed ({why})"),
        last_messages: String::new(),
    };
    match serde_json::from_slice(text) {
        Ok(Reply::Done(result)) => Ok(result),
        Ok(Reply::Failed(Failure::Engine { code, model, messages })) => {
            Err(Error::Engine { code, model, messages })
        }
        Ok(Reply::Failed(Failure::Other(why))) => Err(failed(why)),
        Err(error) => Err(failed(format!("its reply is damaged: {error}"))),
    }
}

/// Returns the last lines of the engine's error file or, without one, of the log, one per line.
fn last_messages(output: &Path, log: &Path) -> String {
    let error_file = error_file(output);
    let files = error_file.iter().map(PathBuf::as_path).chain([log]);
    let lines = files.map(last_lines).find(|lines| !lines.is_empty()).unwrap_or_default();
    match lines.is_empty() {
        true => ".".into(),
        false => format!("; its last messages:\n  {}", lines.join("\n  ")),
    }
}

/// Finds the engine's error file in a folder or one below it.
fn error_file(folder: &Path) -> Option<PathBuf> {
    const NAME: &str = "eplusout.err";
    let below = std::fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path().join(NAME));
    std::iter::once(folder.join(NAME)).chain(below).find(|path| path.is_file())
}

fn last_lines(path: &Path) -> Vec<String> {
    let read = || -> std::io::Result<String> {
        let mut file = File::open(path)?;
        let length = file.metadata()?.len();
        file.seek(SeekFrom::Start(length.saturating_sub(LAST_BYTES)))?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes)?;
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    };
    let text = read().unwrap_or_default();
    let lines: Vec<String> = text.lines().filter(|line| !line.trim().is_empty()).map(str::to_owned).collect();
    lines[lines.len().saturating_sub(LAST_LINES)..].to_vec()
}

/// Makes a path absolute. A worker inherits the current folder, but its order should not depend on it.
fn absolute(path: &Path) -> Result<PathBuf> {
    std::path::absolute(path).map_err(at(path))
}

fn at(path: &Path) -> impl Fn(std::io::Error) -> Error + '_ {
    move |source| Error::Io { path: path.to_owned(), source }
}
