//! The file of evaluations, one line each, from which an interrupted tuning run resumes.

use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::outcome::Outcome;
use super::plan::Plan;
use crate::{Error, Result};

/// A set of parameters and its outcomes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Evaluation {
    /// Values of the searched parameters.
    pub(super) values: Vec<f64>,
    /// Outcome of each building.
    pub(super) outcomes: Vec<Outcome>,
}

/// The evaluations of a plan, appended to a file.
pub(super) struct Record {
    path: PathBuf,
    file: File,
    pub(super) evaluations: Vec<Evaluation>,
}

impl Record {
    /// Opens the file of a plan, or creates it. An incomplete last line is dropped.
    pub(super) fn open(path: &Path, plan: &Plan) -> Result<Self> {
        let io = |source| Error::Io { path: path.to_owned(), source };
        let head = serde_json::to_string(plan).expect("a plan is plain data") + "\n";
        let text = match std::fs::read_to_string(path) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => String::new(),
            text => text.map_err(io)?,
        };
        let whole = &text[..text.rfind('\n').map_or(0, |end| end + 1)];
        let evaluations = match whole.strip_prefix(head.as_str()) {
            Some(lines) => lines.lines().map(|line| read(path, plan, line)).collect::<Result<_>>()?,
            None if whole.is_empty() => Vec::new(),
            None => {
                let why = format!("it starts with {}", whole.lines().next().unwrap_or_default());
                return Err(Error::OtherTuning { path: path.to_owned(), why });
            }
        };
        let mut file = OpenOptions::new().create(true).append(true).open(path).map_err(io)?;
        file.set_len(whole.len() as u64).map_err(io)?;
        if whole.is_empty() {
            file.write_all(head.as_bytes()).map_err(io)?;
        }
        Ok(Self { path: path.to_owned(), file, evaluations })
    }

    pub(super) fn push(&mut self, evaluation: Evaluation) -> Result<()> {
        let line = serde_json::to_string(&evaluation).expect("an evaluation is plain data") + "\n";
        let written = self.file.write_all(line.as_bytes());
        written.map_err(|source| Error::Io { path: self.path.clone(), source })?;
        self.evaluations.push(evaluation);
        Ok(())
    }
}

fn read(path: &Path, plan: &Plan, line: &str) -> Result<Evaluation> {
    let other = |why: String| Error::OtherTuning { path: path.to_owned(), why };
    let evaluation: Evaluation = serde_json::from_str(line).map_err(|error| other(error.to_string()))?;
    if evaluation.outcomes.len() != plan.buildings.len() {
        let (found, expected) = (evaluation.outcomes.len(), plan.buildings.len());
        return Err(other(format!("an evaluation has {found} buildings; expected {expected}")));
    }
    Ok(evaluation)
}
