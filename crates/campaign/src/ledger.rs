//! Counts of the inputs, and the findings.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result};

/// The outcome of an input.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Outcome {
    /// It was accepted.
    Accepted,
    /// It was rejected with an error.
    Rejected,
    /// A guarantee was violated.
    Found,
}

/// Counts by kind, and the folder of the findings.
pub struct Ledger {
    folder: PathBuf,
    counts: BTreeMap<String, [usize; 3]>,
    findings: usize,
}

impl Ledger {
    /// Creates an empty ledger.
    pub fn new(folder: PathBuf) -> Self {
        Self { folder, counts: BTreeMap::new(), findings: 0 }
    }

    /// Counts inputs of a kind.
    pub fn count(&mut self, kind: &str, outcome: Outcome, number: usize) {
        self.counts.entry(kind.to_owned()).or_default()[outcome as usize] += number;
    }

    /// Counts a finding and saves its description with the files or folders that reproduce it.
    pub fn find(&mut self, kind: &str, description: &str, files: &[&Path]) -> Result<()> {
        self.count(kind, Outcome::Found, 1);
        self.findings += 1;
        let number = (1..).find(|number| !self.place(kind, *number).exists()).unwrap_or(0);
        let place = self.place(kind, number);
        std::fs::create_dir_all(&place).with_context(|| format!("cannot write {}", place.display()))?;
        std::fs::write(place.join("finding.txt"), description)?;
        for file in files.iter().filter(|file| file.exists()) {
            copy(file, &place.join(file.file_name().unwrap_or_default()))?;
        }
        eprintln!("finding: {kind}: {}\n  {}", description.lines().next().unwrap_or(""), place.display());
        Ok(())
    }

    /// Counts an input by the violated guarantee, which is a finding, or else by the exit code of the command.
    pub fn judge(
        &mut self,
        kind: &str,
        broken: Option<String>,
        code: Option<i32>,
        folder: &Path,
    ) -> Result<()> {
        match broken {
            Some(description) => self.find(kind, &description, &[folder])?,
            None if code == Some(0) => self.count(kind, Outcome::Accepted, 1),
            None => self.count(kind, Outcome::Rejected, 1),
        }
        Ok(())
    }

    fn place(&self, kind: &str, number: usize) -> PathBuf {
        self.folder.join(format!("{}-{number}", kind.replace([' ', '/'], "-")))
    }

    /// Returns success if nothing was found.
    pub fn exit_code(&self) -> ExitCode {
        if self.findings == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
    }
}

/// A table with one line per kind.
impl fmt::Display for Ledger {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{:48} {:>8} {:>8} {:>8}", "kind", "accepted", "rejected", "findings")?;
        for (kind, [accepted, rejected, found]) in &self.counts {
            writeln!(f, "{kind:48} {accepted:>8} {rejected:>8} {found:>8}")?;
        }
        let sum =
            |outcome: Outcome| self.counts.values().map(|counts| counts[outcome as usize]).sum::<usize>();
        let all = [Outcome::Accepted, Outcome::Rejected, Outcome::Found].map(sum);
        write!(f, "{:48} {:>8} {:>8} {:>8}", "all", all[0], all[1], all[2])
    }
}

/// Copies a file, or a folder with everything in it.
pub fn copy(from: &Path, to: &Path) -> Result<()> {
    if !from.is_dir() {
        std::fs::copy(from, to).with_context(|| format!("cannot copy {}", from.display()))?;
        return Ok(());
    }
    std::fs::create_dir_all(to)?;
    for entry in std::fs::read_dir(from)? {
        let entry = entry?;
        copy(&entry.path(), &to.join(entry.file_name()))?;
    }
    Ok(())
}
