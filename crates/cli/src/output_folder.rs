//! Output folders and files that are written completely or not at all.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Component, Path, PathBuf};

use anyhow::{Context, Result, bail};
use b2b_base::folder_lock::FolderLock;
use b2b_base::new_folders::NewFolders;
use tempfile::TempDir;

/// A folder of output files. Files are staged in the destination, or next to it if it does not exist, and moved into
/// place by [`OutputFolder::keep`]. Dropping the folder before that removes them.
pub struct OutputFolder {
    staging: TempDir,
    destination: PathBuf,
    /// Dropped after the staging folder, which may be in one of them.
    created: NewFolders,
    /// Lock of the destination, if it was claimed.
    _lock: Option<FolderLock>,
}

/// Creates an output folder if there is none, and locks it: one process at a time writes to it.
///
/// # Errors
/// Another process has the lock, or the folder cannot be written.
pub fn lock(folder: &Path) -> Result<FolderLock> {
    let cannot = || cannot_write(folder);
    std::fs::create_dir_all(folder).with_context(cannot)?;
    FolderLock::acquire(folder).with_context(cannot)?.with_context(|| {
        format!(
            "{} is in use by another command; wait for its end, or choose another folder",
            folder.display()
        )
    })
}

/// Files by which the output of a command is known.
const OF_COMMANDS: [(&str, &str); 4] = [
    ("agent.json", "b2b train"),
    ("evaluation.json", "b2b evaluate"),
    ("result.json", "b2b benchmark run"),
    ("trajectory.parquet", "b2b run"),
];

/// Errors if a folder has the output of another command, whose files would be mixed up with this one's.
pub fn refuse_others(folder: &Path, own: &str) -> Result<()> {
    let others = OF_COMMANDS.iter().filter(|(_, command)| *command != own);
    match others.into_iter().find(|(file, _)| folder.join(file).exists()) {
        Some((_, command)) => {
            bail!("{} has the output of `{command}`; choose another folder", folder.display())
        }
        None => Ok(()),
    }
}

/// Returns a path as a part of the name of an output folder, which files of one name in other folders do not share.
pub fn path_in_name(path: &Path) -> String {
    let parts = path.components().filter_map(|part| match part {
        Component::Normal(name) => Some(name.to_string_lossy().replace(' ', "_")),
        _ => None,
    });
    parts.collect::<Vec<_>>().join("_")
}

impl OutputFolder {
    /// Creates the staging folder. Errors if the destination cannot be written; changes none of its files yet.
    pub fn stage(destination: &Path) -> Result<Self> {
        let path = check(destination)?;
        let parent = if path.is_dir() { &path } else { path.parent().unwrap_or(&path) };
        let created = NewFolders::create(parent).with_context(|| cannot_write(destination))?;
        Self::staged_in(parent, destination, created, None)
    }

    /// As [`OutputFolder::stage`], and locks the destination until the folder is dropped. Errors if another process
    /// writes to it.
    pub fn claim(destination: &Path) -> Result<Self> {
        let path = check(destination)?;
        let created = NewFolders::create(&path).with_context(|| cannot_write(destination))?;
        match lock(destination) {
            Ok(lock) => Self::staged_in(&path, destination, created, Some(lock)),
            Err(error) => {
                // The other process has the folder.
                created.keep();
                Err(error)
            }
        }
    }

    fn staged_in(
        parent: &Path,
        destination: &Path,
        created: NewFolders,
        lock: Option<FolderLock>,
    ) -> Result<Self> {
        let staging = b2b_base::scratch::folder_in(parent, ".b2b-unfinished-");
        let staging = staging.with_context(|| cannot_write(destination))?;
        Ok(Self { staging, destination: destination.to_owned(), created, _lock: lock })
    }

    /// Writes one file to the staging folder.
    pub fn write(&self, name: &str, content: impl FnOnce(&mut BufWriter<File>) -> Result<()>) -> Result<()> {
        let write = || {
            let mut file = BufWriter::new(File::create(self.staging.path().join(name))?);
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
    pub fn keep(self) -> Result<()> {
        let cannot = || cannot_write(&self.destination);
        std::fs::create_dir_all(&self.destination).with_context(cannot)?;
        for file in std::fs::read_dir(self.staging.path()).with_context(cannot)? {
            let file = file.with_context(cannot)?;
            std::fs::rename(file.path(), self.destination.join(file.file_name())).with_context(cannot)?;
        }
        self.created.keep();
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
}

/// Returns the absolute path of a destination. Errors if it is a file or not valid UTF-8.
fn check(destination: &Path) -> Result<PathBuf> {
    let shown = destination.display();
    if destination.to_str().is_none() {
        bail!("--out {shown}: the path is not valid UTF-8, which summary.json requires; choose another");
    }
    if destination.exists() && !destination.is_dir() {
        bail!("--out expects a folder, but {shown} is a file");
    }
    std::path::absolute(destination).with_context(|| cannot_write(destination))
}

fn cannot_write(folder: &Path) -> String {
    format!("cannot write the folder {}", folder.display())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn files_of_one_name_in_other_folders_have_other_names() {
        let names = ["office.idf", "a/my office.idf", "../office.idf", "/a/office.epJSON"];
        let expected = ["office.idf", "a_my_office.idf", "office.idf", "a_office.epJSON"];
        assert_eq!(names.map(|name| path_in_name(Path::new(name))), expected);
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
    fn one_process_at_a_time_writes_to_a_claimed_folder() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("a/b");
        let first = OutputFolder::claim(&path).unwrap();
        first.write("x.txt", |file| Ok(file.write_all(b"first")?)).unwrap();
        let said = OutputFolder::claim(&path).err().unwrap().to_string();
        assert!(said.contains("a/b is in use by another command"), "{said}");
        first.keep().unwrap();
        assert_eq!(names(&path), ["x.txt"]);
        drop(OutputFolder::claim(&path).unwrap());
        assert_eq!(names(&path), ["x.txt"], "what was there stays");
        drop(OutputFolder::claim(&root.path().join("c/d")).unwrap());
        assert_eq!(names(root.path()), ["a"]);
    }

    #[test]
    fn the_parent_of_an_existing_folder_need_not_be_writable() {
        use std::os::unix::fs::PermissionsExt as _;
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("own");
        std::fs::create_dir(&path).unwrap();
        let staged = OutputFolder::stage(&path).unwrap();
        assert_eq!(names(root.path()), ["own"], "nothing is written next to it");
        assert!(staged.staging.path().starts_with(&path));
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
