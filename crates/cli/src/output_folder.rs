//! Output folders and files that are written completely or not at all.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use tempfile::TempDir;

/// A folder of output files. Files are staged in the destination, or next to it if it does not exist, and moved into
/// place by [`OutputFolder::keep`]. Dropping the folder before that removes them.
pub struct OutputFolder {
    staging: Option<TempDir>,
    destination: PathBuf,
    /// Parent folders that were created for the destination, deepest first.
    created: Vec<PathBuf>,
}

impl OutputFolder {
    /// Creates the staging folder. Errors if the destination cannot be written; changes none of its files yet.
    pub fn stage(destination: &Path) -> Result<Self> {
        let cannot = || format!("cannot write the folder {}", destination.display());
        if destination.to_str().is_none() {
            bail!(
                "--out {}: the path is not valid UTF-8, which summary.json requires; choose another",
                destination.display()
            );
        }
        let destination_path = std::path::absolute(destination).with_context(cannot)?;
        if destination.exists() && !destination.is_dir() {
            bail!("--out expects a folder, but {} is a file", destination.display());
        }
        let parent = match destination.is_dir() {
            true => &destination_path,
            false => destination_path.parent().unwrap_or(&destination_path),
        };
        let created = parent.ancestors().take_while(|folder| !folder.exists()).map(Path::to_owned).collect();
        let mut folder = Self { staging: None, destination: destination.to_owned(), created };
        std::fs::create_dir_all(parent).with_context(cannot)?;
        let staging = b2b_base::scratch::folder_in(parent, ".b2b-unfinished-");
        folder.staging = Some(staging.with_context(cannot)?);
        Ok(folder)
    }

    /// Writes one file to the staging folder.
    pub fn write(&self, name: &str, content: impl FnOnce(&mut BufWriter<File>) -> Result<()>) -> Result<()> {
        let write = || {
            let mut file = BufWriter::new(File::create(self.staging().join(name))?);
            content(&mut file)?;
            file.flush()?;
            Ok(file.get_ref().sync_all()?)
        };
        let path = self.destination.join(name);
        write().map_err(|error: anyhow::Error| error.context(format!("cannot write {}", path.display())))
    }

    /// Returns the final paths of files with these names.
    pub fn destinations(&self, names: &[&str]) -> Vec<PathBuf> {
        names.iter().map(|name| self.destination.join(name)).collect()
    }

    /// Moves the files to the destination, replacing files with the same names.
    pub fn keep(mut self) -> Result<()> {
        let cannot = || format!("cannot write the folder {}", self.destination.display());
        std::fs::create_dir_all(&self.destination).with_context(cannot)?;
        for file in std::fs::read_dir(self.staging()).with_context(cannot)? {
            let file = file.with_context(cannot)?;
            std::fs::rename(file.path(), self.destination.join(file.file_name())).with_context(cannot)?;
        }
        self.created.clear();
        Ok(())
    }

    /// Writes a single file, completely or not at all.
    pub fn write_file(path: &Path, content: impl FnOnce(&mut BufWriter<File>) -> Result<()>) -> Result<()> {
        let Some(name) = path.file_name().filter(|_| !path.is_dir()) else {
            bail!("--out expects a file, but {} is a folder", path.display());
        };
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let folder = Self::stage(folder.unwrap_or(Path::new(".")))?;
        folder.write(&name.to_string_lossy(), content)?;
        folder.keep()
    }

    fn staging(&self) -> &Path {
        self.staging.as_ref().expect("made by `stage` and dropped last").path()
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        self.staging = None;
        for folder in &self.created {
            // Fails if the folder is no longer empty because something else uses it.
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
    fn an_abandoned_folder_leaves_nothing_behind() {
        let root = tempfile::tempdir().unwrap();
        let folder = OutputFolder::stage(&root.path().join("a/b/c")).unwrap();
        folder.write("x.txt", |file| Ok(file.write_all(b"x")?)).unwrap();
        drop(folder);
        assert_eq!(names(root.path()), [""; 0]);
    }

    #[test]
    fn the_parent_of_an_existing_folder_need_not_be_writable() {
        use std::os::unix::fs::PermissionsExt as _;
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("own");
        std::fs::create_dir(&path).unwrap();
        let staged = OutputFolder::stage(&path).unwrap();
        assert_eq!(names(root.path()), ["own"], "nothing is written next to it");
        assert!(staged.staging().starts_with(&path));
        drop(staged);
        std::fs::set_permissions(root.path(), std::fs::Permissions::from_mode(0o500)).unwrap();
        OutputFolder::write_file(&path.join("x.txt"), |file| Ok(file.write_all(b"x")?)).unwrap();
        std::fs::set_permissions(root.path(), std::fs::Permissions::from_mode(0o700)).unwrap();
        assert_eq!(names(&path), ["x.txt"]);
    }

    #[test]
    fn a_kept_folder_contains_only_its_files() {
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
