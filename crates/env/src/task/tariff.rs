//! The tariff and the emission profile of a task.

use std::path::Path;

use b2b_tariff::{Emissions, Tariff};
use serde::{Deserialize, Serialize};

use crate::{Error, Result};

/// A file that ships with this software, by name, or a user's file with its text, so that a stored task is complete.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "expected the name of one that ships (`b2b list tariffs`), the path of a TOML file, or `name` and `toml`"
)]
pub enum DataFile {
    /// Ships with this software.
    Shipped(String),
    /// A user's file.
    Own {
        /// Name of the file.
        name: String,
        /// Its text.
        toml: String,
    },
}

impl DataFile {
    /// Reads a user's file.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn read(path: &Path) -> Result<Self> {
        let toml =
            std::fs::read_to_string(path).map_err(|source| Error::Io { path: path.to_owned(), source })?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self::Own { name, toml })
    }

    /// Reads the text of the file if this is the path of a user's file, relative to a folder.
    ///
    /// # Errors
    /// Same as [`DataFile::read`].
    pub(super) fn with_text(self, folder: &Path) -> Result<Self> {
        match &self {
            Self::Shipped(path) if path.ends_with(".toml") => Self::read(&folder.join(path)),
            _ => Ok(self),
        }
    }

    /// Returns the name of the file.
    pub fn name(&self) -> &str {
        match self {
            Self::Shipped(name) | Self::Own { name, .. } => name,
        }
    }

    /// Returns the text of the file; `None` for a name that does not ship with this software.
    pub fn text(&self) -> Option<&str> {
        match self {
            Self::Shipped(name) => b2b_tariff::shipped_text(name),
            Self::Own { toml, .. } => Some(toml),
        }
    }

    /// Returns the file as a tariff.
    ///
    /// # Errors
    /// [`Error::Tariff`] for an unknown name, or with the line of an error.
    pub fn tariff(&self) -> Result<Tariff> {
        Ok(match self {
            Self::Shipped(name) => Tariff::named(name)?,
            Self::Own { name, toml } => Tariff::parse(name, &format!("{name}.toml"), toml)?,
        })
    }

    /// Returns the file as an emission profile.
    ///
    /// # Errors
    /// Same as [`DataFile::tariff`].
    pub fn emissions(&self) -> Result<Emissions> {
        Ok(match self {
            Self::Shipped(name) => Emissions::named(name)?,
            Self::Own { name, toml } => Emissions::parse(name, &format!("{name}.toml"), toml)?,
        })
    }
}
