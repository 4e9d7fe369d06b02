//! Computes a digest of the sources that the preparation of a building depends on, so that the cache never returns
//! buildings prepared by another revision.

use std::hash::{DefaultHasher, Hasher};
use std::path::{Path, PathBuf};

/// Sources of the preparation, relative to this crate. A published package lacks them and uses the versions of the
/// crates instead.
const SOURCES: [&str; 5] = ["src", "../base/src", "../building/src", "../climate/src", "../energyplus/src"];

fn main() {
    let mut digest = DefaultHasher::new();
    let mut files = Vec::new();
    for folder in SOURCES {
        println!("cargo::rerun-if-changed={folder}");
        collect(Path::new(folder), &mut files);
    }
    files.sort();
    for file in files {
        digest.write(file.to_string_lossy().as_bytes());
        digest.write(&std::fs::read(&file).unwrap_or_default());
    }
    println!("cargo::rustc-env=B2B_PREPARATION_SOURCES={:016x}", digest.finish());
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    for path in entries.map(|entry| entry.path()) {
        if path.is_dir() { collect(&path, files) } else { files.push(path) }
    }
}
