//! The policy of a benchmark entry: a built-in controller; ONNX files or agents, one for all episodes or one per seed,
//! building or task; or an external program.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::{Path, PathBuf};

use b2b_agent::{Agent, AgentInfo};
use b2b_base::digest::sha256;
use b2b_control::Controller;
use b2b_env::Task;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::external::External;
use crate::{Error, Result};
use b2b_evaluate::EpisodePlan;
use b2b_evaluate::hash_of;
use b2b_evaluate::{ActionScale, BuiltIn, EpisodeContext, OnnxPolicy, Policy, is_agent, is_onnx};

/// Placeholders in a file name.
const PLACEHOLDERS: [&str; 3] = ["{seed}", "{building}", "{task}"];

/// The policy of a benchmark entry.
#[derive(Debug)]
pub enum EntryPolicy {
    /// A built-in controller.
    BuiltIn(BuiltIn),
    /// ONNX files or agents.
    Files(Files),
    /// The author's own program.
    External(External),
}

/// The ONNX files or the agents of a pattern.
#[derive(Debug)]
pub struct Files {
    /// Pattern of the file names, relative to their common folder.
    pattern: String,
    format: Format,
    /// Files by name: the pattern with its placeholders filled in.
    files: BTreeMap<String, File>,
}

/// The kind of the files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    /// ONNX files, with the scale of their actions.
    Onnx(ActionScale),
    /// Folders of agents.
    Agents,
}

#[derive(Debug)]
struct File {
    path: PathBuf,
    sha256: String,
    policy: FilePolicy,
}

#[derive(Debug)]
enum FilePolicy {
    Onnx(Box<OnnxPolicy>),
    Agent(Box<Agent>),
}

impl FilePolicy {
    fn policy(&self) -> &dyn Policy {
        match self {
            Self::Onnx(policy) => policy.as_ref(),
            Self::Agent(agent) => agent.as_ref(),
        }
    }
}

/// The policy of an entry as it is described in a result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum PolicyDescription {
    /// A built-in controller.
    BuiltIn {
        /// Name of the controller.
        name: String,
    },
    /// ONNX files.
    Onnx {
        /// Pattern of the file names.
        pattern: String,
        /// Scale of their actions.
        actions: ActionScale,
        /// SHA-256 of each file by name.
        files: BTreeMap<String, String>,
    },
    /// Trained agents.
    Agents {
        /// Pattern of the names of their folders.
        pattern: String,
        /// The base controller, if the agents correct one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        base: Option<String>,
        /// SHA-256 of each agent by name.
        files: BTreeMap<String, String>,
    },
    /// The author's own program, whose episodes others cannot rerun.
    External {
        /// Its name.
        name: String,
        /// Identity, in one line.
        identity: String,
        /// Whether it acts differently with every seed.
        by_seed: bool,
    },
}

impl PolicyDescription {
    /// Returns the seeds of a protocol that make a difference: only the first for a deterministic policy that was not
    /// trained once per seed.
    pub fn seeds(&self, seeds: &[u64]) -> Vec<u64> {
        let all = match self {
            Self::BuiltIn { name } => name.parse().is_ok_and(BuiltIn::is_stochastic),
            Self::Onnx { pattern, .. } | Self::Agents { pattern, .. } => pattern.contains(PLACEHOLDERS[0]),
            Self::External { by_seed, .. } => *by_seed,
        };
        if all { seeds.to_vec() } else { seeds[..seeds.len().min(1)].to_vec() }
    }
}

impl EntryPolicy {
    /// Reads a policy: the name of a built-in controller, or a path of ONNX files or agents with placeholders. Reads
    /// every file that these episodes need.
    ///
    /// # Errors
    /// [`Error::UnknownPolicy`](b2b_evaluate::Error::UnknownPolicy); errors from [`OnnxPolicy::read`] and
    /// [`Agent::read`].
    pub fn read(text: &str, scale: ActionScale, seeds: &[u64], episodes: &[EpisodePlan]) -> Result<Self> {
        let format = match text.parse() {
            Ok(built_in) => return Ok(Self::BuiltIn(built_in)),
            Err(_) if is_onnx(Path::new(text)) => Format::Onnx(scale),
            Err(_) if is_agent(Path::new(text)) || PLACEHOLDERS.iter().any(|each| text.contains(each)) => {
                Format::Agents
            }
            Err(error) => return Err(error.into()),
        };
        let (folder, pattern) = split(text);
        let path_of = |name: &str| folder.join(name);
        Ok(Self::Files(Files::read(pattern, format, seeds, episodes, path_of)?))
    }

