//! The user's cache folder, where packages are kept between runs.

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::OnceLock;

use super::{Error, Result};

/// A cache of packages, and whether missing ones may be downloaded.
#[derive(Clone, Debug)]
pub struct Cache {
    /// Folder of the cache; created when the first package is stored.
    pub root: PathBuf,
    /// Whether downloads are forbidden.
    pub offline: bool,
    /// Additional environment variables for the package client, such as the address of a mirror.
    pub client_environment: Vec<(String, OsString)>,
    /// Folder of packages installed by the package client, for example a Python `site-packages`. Intact packages in it
    /// are used in place.
    pub packages: Option<PathBuf>,
}

/// The folder given to [`use_packages_in`].
static PACKAGES: OnceLock<PathBuf> = OnceLock::new();

/// Makes every cache of [`Cache::from_env`] look for packages in this folder first: the `site-packages` of the Python
/// program that uses this crate. Only the first call has an effect.
pub fn use_packages_in(folder: PathBuf) {
    let _ = PACKAGES.set(folder);
}

impl Cache {
    /// Creates a cache in this folder, with downloads allowed.
    pub fn new(root: impl Into<PathBuf>) -> Self {
        Self { root: root.into(), offline: false, client_environment: Vec::new(), packages: None }
    }

    /// Creates the cache specified by the environment variables: in [`cache_dir`], without downloads if `B2B_OFFLINE`
    /// is set to anything but `0`.
    ///
    /// # Errors
    /// [`Error::NoCacheFolder`] if the home folder is unknown.
    pub fn from_env() -> Result<Self> {
        let offline = variable("B2B_OFFLINE").is_some_and(|value| value != "0");
        Ok(Self { offline, packages: PACKAGES.get().cloned(), ..Self::new(cache_dir()?) })
    }
}

/// Returns the cache folder: `$B2B_CACHE`, otherwise `building2building` in `$XDG_CACHE_HOME` or in `~/.cache`.
///
/// # Errors
/// [`Error::NoCacheFolder`] when no home folder is known.
pub fn cache_dir() -> Result<PathBuf> {
    let folder = cache_dir_from(variable, std::env::home_dir()).ok_or(Error::NoCacheFolder)?;
    std::path::absolute(&folder).map_err(super::error::at(folder))
}

fn cache_dir_from(variable: impl Fn(&str) -> Option<OsString>, home: Option<PathBuf>) -> Option<PathBuf> {
    if let Some(folder) = variable("B2B_CACHE") {
        return Some(folder.into());
    }
    let xdg = variable("XDG_CACHE_HOME")
        .map(PathBuf::from)
        // The XDG base directory specification requires relative paths to be ignored.
        .filter(|path| path.is_absolute());
    let home = home.filter(|home| !home.as_os_str().is_empty());
    let caches = if let Some(xdg) = xdg { xdg } else { home?.join(".cache") };
    Some(caches.join("building2building"))
}

/// Returns an environment variable that is set and not empty.
pub(super) fn variable(name: &str) -> Option<OsString> {
    std::env::var_os(name).filter(|value| !value.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dir(variables: &[(&str, &str)], home: Option<&str>) -> Option<PathBuf> {
        let variable = |name: &str| {
            let (_, value) = variables.iter().find(|(key, _)| *key == name)?;
            Some(OsString::from(value))
        };
        cache_dir_from(variable, home.map(PathBuf::from))
    }

    #[test]
    fn the_cache_folder_is_b2b_cache_then_xdg_then_home() {
        let all = [("B2B_CACHE", "/b2b"), ("XDG_CACHE_HOME", "/xdg")];
        assert_eq!(dir(&all, Some("/home/me")), Some("/b2b".into()));
        assert_eq!(dir(&all[1..], Some("/home/me")), Some("/xdg/building2building".into()));
        let relative = [("XDG_CACHE_HOME", "xdg")];
        assert_eq!(dir(&relative, Some("/home/me")), Some("/home/me/.cache/building2building".into()));
    }

    #[test]
    fn without_a_home_there_is_no_cache_folder() {
        assert_eq!(dir(&[], None), None);
        assert_eq!(dir(&[], Some("")), None);
    }
}
