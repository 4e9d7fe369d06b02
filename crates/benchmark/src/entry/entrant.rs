//! Who runs in a benchmark: a built-in controller, or ONNX files, one for all or one for each seed, building or task.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::{Path, PathBuf};

use b2b_control::Controller;
use serde::{Deserialize, Serialize};

use crate::policy::{ActionScale, Beginning, BuiltIn, OnnxPolicy, Policy, is_onnx};
use crate::subject::{hash_of, hex};
use crate::{Episode, Error, Result};

/// Placeholders of a file's name.
const PLACEHOLDERS: [&str; 3] = ["{seed}", "{building}", "{task}"];

/// Who runs.
#[derive(Debug)]
pub enum Entrant {
    /// A controller that needs no file.
    BuiltIn(BuiltIn),
    /// Networks.
    Files(Files),
}

/// ONNX files by a pattern.
#[derive(Debug)]
pub struct Files {
    /// Without the folder that all of them are in.
    pattern: String,
    scale: ActionScale,
    /// By the pattern filled in.
    files: BTreeMap<String, File>,
}

#[derive(Debug)]
struct File {
    path: PathBuf,
    sha256: String,
    policy: OnnxPolicy,
}

/// An entrant as a result tells it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum About {
    /// A controller that needs no file.
    BuiltIn {
        /// Its name.
        name: String,
    },
    /// Networks.
    Onnx {
        /// Name of the files, with placeholders.
        pattern: String,
        /// What their numbers mean.
        actions: ActionScale,
        /// SHA-256 of each, by the name filled in.
        files: BTreeMap<String, String>,
    },
}

impl About {
    /// Of the seeds of a protocol those with which it acts differently: the first alone for what neither draws nor was
    /// trained by one.
    pub fn seeds(&self, seeds: &[u64]) -> Vec<u64> {
        let draws = match self {
            Self::BuiltIn { name } => {
                [BuiltIn::Random, BuiltIn::Planner].iter().any(|each| each.to_string() == *name)
            }
            Self::Onnx { pattern, .. } => pattern.contains(PLACEHOLDERS[0]),
        };
        if draws { seeds.to_vec() } else { seeds[..seeds.len().min(1)].to_vec() }
    }
}

impl Entrant {
    /// A name of a built-in controller, or a path with placeholders, of which every file that these episodes need is
    /// read.
    ///
    /// # Errors
    /// [`Error::UnknownPolicy`]; those of [`OnnxPolicy::read`].
    pub fn read(text: &str, scale: ActionScale, seeds: &[u64], episodes: &[Episode]) -> Result<Self> {
        if !is_onnx(Path::new(text)) {
            return Ok(Self::BuiltIn(text.parse()?));
        }
        let (folder, pattern) = split(text);
        let path_of = |name: &str| folder.join(name);
        Ok(Self::Files(Files::read(pattern, scale, seeds, episodes, path_of)?))
    }

    /// The entrant of a result whose networks are in a folder, by their hashes.
    ///
    /// # Errors
    /// [`Error::UnknownPolicy`]; those of [`OnnxPolicy::read`]; [`Error::Forged`] for a file that is another.
    pub fn of(about: &About, folder: &Path) -> Result<Self> {
        let (pattern, actions, files) = match about {
            About::BuiltIn { name } => return Ok(Self::BuiltIn(name.parse()?)),
            About::Onnx { pattern, actions, files } => (pattern, actions, files),
        };
        let file = |(name, sha256): (&String, &String)| {
            let path = folder.join(kept_as(sha256));
            let file = File::read(path, *actions)?;
            if file.sha256 != *sha256 {
                return Err(Error::Forged {
                    folder: folder.to_owned(),
                    what: format!("{} is another file than was run", file.path.display()),
                });
            }
            Ok((name.clone(), file))
        };
        let files = files.iter().map(file).collect::<Result<_>>()?;
        Ok(Self::Files(Files { pattern: pattern.clone(), scale: *actions, files }))
    }

    /// What it is called.
    pub fn name(&self) -> String {
        match self {
            Self::BuiltIn(built_in) => built_in.name(),
            Self::Files(files) => files.name(),
        }
    }

    /// For the result.
    pub fn about(&self) -> About {
        match self {
            Self::BuiltIn(built_in) => About::BuiltIn { name: built_in.to_string() },
            Self::Files(Files { pattern, scale, files }) => About::Onnx {
                pattern: pattern.clone(),
                actions: *scale,
                files: files.iter().map(|(name, file)| (name.clone(), file.sha256.clone())).collect(),
            },
        }
    }

    /// As a policy.
    pub fn policy(&self) -> &dyn Policy {
        match self {
            Self::BuiltIn(built_in) => built_in,
            Self::Files(files) => files,
        }
    }