    /// Reads the policy of a result whose ONNX files or agents are in a folder, named by their hashes.
    ///
    /// # Errors
    /// [`Error::UnknownPolicy`](b2b_evaluate::Error::UnknownPolicy); [`Error::Modified`] for a file with another hash,
    /// or a hash that is no SHA-256; errors from [`OnnxPolicy::read`] and [`Agent::read`].
    pub fn of(description: &PolicyDescription, folder: &Path) -> Result<Self> {
        let (pattern, format, files) = match description {
            PolicyDescription::BuiltIn { name } => return Ok(Self::BuiltIn(name.parse()?)),
            PolicyDescription::External { name, identity, by_seed } => {
                let (name, identity) = (name.clone(), identity.clone());
                return Ok(Self::External(External { name, identity, by_seed: *by_seed, policy: None }));
            }
            PolicyDescription::Onnx { pattern, actions, files } => (pattern, Format::Onnx(*actions), files),
            PolicyDescription::Agents { pattern, files, .. } => (pattern, Format::Agents, files),
        };
        let file = |(name, sha256): (&String, &String)| {
            if sha256.len() != 64 || !sha256.bytes().all(|byte| byte.is_ascii_hexdigit()) {
                let what = format!("`{sha256}` of the policy `{name}` is not a SHA-256");
                return Err(Error::Modified { folder: folder.to_owned(), what });
            }
            let file = File::read(folder.join(format.name_of(sha256)), format)?;
            if file.sha256 != *sha256 {
                return Err(Error::Modified {
                    folder: folder.to_owned(),
                    what: format!("{} is not the file that was run", file.path.display()),
                });
            }
            Ok((name.clone(), file))
        };
        let files = files.iter().map(file).collect::<Result<_>>()?;
        Ok(Self::Files(Files { pattern: pattern.clone(), format, files }))
    }

    /// Returns the name.
    pub fn name(&self) -> String {
        match self {
            Self::BuiltIn(built_in) => built_in.name(),
            Self::Files(files) => files.name(),
            Self::External(external) => external.name(),
        }
    }

    /// Describes the policy for a result.
    pub fn description(&self) -> PolicyDescription {
        match self {
            Self::BuiltIn(built_in) => PolicyDescription::BuiltIn { name: built_in.to_string() },
            Self::Files(files) => files.description(),
            Self::External(External { name, identity, by_seed, .. }) => PolicyDescription::External {
                name: name.clone(),
                identity: identity.clone(),
                by_seed: *by_seed,
            },
        }
    }

    /// Returns the policy itself.
    pub fn policy(&self) -> &dyn Policy {
        match self {
            Self::BuiltIn(built_in) => built_in,
            Self::Files(files) => files,
            Self::External(external) => external,
        }
    }

    /// Returns the seeds that make a difference: see [`PolicyDescription::seeds`].
    pub fn seeds(&self, seeds: &[u64]) -> Vec<u64> {
        self.description().seeds(seeds)
    }

    /// Returns the name of a missing file that one of these episodes needs.
    pub fn missing(&self, episodes: &[EpisodePlan]) -> Option<String> {
        let Self::Files(Files { pattern, files, .. }) = self else { return None };
        let name = |episode: &EpisodePlan| {
            fill(pattern, episode.seed, &episode.subject.name.to_string(), &episode.task.to_string())
        };
        episodes.iter().map(name).find(|name| !files.contains_key(name))
    }

    /// Returns the pattern of its files; empty if it has none.
    pub(super) fn pattern(&self) -> &str {
        match self {
            Self::BuiltIn(_) | Self::External(_) => "",
            Self::Files(files) => &files.pattern,
        }
    }

    /// Returns the records of its agents by name.
    pub(super) fn agents(&self) -> impl Iterator<Item = (&str, &AgentInfo)> {
        let files = match self {
            Self::BuiltIn(_) | Self::External(_) => None,
            Self::Files(files) => Some(&files.files),
        };
        files.into_iter().flatten().filter_map(|(name, file)| match &file.policy {
            FilePolicy::Agent(agent) => Some((name.as_str(), agent.info())),
            FilePolicy::Onnx(_) => None,
        })
    }

    /// Checks that the files have not changed since they were read.
    ///
    /// # Errors
    /// [`Error::ChangedPolicy`]; errors from reading the files.
    pub(super) fn check_files(&self) -> Result<()> {
        let Self::Files(Files { format, files, .. }) = self else { return Ok(()) };
        for file in files.values() {
            let sha256 = match format {
                Format::Onnx(_) => hash_of(&file.path)?,
                Format::Agents => Agent::read(&file.path)?.sha256().to_owned(),
            };
            if sha256 != file.sha256 {
                return Err(Error::ChangedPolicy { path: file.path.clone() });
            }
        }
        Ok(())
    }

    /// Returns the path of each file, and its name in a result.
    pub fn files(&self) -> Vec<(PathBuf, String)> {
        match self {
            Self::BuiltIn(_) | Self::External(_) => Vec::new(),
            Self::Files(Files { format, files, .. }) => {
                files.values().flat_map(|file| file.parts(*format)).collect()
            }
        }
    }
}

/// Splits a path before its first component with a placeholder into folder and pattern.
fn split(text: &str) -> (PathBuf, String) {
    let parts: Vec<_> = Path::new(text).components().collect();
    let has_placeholder = |part: &std::path::Component<'_>| {
        let part = part.as_os_str().to_string_lossy();
        PLACEHOLDERS.iter().any(|each| part.contains(each))
    };
    let first = parts.iter().position(has_placeholder).unwrap_or(parts.len() - 1);
    let rest: PathBuf = parts[first..].iter().collect();
    (parts[..first].iter().collect(), rest.to_string_lossy().into_owned())
}

