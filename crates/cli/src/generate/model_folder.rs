//! A folder of generated models with the manifest that describes them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use b2b_base::aside::write_whole;
use b2b_base::folder_lock::FolderLock;
use b2b_dataset::manifest::Manifest;

use crate::output_folder;

/// Name of the manifest in the folder.
pub const MANIFEST: &str = "manifest.csv";

/// A folder of models, written by one process at a time. Each file is staged and moved into place, so it is always
/// complete. The manifest is written first, so that an interrupted generation can resume.
pub struct ModelFolder {
    root: PathBuf,
    _lock: FolderLock,
}

impl ModelFolder {
    /// Adds the rows of a manifest to the manifest in the folder.
    ///
    /// # Errors
    /// An error with a name, if the folder has another model of that name.
    pub fn open(root: &Path, manifest: &Manifest) -> Result<Self> {
        let folder = Self { root: root.to_owned(), _lock: output_folder::lock(root)? };
        let text = manifest.to_csv();
        let (header, wanted) = rows(&text);
        let mut described = folder.described(header)?;
        for (name, row) in wanted {
            let same = described.insert(name.to_owned(), row.to_owned()).is_some_and(|old| old == row);
            if !same && folder.contains(name) {
                bail!(
                    "{} is of other parameters or of another version of the generator; choose another folder with \
                     --out, or remove it",
                    folder.model(name).display()
                );
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

    /// Returns the rows of the existing manifest by name.
    fn described(&self, header: &str) -> Result<BTreeMap<String, String>> {
        let path = self.root.join(MANIFEST);
        if !path.exists() {
            return Ok(BTreeMap::new());
        }
        let text =
            std::fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
        let (old_header, old_rows) = rows(&text);
        if old_header != header {
            bail!("{} has the columns of another version; choose another folder with --out", path.display());
        }
        Ok(old_rows.map(|(name, row)| (name.to_owned(), row.to_owned())).collect())
    }

    fn model(&self, name: &str) -> PathBuf {
        self.root.join(file_name(name))
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
    fn a_model_of_the_same_row_is_kept_and_another_is_not_replaced() {
        let root = tempfile::tempdir().unwrap();
        let other = |table: &Manifest| ModelFolder::open(root.path(), table).err().unwrap().to_string();
        ModelFolder::open(root.path(), &table("a", 1)).unwrap().write("a", "{}").unwrap();
        assert!(ModelFolder::open(root.path(), &table("a", 1)).unwrap().contains("a"));
        let said = other(&table("a", 2));
        assert!(said.contains("a.epJSON is of other parameters"), "{said}");
        std::fs::remove_file(root.path().join(MANIFEST)).unwrap();
        assert_eq!(other(&table("a", 1)), said, "without a row");
        std::fs::write(root.path().join(MANIFEST), "id\nb\n").unwrap();
        assert!(other(&table("c", 1)).contains("manifest.csv has the columns of another version"));
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
