//! The folder of an evaluation: its definition, and every episode as it ends. Files are written atomically, so that an
//! interrupted evaluation resumes.

use std::collections::BTreeMap;
use std::fs::File;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use b2b_base::aside::{is_unfinished, write_whole, write_whole_by};
use b2b_base::folder_lock::FolderLock;
use b2b_control::Versions;
use b2b_dataset::BuildingName;
use b2b_energyplus::install::{seal, unseal};
use serde::Serialize;
use serde_json::{Value, json};

use super::episode::EpisodePlan;
use super::finished::Finished;
use crate::error::at;
use crate::policy::Policy;
use crate::{Error, Result};

/// The folder of an evaluation, locked by this process.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    /// Whether it was made for this evaluation.
    is_new: bool,
    _lock: FolderLock,
}

/// The definition of an evaluation: `evaluation.json`.
#[derive(Serialize)]
struct Definition {
    versions: Versions,
    /// Episodes from machines that round differently do not belong in one result.
    machine: String,
    policy: String,
    policy_identity: String,
    episodes: Vec<Value>,
}

const DEFINITION: &str = "evaluation.json";
const EPISODES: &str = "episodes";

impl Folder {
    /// Opens the folder for these episodes under this policy, whether new or partly complete. A folder left by another
    /// evaluation in which no episode finished is taken over.
    ///
    /// # Errors
    /// [`Error::OtherEvaluation`] with the differences; [`Error::UnrelatedFiles`]; [`Error::Busy`];
    /// [`Error::NoEpisode`]; [`Error::SameName`]; [`Error::Damaged`]; [`Error::Io`].
    pub fn open(path: &Path, policy: &dyn Policy, episodes: &[EpisodePlan]) -> Result<Self> {
        if episodes.is_empty() {
            return Err(Error::NoEpisode);
        }
        check_names(episodes)?;
        let definition =
            serde_json::to_value(Definition::of(policy, episodes)?).expect("plain data always serializes");
        let file = path.join(DEFINITION);
        if path.exists() && !path.is_dir() {
            return Err(Error::UnrelatedFiles { folder: path.to_owned() });
        }
        // Episodes would be written to the link's target.
        if [DEFINITION, EPISODES].iter().any(|name| path.join(name).is_symlink()) {
            return Err(Error::UnrelatedFiles { folder: path.to_owned() });
        }
        let is_new = !path.exists();
        std::fs::create_dir_all(path).map_err(at(path))?;
        // Locked before the definition is written, so that only one of two evaluations defines a new folder.
        let lock = FolderLock::acquire(path).map_err(at(path))?;
        let lock = lock.ok_or_else(|| Error::Busy { folder: path.to_owned() })?;
        if !file.exists() {
            check_empty(path)?;
            write_whole_by(&file, |out| serde_json::to_writer_pretty(out, &definition).map_err(Into::into))
                .map_err(at(&file))?;
        }
        let text = std::fs::read(&file).map_err(at(&file))?;
        let there: serde_json::Result<Value> = serde_json::from_slice(&text);
        let folder = Self { path: path.to_owned(), is_new, _lock: lock };
        match there {
            Ok(there) if there == definition => {}
            Ok(_) if folder.is_empty()? => {
                let text = serde_json::to_vec_pretty(&definition).expect("plain data always serializes");
                write_whole(&file, &text).map_err(at(&file))?;
            }
            Ok(there) => {
                let differences = differences(&there, &definition);
                return Err(Error::OtherEvaluation { folder: path.to_owned(), differences });
            }
            Err(why) => return Err(Error::Damaged { path: file, why: why.to_string() }),
        }
        folder.remove_temporary()?;
        Ok(folder)
    }

