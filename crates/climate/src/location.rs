//! Locations of buildings.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use b2b_energyplus::install::{Cache, Progress};

use super::{ClimateYear, EpwFile, Place, Region, Site};
use crate::{Error, Result};

/// The location of a building: a known place, a region of Québec, or any other place by its weather file.
#[derive(Clone, Debug, PartialEq)]
pub enum Location {
    /// A place of [`crate::PLACES`].
    Place(&'static Place),
    /// A region of Québec.
    Region(&'static Region),
    /// The place of a weather file.
    File(Arc<WeatherFile>),
}

/// A user's weather file.
#[derive(Clone, Debug, PartialEq)]
pub struct WeatherFile {
    /// The file.
    pub path: PathBuf,
    /// Its name without extension, which names the place.
    pub name: String,
    /// Its SHA-256, in hexadecimal.
    pub sha256: String,
    /// The site in its header.
    pub site: Site,
    /// The climate of its hours.
    pub year: ClimateYear,
    /// ASHRAE 169 climate zone: as given by the user, or [`ClimateYear::zone`].
    pub ashrae_zone: String,
}

impl WeatherFile {
    /// Reads a weather file. Its climate zone is `ashrae_zone`, or computed from the hours.
    ///
    /// # Errors
    /// [`Error::Io`] when it cannot be read, [`Error::Malformed`] with the reason.
    pub fn read(path: &Path, ashrae_zone: Option<&str>) -> Result<Self> {
        let file = EpwFile::open(path)?;
        file.check()?;
        let year = file.year()?.ok_or_else(|| Error::Malformed {
            path: path.to_owned(),
            why: "it does not cover a whole year, which a generated building needs".to_owned(),
        })?;
        Ok(Self {
            path: path.to_owned(),
            name: name(path),
            sha256: file.sha256().to_owned(),
            site: file.site()?,
            ashrae_zone: ashrae_zone.map_or_else(|| year.zone(), str::to_owned),
            year,
        })
    }
}

/// Name of a file, without characters that need quotes in a table.
fn name(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    stem.replace([',', '"', '\n', '\r'], "_")
}

impl Location {
    /// Name.
    pub fn name(&self) -> &str {
        match self {
            Self::Place(place) => place.name,
            Self::Region(region) => region.name,
            Self::File(file) => &file.name,
        }
    }

    /// ASHRAE 169 climate zone; `None` for a region, because its houses do not depend on it.
    pub fn ashrae_zone(&self) -> Option<&str> {
        match self {
            Self::Place(place) => Some(place.ashrae_zone),
            Self::Region(_) => None,
            Self::File(file) => Some(&file.ashrae_zone),
        }
    }

    /// Heating degree-days below 18 °C, K·d, of a region or a file.
    pub fn heating_degree_days(&self) -> Option<f64> {
        match self {
            Self::Place(_) => None,
            Self::Region(region) => Some(region.station.heating_degree_days()),
            Self::File(file) => Some(file.year.heating_degree_days),
        }
    }

    /// Returns the weather file; downloads or generates it when it is not in the cache.
    ///
    /// # Errors
    /// The errors of [`Place::epw_in`] and [`Region::epw`].
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
    fn the_file_of_a_known_place_has_its_site_and_climate_zone() {
        let buffalo = Place::find("Buffalo").unwrap();
        let path = buffalo.epw(&mut Quiet).unwrap();
        let file = WeatherFile::read(&path, None).unwrap();
        assert_eq!((file.sha256.as_str(), file.ashrae_zone.as_str()), (buffalo.sha256, "5A"));
        assert_eq!(file.site, Site::read(&path).unwrap());
        assert_eq!(WeatherFile::read(&path, Some("4C")).unwrap().ashrae_zone, "4C");
    }

    #[test]
    fn a_truncated_file_is_rejected_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("half.epw");
        let whole = std::fs::read(Place::find("Denver").unwrap().epw(&mut Quiet).unwrap()).unwrap();
        std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
        let error = WeatherFile::read(&path, None).unwrap_err().to_string();
        assert!(error.contains("half.epw"), "{error}");
    }
}