    /// [`About::seeds`].
    pub fn seeds(&self, seeds: &[u64]) -> Vec<u64> {
        self.about().seeds(seeds)
    }

    /// Its files: where each is, and its name in a result.
    pub fn files(&self) -> Vec<(&Path, String)> {
        match self {
            Self::BuiltIn(_) => Vec::new(),
            Self::Files(files) => {
                files.files.values().map(|file| (file.path.as_path(), kept_as(&file.sha256))).collect()
            }
        }
    }
}

/// The folder of a pattern, up to the first part with a placeholder, and the rest.
fn split(text: &str) -> (PathBuf, String) {
    let parts: Vec<_> = Path::new(text).components().collect();
    let holds = |part: &std::path::Component<'_>| {
        let part = part.as_os_str().to_string_lossy();
        PLACEHOLDERS.iter().any(|each| part.contains(each))
    };
    let first = parts.iter().position(holds).unwrap_or(parts.len() - 1);
    let rest: PathBuf = parts[first..].iter().collect();
    (parts[..first].iter().collect(), rest.to_string_lossy().into_owned())
}

fn fill(pattern: &str, seed: u64, building: &str, task: &str) -> String {
    let [seeds, buildings, tasks] = PLACEHOLDERS;
    pattern.replace(seeds, &seed.to_string()).replace(buildings, building).replace(tasks, task)
}

fn kept_as(sha256: &str) -> String {
    format!("{}.onnx", &sha256[..sha256.len().min(16)])
}

impl File {
    fn read(path: PathBuf, scale: ActionScale) -> Result<Self> {
        Ok(Self { sha256: hash_of(&path)?, policy: OnnxPolicy::read(&path, scale)?, path })
    }
}

impl Files {
    fn read(
        pattern: String,
        scale: ActionScale,
        seeds: &[u64],
        episodes: &[Episode],
        path_of: impl Fn(&str) -> PathBuf,
    ) -> Result<Self> {
        let mut files = BTreeMap::new();
        for episode in episodes {
            for seed in seeds {
                let (building, task) = (episode.subject.name.to_string(), episode.task.to_string());
                let name = fill(&pattern, *seed, &building, &task);
                if let Entry::Vacant(place) = files.entry(name) {
                    let file = File::read(path_of(place.key()), scale)?;
                    place.insert(file);
                }
            }
        }
        Ok(Self { pattern, scale, files })
    }
}

impl Policy for Files {
    fn name(&self) -> String {
        let path = Path::new(&self.pattern);
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut name = stem.clone();
        for each in PLACEHOLDERS {
            name = name.replace(each, "");
        }
        let name = name.trim_matches(['-', '_', '.', ' ']);
        if name.is_empty() { stem } else { name.to_owned() }
    }

    fn identity(&self) -> String {
        let all: String = self.files.iter().map(|(name, file)| format!("{name} {}\n", file.sha256)).collect();
        format!("onnx {}, {} files, actions {:?}", hex(all.as_bytes()), self.files.len(), self.scale)
    }

    fn controller(&self, beginning: Beginning<'_>) -> Result<Box<dyn Controller>> {
        let Beginning { subject, spaces, seed, .. } = &beginning;
        // The scale of energy is the building's: the task as it was asked has none.
        let task = b2b_env::Task { energy_scale: None, ..spaces.episode.task.clone() };
        let name = fill(&self.pattern, *seed, &subject.name.to_string(), &task.to_string());
        let file = self.files.get(&name).ok_or_else(|| Error::UnknownPolicy { text: name })?;
        file.policy.controller(beginning)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pattern_is_known_without_the_folders_above_it() {
        let parts = |text: &str| {
            let (folder, pattern) = split(text);
            (folder.display().to_string(), pattern)
        };
        assert_eq!(parts("runs/a/ppo.onnx"), ("runs/a".into(), "ppo.onnx".into()));
        assert_eq!(parts("runs/{building}/{seed}.onnx"), ("runs".into(), "{building}/{seed}.onnx".into()));
        assert_eq!(parts("ppo-{seed}.onnx"), (String::new(), "ppo-{seed}.onnx".into()));
        let filled = fill("{building}/{task}-{seed}.onnx", 3, "OfficeSmall-0005", "occupancy+energy0.5");
        assert_eq!(filled, "OfficeSmall-0005/occupancy+energy0.5-3.onnx");
    }

    #[test]
    fn what_neither_draws_nor_was_trained_by_a_seed_runs_once() {
        let seeds = |built_in| Entrant::BuiltIn(built_in).seeds(&[4, 5, 6]);
        assert_eq!(seeds(BuiltIn::Random), [4, 5, 6]);
        assert_eq!(seeds(BuiltIn::Reactive), [4]);
    }
}
