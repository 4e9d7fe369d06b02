//! Location of EnergyPlus: shared library, example models and weather files.

use std::path::{Path, PathBuf};

use super::cache::{Cache, variable};
use super::error::{Error, Result};
use super::package::Installed;
use super::pinned::{Package, Platform, Wheel};
use super::progress::Progress;

/// The package that contains EnergyPlus.
///
/// The wheel contains the library twice; the one without a version in its name loads on its own.
pub static ENGINE: Package = Package {
    name: "pyenergyplus-lbnl",
    version: "26.1.0",
    wheels: &[Wheel {
        platform: Platform::Linux("x86_64"),
        file_name: "pyenergyplus_lbnl-26.1.0-py3-none-manylinux1_x86_64.whl",
        sha256: "16bda1d451a72d8ec27697d8c52f804a7ce1c51b0ccb567b80033652e356720b",
        bytes: 46_106_986,
        files_sha256: "ae9a3276b82cd89fe6c04d99ceaf9641686654caac1a961d94cb9b61b496a45b",
    }],
    keep: &[
        "libenergyplusapi.so",
        "pyenergyplus/data/model/*.idf",
        "pyenergyplus/data/weather/*.epw",
        "pyenergyplus_lbnl-26.1.0.dist-info/licenses/LICENSE.txt",
    ],
    corrections: &[],
};

/// File name of the library.
const LIBRARY: &str = "libenergyplusapi.so";

/// Folders of example models, in the package and in an installation.
const MODELS: &[&str] = &["pyenergyplus/data/model", "ExampleFiles"];
/// Folders of weather files, in the package and in an installation.
const WEATHER: &[&str] = &["pyenergyplus/data/weather", "WeatherData"];

/// An installation of EnergyPlus.
#[derive(Clone, Debug, PartialEq)]
pub struct Engine {
    /// Folder.
    pub root: PathBuf,
    /// Shared library with the C API.
    pub library: PathBuf,
    /// Folder of example models (IDF). Always present in the packaged EnergyPlus.
    pub models: Option<PathBuf>,
    /// Folder of weather files (EPW). Always present in the packaged EnergyPlus.
    pub weather: Option<PathBuf>,
    /// Source of the installation.
    pub source: Source,
}

/// Source of an installation of EnergyPlus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// Installed by the user and named by `B2B_ENERGYPLUS`.
    Installed,
    /// The packaged EnergyPlus: in the cache, or installed by the package client.
    Cached,
}

impl Engine {
    /// Returns the EnergyPlus named by `$B2B_ENERGYPLUS` (the folder of an installation or its shared library),
    /// otherwise the packaged one. Never downloads.
    ///
    /// # Errors
    /// [`Error::NoLibrary`] if there is none at the variable, [`Error::NotInstalled`] if there is none in the cache,
    /// [`Error::NoWheel`] if the cache cannot have one for this platform.
    pub fn find() -> Result<Self> {
        Self::find_in(&Cache::from_env()?, Self::installed_by_user().as_deref())
    }

    /// Like [`Engine::find`], but downloads the package if needed.
    ///
    /// # Errors
    /// [`Error::NoLibrary`], [`Error::NoWheel`], and the errors of [`Package::ensure`].
    pub fn ensure(progress: &mut dyn Progress) -> Result<Self> {
        Self::ensure_in(&Cache::from_env()?, Self::installed_by_user().as_deref(), progress)
    }

    /// Like [`Engine::find`], with an explicit cache and value of `B2B_ENERGYPLUS`.
    ///
    /// # Errors
    /// The errors of [`Engine::find`].
    pub fn find_in(cache: &Cache, installed: Option<&Path>) -> Result<Self> {
        if let Some(path) = installed {
            return Self::installed(path);
        }
        ENGINE.require_native()?;
        let found = ENGINE.find(cache).ok_or_else(|| Error::NotInstalled { cache: cache.root.clone() })?;
        Ok(Self::cached(found))
    }

    /// Like [`Engine::ensure`], with an explicit cache and value of `B2B_ENERGYPLUS`.
    ///
    /// # Errors
    /// The errors of [`Engine::ensure`].
    pub fn ensure_in(cache: &Cache, installed: Option<&Path>, progress: &mut dyn Progress) -> Result<Self> {
        match installed {
            Some(path) => Self::installed(path),
            None => {
                ENGINE.require_native()?;
                Ok(Self::cached(ENGINE.ensure(cache, progress)?))
            }
        }
    }

