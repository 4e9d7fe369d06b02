//! Cached files that are computed rather than downloaded: morphed weather, prepared buildings and baselines.

use std::path::PathBuf;

use anyhow::{Context, Result};
use b2b_climate::region::{remove_morphed, verify_morphed};
use b2b_dataset::prepared_folder;
use b2b_energyplus::install::doctor::{Finding, Health};
use b2b_energyplus::install::{Cache, State, check_sealed, unseal};

/// Verifies the files. Returns a finding for each kind.
pub fn findings(cache: &Cache) -> Vec<Finding> {
    let states = std::iter::once(("morphed weather", verify_morphed(cache)))
        .chain(sealed(cache).map(|(about, folder)| (about, check_sealed(&folder))));
    let finding = |(about, state): (&str, State)| {
        let (health, detail) = match state {
            State::Absent => (Health::Absent, "computed when first needed".to_owned()),
            State::Whole { files, bytes } => (Health::Good, State::verified(files, bytes)),
            State::Damaged(lines) => {
                (Health::Bad, format!("not used; run `b2b setup` to remove: {}", lines.join("; ")))
            }
        };
        Finding { about: about.to_owned(), health, detail }
    };
    states.map(finding).collect()
}

/// Removes damaged files, which are computed again when needed. Returns a line of text for each kind with damage.
pub fn remove_damaged(cache: &Cache) -> Result<Vec<String>> {
    let mut lines = Vec::new();
    if matches!(verify_morphed(cache), State::Damaged(_)) {
        remove_morphed(cache)?;
        lines.push("✓ removed damaged morphed weather".to_owned());
    }
    for (about, folder) in sealed(cache) {
        let mut removed = 0;
        for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
            let path = entry.path();
            let is_damaged = |file: Vec<u8>| unseal(&file).is_none();
            if path.extension().is_some_and(|each| each == "json")
                && std::fs::read(&path).is_ok_and(is_damaged)
            {
                std::fs::remove_file(&path).with_context(|| format!("cannot remove {}", path.display()))?;
                removed += 1;
            }
        }
        if removed > 0 {
            lines.push(format!("✓ removed {removed} damaged files of {about}"));
        }
    }
    Ok(lines)
}

/// Returns the folders of sealed files, which start with their SHA-256.
fn sealed(cache: &Cache) -> impl Iterator<Item = (&'static str, PathBuf)> {
    [
        ("prepared buildings", prepared_folder(&cache.root)),
        ("baselines", b2b_evaluate::Baselines::folder_in(&cache.root)),
    ]
    .into_iter()
}
