//! Collecting a dataset.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::PoisonError;

use b2b_building::Controls;
use b2b_control::Versions;
use b2b_dataset::{BuildingName, Control};
use b2b_env::{Spaces, unscale};
use b2b_evaluate::{EpisodePlan, Evaluation, Policy, Progress, Recorded};
use serde_json::{Value, json};

use super::dataset::{Contents, Dataset, EpisodeMetadata, ModelReading, NewDataset};
use super::episodes::EpisodeFile;
use crate::{Error, Result};

/// A dataset to collect: every episode under every policy.
pub struct Collection<'a> {
    /// Name of the dataset, such as `b2b/office-small-v0`.
    pub id: &'a str,
    /// The episodes: buildings of one type under one task.
    pub episodes: &'a [EpisodePlan],
    /// The policies.
    pub policies: &'a [Box<dyn Policy>],
}

/// Runs the episodes and writes the dataset to a folder. With several buildings, whose bounds differ, actions are
/// rescaled to [-1, 1]; with one, they are in physical units.
///
/// # Errors
/// [`Error::Invalid`] for buildings of several types or with different observations, for a folder that exists, and when
/// an episode is lost; errors from [`Evaluation::record`].
pub fn collect(
    collection: &Collection<'_>,
    destination: &Path,
    evaluation: &Evaluation<'_>,
    progress: &dyn Progress,
) -> Result<Dataset> {
    let building_type = collection.building_type()?;
    if let Some(policy) = collection.policies.iter().find(|policy| policy.controls() == Controls::Own) {
        return Err(Error::Invalid(format!(
            "the policy {} commands no actuators, so there are no actions to record; remove it, or collect a corpus",
            policy.name()
        )));
    }
    let new = NewDataset::create(destination)?;
    let shape = Mutex::new(None);
    let mut episodes = Vec::new();
    for part in 0..collection.policies.len() {
        episodes.extend(collection.record(part, evaluation, progress, &new, &shape)?);
    }
    episodes.sort_by_key(|episode| episode.id);
    let shape = shape.into_inner().unwrap_or_else(PoisonError::into_inner);
    let (Some(shape), Some(example)) = (shape, collection.episodes.first()) else {
        return Err(Error::Invalid("there is no episode to collect".into()));
    };
    let rescaled = collection.is_rescaled();
    let contents = Contents {
        building_type: building_type.clone(),
        task: example.task.to_text(),
        period: collection.periods().join(", "),
        steps_per_hour: example.steps_per_hour,
        rescaled,
        versions: Some(Versions::current()),
        observation_names: shape.observation_names.clone(),
        action_names: shape.action_names.clone(),
        widths: None,
    };
    let names: Vec<String> = collection.policies.iter().map(|policy| policy.name()).collect();
    let spec = spec(&building_type, example, rescaled);
    new.finish(collection.id, &names.join(", "), &contents, &episodes, shape.boxes(), spec.as_ref())?;
    Dataset::open(destination)
}

impl Collection<'_> {
    /// Returns whether actions are rescaled to [-1, 1], because the bounds of several buildings differ.
    fn is_rescaled(&self) -> bool {
        self.buildings() > 1
    }

    /// Runs and writes the episodes of a policy. Their spaces must have the same names as earlier ones.
    fn record(
        &self,
        part: usize,
        evaluation: &Evaluation<'_>,
        progress: &dyn Progress,
        new: &NewDataset,
        shape: &Mutex<Option<Shape>>,
    ) -> Result<Vec<EpisodeMetadata>> {
        let numbered: Vec<(usize, &EpisodePlan)> = self.episodes.iter().enumerate().collect();
        let written = Mutex::new(Vec::new());
        record_each(&numbered, self.policies[part].as_ref(), evaluation, progress, &|number, recorded| {
            let metadata = self.write((part, number), recorded, new, shape)?;
            lock(&written).push(metadata);
            Ok(())
        })?;
        Ok(written.into_inner().unwrap_or_else(PoisonError::into_inner))
    }

    /// Writes an episode of a policy, both given by number.
    fn write(
        &self,
        (part, number): (usize, usize),
        recorded: &Recorded<'_>,
        new: &NewDataset,
        first: &Mutex<Option<Shape>>,
    ) -> Result<EpisodeMetadata> {
        let (episode, rescaled) = (&self.episodes[number], self.is_rescaled());
        let shape = Shape::of(recorded.spaces, rescaled);
        lock(first).get_or_insert_with(|| shape.clone()).merge(&shape, episode)?;
        let file = file_of(recorded, rescaled);
        let placement = &episode.subject.placement;
        let metadata = EpisodeMetadata {
            id: part * self.episodes.len() + number,
            total_steps: file.rewards.len(),
            seed: episode.seed,
            building: match model_path(episode) {
                Some(path) => format!("{}{}", path.display(), placement.control.suffix()),
                None => episode.subject.label(),
            },
            place: placement.place.map(|place| place.name.to_owned()),
            weather: placement.weather.as_deref().map(absolute),
            reading: ModelReading {
                keep_design_days: placement.keep_design_days,
                transition: placement.transition.as_deref().map(absolute),
            },
            policy: self.policies[part].name(),
            policy_identity: Some(self.policies[part].identity()),
            period: Some(episode.period.to_string()),
            episode_return: file.rewards.iter().sum(),
            corpus: None,
        };
        new.write(&metadata, &file)?;
        Ok(metadata)
    }

    /// Returns the type of all buildings, or the name of the only model file.
    fn building_type(&self) -> Result<String> {
        let mut types: Vec<&str> =
            self.episodes.iter().map(|episode| episode.subject.building_type()).collect();
        types.sort_unstable();
        types.dedup();
        match types[..] {
            ["", ..] if types.len() > 1 || self.buildings() > 1 => Err(Error::Invalid(
                "there is a model file among the buildings; collect one dataset for each".into(),
            )),
            [""] => Ok(self.episodes[0].subject.name.to_string()),
            [one] => Ok(one.to_owned()),
            _ => Err(Error::Invalid(format!(
                "the buildings are of the types {}; collect one dataset for each type",
                types.join(", ")
            ))),
        }
    }

    /// Returns the run periods in order.
    fn periods(&self) -> Vec<String> {
        let mut periods: Vec<String> = Vec::new();
        for episode in self.episodes {
            let period = episode.period.to_string();
            if !periods.contains(&period) {
                periods.push(period);
            }
        }
        periods
    }

    fn buildings(&self) -> usize {
        let mut names: Vec<String> =
            self.episodes.iter().map(|episode| episode.subject.name.to_string()).collect();
        names.sort_unstable();
        names.dedup();
        names.len()
    }
}

