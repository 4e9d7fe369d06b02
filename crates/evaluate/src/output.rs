//! The result files of an evaluation.

use std::fs::File;
use std::path::{Path, PathBuf};

use b2b_base::digest_list::{DigestList, read_verified};

use crate::error::at;
use crate::evaluation::{EpisodeResult, Folder, read_episodes, write_episodes};
use crate::results::Results;
use crate::summary::Summary;
use crate::{Result, report};

const EPISODES: &str = "episodes.parquet";
const SUMMARY: &str = "summary.json";
const REPORT: &str = "report.html";

/// Reads the table of episodes from an evaluation's folder, and checks its digest if the folder has digests.
///
/// # Errors
/// [`Error::Io`](crate::Error::Io), also for a table that was changed; [`Error::Table`](crate::Error::Table).
pub fn read_rows(folder: &Path) -> Result<Vec<EpisodeResult>> {
    let path = folder.join(EPISODES);
    read_verified(folder, EPISODES).map_err(at(&path))?;
    let file = File::open(&path).map_err(at(&path))?;
    read_episodes(file).map_err(|source| crate::Error::Table { path, source })
}

impl Results {
    /// Writes the table, the summary and the report to the evaluation's folder, with digests of the table and the
    /// summary. Returns the paths of the table, the summary and the report.
    ///
    /// # Errors
    /// [`Error::Io`](crate::Error::Io).
    pub fn write(&self, folder: &Folder, summary: &Summary) -> Result<[PathBuf; 3]> {
        folder.write(EPISODES, |file| {
            write_episodes(file, &self.rows, &summary.versions).map_err(std::io::Error::other)
        })?;
        folder.write(REPORT, |file| report::write(file, self, summary, &|number| folder.read(number)))?;
        folder.write(SUMMARY, |file| Ok(serde_json::to_writer_pretty(file, summary)?))?;
        let mut digests = DigestList::default();
        for name in [EPISODES, SUMMARY] {
            let path = folder.path_of(name);
            digests.add(name, &std::fs::read(&path).map_err(at(&path))?);
        }
        digests.write(folder.path()).map_err(at(folder.path()))?;
        Ok([EPISODES, SUMMARY, REPORT].map(|name| folder.path_of(name)))
    }
}
