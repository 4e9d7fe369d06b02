//! The files of a dataset.
//!
//! The layout is Minari's `parquet` storage: `data/metadata.json` describes the dataset, `data/N/metadata.json`
//! episode N, and `data/N/part-0.parquet` has its steps. `SHA256SUMS` has the digests of all files.

use std::path::{Path, PathBuf};

use b2b_base::digest_list::DigestList;
use b2b_base::folder_lock::FolderLock;
use b2b_base::new_folders::NewFolders;
use b2b_control::Versions;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use tempfile::TempDir;

use super::episodes::{self, EpisodeFile};
use crate::error::at;
use crate::{Error, Result};

/// Version of Minari that defines the format.
const MINARI: &str = "0.5.3";
pub(super) const METADATA: &str = "metadata.json";

/// Contents of a dataset, in addition to Minari's own metadata.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contents {
    /// Building type.
    pub building_type: String,
    /// Task.
    pub task: String,
    /// Run periods, separated by commas.
    pub period: String,
    /// Zone time steps per hour.
    pub steps_per_hour: u32,
    /// Whether actions are scaled from the bounds of each actuator to [-1, 1]; otherwise they are in physical units.
    pub rescaled: bool,
    /// Names of the values of an observation.
    pub observation_names: Vec<String>,
    /// Names of the actuators.
    pub action_names: Vec<String>,
    /// Widths of observations and actions in a corpus, whose names are in the graphs of its buildings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub widths: Option<[usize; 2]>,
    /// Versions that recorded it; `None` in a dataset from an earlier version.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub versions: Option<Versions>,
}

/// Metadata of an episode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpisodeMetadata {
    /// Number.
    pub id: usize,
    /// Number of steps.
    pub total_steps: usize,
    /// Seed of the policy.
    pub seed: u64,
    /// Building.
    pub building: String,
    /// Place of its weather; `None` for the building's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<String>,
    /// Weather file, instead of a place.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weather: Option<PathBuf>,
    /// How its model file was read.
    #[serde(default, skip_serializing_if = "ModelReading::is_default")]
    pub reading: ModelReading,
    /// Policy.
    pub policy: String,
    /// Identity of the policy; `None` in a corpus, whose definition has it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub policy_identity: Option<String>,
    /// Run period; `None` in a dataset from an earlier version, which has only one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub period: Option<String>,
    /// Return.
    pub episode_return: f64,
    /// Further metadata of an episode in a corpus.
    #[serde(flatten, default, skip_serializing_if = "Option::is_none")]
    pub corpus: Option<CorpusEpisode>,
}

/// How a model file is read, as [`Placement`](b2b_dataset::Placement) says.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(default)]
pub struct ModelReading {
    /// Whether it keeps its design days instead of the weather file's.
    pub keep_design_days: bool,
    /// Folder of EnergyPlus's Transition programs that convert it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transition: Option<PathBuf>,
}

impl ModelReading {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// Metadata of an episode in a corpus.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CorpusEpisode {
    /// Type of its building.
    pub building_type: String,
    /// Task.
    pub task: String,
    /// The controller whose actions are the labels; empty where the building's own controls act.
    pub expert: String,
    /// File name of its graph.
    pub graph: String,
    /// Width of an observation without padding.
    pub observation_width: usize,
    /// Number of actuators: width of an action without padding.
    pub action_width: usize,
}

/// A dataset on disk.
#[derive(Clone, Debug)]
pub struct Dataset {
    path: PathBuf,
    /// Contents.
    pub contents: Contents,
    /// Its episodes, in order.
    pub episodes: Vec<EpisodeMetadata>,
    /// Digests of its files; `None` in a dataset from an earlier version.
    digests: Option<DigestList>,
}

#[derive(Deserialize)]
struct Metadata {
    total_episodes: usize,
    data_format: String,
    b2b: Option<Contents>,
}

