//! The administrative regions of Québec and their weather.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use b2b_energyplus::install::{Cache, Progress};

use super::station::{Station, rows};
use super::weather::{Place, plain};
use super::{MORPH_VERSION, morph};
use crate::{Error, Result};

/// One row per region: its name, its station and the reason for that station.
const REGIONS: &str = include_str!("../data/quebec_regions.csv");
/// The place whose weather file is the base of the morphed files.
const BASE: &str = "Montréal";
/// The station of the base file.
const BASE_STATION: &str = "CAN_PQ_Montreal.Intl.AP.716270_CWEC";

/// An administrative region of Québec.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Its name.
    pub name: &'static str,
    /// The station that represents its climate: one in the region, or the nearest.
    pub station: &'static Station,
}

impl Region {
    /// Returns the 15 regions of the stock survey, in official order.
    pub fn all() -> &'static [Self] {
        static REGIONS: LazyLock<Vec<Region>> = LazyLock::new(read);
        &REGIONS
    }

    /// Returns the region with this name, ignoring case, spaces, punctuation and accents.
    ///
    /// # Errors
    /// [`Error::UnknownPlace`] listing the regions.
    pub fn find(name: &str) -> Result<&'static Self> {
        let wanted = plain(name);
        Self::all().iter().find(|region| plain(region.name) == wanted).ok_or_else(|| Error::UnknownPlace {
            name: name.to_owned(),
            near: None,
            known: Self::all().iter().map(|region| region.name).collect(),
        })
    }

    /// Returns its EPW file: the published file of Montréal, or one morphed from it and kept in the cache.
    ///
    /// # Errors
    /// Those of [`Place::epw_in`] and [`morph`]; [`Error::Io`] when the cache cannot be written.
    pub fn epw(&self, cache: &Cache, progress: &mut dyn Progress) -> Result<PathBuf> {
        let mut base = || Place::find(BASE)?.epw_in(cache, progress);
        if self.station.name == BASE_STATION {
            return base();
        }
        let folder = cache.root.join(format!("morphed-{MORPH_VERSION}"));
        let file = folder.join(format!("{}_morphed.epw", self.station.name.replace('\'', "")));
        if !file.exists() {
            let base = base()?;
            let text = std::fs::read(&base).map_err(|source| Error::Io { path: base, source })?;
            write(&folder, &file, &morph(&String::from_utf8_lossy(&text), self.station)?)?;
        }
        Ok(file)
    }
}

fn read() -> Vec<Region> {
    rows(REGIONS)
        .map(|row| Region {
            name: row[0],
            station: Station::find(row[1]).expect("the embedded table names stations"),
        })
        .collect()
}

/// Writes a file atomically, also when other processes write it at the same time.
fn write(folder: &Path, file: &Path, text: &str) -> Result<()> {
    let at = |source| Error::Io { path: file.to_owned(), source };
    std::fs::create_dir_all(folder).map_err(at)?;
    let aside = tempfile::TempDir::new_in(folder).map_err(at)?;
    let new = aside.path().join("new.epw");
    std::fs::write(&new, text).map_err(at)?;
    std::fs::rename(&new, file).map_err(at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_region_has_a_station_and_is_found_by_its_name() {
        assert_eq!(Region::all().len(), 15);
        for region in Region::all() {
            assert_eq!(Region::find(&region.name.to_uppercase()).unwrap(), region);
        }
        assert_eq!(Region::find("Cote Nord").unwrap().name, "Côte-Nord");
    }

    #[test]
    fn the_error_of_an_unknown_region_lists_the_regions() {
        let error = Region::find("Ontario").unwrap_err().to_string();
        assert!(error.contains("Ontario") && error.contains("Estrie"), "{error}");
    }
}
