//! Real runs of the package client on tiny wheels in a local folder.

use std::io::{Read, Write};
use std::ops::ControlFlow;
use std::panic::AssertUnwindSafe;
use std::sync::Barrier;
use std::sync::atomic::{AtomicUsize, Ordering};

use tempfile::TempDir;
use zip::write::SimpleFileOptions;

use super::*;
use crate::install::Quiet;
use crate::install::doctor::{self, Health};
use crate::install::pinned::Platform;

const EPW: &str = "tiny/weather/AK_Here.epw";

/// A registry that is a folder with one tiny wheel, and an empty cache that downloads from it.
struct Registry {
    folder: TempDir,
    cache: Cache,
    package: Package,
}

impl Registry {
    fn new() -> Self {
        Self::with(&["tiny/weather/*.epw"], &[])
    }

    /// Creates a registry whose wheel also contains the `further` files.
    fn with(keep: &'static [&'static str], further: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let wheel = folder.path().join("tiny-1.0-py3-none-any.whl");
        let mut zip = zip::ZipWriter::new(File::create(&wheel).unwrap());
        let metadata = "Metadata-Version: 2.1\nName: tiny\nVersion: 1.0\nRequires-Python: >=99\n";
        let tag = "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n";
        let files = [
            ("tiny-1.0.dist-info/METADATA", metadata),
            ("tiny-1.0.dist-info/WHEEL", tag),
            ("tiny-1.0.dist-info/RECORD", ""),
            ("tiny/__init__.py", ""),
            ("tiny/weather/deep/AK_There.epw", "not wanted"),
            (EPW, "LOCATION,Here\n"),
            ("tiny/weather/CA_San.Deigo.epw", "LOCATION,San Diego\n"),
        ];
        for (path, text) in files.into_iter().chain(further.iter().map(|path| (*path, "more"))) {
            zip.start_file(path, SimpleFileOptions::default()).unwrap();
            zip.write_all(text.as_bytes()).unwrap();
        }
        zip.finish().unwrap();
        let mut cache = Cache::new(folder.path().join("cache"));
        cache.client_environment =
            vec![("PIP_NO_INDEX".into(), "1".into()), ("PIP_FIND_LINKS".into(), folder.path().into())];
        let pinned = Wheel {
            platform: Platform::Any,
            file_name: "tiny-1.0-py3-none-any.whl",
            sha256: manifest::sha256(&wheel).unwrap().leak(),
            bytes: wheel.metadata().unwrap().len(),
            files_sha256: list_of(&wheel, keep).leak(),
        };
        let package = package_of(vec![pinned].leak(), keep);
        Self { folder, cache, package }
    }

    fn wheel(&self) -> PathBuf {
        self.folder.path().join("tiny-1.0-py3-none-any.whl")
    }

    /// Files in the cache, without the lock and the stamp.
    fn cached(&self) -> Vec<String> {
        let Ok(entries) = std::fs::read_dir(&self.cache.root) else {
            return Vec::new();
        };
        entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .filter(|name| !name.ends_with(".lock") && !name.ends_with(".verified"))
            .collect()
    }
}

/// Returns the SHA-256 of the list of wanted files in a wheel.
fn list_of(wheel: &Path, keep: &'static [&'static str]) -> String {
    let package = package_of(&[], keep);
    let mut archive = ZipArchive::new(File::open(wheel).unwrap()).unwrap();
    let mut files = Vec::new();
    for index in 0..archive.len() {
        let mut entry = archive.by_index(index).unwrap();
        let name = entry.name().unwrap().into_owned();
        if package.wants(&name) {
            let mut content = Vec::new();
            entry.read_to_end(&mut content).unwrap();
            let (path, bytes) = (package.corrected(&name), content.len() as u64);
            files.push(UnpackedFile { path, bytes, sha256: b2b_base::digest::sha256(content) });
        }
    }
    let (package, version, wheel_sha256) = (String::new(), String::new(), String::new());
    Manifest { package, version, wheel_sha256, keep: Vec::new(), files }.digest()
}

