//! Where a building stands.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use b2b_energyplus::install::{Cache, Progress};
use sha2::{Digest, Sha256};

use super::{ClimateYear, Place, Region, Site, epw};
use crate::{Error, Result};

/// A known place, a region of Québec, or any other place by its weather file.
#[derive(Clone, Debug, PartialEq)]
pub enum Location {
    /// A place of [`super::PLACES`].
    Place(&'static Place),
    /// A region of Québec.
    Region(&'static Region),
    /// A place that a weather file is of.
    File(Arc<WeatherFile>),
}

/// A weather file of the user, read once.
#[derive(Clone, Debug, PartialEq)]
pub struct WeatherFile {
    /// The file.
    pub path: PathBuf,
    /// Its name without extension: what the place is called.
    pub name: String,
    /// Its SHA-256, in hexadecimal.
    pub sha256: String,
    /// What its header says.
    pub site: Site,
    /// What its hours say.
    pub year: ClimateYear,
    /// Climate zone of ASHRAE 169: what the user says, or [`ClimateYear::zone`].
    pub ashrae_zone: String,
}

impl WeatherFile {
    /// Reads a weather file; its climate zone follows from its hours unless it is given.
    ///
    /// # Errors
    /// [`Error::Io`] when it cannot be read, [`Error::Malformed`] naming what is wrong in it.
    pub fn read(path: &Path, ashrae_zone: Option<&str>) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(|source| Error::Io { path: path.to_owned(), source })?;
        let text = String::from_utf8_lossy(&bytes);
        epw::check(&text, path)?;
        let year = ClimateYear::from_epw(&text).ok_or_else(|| Error::Malformed {
            path: path.to_owned(),
            why: "a month has no hour of weather".to_owned(),
        })?;
        Ok(Self {
            path: path.to_owned(),
            name: name(path),
            sha256: Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect(),
            site: Site::from_epw(&text, path)?,
            ashrae_zone: ashrae_zone.map_or_else(|| year.zone(), str::to_owned),
            year,
        })
    }
}

/// Without what would need quotes in a table.
fn name(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    stem.replace([',', '"', '\n', '\r'], "_")
}

impl Location {
    /// What it is called.
    pub fn name(&self) -> &str {
        match self {
            Self::Place(place) => place.name,
            Self::Region(region) => region.name,
            Self::File(file) => &file.name,
        }
    }

    /// Climate zone of ASHRAE 169; `None` for a region, whose houses are not built by it.
    pub fn ashrae_zone(&self) -> Option<&str> {
        match self {
            Self::Place(place) => Some(place.ashrae_zone),
            Self::Region(_) => None,
            Self::File(file) => Some(&file.ashrae_zone),
        }
    }

    /// Degree-days under 18 °C, K·d, of a region or a file.
    pub fn heating_degree_days(&self) -> Option<f64> {
        match self {
            Self::Place(_) => None,
            Self::Region(region) => Some(region.station.heating_degree_days()),
            Self::File(file) => Some(file.year.heating_degree_days),
        }
    }

    /// The weather file, fetched or made when it is not in the cache.
    ///
    /// # Errors
    /// Those of [`Place::epw_in`] and [`Region::epw`].
    pub fn weather(&self, cache: &Cache, progress: &mut dyn Progress) -> Result<PathBuf> {
        match self {
            Self::Place(place) => place.epw_in(cache, progress),
            Self::Region(region) => region.epw(cache, progress),
            Self::File(file) => Ok(file.path.clone()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use b2b_energyplus::install::Quiet;

    #[test]
    fn a_file_of_a_known_place_is_that_place_by_another_name() {
        let buffalo = Place::find("Buffalo").unwrap();
        let path = buffalo.epw(&mut Quiet).unwrap();
        let file = WeatherFile::read(&path, None).unwrap();
        assert_eq!((file.sha256.as_str(), file.ashrae_zone.as_str()), (buffalo.sha256, "5A"));
        assert_eq!(file.site, Site::read(&path).unwrap());
        assert_eq!(WeatherFile::read(&path, Some("4C")).unwrap().ashrae_zone, "4C");
    }

    #[test]
    fn a_file_that_is_cut_short_is_refused_with_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("half.epw");
        let whole = std::fs::read(Place::find("Denver").unwrap().epw(&mut Quiet).unwrap()).unwrap();
        std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
        let error = WeatherFile::read(&path, None).unwrap_err().to_string();
        assert!(error.contains("half.epw"), "{error}");
    }
}