impl Dataset {
    /// Reads the description of a dataset that [`collect`](super::collect) or
    /// [`collect_corpus`](super::collect_corpus) wrote.
    ///
    /// # Errors
    /// [`Error::Io`] for a file that cannot be read or was changed; [`Error::Invalid`] for invalid metadata or another
    /// kind of dataset.
    pub fn open(path: &Path) -> Result<Self> {
        let digests = DigestList::read(path).map_err(at(path))?;
        let name = format!("data/{METADATA}");
        let file = path.join(&name);
        let Metadata { total_episodes, data_format, b2b } = read_json(path, &name, digests.as_ref())?;
        let wrong = |why: &str| Error::Invalid(format!("{}: {why}", file.display()));
        if data_format != "parquet" {
            return Err(wrong(&format!(
                "the format is {data_format}; expected parquet, as `b2b collect` writes"
            )));
        }
        let contents =
            b2b.ok_or_else(|| wrong("it does not name buildings; expected a dataset of `b2b collect`"))?;
        let episode = |number: usize| read_json(path, &format!("data/{number}/{METADATA}"), digests.as_ref());
        let episodes = (0..total_episodes).map(episode).collect::<Result<_>>()?;
        Ok(Self { path: path.to_owned(), contents, episodes, digests })
    }

    /// Reads the steps of an episode.
    ///
    /// # Errors
    /// [`Error::Io`] for a file that cannot be read or was changed; [`Error::Invalid`] for a damaged one.
    pub fn read(&self, episode: usize) -> Result<EpisodeFile> {
        let path = episodes::path(&self.path.join("data"), episode);
        let name = episodes::path(Path::new("data"), episode);
        if let Some(digests) = &self.digests {
            digests.read_file(&self.path, &name.to_string_lossy()).map_err(at(&path))?;
        }
        let Contents { observation_names, action_names, widths, .. } = &self.contents;
        let [observation, action] = widths.unwrap_or([observation_names.len(), action_names.len()]);
        let mut file = episodes::read(&path, observation, action)?;
        if let Some(of) = &self.episodes[episode].corpus {
            cut(&mut file.observations, observation, of.observation_width);
            cut(&mut file.actions, action, of.action_width);
            cut(&mut file.expert, action, of.action_width);
        }
        Ok(file)
    }
}

/// Removes the padding of rows.
fn cut(values: &mut Vec<f32>, from: usize, to: usize) {
    let rows = values.len() / from;
    (0..rows).for_each(|row| values.copy_within(row * from..row * from + to, row * to));
    values.truncate(rows * to);
}

/// A dataset that is being written to a temporary folder and is moved into place once complete. Until then, its place is
/// an empty, locked folder, so that nobody else can take it.
#[derive(Debug)]
pub(super) struct NewDataset {
    destination: PathBuf,
    staging: TempDir,
    _lock: FolderLock,
    /// Dropped after the staging folder, which is in one of them.
    _folders: NewFolders,
}

impl NewDataset {
    /// Begins a dataset.
    pub(super) fn create(destination: &Path) -> Result<Self> {
        let shown = destination.display();
        let taken =
            |why| Error::Invalid(format!("{shown} {why}; remove it, or choose another name or version"));
        let is_empty = |mut entries: std::fs::ReadDir| entries.next().is_none();
        if destination.exists() && !destination.read_dir().is_ok_and(is_empty) {
            return Err(taken("exists"));
        }
        let folders = NewFolders::create(destination).map_err(at(destination))?;
        let Some(lock) = FolderLock::acquire(destination).map_err(at(destination))? else {
            // The other process has the folder.
            folders.keep();
            return Err(taken("is being written by another command"));
        };
        let parent = destination.parent().filter(|parent| !parent.as_os_str().is_empty());
        let parent = parent.unwrap_or(Path::new("."));
        let staging = b2b_base::scratch::folder_in(parent, ".b2b-unfinished-").map_err(at(parent))?;
        let new = Self { destination: destination.to_owned(), staging, _lock: lock, _folders: folders };
        std::fs::create_dir(new.whole()).map_err(at(parent))?;
        Ok(new)
    }

