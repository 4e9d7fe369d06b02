//! The folder of a corpus.

use std::fs::create_dir_all;
use std::path::{Path, PathBuf};

use b2b_base::aside::{is_unfinished, write_whole};
use b2b_base::digest_list::DigestList;
use b2b_base::scratch::folder_in;
use b2b_building::morphology::Universe;
use b2b_control::Versions;
use serde_json::json;

use super::card::card;
use super::definition::{Definition, STEPS_PER_HOUR, Source, named};
use crate::error::at;
use crate::offline::collection::box_space;
use crate::offline::dataset::{
    Contents, EpisodeMetadata, METADATA, files, metadata, read_json, write_digests, write_json,
};
use crate::offline::episodes::{self, EpisodeFile};
use crate::{Error, Result};

/// Definition, identities of the policies, and versions, which tell one corpus from another.
const CORPUS: &str = "corpus.json";
/// The description for people.
const CARD: &str = "README.md";
/// Folder of the graphs.
const GRAPHS: &str = "graphs";
/// The node types.
const UNIVERSE: &str = "universe.json";

/// The folder of a corpus, to which several processes may write.
pub(super) struct Writer<'a> {
    folder: PathBuf,
    definition: &'a Definition,
}

impl<'a> Writer<'a> {
    /// Begins or continues a corpus.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a folder with something else.
    pub(super) fn open(folder: &Path, definition: &'a Definition) -> Result<Self> {
        let identity = |policy: Source<'_>| match policy {
            Source::Named(name) => Some(named(name).map(|policy| policy.identity())),
            // Definition and versions determine the agent.
            Source::Stage(_) => None,
        };
        let policies = definition.policies().filter_map(|(_, policy)| identity(policy));
        let policies = policies.collect::<Result<Vec<_>>>()?;
        let expected =
            json!({ "definition": definition, "policies": policies, "versions": Versions::current() });
        let path = folder.join(CORPUS);
        let writer = Self { folder: folder.to_owned(), definition };
        create_dir_all(folder).map_err(at(folder))?;
        // Shards begin at the same time, and the definition is the first of their files.
        if !path.exists() && !writer.has_files()? {
            write_whole(&path, expected.to_string().as_bytes()).map_err(at(&path))?;
        }
        let refused = |what: &str| {
            let shown = folder.display();
            Error::Invalid(format!("{shown} is {what}; choose another name or version, or remove it"))
        };
        if !path.exists() {
            return Err(refused("not a corpus"));
        }
        if read_json::<serde_json::Value>(folder, CORPUS, None)? != expected {
            return Err(refused("another corpus, or of other policies or versions"));
        }
        for each in [writer.graphs(), writer.data()] {
            create_dir_all(&each).map_err(at(&each))?;
        }
        let universe_file = folder.join(UNIVERSE);
        if !universe_file.exists() {
            let universe = serde_json::to_string(&Universe::new()).expect("it is plain data");
            write_whole(&universe_file, universe.as_bytes()).map_err(at(&universe_file))?;
        }
        Ok(writer)
    }

    /// Returns whether the folder has files.
    fn has_files(&self) -> Result<bool> {
        for entry in self.folder.read_dir().map_err(at(&self.folder))? {
            let name = entry.map_err(at(&self.folder))?.file_name();
            if !is_unfinished(name.as_ref()) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Returns the folder of the graphs.
    pub(super) fn graphs(&self) -> PathBuf {
        self.folder.join(GRAPHS)
    }

    fn data(&self) -> PathBuf {
        self.folder.join("data")
    }

    /// Returns whether an episode is there.
    pub(super) fn has(&self, number: usize) -> bool {
        self.data().join(number.to_string()).exists()
    }

    /// Writes an episode, padded to the widths of the corpus.
    pub(super) fn write(&self, metadata: &EpisodeMetadata, mut file: EpisodeFile) -> Result<()> {
        let of = metadata.corpus.as_ref().expect("it is an episode of a corpus");
        let [observation, action] = self.definition.widths;
        for (what, values, width, to) in [
            ("observations", &mut file.observations, of.observation_width, observation),
            ("actions", &mut file.actions, of.action_width, action),
            ("expert actions", &mut file.expert, of.action_width, action),
        ] {
            if width > to {
                return Err(Error::Invalid(format!(
                    "{} has {what} of {width} values, more than the {to} of the corpus; widen it in its definition",
                    metadata.building
                )));
            }
            *values = padded(values, width, to, metadata.total_steps);
        }
        let data = self.data();
        let staging = folder_in(&data, ".b2b-unfinished-").map_err(at(&data))?;
        let number = metadata.id.to_string();
        let whole = staging.path().join(&number);
        std::fs::create_dir(&whole).map_err(at(&data))?;
        episodes::write(&episodes::path(staging.path(), metadata.id), &file, metadata.total_steps)?;
        write_json(&whole.join(METADATA), &serde_json::to_value(metadata).expect("it is plain data"))?;
        let place = data.join(number);
        match std::fs::rename(&whole, &place) {
            // Another process has written the same episode.
            Err(_) if place.exists() => Ok(()),
            renamed => renamed.map_err(at(&place)),
        }
    }

    /// Writes the description, the card and the digests, which make the folder a dataset. Checks the files of a dataset
    /// that has its digests.
    pub(super) fn finish(&self, id: &str, name: &str) -> Result<()> {
        let digests = DigestList::read(&self.folder).map_err(at(&self.folder))?;
        let read =
            |number: usize| read_json(&self.folder, &format!("data/{number}/{METADATA}"), digests.as_ref());
        let episodes =
            (0..self.definition.episode_count()).map(read).collect::<Result<Vec<EpisodeMetadata>>>()?;
        if let Some(digests) = &digests {
            return self.all_files(&episodes).into_iter().try_for_each(|name| {
                let path = self.folder.join(&name);
                digests.read_file(&self.folder, &name.to_string_lossy()).map(drop).map_err(at(&path))
            });
        }
        let mut tasks = Vec::new();
        for (task, _) in self.definition.policies() {
            if !tasks.contains(&task) {
                tasks.push(task);
            }
        }
        let contents = Contents {
            building_type: "all".into(),
            task: tasks.join(", "),
            period: "a week of each episode".into(),
            steps_per_hour: STEPS_PER_HOUR,
            rescaled: true,
            observation_names: Vec::new(),
            action_names: Vec::new(),
            widths: Some(self.definition.widths),
            versions: Some(Versions::current()),
        };
        let [observation, action] = self.definition.widths;
        let spaces = [vec![[f32::MIN, f32::MAX]; observation], vec![[-1.0, 1.0]; action]];
        let policies: Vec<_> = self.definition.policies().map(|(_, policy)| policy.to_string()).collect();
        let card = card(id, name, self.definition, &episodes);
        let spaces = spaces.map(|bounds| box_space(&bounds));
        let description = format!("corpus `{name}`: see {CARD}");
        let described = metadata(id, &policies.join(", "), &description, &contents, &episodes, spaces);
        let path = self.folder.join(CARD);
        write_whole(&path, card.as_bytes()).map_err(at(&path))?;
        let path = self.data().join(METADATA);
        write_whole(&path, described.to_string().as_bytes()).map_err(at(&path))?;
        write_digests(&self.folder, self.all_files(&episodes)).map_err(at(&self.folder))
    }

    fn all_files(&self, episodes: &[EpisodeMetadata]) -> Vec<PathBuf> {
        let graph =
            |episode: &EpisodeMetadata| episode.corpus.as_ref().map(|of| Path::new(GRAPHS).join(&of.graph));
        let mut all = files(episodes);
        all.extend(episodes.iter().filter_map(graph));
        all.extend([CORPUS, CARD, UNIVERSE].map(PathBuf::from));
        for (_, policy) in self.definition.policies() {
            let Source::Stage(stage) = policy else { continue };
            let folders = self.definition.types.iter().map(|of| stage.folder(Path::new(""), *of));
            all.extend(folders.flat_map(|folder| b2b_agent::FILES.map(|file| folder.join(file))));
        }
        all
    }
}

/// Returns rows padded with zeros to a width. Rows without values become rows of zeros.
fn padded(values: &[f32], width: usize, to: usize, steps: usize) -> Vec<f32> {
    if width == 0 {
        return vec![0.0; to * steps];
    }
    let mut rows = Vec::with_capacity(values.len() / width * to);
    for row in values.chunks_exact(width) {
        rows.extend_from_slice(row);
        rows.resize(rows.len() + to - width, 0.0);
    }
    rows
}
