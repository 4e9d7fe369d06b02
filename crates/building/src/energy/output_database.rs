//! The database (SQLite) with the engine's reports of a run.

use std::path::{Path, PathBuf};

use b2b_base::scratch::temporary_folder;
use b2b_climate::{EpwFile, mild_year};
use b2b_energyplus::{Library, Run};
use rusqlite::{Connection, OpenFlags};
use serde_json::json;
use tempfile::TempDir;

use crate::{Error, Model, Result, outputs};

/// The database of a run, in a temporary folder.
pub(crate) struct OutputDatabase {
    _folder: TempDir,
    path: PathBuf,
}

impl OutputDatabase {
    /// Makes the database a model's only output.
    pub(crate) fn request(model: &mut Model) {
        outputs::write_only(model, &["sqlite"]);
        model.insert("Output:SQLite", "Output:SQLite", json!({"option_type": "Simple"}));
    }

    /// Runs a model that [requests](Self::request) the database to its end, with the time steps of the weather file if
    /// it has several rows an hour. The temporary folder's name begins with `prefix`.
    ///
    /// # Errors
    /// [`Error::Engine`] with the engine's messages when it rejects the model; [`Error::Climate`] when the weather file
    /// cannot be read; [`Error::Io`] when temporary files cannot be written.
    pub(crate) fn of(mut model: Model, weather: &Path, library: &Library, prefix: &str) -> Result<Self> {
        let rows = EpwFile::open(weather)?.record()?.intervals();
        if rows > 1 {
            model.remove_class("Timestep");
            model.insert("Timestep", "Timestep 1", json!({"number_of_timesteps_per_hour": rows}));
        }
        Self::run(&model, temporary(prefix)?, weather, library)
    }

    /// Runs a model whose reports do not depend on the weather, like [`OutputDatabase::of`], in a year with or without
    /// 29 February.
    ///
    /// # Errors
    /// [`Error::Engine`] with the engine's messages when it rejects the model; [`Error::Io`] when temporary files
    /// cannot be written.
    pub(crate) fn in_any_weather(
        model: &Model,
        is_leap: bool,
        library: &Library,
        prefix: &str,
    ) -> Result<Self> {
        let folder = temporary(prefix)?;
        let weather = folder.path().join("any.epw");
        write(&weather, &mild_year(is_leap))?;
        Self::run(model, folder, &weather, library)
    }

    fn run(model: &Model, folder: TempDir, weather: &Path, library: &Library) -> Result<Self> {
        let input = folder.path().join("model.epJSON");
        write(&input, &model.to_epjson())?;
        Run::new(&input, weather).output(folder.path()).to_end(library)?;
        let path = folder.path().join("eplusout.sql");
        Ok(Self { _folder: folder, path })
    }

    /// Reads from the database. An error of SQLite becomes one of this crate with the database's path.
    pub(crate) fn read<T>(
        &self,
        read: impl FnOnce(&Connection) -> rusqlite::Result<T>,
        unreadable: impl FnOnce(PathBuf, rusqlite::Error) -> Error,
    ) -> Result<T> {
        let database = Connection::open_with_flags(&self.path, OpenFlags::SQLITE_OPEN_READ_ONLY);
        let found = database.and_then(|database| read(&database));
        found.map_err(|source| unreadable(self.path.clone(), source))
    }
}

fn temporary(prefix: &str) -> Result<TempDir> {
    Ok(temporary_folder(prefix).map_err(b2b_energyplus::Error::from)?)
}

fn write(path: &Path, text: &str) -> Result<()> {
    std::fs::write(path, text).map_err(|source| Error::Io { path: path.to_owned(), source })
}
