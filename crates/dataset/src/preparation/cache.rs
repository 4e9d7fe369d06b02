//! The cache of prepared buildings on disk.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use b2b_base::aside::{is_unfinished, write_whole};
use b2b_building::PreparedBuilding;
use b2b_energyplus::install::{cache_dir, seal, unseal};

/// Environment variable with the capacity in megabytes; 0 disables the cache.
const CAPACITY: &str = "B2B_PREPARED_MB";
/// Capacity by default, MB.
const DEFAULT_MB: u64 = 2000;

/// Returns the folder of prepared buildings in a cache.
pub fn prepared_folder(cache: &Path) -> PathBuf {
    cache.join("prepared")
}

/// A folder of prepared buildings, one sealed JSON file each.
///
/// A file is written aside and renamed, so processes may share the folder. A file whose digest does not match is
/// ignored and replaced. Beyond the capacity, the least recently used files are removed. Failures to read or write only
/// cost time and are not reported.
#[derive(Clone, Debug)]
pub(crate) struct PreparationCache {
    folder: PathBuf,
    /// Bytes.
    capacity: u64,
}

impl PreparationCache {
    /// The folder `prepared` of the user's cache, with the capacity of `B2B_PREPARED_MB`; `None` if it is disabled.
    pub(crate) fn from_env() -> Option<Self> {
        let given = std::env::var(CAPACITY).ok().and_then(|text| text.trim().parse().ok());
        let capacity = given.unwrap_or(DEFAULT_MB) * 1_000_000;
        (capacity > 0).then_some(Self { folder: prepared_folder(&cache_dir().ok()?), capacity })
    }

    /// Returns the building of a key if it is cached and intact, and marks it as used.
    pub(crate) fn read(&self, key: &str) -> Option<PreparedBuilding> {
        let path = self.path(key);
        let file = fs::read(&path).ok()?;
        let building = serde_json::from_slice(unseal(&file)?).ok()?;
        let used = File::options().append(true).open(&path);
        let _ = used.and_then(|file| file.set_modified(SystemTime::now()));
        Some(building)
    }

    /// Stores the building of a key, and removes the least recently used beyond the capacity.
    pub(crate) fn write(&self, key: &str, building: &PreparedBuilding) {
        let _ = self.try_write(key, building);
    }

    fn try_write(&self, key: &str, building: &PreparedBuilding) -> std::io::Result<()> {
        let json = serde_json::to_vec(building)?;
        fs::create_dir_all(&self.folder)?;
        let written = write_whole(&self.path(key), &seal(&json));
        self.make_room();
        written
    }

    /// Removes the least recently used files beyond the capacity.
    fn make_room(&self) {
        let mut files = self.files();
        files.sort();
        let mut size: u64 = files.iter().map(|(_, size, _)| size).sum();
        for (_, bytes, path) in files {
            if size > self.capacity && !is_unfinished(&path) {
                size -= bytes;
                // Another process may have removed it already.
                let _ = fs::remove_file(path);
            }
        }
    }

    /// The files: when each was last used, its size and its path.
    fn files(&self) -> Vec<(SystemTime, u64, PathBuf)> {
        let entries = fs::read_dir(&self.folder).into_iter().flatten().flatten();
        let file = |entry: fs::DirEntry| {
            let metadata = entry.metadata().ok()?;
            Some((metadata.modified().ok()?, metadata.len(), entry.path()))
        };
        entries.filter_map(file).collect()
    }

    fn path(&self, key: &str) -> PathBuf {
        Path::new(&self.folder).join(format!("{key}.json"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    /// A building that was never sized, which makes no difference to the cache.
    fn building(name: &str) -> PreparedBuilding {
        let empty = serde_json::json!({
            "name": name, "class": null, "prototype": false, "model": {}, "model_sha256": "", "zones": [], "systems": [],
            "layouts": [], "uncontrolled": [], "conditioned_floor_area": 123.4, "meters": [],
        });
        serde_json::from_value(empty).unwrap()
    }

    fn cache(folder: &Path, capacity: u64) -> PreparationCache {
        PreparationCache { folder: folder.join("prepared"), capacity }
    }

    #[test]
    fn a_stored_building_is_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let cache = cache(folder.path(), 1 << 20);
        assert_eq!(cache.read("key"), None);
        cache.write("key", &building("house"));
        assert_eq!(cache.read("key"), Some(building("house")));
        assert_eq!(cache.read("other"), None);
        assert_eq!(cache.files().len(), 1, "nothing is left aside");
    }

    #[test]
    fn a_damaged_file_is_ignored_and_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let cache = cache(folder.path(), 1 << 20);
        cache.write("key", &building("house"));
        let whole = fs::read(cache.path("key")).unwrap();
        let changed: Vec<u8> = whole.iter().map(|byte| if *byte == b'4' { b'5' } else { *byte }).collect();
        for damaged in [&whole[..whole.len() - 9], &changed, b"", b"no line"] {
            fs::write(cache.path("key"), damaged).unwrap();
            assert_eq!(cache.read("key"), None);
        }
        cache.write("key", &building("house"));
        assert_eq!(cache.read("key"), Some(building("house")));
    }

    #[test]
    fn the_least_recently_used_is_removed_beyond_the_capacity() {
        let folder = tempfile::tempdir().unwrap();
        let size = serde_json::to_vec(&building("0")).unwrap().len() as u64 + 65;
        let cache = cache(folder.path(), 3 * size);
        for number in 0..3u64 {
            cache.write(&number.to_string(), &building(&number.to_string()));
            let file = File::options().append(true).open(cache.path(&number.to_string())).unwrap();
            file.set_modified(SystemTime::now() - Duration::from_secs(100 - number)).unwrap();
        }
        assert!(cache.read("0").is_some(), "the oldest is used");
        cache.write("3", &building("3"));
        let kept = ["0", "1", "2", "3"].map(|key| cache.read(key).is_some());
        assert_eq!(kept, [true, false, true, true]);
    }
}
