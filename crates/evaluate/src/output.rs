//! The files that an evaluation leaves in its folder.

use std::path::PathBuf;

use crate::evaluation::{Folder, write_episodes};
use crate::results::Results;
use crate::summary::Summary;
use crate::{Result, report};

const EPISODES: &str = "episodes.parquet";
const SUMMARY: &str = "summary.json";
const REPORT: &str = "report.html";

impl Results {
    /// Writes the table, the summary and the report to the evaluation's folder and returns their paths.
    ///
    /// # Errors
    /// [`Error::Io`](crate::Error::Io).
    pub fn write(&self, folder: &Folder, summary: &Summary) -> Result<[PathBuf; 3]> {
        folder.write(EPISODES, |file| {
            write_episodes(file, &self.rows, &summary.versions).map_err(std::io::Error::other)
        })?;
        folder.write(REPORT, |file| report::write(file, self, summary, &|number| folder.read(number)))?;
        folder.write(SUMMARY, |file| Ok(serde_json::to_writer_pretty(file, summary)?))?;
        Ok([EPISODES, SUMMARY, REPORT].map(|name| folder.path_of(name)))
    }
}