fn fill(pattern: &str, seed: u64, building: &str, task: &str) -> String {
    let [seeds, buildings, tasks] = PLACEHOLDERS;
    pattern.replace(seeds, &seed.to_string()).replace(buildings, building).replace(tasks, task)
}

impl Format {
    /// Returns the name of a file or a folder in a result.
    fn name_of(self, sha256: &str) -> String {
        let short = sha256.get(..16).unwrap_or(sha256);
        match self {
            Self::Onnx(_) => format!("{short}.onnx"),
            Self::Agents => short.to_owned(),
        }
    }
}

impl File {
    fn read(path: PathBuf, format: Format) -> Result<Self> {
        Ok(match format {
            Format::Onnx(scale) => {
                let policy = FilePolicy::Onnx(Box::new(OnnxPolicy::read(&path, scale)?));
                Self { sha256: hash_of(&path)?, policy, path }
            }
            Format::Agents => {
                let agent = Agent::read(&path)?;
                Self { sha256: agent.sha256().to_owned(), policy: FilePolicy::Agent(Box::new(agent)), path }
            }
        })
    }

    /// Returns the path of each of its files, and the file's name in a result.
    fn parts(&self, format: Format) -> Vec<(PathBuf, String)> {
        let name = format.name_of(&self.sha256);
        match format {
            Format::Onnx(_) => vec![(self.path.clone(), name)],
            Format::Agents => {
                b2b_agent::FILES.map(|file| (self.path.join(file), format!("{name}/{file}"))).into()
            }
        }
    }
}

impl Files {
    fn read(
        pattern: String,
        format: Format,
        seeds: &[u64],
        episodes: &[EpisodePlan],
        path_of: impl Fn(&str) -> PathBuf,
    ) -> Result<Self> {
        let mut files = BTreeMap::new();
        for episode in episodes {
            for seed in seeds {
                let (building, task) = (episode.subject.name.to_string(), episode.task.to_string());
                let name = fill(&pattern, *seed, &building, &task);
                if let Entry::Vacant(place) = files.entry(name) {
                    let file = File::read(path_of(place.key()), format)?;
                    place.insert(file);
                }
            }
        }
        Ok(Self { pattern, format, files })
    }

    fn description(&self) -> PolicyDescription {
        let pattern = self.pattern.clone();
        let files = self.files.iter().map(|(name, file)| (name.clone(), file.sha256.clone())).collect();
        match self.format {
            Format::Onnx(actions) => PolicyDescription::Onnx { pattern, actions, files },
            Format::Agents => PolicyDescription::Agents { pattern, base: self.base(), files },
        }
    }

    /// Returns the agents' base controller, taken from the first agent because all agents of an entry share it.
    fn base(&self) -> Option<String> {
        match self.files.values().next().map(|file| &file.policy) {
            Some(FilePolicy::Agent(agent)) => agent.info().interface.acting.base(),
            _ => None,
        }
    }
}

impl Files {
    /// Returns the policy of the file for an episode.
    fn of_episode(&self, context: &EpisodeContext<'_>) -> Result<&dyn Policy> {
        let EpisodeContext { subject, spaces, seed, .. } = context;
        // The energy scale comes from the building; the requested task has none.
        let task = Task { energy_scale: None, ..spaces.episode.task.clone() };
        let name = fill(&self.pattern, *seed, &subject.name.to_string(), &task.to_string());
        match self.files.get(&name) {
            Some(file) => Ok(file.policy.policy()),
            None => Err(b2b_evaluate::Error::UnknownPolicy { text: name }.into()),
        }
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
        let count = self.files.len();
        match self.format {
            Format::Onnx(scale) => format!("onnx {}, {count} files, actions {scale:?}", sha256(all)),
            Format::Agents => format!("agents {}, {count} folders", sha256(all)),
        }
    }

    fn observation_width(&self) -> Option<usize> {
        let mut widths = self.files.values().map(|file| file.policy.policy().observation_width());
        let first = widths.next()??;
        widths.all(|width| width == Some(first)).then_some(first)
    }

    fn ignores_interface(&self) -> bool {
        self.format == Format::Agents
    }

    fn has_memory(&self) -> bool {
        self.files.values().any(|file| file.policy.policy().has_memory())
    }

    fn description(&self, context: &EpisodeContext<'_>) -> b2b_evaluate::Result<Option<Value>> {
        self.of_episode(context)?.description(context)
    }

    fn controller(&self, context: EpisodeContext<'_>) -> b2b_evaluate::Result<Box<dyn Controller>> {
        self.of_episode(&context)?.controller(context)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pattern_is_split_from_its_folder() {
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
    fn a_deterministic_policy_runs_with_one_seed() {
        let seeds = |built_in| EntryPolicy::BuiltIn(built_in).seeds(&[4, 5, 6]);
        assert_eq!(seeds(BuiltIn::random()), [4, 5, 6]);
        assert_eq!(seeds(BuiltIn::reactive()), [4]);
    }
}