/// Runs episodes, which are given with their numbers, and passes the steps of each to `write`.
///
/// # Errors
/// The first error of `write`; [`Error::Invalid`] for a lost episode; errors from [`Evaluation::record`].
pub(super) fn record_each(
    episodes: &[(usize, &EpisodePlan)],
    policy: &dyn Policy,
    evaluation: &Evaluation<'_>,
    progress: &dyn Progress,
    write: &(dyn Fn(usize, &Recorded<'_>) -> Result<()> + Sync),
) -> Result<()> {
    progress.begin(&policy.name(), episodes.len(), episodes.iter().map(|(_, episode)| episode.days()).sum());
    let failure = Mutex::new(None);
    let recorded = evaluation.record(episodes, policy, progress, &|number, recorded| {
        let outcome = match recorded {
            Ok(recorded) => write(number, recorded),
            Err(lost) => {
                let own = episodes.iter().find(|(known, _)| *known == number);
                let name = own.map_or_else(|| number.to_string(), |(_, episode)| episode.to_string());
                Err(Error::Invalid(format!("{name} was lost: {lost}")))
            }
        };
        outcome.map_err(|error| {
            lock(&failure).get_or_insert(error);
            b2b_evaluate::Error::Interrupted
        })
    });
    recorded.map_err(|error| lock(&failure).take().unwrap_or_else(|| error.into()))
}

/// The spaces of a dataset: names, and the bounds of all of its buildings.
#[derive(Clone, Debug)]
struct Shape {
    observation_names: Vec<String>,
    observation: Vec<[f32; 2]>,
    action_names: Vec<String>,
    action: Vec<[f32; 2]>,
}

impl Shape {
    fn of(spaces: &Spaces, rescaled: bool) -> Self {
        let slots = spaces.observation.slots();
        let action = spaces.action.low().iter().zip(spaces.action.high());
        Self {
            observation_names: slots.iter().map(|slot| slot.name.clone()).collect(),
            observation: slots.iter().map(|slot| [slot.low as f32, slot.high as f32]).collect(),
            action_names: spaces.action.names().to_vec(),
            action: action
                .map(|(low, high)| if rescaled { [-1.0, 1.0] } else { [*low as f32, *high as f32] })
                .collect(),
        }
    }

    /// Widens the bounds to include another building's.
    fn merge(&mut self, other: &Self, episode: &EpisodePlan) -> Result<()> {
        let names = |shape: &Self| [shape.observation_names.clone(), shape.action_names.clone()].concat();
        if names(self) != names(other) {
            return Err(Error::Invalid(format!(
                "{} has other observations or actuators than an earlier building; collect one dataset for each building",
                episode.subject.name
            )));
        }
        for (bounds, other) in self.observation.iter_mut().zip(&other.observation) {
            *bounds = [bounds[0].min(other[0]), bounds[1].max(other[1])];
        }
        Ok(())
    }

    /// Returns the spaces of observation and action, as Minari writes them.
    fn boxes(&self) -> [Value; 2] {
        [&self.observation, &self.action].map(|bounds| box_space(bounds))
    }
}

/// Returns the space of a vector with these bounds, as Minari writes it.
pub(super) fn box_space(bounds: &[[f32; 2]]) -> Value {
    let side = |index: usize| bounds.iter().map(|each| each[index]).collect::<Vec<f32>>();
    json!({"type": "Box", "dtype": "float32", "shape": [bounds.len()], "low": side(0), "high": side(1)})
}

/// Returns the steps of a recorded episode, with actions in [-1, 1] if they are rescaled.
pub(super) fn file_of(recorded: &Recorded<'_>, rescaled: bool) -> EpisodeFile {
    let Recorded { spaces, first_observation, trajectory, .. } = recorded;
    let observations = first_observation.iter().chain(&trajectory.observations);
    EpisodeFile {
        observations: observations.map(|value| *value as f32).collect(),
        actions: match rescaled {
            true => unscaled(&trajectory.actions, spaces),
            false => trajectory.actions.iter().map(|value| *value as f32).collect(),
        },
        rewards: trajectory.penalties.iter().map(|[temperature, energy]| -(temperature + energy)).collect(),
        expert: Vec::new(),
    }
}

/// Returns actions, row by row, scaled from the bounds of each actuator to [-1, 1].
pub(super) fn unscaled(actions: &[f64], spaces: &Spaces) -> Vec<f32> {
    let bounds = spaces.action.low().iter().zip(spaces.action.high()).cycle();
    actions.iter().zip(bounds).map(|(value, (low, high))| unscale(*value, *low, *high) as f32).collect()
}

/// Returns the absolute path of the model file of an episode.
fn model_path(episode: &EpisodePlan) -> Option<PathBuf> {
    match &episode.subject.name {
        BuildingName::Model(path) => Some(absolute(path)),
        BuildingName::Id(_) | BuildingName::Type(_) => None,
    }
}

/// Returns an absolute path, so that a dataset can be used in any folder.
fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

/// Returns the specification from which Gymnasium makes the environment of an episode; `None` for a model that was read
/// in a way for which `make_env` has no argument.
fn spec(building_type: &str, episode: &EpisodePlan, rescaled: bool) -> Option<Value> {
    let placement = &episode.subject.placement;
    if placement.keep_design_days || placement.transition.is_some() || placement.allow_external {
        return None;
    }
    let EpisodePlan { subject, task, period, steps_per_hour, .. } = episode;
    let mut arguments = json!({
        "run_period": period.to_string(),
        "timesteps_per_hour": steps_per_hour,
        "task": task.to_text(),
        "rescale_action": rescaled,
    });
    match (&subject.name, model_path(episode)) {
        (_, Some(path)) => arguments["building_id"] = path.display().to_string().into(),
        (BuildingName::Id(id), None) => {
            arguments["building_type"] = building_type.into();
            arguments["building_id"] = id.to_string().into();
        }
        (_, None) => arguments["building_type"] = building_type.into(),
    }
    if let Some(place) = placement.place {
        arguments["place"] = place.name.into();
    }
    if placement.control != Control::default() {
        arguments["control"] = json!(placement.control);
    }
    if let Some(weather) = &placement.weather {
        arguments["weather"] = absolute(weather).display().to_string().into();
    }
    Some(json!({
        "id": format!("b2b/{building_type}-v0"),
        "entry_point": "building2building.env:BuildingEnv",
        "reward_threshold": null,
        "nondeterministic": false,
        "max_episode_steps": null,
        "order_enforce": false,
        "disable_env_checker": true,
        "kwargs": arguments,
        "additional_wrappers": [],
        "vector_entry_point": "building2building.vector:BuildingVectorEnv",
    }))
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use b2b_building::Period;
    use b2b_evaluate::Subject;

    use super::*;

    #[test]
    fn an_environment_of_a_model_file_is_made_from_its_path_and_its_weather() {
        let weather = Some("boston.epw".into());
        let placement = b2b_dataset::Placement { weather, ..b2b_dataset::Placement::default() };
        let subject = Subject { name: BuildingName::Model("office.idf".into()), placement };
        let task = "constant".parse().unwrap();
        let episode = EpisodePlan { subject, task, period: Period::WINTER, seed: 0, steps_per_hour: 12 };
        let made = spec("office", &episode, false).unwrap();
        let [path, weather] = ["office.idf", "boston.epw"].map(|file| json!(absolute(Path::new(file))));
        assert_eq!(made["kwargs"]["building_id"], path);
        assert_eq!((&made["kwargs"]["building_type"], &made["kwargs"]["weather"]), (&Value::Null, &weather));
        let mut kept = episode;
        kept.subject.placement.keep_design_days = true;
        assert_eq!(spec("office", &kept, false), None, "make_env sizes with the design days of the weather");
    }
}
