//! The folder of an evaluation: what was asked, and every episode as it ended. Nothing in it is ever half-written, so
//! that whoever starts again goes on from there.

use std::fs::File;
use std::io::{BufReader, Write};
use std::path::{Path, PathBuf};

use b2b_dataset::GENERATOR_VERSION;
use b2b_energyplus::install::ENGINE_VERSION;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{Episode, Finished};
use crate::baseline::controllers_hash;
use crate::error::at;
use crate::policy::Policy;
use crate::{Error, Result};

/// What made the results, beside the policy.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Versions {
    /// Of this package.
    pub package: String,
    /// Of the buildings.
    pub generator: String,
    /// Of EnergyPlus.
    pub engine: String,
    /// Hash of the parameters of the reactive controllers.
    pub controllers: String,
}

/// An evaluation on disk, held by this process alone.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    _lock: File,
}

/// What an evaluation is, as it is written down.
#[derive(Serialize)]
struct About {
    versions: Versions,
    policy: String,
    policy_identity: String,
    episodes: Vec<Asked>,
}

#[derive(Serialize)]
struct Asked {
    building: String,
    task: String,
    task_hash: String,
    period: String,
    seed: u64,
    steps_per_hour: u32,
}

const ABOUT: &str = "evaluation.json";
const EPISODES: &str = "episodes";
/// Ending of a file that is being written.
const ASIDE: &str = ".aside";

impl Versions {
    /// Those of this program.
    pub fn current() -> Self {
        Self {
            package: env!("CARGO_PKG_VERSION").to_owned(),
            generator: GENERATOR_VERSION.to_owned(),
            engine: ENGINE_VERSION.to_owned(),
            controllers: controllers_hash(),
        }
    }
}

impl Folder {
    /// The folder of these episodes under this policy: a new one, or one that holds some of them already.
    ///
    /// # Errors
    /// [`Error::OtherEvaluation`] with what differs; [`Error::Foreign`]; [`Error::Busy`]; [`Error::NoEpisode`];
    /// [`Error::Io`].
    pub fn open(path: &Path, policy: &dyn Policy, episodes: &[Episode]) -> Result<Self> {
        if episodes.is_empty() {
            return Err(Error::NoEpisode);
        }
        let about = serde_json::to_value(About::of(policy, episodes)?).expect("it is plain data");
        let file = path.join(ABOUT);
        if !file.exists() {
            check_empty(path)?;
            let folder = path.join(EPISODES);
            std::fs::create_dir_all(&folder).map_err(at(&folder))?;
            write(&file, |out| serde_json::to_writer_pretty(out, &about).map_err(Into::into))?;
        }
        let lock = File::open(&file).map_err(at(&file))?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(std::fs::TryLockError::WouldBlock) => return Err(Error::Busy { folder: path.to_owned() }),
            Err(std::fs::TryLockError::Error(source)) => return Err(at(&file)(source)),
        }
        let damaged = |why: serde_json::Error| Error::Damaged { path: file.clone(), why: why.to_string() };
        let there: Value = serde_json::from_reader(BufReader::new(&lock)).map_err(damaged)?;
        if there != about {
            let differences = differences(&there, &about);
            return Err(Error::OtherEvaluation { folder: path.to_owned(), differences });
        }
        let folder = Self { path: path.to_owned(), _lock: lock };
        folder.sweep()?;
        Ok(folder)
    }

    /// An episode by its number, if it has ended. What cannot be read has not.
    pub fn read(&self, number: usize) -> Option<Finished> {
        let file = File::open(self.episode(number)).ok()?;
        serde_json::from_reader(BufReader::new(file)).ok()
    }

    /// Keeps an episode: on disk when this returns.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn keep(&self, number: usize, finished: &Finished) -> Result<()> {
        write(&self.episode(number), |out| serde_json::to_writer(out, finished).map_err(Into::into))
    }

    /// Writes a file of results, whole or not at all.
    ///
    /// # Errors
    /// [`Error::Io`], and what `content` says.
    pub fn write(&self, name: &str, content: impl FnOnce(&mut File) -> std::io::Result<()>) -> Result<()> {
        write(&self.path.join(name), content)
    }

    /// Where a file of results is.
    pub fn path_of(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    fn episode(&self, number: usize) -> PathBuf {
        self.path.join(EPISODES).join(format!("{number:06}.json"))
    }

    /// Removes what a process that was killed was writing.
    fn sweep(&self) -> Result<()> {
        for folder in [self.path.clone(), self.path.join(EPISODES)] {
            std::fs::create_dir_all(&folder).map_err(at(&folder))?;
            for entry in std::fs::read_dir(&folder).map_err(at(&folder))? {
                let path = entry.map_err(at(&folder))?.path();
                if path.to_string_lossy().ends_with(ASIDE) {
                    std::fs::remove_file(&path).map_err(at(&path))?;
                }
            }
        }
        Ok(())
    }
}

