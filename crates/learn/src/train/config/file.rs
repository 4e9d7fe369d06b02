//! Reading and writing configurations: the options of all parts in one TOML table.

use std::path::Path;

use b2b_base::suggestion::with_suggestion;
use serde::Serialize;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

use super::idle;
use super::preset_choice::PresetChoice;
use super::train_config::TrainConfig;
use crate::error::{Error, Result, at};
use crate::learners::{LearnerChoice, LearnerKind, kinds};

/// Name of the configuration in a run's folder.
pub const CONFIG: &str = "config.toml";

/// The presets by name: TOML files with the options that differ from the defaults.
const PRESETS: [(&str, &str); 7] = [
    ("direct", include_str!("../../../data/direct.toml")),
    ("graph", include_str!("../../../data/graph.toml")),
    ("paper", include_str!("../../../data/paper.toml")),
    ("recurrent", include_str!("../../../data/recurrent.toml")),
    ("residual", include_str!("../../../data/residual.toml")),
    ("supervisory", include_str!("../../../data/supervisory.toml")),
    ("supervisory-graph", include_str!("../../../data/supervisory-graph.toml")),
];

/// The option with the name of the learner.
const ALGORITHM: &str = "algorithm";
/// The table of the evaluations.
const EVALUATION: &str = "evaluation";

/// The option that only the caller may set.
const PERMISSION: &str = "allow_external";

/// A value read from a table, or why the table is invalid.
pub(super) type Read<T> = std::result::Result<T, String>;