    /// Returns the folder that is moved to the destination. It has the permissions of a new folder; its parent is
    /// private.
    fn whole(&self) -> PathBuf {
        self.staging.path().join("dataset")
    }

    fn data(&self) -> PathBuf {
        self.whole().join("data")
    }

    /// Writes an episode.
    pub(super) fn write(&self, metadata: &EpisodeMetadata, episode: &EpisodeFile) -> Result<()> {
        let path = episodes::path(&self.data(), metadata.id);
        let folder = path.parent().unwrap_or(&path);
        std::fs::create_dir_all(folder).map_err(at(folder))?;
        episodes::write(&path, episode, metadata.total_steps)?;
        write_json(&folder.join(METADATA), &serde_json::to_value(metadata).expect("it is plain data"))
    }

    /// Writes the description and moves everything to its place.
    pub(super) fn finish(
        self,
        id: &str,
        algorithm: &str,
        contents: &Contents,
        episodes: &[EpisodeMetadata],
        [observation, action]: [Value; 2],
        spec: Option<&Value>,
    ) -> Result<()> {
        let description = format!("{algorithm} on {} episodes of {}", episodes.len(), contents.building_type);
        let mut metadata = metadata(id, algorithm, &description, contents, episodes, [observation, action]);
        if let Some(spec) = spec {
            metadata["env_spec"] = spec.to_string().into();
        }
        write_json(&self.data().join(METADATA), &metadata)?;
        write_digests(&self.whole(), files(episodes)).map_err(at(&self.destination))?;
        std::fs::rename(self.whole(), &self.destination).map_err(at(&self.destination))
    }
}

/// Returns Minari's description of a dataset.
pub(super) fn metadata(
    id: &str,
    algorithm: &str,
    description: &str,
    contents: &Contents,
    episodes: &[EpisodeMetadata],
    [observation, action]: [Value; 2],
) -> Value {
    json!({
        "total_episodes": episodes.len(),
        "total_steps": episodes.iter().map(|episode| episode.total_steps).sum::<usize>(),
        "data_format": "parquet",
        "jpeg_encoding": false,
        "observation_space": observation.to_string(),
        "action_space": action.to_string(),
        "dataset_id": id,
        "minari_version": MINARI,
        "author": ["building2building"],
        "algorithm_name": algorithm,
        "description": description,
        "requirements": ["building2building"],
        "b2b": contents,
    })
}

/// Returns the files of the episodes of a dataset and its description.
pub(super) fn files(episodes: &[EpisodeMetadata]) -> Vec<PathBuf> {
    let data = Path::new("data");
    let of_episode = |episode: &EpisodeMetadata| {
        [data.join(episode.id.to_string()).join(METADATA), episodes::path(data, episode.id)]
    };
    std::iter::once(data.join(METADATA)).chain(episodes.iter().flat_map(of_episode)).collect()
}

/// Writes the digests of files in a folder.
pub(super) fn write_digests(folder: &Path, files: Vec<PathBuf>) -> std::io::Result<()> {
    let mut digests = DigestList::default();
    for name in files {
        digests.add(name.to_string_lossy(), &std::fs::read(folder.join(&name))?);
    }
    digests.write(folder)
}

/// Reads a file of a dataset, verified if there are digests.
pub(super) fn read_json<T: for<'a> Deserialize<'a>>(
    folder: &Path,
    name: &str,
    digests: Option<&DigestList>,
) -> Result<T> {
    let path = folder.join(name);
    let text = match digests {
        Some(digests) => digests.read_file(folder, name),
        None => std::fs::read(&path),
    };
    let text = text.map_err(at(&path))?;
    serde_json::from_slice(&text).map_err(|error| Error::Invalid(format!("{}: {error}", path.display())))
}

