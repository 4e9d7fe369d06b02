//! The administrative regions of Québec and their weather.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use b2b_base::aside::write_whole;
use b2b_base::digest::sha256;
use b2b_energyplus::install::{Cache, Progress, State};

use super::station::{Station, rows};
use super::weather::{Place, plain};
use super::{MORPH_VERSION, morph};
use crate::{Error, Result};

/// One row per region: name, station and the reason for its choice.
const REGIONS: &str = include_str!("../data/quebec_regions.csv");
/// SHA-256 of the morphed file of each station of a region, except the base's.
const MORPHED: &str = include_str!("../data/morphed_sha256.csv");
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
    /// The errors of [`Place::epw_in`] and [`morph`]; [`Error::Io`] when the cache cannot be written;
    /// [`Error::Malformed`] when this machine computes bytes that differ from the dataset's.
    pub fn epw(&self, cache: &Cache, progress: &mut dyn Progress) -> Result<PathBuf> {
        let mut base = || Place::find(BASE)?.epw_in(cache, progress);
        if self.station.name == BASE_STATION {
            return base();
        }
        let file = self.morphed_file(cache);
        // A changed file is written again.
        if !std::fs::read(&file).is_ok_and(|text| sha256(text) == self.morphed_sha256()) {
            let base = base()?;
            let text = std::fs::read(&base).map_err(|source| Error::Io { path: base, source })?;
            let text = morph(&String::from_utf8_lossy(&text), self.station)?;
            let (found, expected) = (sha256(&text), self.morphed_sha256());
            if found != expected {
                let why = format!("morphed to SHA-256 {found}, expected {expected}");
                return Err(Error::Malformed { path: file, why });
            }
            write(&morphed_folder(cache), &file, &text)?;
        }
        Ok(file)
    }

    fn morphed_file(&self, cache: &Cache) -> PathBuf {
        morphed_folder(cache).join(format!("{}_morphed.epw", self.station.name.replace('\'', "")))
    }

    fn morphed_sha256(&self) -> &'static str {
        let row = rows(MORPHED).find(|row| row[0] == self.station.name);
        row.expect("the embedded table has every morphed station")[1]
    }
}

fn morphed_folder(cache: &Cache) -> PathBuf {
    cache.root.join(format!("morphed-{MORPH_VERSION}"))
}

/// Verifies the morphed files in a cache.
pub fn verify_morphed(cache: &Cache) -> State {
    let (mut files, mut bytes, mut damaged) = (0, 0, Vec::new());
    let mut seen = HashSet::new();
    let stations = Region::all().iter().filter(|region| region.station.name != BASE_STATION);
    for region in stations.filter(|region| seen.insert(region.station.name)) {
        let file = region.morphed_file(cache);
        match std::fs::read(&file) {
            Ok(text) if sha256(&text) == region.morphed_sha256() => {
                files += 1;
                bytes += text.len() as u64;
            }
            Ok(_) => damaged.push(format!("{}: it was changed", file.display())),
            Err(_) => {}
        }
    }
    State::of_files(files, bytes, damaged)
}

/// Removes the morphed files of a cache; they are written again when needed.
///
/// # Errors
/// [`Error::Io`].
pub fn remove_morphed(cache: &Cache) -> Result<()> {
    let folder = morphed_folder(cache);
    match std::fs::remove_dir_all(&folder) {
        Err(source) if source.kind() != std::io::ErrorKind::NotFound => {
            Err(Error::Io { path: folder, source })
        }
        _ => Ok(()),
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

/// Writes a file atomically, even while other processes write it.
fn write(folder: &Path, file: &Path, text: &str) -> Result<()> {
    let at = |source| Error::Io { path: file.to_owned(), source };
    std::fs::create_dir_all(folder).map_err(at)?;
    write_whole(file, text.as_bytes()).map_err(at)
}

#[cfg(test)]
mod tests {
    use b2b_energyplus::install::Quiet;

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
    fn morphed_files_have_the_bytes_of_the_dataset_and_changed_ones_are_written_again() {
        let user = Cache::from_env().unwrap();
        let folder = tempfile::tempdir().unwrap();
        let base = Place::find(BASE).unwrap().epw_in(&user, &mut Quiet).unwrap();
        let mut cache = Cache::new(folder.path());
        cache.packages = None;
        let package = user.root.join("cerc-hub-0.3.5");
        assert!(base.starts_with(&package));
        std::os::unix::fs::symlink(&package, folder.path().join("cerc-hub-0.3.5")).unwrap();
        for region in Region::all() {
            region.epw(&cache, &mut Quiet).unwrap();
        }
        assert!(matches!(verify_morphed(&cache), State::Whole { files: 13, .. }));
        let file = Region::find("Côte-Nord").unwrap().morphed_file(&cache);
        let whole = std::fs::read_to_string(&file).unwrap();
        let changed = whole.replacen(",0,", ",9,", 1);
        assert!(changed != whole && changed.len() == whole.len());
        std::fs::write(&file, changed).unwrap();
        assert!(matches!(verify_morphed(&cache), State::Damaged(lines) if lines.len() == 1));
        Region::find("Côte-Nord").unwrap().epw(&cache, &mut Quiet).unwrap();
        assert_eq!(std::fs::read_to_string(&file).unwrap(), whole);
        remove_morphed(&cache).unwrap();
        assert_eq!(verify_morphed(&cache), State::Absent);
    }

    #[test]
    fn the_error_of_an_unknown_region_lists_the_regions() {
        let error = Region::find("Ontario").unwrap_err().to_string();
        assert!(error.contains("Ontario") && error.contains("Estrie"), "{error}");
    }
}