fn package_of(wheels: &'static [Wheel], keep: &'static [&'static str]) -> Package {
    Package { name: "tiny", version: "1.0", wheels, keep, corrections: &[("San.Deigo", "San.Diego")] }
}

/// Counts downloads.
#[derive(Default)]
struct Downloads(AtomicUsize);

impl Progress for &Downloads {
    fn begin(&mut self, what: &str, _total_bytes: u64) {
        if what.starts_with("downloading") {
            self.0.fetch_add(1, Ordering::Relaxed);
        }
    }
}

#[test]
fn only_the_wanted_files_are_unpacked_and_recorded() {
    let registry = Registry::new();
    let found = registry.package.ensure(&registry.cache, &mut Quiet).unwrap();
    let paths: Vec<_> = found.manifest.files.iter().map(|file| file.path.as_str()).collect();
    assert_eq!(paths, [EPW, "tiny/weather/CA_San.Diego.epw"]);
    let (path, record) = found.file(EPW).unwrap();
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "LOCATION,Here\n");
    assert_eq!(record.sha256, manifest::sha256(&path).unwrap());
    assert_eq!(registry.cached(), ["tiny-1.0"]);
}

#[test]
fn a_corrupted_wheel_is_rejected_and_leaves_no_files() {
    let registry = Registry::new();
    let mut wheel = std::fs::OpenOptions::new().append(true).open(registry.wheel()).unwrap();
    wheel.write_all(b"?").unwrap();
    let error = registry.package.ensure(&registry.cache, &mut Quiet).unwrap_err();
    assert!(matches!(error, Error::Checksum { .. }), "{error}");
    assert_eq!(registry.cached(), [""; 0]);
}

#[test]
fn a_path_that_leaves_the_folder_is_rejected() {
    let registry = Registry::with(&["../*.epw"], &["../evil.epw"]);
    let error = registry.package.ensure(&registry.cache, &mut Quiet).unwrap_err();
    assert!(matches!(error, Error::BadWheel { .. }), "{error}");
    assert_eq!(registry.cached(), [""; 0]);
}

#[test]
fn concurrent_calls_download_once() {
    let registry = Registry::new();
    let downloads = Downloads::default();
    let start = Barrier::new(4);
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                start.wait();
                registry.package.ensure(&registry.cache, &mut &downloads).unwrap();
            });
        }
    });
    assert_eq!(downloads.0.load(Ordering::Relaxed), 1);
    assert_eq!(registry.cached(), ["tiny-1.0"]);
}

#[test]
fn the_error_without_cache_and_network_says_what_to_do() {
    let mut registry = Registry::new();
    registry.cache.offline = true;
    let error = registry.package.ensure(&registry.cache, &mut Quiet).unwrap_err();
    assert!(matches!(error, Error::Offline { .. }), "{error}");
    for way in ["tiny==1.0", "b2b setup", "B2B_CACHE", "B2B_ENERGYPLUS"] {
        assert!(error.to_string().contains(way), "{error}");
    }
    assert!(!registry.cache.root.exists());
}

#[test]
fn an_intact_package_of_the_client_is_used_in_place() {
    let registry = Registry::with(&[EPW], &[]);
    let package = Package { corrections: &[], ..registry.package };
    let there = registry.folder.path().join("site-packages");
    std::fs::create_dir_all(there.join("tiny/weather")).unwrap();
    std::fs::create_dir_all(there.join("tiny-1.0.dist-info")).unwrap();
    let mut cache = registry.cache.clone();
    (cache.packages, cache.offline) = (Some(there.clone()), true);
    assert!(package.find(&cache).is_none(), "without a record");
    let empty = "47DEQpj8HBSa-_TImW-5JCeuQeRkm5NMpJWZG3hSuFU";
    let here = "sPt8GLj0tOGtgAmHynCgJpDm7GlTy9eWIND6s1nFWHY";
    let record = format!("tiny/__init__.py,sha256={empty},0\n{EPW},sha256={here},14\nlist,,\n");
    std::fs::write(there.join("tiny-1.0.dist-info/RECORD"), record).unwrap();
    assert!(package.find(&cache).is_none(), "without its file");
    std::fs::write(there.join(EPW), "LOCATION,Here\n").unwrap();
    let found = package.ensure(&cache, &mut Quiet).unwrap();
    let (path, file) = found.file("AK_Here.epw").unwrap();
    assert_eq!((path, found.manifest.files.len()), (there.join(EPW), 1));
    assert_eq!(file.sha256, b2b_base::digest::sha256("LOCATION,Here\n"));
    assert!(matches!(package.verify(&cache), State::Whole { files: 1, bytes: 14 }));
    assert_eq!(package.repair(&cache, &mut Quiet).unwrap().root, there, "without a download");
    assert!(!cache.root.exists());
    std::fs::write(there.join(EPW), "LOCATION,hERE\n").unwrap();
    assert!(package.find(&cache).is_none(), "with a changed byte");
    assert_eq!(package.verify(&cache), State::Absent, "the cache does not have it");
}