pub(super) fn write_json(path: &Path, value: &Value) -> Result<()> {
    std::fs::write(path, value.to_string()).map_err(at(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn contents() -> Contents {
        Contents {
            building_type: "OfficeSmall".into(),
            task: "occupancy".into(),
            period: "winter".into(),
            steps_per_hour: 12,
            rescaled: true,
            observation_names: vec!["a".into(), "b".into()],
            action_names: vec!["c".into()],
            widths: None,
            versions: None,
        }
    }

    #[test]
    fn a_dataset_reads_back_unchanged_and_is_never_half_written() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("b2b/small-v0");
        let episode = EpisodeFile {
            observations: vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
            actions: vec![0.5, -0.5],
            rewards: vec![-1.25, -0.5],
            expert: Vec::new(),
        };
        let metadata = |id| EpisodeMetadata {
            id,
            total_steps: 2,
            seed: 7,
            building: "OfficeSmall-0042".into(),
            place: None,
            weather: None,
            reading: ModelReading::default(),
            policy: "reactive".into(),
            policy_identity: Some("reactive 0".into()),
            period: Some("winter".into()),
            episode_return: -1.75,
            corpus: None,
        };
        let new = NewDataset::create(&path).unwrap();
        let episodes = [metadata(0), metadata(1)];
        episodes.iter().for_each(|metadata| new.write(metadata, &episode).unwrap());
        assert_eq!(std::fs::read_dir(&path).unwrap().count(), 0);
        let said = NewDataset::create(&path).unwrap_err().to_string();
        assert!(said.contains("small-v0 is being written by another command"), "{said}");
        let box_space = json!({"type": "Box"});
        new.finish(
            "b2b/small-v0",
            "reactive",
            &contents(),
            &episodes,
            [box_space.clone(), box_space],
            Some(&json!({})),
        )
        .unwrap();
        let dataset = Dataset::open(&path).unwrap();
        assert_eq!((&dataset.contents, &dataset.episodes[..]), (&contents(), &episodes[..]));
        assert_eq!(dataset.read(1).unwrap(), episode);
        let left = std::fs::read_dir(root.path().join("b2b")).unwrap().count();
        assert_eq!(left, 1);

        let said = NewDataset::create(&path).unwrap_err().to_string();
        assert!(said.contains("small-v0 exists"), "{said}");
        drop(NewDataset::create(&root.path().join("b2b/other-v0")).unwrap());
        assert_eq!(std::fs::read_dir(root.path().join("b2b")).unwrap().count(), 1);
        drop(NewDataset::create(&root.path().join("own/houses/all-v0")).unwrap());
        assert_eq!(std::fs::read_dir(root.path()).unwrap().count(), 1, "no empty folder is left");
        assert_every_flipped_bit_is_an_error(&path);
        std::fs::write(path.join("data/1/part-0.parquet"), "damaged").unwrap();
        assert!(dataset.read(1).unwrap_err().to_string().contains("part-0.parquet"));
        assert!(Dataset::open(root.path()).is_err());
    }

    /// Changes a bit of every byte of a file of each kind, except the digests.
    fn assert_every_flipped_bit_is_an_error(path: &Path) {
        let all =
            || Dataset::open(path).and_then(|dataset| (0..2).try_for_each(|n| dataset.read(n).map(drop)));
        all().unwrap();
        for name in ["metadata.json", "1/metadata.json", "0/part-0.parquet"] {
            let file = path.join("data").join(name);
            let whole = std::fs::read(&file).unwrap();
            for byte in 0..whole.len() {
                let mut damaged = whole.clone();
                damaged[byte] ^= 1 << (byte % 8);
                std::fs::write(&file, damaged).unwrap();
                let said = all().unwrap_err().to_string();
                assert!(said.contains(name) && said.contains("changed"), "byte {byte}: {said}");
            }
            std::fs::write(&file, whole).unwrap();
        }
        // A dataset from an earlier version has no digests.
        let digests = path.join(b2b_base::digest_list::DIGESTS);
        let text = std::fs::read(&digests).unwrap();
        std::fs::remove_file(&digests).unwrap();
        all().unwrap();
        std::fs::write(&digests, text).unwrap();
    }
}