impl TrainConfig {
    /// Returns the names of the presets.
    pub fn presets() -> impl Iterator<Item = &'static str> {
        PRESETS.into_iter().map(|(name, _)| name)
    }

    /// Returns a preset.
    ///
    /// # Errors
    /// [`Error::Invalid`] for an unknown name.
    pub fn preset(name: &str) -> Result<Self> {
        let found = PRESETS.into_iter().find(|(each, _)| *each == name);
        let (_, text) = found.ok_or_else(|| {
            let names: Vec<_> = Self::presets().map(|name| format!("`{name}`")).collect();
            let message = format!("unknown preset `{name}`; expected {}", names.join(" or "));
            Error::Invalid(with_suggestion(&message))
        })?;
        Self::default().with_changes(text).map_err(Error::Invalid)
    }

    /// Returns the configuration with the changes of a TOML text. The text may start from a preset, with
    /// `preset = "paper"`.
    ///
    /// # Errors
    /// Why the text is invalid: a value of the wrong type, or an unknown key with a suggestion.
    pub fn with_changes(&self, text: &str) -> Read<Self> {
        self.with_untrusted(toml::from_str(text).map_err(|error| error.to_string())?)
    }

    /// Like [`TrainConfig::with_changes`], for a JSON object with the caller's arguments, which may include
    /// `allow_external`. Unlike in a file, options of a learner that is not chosen are an error.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the reason.
    pub fn with_json(&self, text: &str) -> Result<Self> {
        let mut changes: Table =
            serde_json::from_str(text).map_err(|error| Error::Invalid(error.to_string()))?;
        let permission = changes.remove(PERMISSION);
        let learners = of_learners(&changes);
        let mut config = self.with_table(changes).map_err(Error::Invalid)?;
        let chosen = config.learner.name();
        if let Some(other) = learners.into_iter().find(|name| *name != chosen) {
            return Err(Error::Invalid(format!(
                "`{other}` has no effect: `{ALGORITHM}` is {chosen}; choose {other}, or remove it"
            )));
        }
        match permission {
            None => {}
            Some(Value::Boolean(allow)) => config.training_set.allow_external = allow,
            Some(other) => {
                return Err(Error::Invalid(format!("`{PERMISSION}` is {other}; expected a boolean")));
            }
        }
        Ok(config)
    }

    /// Returns the preset of a run with the changes of a file and of a JSON object with the caller's options. Without
    /// `preset`, it is the one for the options of both.
    ///
    /// # Errors
    /// Errors of [`TrainConfig::preset`], [`TrainConfig::with_file`] and [`TrainConfig::with_json`].
    pub fn of_json(options: &str, preset: Option<&str>, file: Option<&Path>) -> Result<Self> {
        // What is invalid is reported by `with_json`.
        let mut given: PresetChoice = serde_json::from_str(options).unwrap_or_default();
        given.preset = preset.map(str::to_owned).or(given.preset);
        let (mut base, mut ignored) = (Self::preset(&given.name(file)?)?, vec!["preset"]);
        let options_table: Table = serde_json::from_str(options).unwrap_or_default();
        if let Some(name) = options_table.get(ALGORITHM).and_then(Value::as_str) {
            base = base.with_algorithm(name)?;
            ignored.push(ALGORITHM);
        }
        let base = file.map_or_else(|| Ok(base.clone()), |file| base.with_file(file, &ignored))?;
        base.with_json(options)
    }

    /// Returns the configuration with the changes of a file, without the options in `ignored`.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::ConfigFile`] with what is wrong.
    pub fn with_file(&self, path: &Path, ignored: &[&str]) -> Result<Self> {
        read_table(path, |mut changes| {
            ignored.iter().for_each(|key| drop(changes.remove(*key)));
            self.with_untrusted(changes)
        })
    }

    /// Returns the configuration of a run, from its folder, without `allow_external`.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::ConfigFile`] with what is wrong.
    pub fn of_run(folder: &Path) -> Result<Self> {
        // It has every option, including the ones its problem set.
        read_table(&folder.join(CONFIG), |mut table| {
            table.remove(PERMISSION);
            Self::from_table(table)
        })
    }

    /// Returns the configuration as a TOML text with every option.
    pub fn to_toml(&self) -> String {
        let parts = toml::to_string(self).expect("plain data always serializes");
        format!("{ALGORITHM} = {:?}\n{parts}\n{}", self.learner.name(), self.learner.to_toml())
    }

    /// Like [`TrainConfig::with_table`], for a file, which cannot grant permissions.
    fn with_untrusted(&self, mut changes: Table) -> Read<Self> {
        match changes.remove(PERMISSION) {
            None | Some(Value::Boolean(false)) => self.with_table(changes),
            Some(_) => Err(format!(
                "`{PERMISSION}` cannot be set in a file; remove it, and pass --allow-external (allow_external=True in \
                 Python) if you trust the author of the model"
            )),
        }
    }

    fn with_table(&self, mut changes: Table) -> Read<Self> {
        let said = |error: Error| error.to_string();
        let is_whole = is_whole(&changes);
        let (mut base, problem) = match changes.remove("preset") {
            // A preset has no problem: this configuration's is applied to it.
            Some(Value::String(name)) => {
                (Self::preset(&name).map_err(said)?, self.training_set.problem.clone())
            }
            Some(other) => return Err(format!("`preset` is {other}; expected a name")),
            // What the file of a run leaves out is `None`, and not this configuration's.
            None if is_whole => {
                let default = Self::default().with_algorithm(self.learner.name()).map_err(said)?;
                (default, self.training_set.problem.clone())
            }
            None => (self.clone(), String::new()),
        };
        let problem = changes.get("problem").and_then(Value::as_str).unwrap_or(&problem);
        if !problem.is_empty() {
            // Whether a problem has an agent of this kind depends on its network.
            if let Some(policy) = changes.get("policy") {
                let policy = policy.clone().try_into();
                base.agent.policy = policy.map_err(|error| with_suggestion(error.message()))?;
            }
            base = base.with_problem(problem).map_err(said)?;
        }
        let algorithm = changes.get(ALGORITHM).and_then(Value::as_str);
        if let Some(name) = algorithm.filter(|name| *name != base.learner.name()) {
            base = base.with_algorithm(name).map_err(said)?;
        }
        let mut all: Table = toml::from_str(&base.to_toml()).map_err(|error| error.to_string())?;
        let chosen = if is_whole { Vec::new() } else { idle::chosen(&all, &changes) };
        merge(&mut all, changes);
        let mut config = Self::from_table(all)?;
        idle::check(&config, &chosen)?;
        config.training_set.allow_external = self.training_set.allow_external;
        Ok(config)
    }

    /// Reads a table with the options of all parts; what it leaves out has its default.
    fn from_table(table: Table) -> Read<Self> {
        let mut options = Options { table, known: Vec::new() };
        let config = Self {
            training_set: options.part()?,
            agent: options.part()?,
            budget: options.part()?,
            rewards: options.part()?,
            noise: options.part()?,
            checkpoints: options.part()?,
            evaluation: options
                .table(EVALUATION)?
                .try_into()
                .map_err(|error| explained(EVALUATION, &error))?,
            learner: options.learner()?,
        };
        options.finish().map(|()| config)
    }
}

/// The unread options of a table, and the names of all known options.
struct Options {
    table: Table,
    known: Vec<String>,
}