#[test]
fn offline_with_a_full_cache_works() {
    let mut registry = Registry::new();
    let online = registry.package.ensure(&registry.cache, &mut Quiet).unwrap();
    registry.cache.offline = true;
    std::fs::remove_file(registry.wheel()).unwrap();
    let offline = registry.package.ensure(&registry.cache, &mut Quiet).unwrap();
    assert_eq!(offline.manifest, online.manifest);
}

#[test]
fn the_error_of_a_failing_client_quotes_its_output() {
    let registry = Registry::new();
    std::fs::remove_file(registry.wheel()).unwrap();
    let error = registry.package.ensure(&registry.cache, &mut Quiet).unwrap_err();
    assert!(matches!(error, Error::Download { .. }), "{error}");
    for part in ["No matching distribution found for tiny==1.0", "b2b setup"] {
        assert!(error.to_string().contains(part), "{error}");
    }
    assert_eq!(registry.cached(), [""; 0]);
}

#[test]
fn a_truncated_or_lost_file_is_found_and_repaired() {
    let registry = Registry::new();
    let Registry { cache, package, .. } = &registry;
    let found = package.ensure(cache, &mut Quiet).unwrap();
    for file in [EPW, "manifest.json"] {
        let is_damaged = || {
            assert!(package.find(cache).is_none());
            assert!(!matches!(package.verify(cache), State::Whole { .. }));
        };
        std::fs::write(found.root.join(file), "{").unwrap();
        is_damaged();
        std::fs::remove_file(found.root.join(file)).unwrap();
        is_damaged();
        let repaired = package.ensure(cache, &mut Quiet).unwrap();
        assert_eq!(repaired.manifest, found.manifest);
        assert!(matches!(package.verify(cache), State::Whole { files: 2, .. }));
    }
    assert_eq!(registry.cached(), ["tiny-1.0"]);
}

#[test]
fn a_changed_byte_is_found_by_the_doctor_and_repaired_by_setup() {
    let Registry { cache, package, folder: _folder } = &Registry::new();
    let found = package.ensure(cache, &mut Quiet).unwrap();
    let health = || {
        let findings = doctor::report(cache, None, &[package]);
        let finding = findings.iter().find(|finding| finding.about == "tiny==1.0").unwrap();
        (finding.health, finding.detail.clone())
    };
    assert_eq!(health().0, Health::Good);
    std::fs::write(found.root.join(EPW), "LOCATION,hERE\n").unwrap();
    let (bad, detail) = health();
    assert_eq!(bad, Health::Bad);
    assert!(detail.contains(EPW), "{detail}");
    package.repair(cache, &mut Quiet).unwrap();
    assert_eq!(health().0, Health::Good);
}

#[test]
fn a_changed_byte_is_never_used() {
    let Registry { cache, package, folder: _folder } = &Registry::new();
    let found = package.ensure(cache, &mut Quiet).unwrap();
    let file = found.root.join(EPW);
    let modified = file.metadata().unwrap().modified().unwrap();
    assert!(package.find(cache).is_some());
    std::fs::write(&file, "LOCATION,hERE\n").unwrap();
    File::options().append(true).open(&file).unwrap().set_modified(modified).unwrap();
    assert!(package.find(cache).is_none(), "size and time of modification do not tell");
    let offline = Cache { offline: true, ..cache.clone() };
    let error = package.ensure(&offline, &mut Quiet).unwrap_err();
    assert!(error.to_string().contains("damaged"), "{error}");
    package.ensure(cache, &mut Quiet).unwrap();
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "LOCATION,Here\n");
}

