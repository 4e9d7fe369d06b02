//! A folder of results that appears whole or not at all.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use tempfile::TempDir;

/// Files are written into a folder beside the destination and moved there in the end. Dropped before that,
/// it leaves nothing behind.
pub struct OutputFolder {
    staging: Option<TempDir>,
    destination: PathBuf,
    /// Folders above the destination that were made for it, the deepest first.
    made: Vec<PathBuf>,
}

impl OutputFolder {
    /// Makes sure that the destination can be written, and changes nothing there yet.
    pub fn stage(destination: &Path) -> Result<Self> {
        let cannot = || format!("the folder {} cannot be written", destination.display());
        let destination_path = std::path::absolute(destination).with_context(cannot)?;
        if destination.exists() && !destination.is_dir() {
            anyhow::bail!("{} is a file: give --out a folder", destination.display());
        }
        let parent = destination_path.parent().unwrap_or(&destination_path);
        let made = parent.ancestors().take_while(|folder| !folder.exists()).map(Path::to_owned).collect();
        let mut folder = Self { staging: None, destination: destination.to_owned(), made };
        std::fs::create_dir_all(parent).with_context(cannot)?;
        let staging = tempfile::Builder::new().prefix(".b2b-unfinished-").tempdir_in(parent);
        folder.staging = Some(staging.with_context(cannot)?);
        Ok(folder)
    }

    /// Writes one file.
    pub fn write(&self, name: &str, content: impl FnOnce(&mut BufWriter<File>) -> Result<()>) -> Result<()> {
        let write = || {
            let mut file = BufWriter::new(File::create(self.staging().join(name))?);
            content(&mut file)?;
            file.flush()?;
            Ok(file.get_ref().sync_all()?)
        };
        let path = self.destination.join(name);
        write().map_err(|error: anyhow::Error| error.context(format!("{} cannot be written", path.display())))
    }

    /// Where files of these names will be.
    pub fn destinations(&self, names: &[&str]) -> Vec<PathBuf> {
        names.iter().map(|name| self.destination.join(name)).collect()
    }

    /// Moves the files to the destination; files of the same names there are replaced.
    pub fn keep(mut self) -> Result<()> {
        let cannot = || format!("the folder {} cannot be written", self.destination.display());
        std::fs::create_dir_all(&self.destination).with_context(cannot)?;
        for file in std::fs::read_dir(self.staging()).with_context(cannot)? {
            let file = file.with_context(cannot)?;
            std::fs::rename(file.path(), self.destination.join(file.file_name())).with_context(cannot)?;
        }
        self.made.clear();
        Ok(())
    }

    fn staging(&self) -> &Path {
        self.staging.as_ref().expect("made by `stage` and dropped last").path()
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        self.staging = None;
        for folder in &self.made {
            // Not empty: somebody else uses it by now.
            let _ = std::fs::remove_dir(folder);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn what_is_not_kept_leaves_nothing() {
        let root = tempfile::tempdir().unwrap();
        let folder = OutputFolder::stage(&root.path().join("a/b/c")).unwrap();
        folder.write("x.txt", |file| Ok(file.write_all(b"x")?)).unwrap();
        drop(folder);
        assert_eq!(names(root.path()), [""; 0]);
    }

    #[test]
    fn what_is_kept_is_there_alone() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("a/b");
        for text in ["first", "second"] {
            let folder = OutputFolder::stage(&path).unwrap();
            folder.write("x.txt", |file| Ok(file.write_all(text.as_bytes())?)).unwrap();
            folder.keep().unwrap();
            assert_eq!(std::fs::read_to_string(path.join("x.txt")).unwrap(), text);
        }
        assert_eq!((names(&root.path().join("a")), names(&path)), (vec!["b".into()], vec!["x.txt".into()]));
    }
}