impl About {
    fn of(policy: &dyn Policy, episodes: &[Episode]) -> Result<Self> {
        let asked = |episode: &Episode| {
            Ok(Asked {
                building: episode.subject.identity()?,
                task: episode.task.to_string(),
                task_hash: episode.task.hash(),
                period: episode.period.to_string(),
                seed: episode.seed,
                steps_per_hour: episode.steps_per_hour,
            })
        };
        Ok(Self {
            versions: Versions::current(),
            policy: policy.name(),
            policy_identity: policy.identity(),
            episodes: episodes.iter().map(asked).collect::<Result<_>>()?,
        })
    }
}

/// A folder for a new evaluation holds nothing but what a first start may have left.
fn check_empty(path: &Path) -> Result<()> {
    let Ok(entries) = std::fs::read_dir(path) else {
        return if path.exists() { Err(Error::Foreign { folder: path.to_owned() }) } else { Ok(()) };
    };
    for entry in entries {
        let name = entry.map_err(at(path))?.file_name();
        if name != EPISODES && !name.to_string_lossy().ends_with(ASIDE) {
            return Err(Error::Foreign { folder: path.to_owned() });
        }
    }
    Ok(())
}

/// In what two evaluations differ, for people.
fn differences(there: &Value, here: &Value) -> String {
    const NONE: &Value = &Value::Null;
    let mut found = Vec::new();
    for name in ["policy", "policy_identity"] {
        compare(name, &there[name], &here[name], &mut found);
    }
    for name in ["package", "generator", "engine", "controllers"] {
        compare(name, &there["versions"][name], &here["versions"][name], &mut found);
    }
    let list = |value: &Value| value["episodes"].as_array().cloned().unwrap_or_default();
    let (theirs, ours) = (list(there), list(here));
    if theirs.len() != ours.len() {
        found.push(format!("{} episodes there, {} here", theirs.len(), ours.len()));
    }
    let pairs = theirs.iter().zip(&ours).enumerate();
    if let Some((number, (there, here))) = pairs.into_iter().find(|(_, (there, here))| there != here) {
        for name in ["building", "task", "task_hash", "period", "seed", "steps_per_hour"] {
            let what = format!("{name} of episode {number}");
            compare(&what, there.get(name).unwrap_or(NONE), here.get(name).unwrap_or(NONE), &mut found);
        }
    }
    if found.is_empty() { "in its form".to_owned() } else { found.join("; ") }
}

fn compare(what: &str, there: &Value, here: &Value, found: &mut Vec<String>) {
    if there != here {
        found.push(format!("{what} is {there} there and {here} here"));
    }
}