    /// Returns whether the folder has no episodes, readable or not, and no results, and its definition is not a link.
    fn is_empty(&self) -> Result<bool> {
        let definition = self.path.join(DEFINITION);
        let file = std::fs::symlink_metadata(&definition).map_err(at(&definition))?;
        if !file.is_file() || file.nlink() > 1 {
            return Ok(false);
        }
        let episodes = self.path.join(EPISODES);
        for folder in [&self.path, &episodes].into_iter().filter(|folder| folder.exists()) {
            for entry in std::fs::read_dir(folder).map_err(at(folder))? {
                let path = entry.map_err(at(folder))?.path();
                if path != episodes && path != definition && !is_unfinished(&path) {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }

    /// Carries out work in the folder; after an error, a folder in which nothing has finished loses its definition, and
    /// is removed if it is new.
    ///
    /// # Errors
    /// The errors of the work.
    pub fn carry_out<T, E>(
        self,
        work: impl FnOnce(&Self) -> std::result::Result<T, E>,
    ) -> std::result::Result<T, E> {
        let done = work(&self);
        if done.is_err() {
            self.withdraw();
        }
        done
    }

    /// Removes the definition if nothing has finished, so that an evaluation that is refused leaves nothing behind.
    fn withdraw(self) {
        if !matches!(self.is_empty(), Ok(true)) {
            return;
        }
        // What cannot be removed is harmless: the next evaluation replaces it.
        let _ = std::fs::remove_file(self.path.join(DEFINITION));
        let _ = std::fs::remove_dir(self.path.join(EPISODES));
        if self.is_new {
            let _ = std::fs::remove_dir(&self.path);
        }
    }

    /// Returns an episode by its number; `None` if it has not ended, cannot be read or was changed.
    pub fn read(&self, number: usize) -> Option<Finished> {
        read_kept(&self.path, number)
    }

    /// Writes an episode to disk.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn keep(&self, number: usize, finished: &Finished) -> Result<()> {
        let json = serde_json::to_vec(finished).expect("plain data always serializes");
        let path = episode_path(&self.path, number);
        write_whole(&path, &seal(&json)).map_err(at(&path))
    }

    /// Writes a results file atomically.
    ///
    /// # Errors
    /// [`Error::Io`], also for errors of `content`.
    pub fn write(&self, name: &str, content: impl FnOnce(&mut File) -> std::io::Result<()>) -> Result<()> {
        let path = self.path.join(name);
        write_whole_by(&path, content).map_err(at(&path))
    }

    /// Returns its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the path of a results file.
    pub fn path_of(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Removes temporary files of a killed process.
    fn remove_temporary(&self) -> Result<()> {
        for folder in [self.path.clone(), self.path.join(EPISODES)] {
            std::fs::create_dir_all(&folder).map_err(at(&folder))?;
            for entry in std::fs::read_dir(&folder).map_err(at(&folder))? {
                let path = entry.map_err(at(&folder))?.path();
                if is_unfinished(&path) {
                    std::fs::remove_file(&path).map_err(at(&path))?;
                }
            }
        }
        Ok(())
    }
}

fn episode_path(folder: &Path, number: usize) -> PathBuf {
    folder.join(EPISODES).join(format!("{number:06}.json"))
}

/// Returns an episode in the folder of an evaluation, by its number; `None` if it has not ended, cannot be read or was
/// changed.
pub fn read_kept(folder: &Path, number: usize) -> Option<Finished> {
    let file = std::fs::read(episode_path(folder, number)).ok()?;
    serde_json::from_slice(unseal(&file)?).ok()
}

impl Definition {
    fn of(policy: &dyn Policy, episodes: &[EpisodePlan]) -> Result<Self> {
        let definition = |episode: &EpisodePlan| {
            Ok(json!({
                "building": episode.subject.identity()?,
                "task": episode.task.to_string(),
                "task_hash": episode.task.hash(),
                "period": episode.period.to_string(),
                "seed": episode.seed,
                "steps_per_hour": episode.steps_per_hour,
            }))
        };
        Ok(Self {
            versions: Versions::current(),
            machine: b2b_base::machine::fingerprint(),
            policy: policy.name(),
            policy_identity: policy.identity(),
            episodes: episodes.iter().map(definition).collect::<Result<_>>()?,
        })
    }
}

/// Errors for model files in different folders with one name.
fn check_names(episodes: &[EpisodePlan]) -> Result<()> {
    let mut known: BTreeMap<String, PathBuf> = BTreeMap::new();
    for EpisodePlan { subject, .. } in episodes {
        let BuildingName::Model(path) = &subject.name else { continue };
        let path = std::fs::canonicalize(path).unwrap_or_else(|_| path.clone());
        let first = known.entry(subject.label()).or_insert_with(|| path.clone());
        if *first != path {
            let [first, second] = [&*first, &path].map(|path| path.display().to_string());
            return Err(Error::SameName { name: subject.label(), first, second });
        }
    }
    Ok(())
}

/// Errors if the folder of a new evaluation contains anything but leftovers of an interrupted start.
fn check_empty(path: &Path) -> Result<()> {
    let Ok(entries) = std::fs::read_dir(path) else {
        return if path.exists() { Err(Error::UnrelatedFiles { folder: path.to_owned() }) } else { Ok(()) };
    };
    for entry in entries {
        let name = entry.map_err(at(path))?.file_name();
        if name != EPISODES && !is_unfinished(name.as_ref()) {
            return Err(Error::UnrelatedFiles { folder: path.to_owned() });
        }
    }
    Ok(())
}

/// Describes how two evaluations differ.
fn differences(there: &Value, here: &Value) -> String {
    const NONE: &Value = &Value::Null;
    let mut found = Vec::new();
    for name in ["machine", "policy", "policy_identity"] {
        compare(name, &there[name], &here[name], &mut found);
    }
    for name in ["package", "generator", "engine", "controllers", "guideline36"] {
        compare(name, &there["versions"][name], &here["versions"][name], &mut found);
    }
    let list = |value: &Value| value["episodes"].as_array().cloned().unwrap_or_default();
    let (theirs, ours) = (list(there), list(here));
    if theirs.len() != ours.len() {
        found.push(format!("{} episodes in the folder and {} in this command", theirs.len(), ours.len()));
    }
    let pairs = theirs.iter().zip(&ours).enumerate();
    if let Some((number, (there, here))) = pairs.into_iter().find(|(_, (there, here))| there != here) {
        for name in ["building", "task", "task_hash", "period", "seed", "steps_per_hour"] {
            let what = format!("{name} of episode {number}");
            compare(&what, there.get(name).unwrap_or(NONE), here.get(name).unwrap_or(NONE), &mut found);
        }
    }
    if found.is_empty() { "its format".to_owned() } else { found.join("; ") }
}

fn compare(what: &str, there: &Value, here: &Value, found: &mut Vec<String>) {
    if there != here {
        found.push(format!("{what} is {there} in the folder and {here} in this command"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BuiltIn, Subject};

    fn episodes(buildings: &[&str]) -> Vec<EpisodePlan> {
        let episode = |name: &&str| EpisodePlan {
            subject: Subject::at_home(name.parse().unwrap()),
            task: "constant".parse().unwrap(),
            period: "01-01..01-02".parse().unwrap(),
            seed: 0,
            steps_per_hour: 12,
        };
        buildings.iter().map(episode).collect()
    }

    #[test]
    fn a_folder_of_a_different_evaluation_is_an_error_that_names_the_differences() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("results");
        let houses = episodes(&["SingleFamilyHouse-1", "SingleFamilyHouse-2"]);
        drop(Folder::open(&path, &BuiltIn::random(), &houses).unwrap());
        std::fs::write(episode_path(&path, 0), "").unwrap();
        drop(Folder::open(&path, &BuiltIn::random(), &houses).unwrap());
        let refused = |policy: BuiltIn, episodes: &[EpisodePlan]| {
            Folder::open(&path, &policy, episodes).unwrap_err().to_string()
        };
        let said = refused(BuiltIn::constant(), &houses);
        assert!(
            said.contains("\"random\" in the folder") && said.contains("\"constant\" in this command"),
            "{said}"
        );
        let said = refused(BuiltIn::random(), &episodes(&["SingleFamilyHouse-1", "SingleFamilyHouse-3"]));
        assert!(said.contains("building of episode 1") && said.contains("SingleFamilyHouse-0003"), "{said}");
        let said = refused(BuiltIn::random(), &houses[..1]);
        assert!(said.contains("2 episodes in the folder and 1 in this command"), "{said}");
    }

    #[test]
    fn two_models_of_one_name_are_refused() {
        let root = tempfile::tempdir().unwrap();
        let plans = episodes(&["a/off.idf", "b/off.idf"]);
        let refused = Folder::open(&root.path().join("results"), &BuiltIn::random(), &plans);
        let said = refused.unwrap_err().to_string();
        assert!(said.contains("a/off.idf and b/off.idf are both named `off`"), "{said}");
    }

    #[test]
    fn a_folder_in_which_nothing_has_finished_does_not_block_another_evaluation() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("results");
        let houses = episodes(&["SingleFamilyHouse-1", "SingleFamilyHouse-2"]);
        drop(Folder::open(&path, &BuiltIn::random(), &houses).unwrap());
        let folder = Folder::open(&path, &BuiltIn::constant(), &houses[..1]).unwrap();
        let busy = Folder::open(&path, &BuiltIn::random(), &houses).unwrap_err();
        assert!(matches!(busy, Error::Busy { .. }), "{busy}");
        drop(folder);
        std::fs::write(episode_path(&path, 0), "").unwrap();
        drop(Folder::open(&path, &BuiltIn::constant(), &houses[..1]).unwrap());
        let other = Folder::open(&path, &BuiltIn::random(), &houses).unwrap_err();
        assert!(matches!(other, Error::OtherEvaluation { .. }), "{other}");
    }

    #[test]
    fn an_evaluation_that_is_withdrawn_leaves_only_what_has_finished() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("results");
        let houses = episodes(&["SingleFamilyHouse-1"]);
        let open = || Folder::open(&path, &BuiltIn::random(), &houses).unwrap();
        open().withdraw();
        assert!(!path.exists());
        let folder = open();
        std::fs::write(episode_path(&path, 0), "").unwrap();
        folder.withdraw();
        assert!(path.join(DEFINITION).exists() && episode_path(&path, 0).exists());
    }

    #[test]
    fn a_folder_in_use_or_with_unrelated_files_is_an_error() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("results");
        let houses = episodes(&["SingleFamilyHouse-1"]);
        let folder = Folder::open(&path, &BuiltIn::random(), &houses).unwrap();
        let busy = Folder::open(&path, &BuiltIn::random(), &houses).unwrap_err();
        assert!(matches!(busy, Error::Busy { .. }), "{busy}");
        drop(folder);
        std::fs::write(root.path().join("thesis.tex"), "").unwrap();
        let foreign = Folder::open(root.path(), &BuiltIn::random(), &houses).unwrap_err();
        assert!(matches!(foreign, Error::UnrelatedFiles { .. }), "{foreign}");
        let linked = root.path().join("linked");
        std::fs::create_dir_all(&linked).unwrap();
        std::os::unix::fs::symlink(path.join(EPISODES), linked.join(EPISODES)).unwrap();
        let foreign = Folder::open(&linked, &BuiltIn::random(), &houses).unwrap_err();
        assert!(matches!(foreign, Error::UnrelatedFiles { .. }), "{foreign}");
        let none = Folder::open(&root.path().join("other"), &BuiltIn::random(), &[]).unwrap_err();
        assert!(matches!(none, Error::NoEpisode), "{none}");
    }

    #[test]
    fn an_interrupted_write_is_removed_and_a_damaged_episode_counts_as_missing() {
        let root = tempfile::tempdir().unwrap();
        let houses = episodes(&["SingleFamilyHouse-1"]);
        let path = root.path().join("results");
        drop(Folder::open(&path, &BuiltIn::random(), &houses).unwrap());
        let half = path.join(EPISODES).join(".aside-x1y2z3");
        std::fs::write(&half, "{\"record\": {").unwrap();
        std::fs::write(path.join(EPISODES).join("000000.json"), "{\"record\": {").unwrap();
        let folder = Folder::open(&path, &BuiltIn::random(), &houses).unwrap();
        assert!(!half.exists());
        assert_eq!(folder.read(0), None);
    }
}
