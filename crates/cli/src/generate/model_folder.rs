//! A folder of generated models with the manifest that describes them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use b2b_base::aside::write_whole;
use b2b_base::folder_lock::FolderLock;
use b2b_dataset::manifest::Manifest;

use crate::output_folder;

/// Name of the manifest in the folder.
pub const MANIFEST: &str = "manifest.csv";

/// A folder of models, written by one process at a time. Each file is staged and moved into place, so it is always
/// complete. A file whose row in the manifest has changed is removed before the manifest is updated, so that an
/// interrupted generation can resume.
pub struct ModelFolder {
    root: PathBuf,
    _lock: FolderLock,
}

impl ModelFolder {
    /// Updates the manifest in the folder and removes the models that no longer match it. Rows of other names are kept.
    pub fn open(root: &Path, manifest: &Manifest) -> Result<Self> {
        let folder = Self { root: root.to_owned(), _lock: output_folder::lock(root)? };
        let text = manifest.to_csv();
        let (header, wanted) = rows(&text);
        let mut described = folder.described(header)?;
        for (name, row) in wanted {
            if described.get(name).is_none_or(|old| old != row) {
                folder.remove(name)?;
                described.insert(name.to_owned(), row.to_owned());
            }
        }
        let lines: Vec<_> = described.into_values().collect();
        folder.write_file(MANIFEST, &format!("{header}\n{}\n", lines.join("\n")))?;
        Ok(folder)
    }

    /// Returns whether the model of this name exists.
    pub fn contains(&self, name: &str) -> bool {
        self.model(name).is_file()
    }

    /// Writes the model of this name.
    pub fn write(&self, name: &str, epjson: &str) -> Result<()> {
        self.write_file(&file_name(name), epjson)
    }

    /// Returns the rows of the existing manifest by name; none if its columns differ.
    fn described(&self, header: &str) -> Result<BTreeMap<String, String>> {
        let path = self.root.join(MANIFEST);
        if !path.exists() {
            return Ok(BTreeMap::new());
        }
        let text =
            std::fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
        let (old_header, old_rows) = rows(&text);
        let known = old_rows.filter(|_| old_header == header);
        Ok(known.map(|(name, row)| (name.to_owned(), row.to_owned())).collect())
    }

    fn model(&self, name: &str) -> PathBuf {
        self.root.join(file_name(name))
    }

    fn remove(&self, name: &str) -> Result<()> {
        let path = self.model(name);
        if path.exists() {
            std::fs::remove_file(&path).with_context(|| format!("cannot remove {}", path.display()))?;
        }
        Ok(())
    }

    fn write_file(&self, name: &str, content: &str) -> Result<()> {
        let path = self.root.join(name);
        write_whole(&path, content.as_bytes()).with_context(|| format!("cannot write {}", path.display()))
    }
}

fn file_name(name: &str) -> String {
    format!("{name}.epJSON")
}

/// Returns the header of a manifest, and its rows with their first cells.
fn rows(text: &str) -> (&str, impl Iterator<Item = (&str, &str)>) {
    let mut lines = text.lines();
    let header = lines.next().unwrap_or_default();
    (header, lines.map(|row| (row.split(',').next().unwrap_or_default(), row)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use b2b_building::BuildingType;
    use b2b_dataset::manifest::of_buildings;
    use b2b_dataset::{Places, sample};

    fn table(name: &str, seed: u64) -> Manifest {
        let buildings = sample(BuildingType::Warehouse, 1, seed, &Places::All, &[]).unwrap();
        of_buildings(buildings.iter().map(|building| (name, building)))
    }

    fn names(root: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(root).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_model_is_kept_only_while_its_row_is_unchanged() {
        let root = tempfile::tempdir().unwrap();
        ModelFolder::open(root.path(), &table("a", 1)).unwrap().write("a", "{}").unwrap();
        assert!(ModelFolder::open(root.path(), &table("a", 1)).unwrap().contains("a"));
        assert!(!ModelFolder::open(root.path(), &table("a", 2)).unwrap().contains("a"));
    }

    #[test]
    fn a_model_without_a_manifest_row_is_removed() {
        let root = tempfile::tempdir().unwrap();
        std::fs::write(root.path().join("a.epJSON"), "half").unwrap();
        assert!(!ModelFolder::open(root.path(), &table("a", 1)).unwrap().contains("a"));
    }

    #[test]
    fn a_second_generation_adds_to_the_folder() {
        let root = tempfile::tempdir().unwrap();
        ModelFolder::open(root.path(), &table("a", 1)).unwrap().write("a", "{}").unwrap();
        ModelFolder::open(root.path(), &table("b", 1)).unwrap().write("b", "{}").unwrap();
        let manifest = std::fs::read_to_string(root.path().join(MANIFEST)).unwrap();
        assert_eq!(manifest.lines().count(), 3);
        assert_eq!(names(root.path()), ["a.epJSON", "b.epJSON", MANIFEST]);
    }

    #[test]
    fn two_generations_at_once_do_not_share_a_folder() {
        let root = tempfile::tempdir().unwrap();
        let _first = ModelFolder::open(root.path(), &table("a", 1)).unwrap();
        let said = ModelFolder::open(root.path(), &table("b", 1)).err().unwrap().to_string();
        assert!(said.contains("is in use by another command"), "{said}");
    }
}