#[test]
fn a_manifest_with_another_list_of_files_is_damaged() {
    let Registry { cache, package, folder: _folder } = &Registry::new();
    let found = package.ensure(cache, &mut Quiet).unwrap();
    let mut changed = found.manifest.clone();
    changed.files[0].sha256 = b2b_base::digest::sha256("LOCATION,hERE\n");
    for manifest in [Manifest { files: Vec::new(), ..changed.clone() }, changed] {
        manifest.write(&found.root).unwrap();
        std::fs::write(found.root.join(EPW), "LOCATION,hERE\n").unwrap();
        assert!(package.find(cache).is_none());
        assert!(matches!(package.verify(cache), State::Damaged(_)));
        package.repair(cache, &mut Quiet).unwrap();
        assert!(matches!(package.verify(cache), State::Whole { files: 2, .. }));
    }
}

#[test]
fn a_verified_package_is_not_read_again() {
    let Registry { cache, package, folder: _folder } = &Registry::new();
    let found = package.ensure(cache, &mut Quiet).unwrap();
    assert!(package.find(cache).is_some());
    let wheel = package.wheel();
    let stamp = Stamp::of(package, &found.manifest, &found.root, cache).unwrap();
    assert!(stamp.is_known() && package.is_whole(&found, wheel, cache));
}

#[test]
fn a_different_choice_of_files_is_a_separate_installation() {
    let mut registry = Registry::new();
    registry.package.ensure(&registry.cache, &mut Quiet).unwrap();
    let keep = &["tiny/__init__.py"];
    let Wheel { platform, file_name, sha256, bytes, .. } = registry.package.wheels[0];
    let files_sha256 = list_of(&registry.wheel(), keep).leak();
    let wheel = Wheel { platform, file_name, sha256, bytes, files_sha256 };
    registry.package = package_of(vec![wheel].leak(), keep);
    assert!(registry.package.find(&registry.cache).is_none());
    let found = registry.package.ensure(&registry.cache, &mut Quiet).unwrap();
    assert!(found.file("tiny/__init__.py").is_some());
    assert!(!found.root.join(EPW).exists());
}

#[test]
fn files_of_a_killed_process_are_removed() {
    let registry = Registry::new();
    let left = registry.cache.root.join(".tiny-1.0.partial/wheel");
    std::fs::create_dir_all(&left).unwrap();
    std::fs::write(left.join("tiny-1.0-py3-none-any.whl"), "half").unwrap();
    registry.package.ensure(&registry.cache, &mut Quiet).unwrap();
    assert_eq!(registry.cached(), ["tiny-1.0"]);
}

/// Calls a function at the first `advance`.
struct AtOnce(fn() -> ControlFlow<()>);

impl Progress for AtOnce {
    fn advance(&mut self, _bytes: u64) -> ControlFlow<()> {
        (self.0)()
    }
}

#[test]
fn cancellation_leaves_no_files() {
    let registry = Registry::new();
    let mut cancel = AtOnce(|| ControlFlow::Break(()));
    let error = registry.package.ensure(&registry.cache, &mut cancel).unwrap_err();
    assert!(matches!(&error, Error::Cancelled { what } if what == "downloading tiny==1.0"));
    assert_eq!(registry.cached(), [""; 0]);
}

#[test]
fn a_panic_leaves_no_files_and_releases_the_lock() {
    let registry = Registry::new();
    let mut panic = AtOnce(|| panic!("a progress bar that panics"));
    let ensure = || registry.package.ensure(&registry.cache, &mut panic);
    assert!(std::panic::catch_unwind(AssertUnwindSafe(ensure)).is_err());
    assert_eq!(registry.cached(), [""; 0]);
    registry.package.ensure(&registry.cache, &mut Quiet).unwrap();
}

#[test]
fn a_platform_without_a_wheel_gets_data_files_but_no_library() {
    let mut registry = Registry::new();
    registry.package.require_native().unwrap();
    let platform = Platform::Linux("another");
    let Wheel { file_name, sha256, bytes, files_sha256, .. } = registry.package.wheels[0];
    let wheel = Wheel { platform, file_name, sha256, bytes, files_sha256 };
    registry.package = package_of(vec![wheel].leak(), registry.package.keep);
    let found = registry.package.ensure(&registry.cache, &mut Quiet).unwrap();
    assert!(found.root.join(EPW).exists());
    let error = registry.package.require_native().unwrap_err().to_string();
    assert!(error.contains("tiny==1.0") && error.contains("B2B_ENERGYPLUS"), "{error}");
}