/// Writes a file beside its place, has it on disk, and moves it there.
pub(crate) fn write(path: &Path, content: impl FnOnce(&mut File) -> std::io::Result<()>) -> Result<()> {
    let mut aside = path.as_os_str().to_owned();
    aside.push(ASIDE);
    let aside = PathBuf::from(aside);
    let written = File::create(&aside).and_then(|mut file| {
        content(&mut file)?;
        file.flush()?;
        file.sync_all()?;
        std::fs::rename(&aside, path)?;
        // The name is on disk with its folder.
        path.parent().map_or(Ok(()), |folder| File::open(folder)?.sync_all())
    });
    written.map_err(|source| {
        // It may never have been made.
        let _ = std::fs::remove_file(&aside);
        at(path)(source)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BuiltIn, Subject};

    fn episodes(buildings: &[&str]) -> Vec<Episode> {
        let episode = |name: &&str| Episode {
            subject: Subject::at_home(name.parse().unwrap()),
            task: "constant".parse().unwrap(),
            period: "01-01..01-02".parse().unwrap(),
            seed: 0,
            steps_per_hour: 12,
        };
        buildings.iter().map(episode).collect()
    }

    #[test]
    fn a_folder_of_another_evaluation_is_refused_with_what_differs() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("results");
        let houses = episodes(&["SingleFamilyHouse-1", "SingleFamilyHouse-2"]);
        drop(Folder::open(&path, &BuiltIn::Random, &houses).unwrap());
        drop(Folder::open(&path, &BuiltIn::Random, &houses).unwrap());
        let refused = |policy: BuiltIn, episodes: &[Episode]| {
            Folder::open(&path, &policy, episodes).unwrap_err().to_string()
        };
        let said = refused(BuiltIn::Constant, &houses);
        assert!(said.contains("\"random\" there") && said.contains("\"constant\" here"), "{said}");
        let said = refused(BuiltIn::Random, &episodes(&["SingleFamilyHouse-1", "SingleFamilyHouse-3"]));
        assert!(said.contains("building of episode 1") && said.contains("SingleFamilyHouse-0003"), "{said}");
        let said = refused(BuiltIn::Random, &houses[..1]);
        assert!(said.contains("2 episodes there, 1 here"), "{said}");
    }

    #[test]
    fn a_folder_is_one_process_s_and_of_an_evaluation() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("results");
        let houses = episodes(&["SingleFamilyHouse-1"]);
        let folder = Folder::open(&path, &BuiltIn::Random, &houses).unwrap();
        let busy = Folder::open(&path, &BuiltIn::Random, &houses).unwrap_err();
        assert!(matches!(busy, Error::Busy { .. }), "{busy}");
        drop(folder);
        std::fs::write(root.path().join("thesis.tex"), "").unwrap();
        let foreign = Folder::open(root.path(), &BuiltIn::Random, &houses).unwrap_err();
        assert!(matches!(foreign, Error::Foreign { .. }), "{foreign}");
        let none = Folder::open(&root.path().join("other"), &BuiltIn::Random, &[]).unwrap_err();
        assert!(matches!(none, Error::NoEpisode), "{none}");
    }

    #[test]
    fn an_interrupted_write_is_swept_away_and_a_damaged_episode_is_none() {
        let root = tempfile::tempdir().unwrap();
        let houses = episodes(&["SingleFamilyHouse-1"]);
        let path = root.path().join("results");
        drop(Folder::open(&path, &BuiltIn::Random, &houses).unwrap());
        let half = path.join(EPISODES).join("000000.json.aside");
        std::fs::write(&half, "{\"record\": {").unwrap();
        std::fs::write(path.join(EPISODES).join("000000.json"), "{\"record\": {").unwrap();
        let folder = Folder::open(&path, &BuiltIn::Random, &houses).unwrap();
        assert!(!half.exists());
        assert_eq!(folder.read(0), None);
    }

    #[test]
    fn a_file_that_fails_half_way_leaves_what_was_there() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("episodes.parquet");
        write(&path, |file| file.write_all(b"whole")).unwrap();
        let failed = write(&path, |file| {
            file.write_all(b"ha")?;
            Err(std::io::Error::other("the disk is full"))
        });
        let said = failed.unwrap_err().to_string();
        assert!(said.contains("episodes.parquet") && said.contains("full"), "{said}");
        assert_eq!(std::fs::read(&path).unwrap(), b"whole");
        assert_eq!(std::fs::read_dir(root.path()).unwrap().count(), 1);
    }
}
