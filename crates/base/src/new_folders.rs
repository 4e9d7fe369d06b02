//! Folders that are removed again if they stay empty.

use std::io::Result;
use std::path::{Path, PathBuf};

/// Folders that were created for future files, deepest first. The empty ones are removed on drop.
#[derive(Debug)]
pub struct NewFolders(Vec<PathBuf>);

impl NewFolders {
    /// Creates a folder and its parents where they are missing.
    ///
    /// # Errors
    /// Errors of the operating system.
    pub fn create(folder: &Path) -> Result<Self> {
        let path = std::path::absolute(folder)?;
        let absent = path.ancestors().take_while(|each| !each.exists()).map(Path::to_owned);
        let new = Self(absent.collect());
        std::fs::create_dir_all(folder)?;
        Ok(new)
    }

    /// Keeps the folders, empty or not.
    pub fn keep(mut self) {
        self.0.clear();
    }
}

impl Drop for NewFolders {
    fn drop(&mut self) {
        for folder in &self.0 {
            // Fails if the folder is not empty.
            let _ = std::fs::remove_dir(folder);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_new_folders_that_are_empty_and_not_kept_are_removed() {
        let root = tempfile::tempdir().unwrap();
        let at = |path: &str| root.path().join(path);
        drop(NewFolders::create(&at("a/b")).unwrap());
        assert!(!at("a").exists());
        NewFolders::create(&at("kept")).unwrap().keep();
        drop(NewFolders::create(&at("kept")).unwrap());
        assert!(at("kept").exists(), "it was there before");
        let used = NewFolders::create(&at("c/d")).unwrap();
        std::fs::write(at("c/x"), "").unwrap();
        drop(used);
        assert!(at("c").exists() && !at("c/d").exists());
    }
}