impl Options {
    /// Reads the options of a part.
    fn part<P: Default + Serialize + DeserializeOwned>(&mut self) -> Read<P> {
        let all = Table::try_from(P::default()).expect("plain data always serializes");
        let own: Table = all.keys().filter_map(|key| Some((key.clone(), self.table.remove(key)?))).collect();
        self.known.extend(all.into_iter().map(|(key, _)| key));
        let part: P = own.clone().try_into().map_err(|error| {
            let is_wrong = |(key, value): &(&String, &Value)| {
                Table::from_iter([((*key).clone(), (*value).clone())]).try_into::<P>().is_err()
            };
            let wrong = own.iter().find(is_wrong).map_or("", |(key, _)| key);
            explained(wrong, &error)
        })?;
        check_kinds(&own, &Table::try_from(&part).expect("plain data always serializes"))?;
        Ok(part)
    }

    /// Takes a table of options; an absent one is empty.
    fn table(&mut self, name: &'static str) -> Read<Table> {
        self.known.push(name.into());
        match self.table.remove(name) {
            None => Ok(Table::new()),
            Some(Value::Table(own)) => Ok(own),
            Some(other) => Err(format!("`{name}` is {other}; expected a table")),
        }
    }

    /// Reads the learner. Options of other learners are checked, but not kept.
    fn learner(&mut self) -> Read<LearnerChoice> {
        let chosen = match self.table.remove(ALGORITHM) {
            None => LearnerChoice::default().name(),
            Some(Value::String(name)) => LearnerKind::find(&name).map_err(|error| error.to_string())?.name,
            Some(other) => return Err(format!("`{ALGORITHM}` is {other}; expected a name")),
        };
        self.known.push(ALGORITHM.into());
        let mut learner = LearnerChoice::default();
        for kind in kinds() {
            let read = kind.read(self.table(kind.name)?).map_err(|error| explained(kind.name, &error))?;
            if kind.name == chosen {
                learner = read;
            }
        }
        Ok(learner)
    }

    /// Checks that all options are read.
    fn finish(self) -> Read<()> {
        let Some(unknown) = self.table.keys().next() else { return Ok(()) };
        let known = self.known.join("`, `");
        Err(with_suggestion(&format!("unknown field `{unknown}`, expected one of `{known}`")))
    }
}

/// Returns the learners with options in a table.
fn of_learners(table: &Table) -> Vec<&'static str> {
    let has_options =
        |name: &&str| table.get(*name).and_then(Value::as_table).is_some_and(|own| !own.is_empty());
    kinds().into_iter().map(|kind| kind.name).filter(has_options).collect()
}

/// Returns whether a table is the file of a run, which has every option but those that are `None`. What the caller gives
/// was taken out of it.
fn is_whole(changes: &Table) -> bool {
    let all: Table = toml::from_str(&TrainConfig::default().to_toml()).expect("what is written can be read");
    let given = [ALGORITHM, "problem", LearnerChoice::default().name()];
    all.keys().all(|key| given.contains(&key.as_str()) || changes.contains_key(key))
}

/// Checks that a table whose `kind` has no options has none, which the readers of such kinds accept.
fn check_kinds(given: &Table, read: &Table) -> Read<()> {
    for (key, value) in given {
        let (Value::Table(given), Some(Value::Table(read))) = (value, read.get(key)) else { continue };
        let Some(kind) = read.get("kind").filter(|_| read.len() == 1) else { continue };
        if let Some(unknown) = given.keys().find(|name| *name != "kind") {
            return Err(format!("`{key}`: unknown field `{unknown}`; {kind} has no options"));
        }
    }
    Ok(())
}

/// Returns why an option is invalid.
fn explained(key: &str, error: &toml::de::Error) -> String {
    format!("`{key}`: {}", with_suggestion(error.message()))
}

/// Reads a TOML file.
pub(super) fn read_table<T>(path: &Path, read: impl FnOnce(Table) -> Read<T>) -> Result<T> {
    let text = std::fs::read_to_string(path).map_err(at(path))?;
    let table = toml::from_str(&text).map_err(|error| error.to_string());
    table.and_then(read).map_err(|why| Error::ConfigFile { path: path.to_owned(), why })
}

/// Overrides the options of one table by another's, also within tables. A table with a `kind` is replaced as a whole.
pub fn merge(base: &mut Table, changes: Table) {
    for (key, value) in changes {
        match (base.get_mut(&key), value) {
            (Some(Value::Table(into)), Value::Table(from)) if !from.contains_key("kind") => merge(into, from),
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
}