    /// Returns the value of `B2B_ENERGYPLUS`, if set.
    pub fn installed_by_user() -> Option<PathBuf> {
        variable("B2B_ENERGYPLUS").map(PathBuf::from)
    }

    fn installed(path: &Path) -> Result<Self> {
        let none = || Error::NoLibrary { path: path.to_owned(), looked_for: LIBRARY };
        let path = std::path::absolute(path).map_err(|_| none())?;
        let library = if path.is_dir() { path.join(LIBRARY) } else { path };
        let is_library =
            library.file_name().is_some_and(|name| name.to_string_lossy().contains("energyplusapi"));
        if !library.is_file() || !is_library {
            return Err(none());
        }
        let root = library.parent().ok_or_else(none)?.to_owned();
        Ok(Self::at(root, library, Source::Installed))
    }

    fn cached(found: Installed) -> Self {
        let library = found.root.join(LIBRARY);
        Self::at(found.root, library, Source::Cached)
    }

    fn at(root: PathBuf, library: PathBuf, source: Source) -> Self {
        let first = |folders: &[&str]| {
            let mut there = folders.iter().map(|folder| root.join(folder));
            there.find(|folder| folder.is_dir())
        };
        let (models, weather) = (first(MODELS), first(WEATHER));
        Self { root, library, models, weather, source }
    }
}

#[cfg(test)]
#[allow(unsafe_code, reason = "a library that is loaded")]
mod tests {
    use super::*;
    use crate::install::{Quiet, State};

    #[test]
    fn an_installed_energyplus_is_found_by_its_folder_or_its_library() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        std::fs::write(root.join(LIBRARY), "").unwrap();
        std::fs::create_dir(root.join("WeatherData")).unwrap();
        let cache = Cache::new(root.join("cache"));
        for path in [root.to_owned(), root.join(LIBRARY)] {
            let engine = Engine::ensure_in(&cache, Some(&path), &mut Quiet).unwrap();
            assert_eq!(engine.source, Source::Installed);
            assert_eq!(engine.library, root.join(LIBRARY));
            assert_eq!(engine.models, None);
            assert_eq!(engine.weather, Some(root.join("WeatherData")));
        }
        assert!(!cache.root.exists());
    }

    #[test]
    fn the_error_for_a_folder_without_the_library_names_the_folder() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::new(folder.path());
        for path in [folder.path().to_owned(), folder.path().join("nowhere")] {
            let error = Engine::find_in(&cache, Some(&path)).unwrap_err().to_string();
            assert!(error.contains(path.to_str().unwrap()), "{error}");
            assert!(error.contains(LIBRARY), "{error}");
        }
    }

    #[test]
    fn a_missing_energyplus_is_an_error_with_remedies() {
        let folder = tempfile::tempdir().unwrap();
        let error = Engine::find_in(&Cache::new(folder.path()), None).unwrap_err().to_string();
        for way in ["b2b setup", "B2B_CACHE", "B2B_ENERGYPLUS"] {
            assert!(error.contains(way), "{error}");
        }
    }

    /// Uses the user's own cache, and fills it if it is empty.
    #[test]
    fn the_packaged_energyplus_is_installed_automatically() {
        let cache = Cache::from_env().unwrap();
        let engine = Engine::ensure_in(&cache, None, &mut Quiet).unwrap();
        assert_eq!(engine, Engine::find_in(&cache, None).unwrap());
        assert_eq!(engine.source, Source::Cached);
        let count = |folder: &Option<PathBuf>| std::fs::read_dir(folder.as_ref().unwrap()).unwrap().count();
        assert_eq!(count(&engine.models), 32);
        assert_eq!(count(&engine.weather), 16);
        assert!(matches!(ENGINE.verify(&cache), State::Whole { .. }));
        // SAFETY: the library's initializers only set up C++ statics, and no function is called.
        let library = unsafe { libloading::Library::new(&engine.library) }.unwrap();
        // SAFETY: the symbol is looked up, never called.
        let symbol = unsafe { library.get::<unsafe extern "C" fn()>(b"stateNew") };
        assert!(symbol.is_ok());
    }
}
