//! The tasks of a training run.

use std::fmt;
use std::str::FromStr;

use b2b_env::Task;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error as _, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The tasks of a training run, at least one.
///
/// In a configuration, they are a text of one or several short forms separated by commas, the path of a JSON file, a
/// table with the options of a task, or a list of these. A file is read when the configuration is, so that the
/// configuration of a run has the whole task.
#[derive(Clone, Debug, PartialEq)]
pub struct Tasks(Vec<Task>);

impl Tasks {
    /// Returns the tasks.
    pub fn as_slice(&self) -> &[Task] {
        &self.0
    }
}

impl From<Task> for Tasks {
    fn from(task: Task) -> Self {
        Self(vec![task])
    }
}

impl Default for Tasks {
    fn default() -> Self {
        Task::default().into()
    }
}

impl FromIterator<Task> for Tasks {
    /// Collects tasks; the default task if there are none.
    fn from_iter<I: IntoIterator<Item = Task>>(tasks: I) -> Self {
        let tasks: Vec<Task> = tasks.into_iter().collect();
        if tasks.is_empty() { Self::default() } else { Self(tasks) }
    }
}

impl FromStr for Tasks {
    type Err = b2b_env::Error;

    /// Parses a JSON object, or texts of [`Task::from_text`] separated by commas.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        if text.trim_start().starts_with('{') {
            return Ok(Task::from_text(text)?.into());
        }
        text.split(',').map(|task| Task::from_text(task.trim())).collect()
    }
}

impl fmt::Display for Tasks {
    /// Writes the short forms, separated by commas.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let texts: Vec<String> = self.0.iter().map(ToString::to_string).collect();
        f.write_str(&texts.join(","))
    }
}

/// A task in a configuration: its short form if it has one, otherwise all of its options.
struct Entry<'a>(&'a Task);

impl Serialize for Entry<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0.short_form() {
            Some(text) => text.serialize(serializer),
            None => self.0.serialize(serializer),
        }
    }
}

impl Serialize for Tasks {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let entries: Vec<Entry<'_>> = self.0.iter().map(Entry).collect();
        let texts: Option<Vec<String>> = self.0.iter().map(Task::short_form).collect();
        match (texts, &entries[..]) {
            (Some(texts), _) => texts.join(",").serialize(serializer),
            (None, [entry]) => entry.serialize(serializer),
            (None, entries) => entries.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Tasks {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(TasksVisitor)
    }
}

struct TasksVisitor;

impl<'de> Visitor<'de> for TasksVisitor {
    type Value = Tasks;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a task as text, a table, or a list of these")
    }

    fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Tasks, E> {
        text.parse().map_err(E::custom)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Tasks, A::Error> {
        // As in a JSON file: what is omitted depends on the task.
        let given = serde_json::Map::deserialize(MapAccessDeserializer::new(map))?;
        let task = Task::from_text(&serde_json::Value::from(given).to_string());
        Ok(task.map_err(A::Error::custom)?.into())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Tasks, A::Error> {
        let mut all = Vec::new();
        while let Some(Tasks(tasks)) = list.next_element()? {
            all.extend(tasks);
        }
        match all.is_empty() {
            true => Err(A::Error::invalid_length(0, &self)),
            false => Ok(Tasks(all)),
        }
    }
}

#[cfg(test)]
mod tests {
    use b2b_env::Faults;

    use super::super::TrainConfig;
    use super::*;

    fn configured(text: &str) -> Result<Tasks, String> {
        TrainConfig::default().with_changes(text).map(|config| config.training_set.task)
    }

    #[test]
    fn tasks_survive_a_configuration_file() {
        let own = Task { comfort_band: 0.5, faults: Faults::default(), ..Task::default() };
        let occupancy: Task = "occupancy+energy0.5".parse().unwrap();
        for tasks in [vec![occupancy.clone()], vec![own.clone()], vec![occupancy.clone(), own, occupancy]] {
            let mut config = TrainConfig::default();
            config.training_set.task = tasks.iter().cloned().collect();
            assert_eq!(configured(&config.to_toml()).unwrap().as_slice(), tasks, "{}", config.to_toml());
        }
    }

    #[test]
    fn a_task_may_be_text_a_table_or_a_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mine.json");
        std::fs::write(&path, r#"{"comfort_band": 0.5, "energy_scale": null}"#).unwrap();
        let own = Task { comfort_band: 0.5, ..Task::default() };
        let file = format!("task = '{}'", path.display());
        let object = r#"task = '{"comfort_band": 0.5, "energy_scale": null}'"#;
        for text in [file.as_str(), object, "task = { comfort_band = 0.5 }", "[[task]]\ncomfort_band = 0.5"] {
            assert_eq!(configured(text).unwrap().as_slice(), std::slice::from_ref(&own), "{text}");
        }
        let several = configured("task = ['constant', { comfort_band = 0.5 }, 'occupancy,random']").unwrap();
        let random: Task = "random".parse().unwrap();
        assert_eq!(several.as_slice(), [Task::default(), own, "occupancy".parse().unwrap(), random]);
    }

    #[test]
    fn invalid_tasks_are_errors_that_name_them() {
        for (text, named) in [
            ("task = 'warm'", "unknown task `warm`"),
            ("task = { comfort_bend = 0.5 }", "comfort_bend"),
            ("task = { energy_weight = -1 }", "energy_weight"),
            ("task = []", "a task as text"),
            ("task = 3", "a task as text"),
            ("task = 'none.json'", "none.json"),
        ] {
            let error = configured(text).unwrap_err();
            assert!(error.contains(named), "{text}: {error}");
        }
    }
}
