//! Behavior cloning (Pomerleau 1991): an agent that imitates the actions of a dataset, by least squares.

use std::collections::BTreeSet;
use std::sync::Arc;

use b2b_agent::network::{Activation, Actor, Distribution, Mlp, Shape};
use b2b_agent::{Acting, AgentInfo, FORMAT, Interface, ObservationOptions, Pilot, TrainingInfo};
use b2b_control::Versions;
use b2b_env::{ActionSpace, Spaces, unscale};

use super::dataset::{CorpusEpisode, Dataset, EpisodeMetadata};
use super::episodes::EpisodeFile;
use crate::nn::{Adam, InitialGains, Pass, orthogonal};
use crate::random::RandomStream;
use crate::{Error, Result};

/// Gains of the initial weights.
const GAINS: InitialGains = InitialGains { hidden: std::f32::consts::SQRT_2, last: 0.01 };
/// ε of Adam.
const EPSILON: f32 = 1e-8;
/// Log standard deviation for further training.
const LOG_STD: f32 = -2.0;
/// The last 1/`HELD_OUT` of every episode is held out.
const HELD_OUT: usize = 10;

/// Steps whose errors are computed at a time.
const CHUNK: usize = 4096;

/// Options of cloning.
#[derive(Clone, Debug, PartialEq)]
pub struct CloneConfig {
    /// Type of the buildings to learn from, in a corpus of several.
    pub building_type: Option<String>,
    /// Task of the episodes to learn from, in a corpus of several.
    pub task: Option<String>,
    /// Observation of the agent.
    pub observation: ObservationOptions,
    /// Widths of the hidden layers.
    pub hidden: Vec<usize>,
    /// Steps of the optimizer.
    pub updates: usize,
    /// Recorded steps in each update.
    pub batch_size: usize,
    /// Learning rate, which falls linearly to 0.
    pub learning_rate: f64,
    /// Random seed.
    pub seed: u64,
}

/// A cloned policy.
#[derive(Clone, Debug)]
pub struct Cloned {
    /// Description of the agent.
    pub info: AgentInfo,
    /// Its network.
    pub actor: Actor,
    /// Root mean square error of the actions, as a share of half their range: over the training steps, and over the
    /// last tenth of every episode, which is held out.
    pub errors: [f64; 2],
}

/// Learns the actions of a dataset. `spaces` finds the spaces of an episode, whose building must still have its model;
/// `progress` is called with the number of updates so far, and returns `false` to stop.
///
/// # Errors
/// [`Error::Interrupted`] if `progress` returns `false`; [`Error::Invalid`] for several types or tasks, for buildings
/// whose observations or actuators differ or do not match the recorded ones, and for no episode or step to learn from;
/// errors from [`Dataset::read`], [`Pilot::new`] and `spaces`.
pub fn clone_policy(
    dataset: &Dataset,
    config: &CloneConfig,
    spaces: &mut dyn FnMut(&EpisodeMetadata) -> Result<Arc<Spaces>>,
    progress: &mut dyn FnMut(usize) -> bool,
) -> Result<Cloned> {
    let interface = Interface { observation: config.observation, acting: Acting::Direct, nodes: None };
    let (mut learned, mut held_out) = (Samples::default(), Samples::default());
    let mut known: Option<(Vec<String>, Arc<Spaces>)> = None;
    let selected = config.selected(dataset)?;
    for (number, episode) in selected.iter().copied() {
        let spaces = spaces(episode)?;
        let pilot = Pilot::new(interface, &spaces)?;
        let names = [pilot.observation().names(), spaces.action.names().to_vec()].concat();
        if names != known.get_or_insert_with(|| (names.clone(), Arc::clone(&spaces))).0 {
            return Err(Error::Invalid(format!(
                "{} has other observations or actuators than {}; with the observation `roles` all houses have the same, \
                 or collect one dataset for each building",
                episode.building, selected[0].1.building
            )));
        }
        let file = dataset.read(number)?;
        check(&file, &spaces, episode)?;
        add(file, pilot, &spaces.action, dataset.contents.rescaled, [&mut learned, &mut held_out]);
    }
    let Some((_, spaces)) = known.filter(|_| !learned.actions.is_empty()) else {
        return Err(Error::Invalid("the dataset has no steps".into()));
    };
    let pilot = Pilot::new(interface, &spaces)?;
    let (inputs, outputs) = pilot.widths();
    let shape = Mlp::new(inputs, &config.hidden, outputs, Activation::Tanh);
    let parameters = fit(&shape, &learned, config, progress)?;
    let errors = [&learned, &held_out].map(|samples| samples.error(&shape, &parameters));
    let distribution = Distribution::Gaussian { log_std: vec![LOG_STD; outputs] };
    let actor = Actor { shape: Shape::Mlp(shape), parameters, distribution };
    let info = AgentInfo {
        format: FORMAT,
        interface,
        slots: pilot.observation().names(),
        actuators: spaces.action.names().to_vec(),
        node_types: Vec::new(),
        network: actor.shape.clone(),
        memory_episodes: None,
        distribution: actor.distribution.clone(),
        task: spaces.episode.task.clone(),
        training: training(&selected, dataset, config),
        weights: String::new(),
    };
    Ok(Cloned { info, actor, errors })
}

impl CloneConfig {
    /// Returns the episodes to learn from, with their numbers.
    fn selected<'a>(&self, dataset: &'a Dataset) -> Result<Vec<(usize, &'a EpisodeMetadata)>> {
        let is_or = |wanted: &Option<String>, own: &str| wanted.as_ref().is_none_or(|wanted| wanted == own);
        let is_selected = |(_, episode): &(usize, &EpisodeMetadata)| match &episode.corpus {
            // Without actuators there is nothing to imitate.
            Some(of) => {
                of.action_width > 0
                    && is_or(&self.building_type, &of.building_type)
                    && is_or(&self.task, &of.task)
            }
            None => {
                is_or(&self.building_type, &dataset.contents.building_type)
                    && is_or(&self.task, &dataset.contents.task)
            }
        };
        let selected: Vec<_> = dataset.episodes.iter().enumerate().filter(is_selected).collect();
        let types = different(&selected, |of| &of.building_type);
        let tasks = different(&selected, |of| &of.task);
        for (option, found) in [("type", types), ("task", tasks)] {
            if found.len() > 1 {
                return Err(Error::Invalid(format!(
                    "the dataset has episodes of {}; choose one with --{option}",
                    found.join(", ")
                )));
            }
        }
        if selected.is_empty() {
            let wanted = [&self.building_type, &self.task].map(|it| it.as_deref().unwrap_or("any"));
            let all: Vec<_> = dataset.episodes.iter().enumerate().collect();
            let contents = &dataset.contents;
            let there = match &all[..] {
                [(_, EpisodeMetadata { corpus: Some(_), .. }), ..] => {
                    [different(&all, |of| &of.building_type), different(&all, |of| &of.task)]
                        .map(|each| each.join(", "))
                }
                _ => [contents.building_type.clone(), contents.task.clone()],
            };
            return Err(Error::Invalid(format!(
                "the dataset has no episode with actions of the type {} under the task {}; it has {} under {}",
                wanted[0], wanted[1], there[0], there[1]
            )));
        }
        Ok(selected)
    }
}

/// Returns the different values among episodes of a corpus.
fn different<'a>(
    selected: &[(usize, &'a EpisodeMetadata)],
    value: fn(&CorpusEpisode) -> &str,
) -> Vec<&'a str> {
    let values = selected.iter().filter_map(|(_, episode)| episode.corpus.as_ref()).map(value);
    values.collect::<BTreeSet<_>>().into_iter().collect()
}

fn training(episodes: &[(usize, &EpisodeMetadata)], dataset: &Dataset, config: &CloneConfig) -> TrainingInfo {
    let mut buildings: Vec<&str> = Vec::new();
    for (_, episode) in episodes {
        if !buildings.contains(&episode.building.as_str()) {
            buildings.push(&episode.building);
        }
    }
    let versions = dataset.contents.versions.clone().unwrap_or_else(Versions::current);
    let Versions { package, generator, engine, .. } = versions;
    TrainingInfo {
        algorithm: "behavior cloning".into(),
        buildings: buildings.join(", "),
        period: dataset.contents.period.clone(),
        steps_per_hour: dataset.contents.steps_per_hour,
        steps: episodes.iter().map(|(_, episode)| episode.total_steps as u64).sum(),
        seed: config.seed,
        package,
        generator,
        engine,
        ..TrainingInfo::default()
    }
}

/// Checks that an episode has the widths of its building.
fn check(file: &EpisodeFile, spaces: &Spaces, episode: &EpisodeMetadata) -> Result<()> {
    let steps = episode.total_steps;
    let (observations, actions) = (spaces.observation.len(), spaces.action.len());
    if file.observations.len() == (steps + 1) * observations && file.actions.len() == steps * actions {
        return Ok(());
    }
    Err(Error::Invalid(format!(
        "episode {} does not have {observations} observations and {actions} actions for each of {steps} steps, as {} has; \
         collect the dataset again",
        episode.id, episode.building
    )))
}

/// Adds the steps of an episode to the training samples, and its end to the held-out ones.
fn add(
    file: EpisodeFile,
    mut pilot: Pilot,
    space: &ActionSpace,
    rescaled: bool,
    [learned, held_out]: [&mut Samples; 2],
) {
    let (inputs, outputs) = pilot.widths();
    let width = file.observations.len() / (file.rewards.len() + 1);
    let steps = file.rewards.len();
    pilot.reset();
    // In a corpus, the agent learns the expert's actions, not the recorded ones. The previous action that it observes
    // is the expert's too, because it will be its own when it acts.
    let targets = if file.expert.is_empty() { &file.actions } else { &file.expert };
    let rows = file.observations.chunks_exact(width).zip(targets.chunks_exact(outputs));
    for (step, (observation, target)) in rows.enumerate() {
        let observation: Vec<f64> = observation.iter().map(|value| f64::from(*value)).collect();
        let bounds = space.low().iter().zip(space.high());
        let scaled = target.iter().zip(bounds).map(|(value, (low, high))| match rescaled {
            true => *value,
            false => unscale(f64::from(*value), *low, *high) as f32,
        });
        let scaled: Vec<f32> = scaled.map(|value| value.clamp(-1.0, 1.0)).collect();
        let samples = if step >= steps - steps / HELD_OUT { &mut *held_out } else { &mut *learned };
        samples.widths = (inputs, outputs);
        samples.observations.extend_from_slice(pilot.observe(&observation));
        samples.actions.extend_from_slice(&scaled);
        pilot.act(&scaled);
    }
}

/// Observations of the agent and the actions of the dataset.
#[derive(Default)]
struct Samples {
    widths: (usize, usize),
    observations: Vec<f32>,
    actions: Vec<f32>,
}

impl Samples {
    fn len(&self) -> usize {
        self.actions.len() / self.widths.1.max(1)
    }

    /// Returns the root mean square of the errors; NaN without samples.
    fn error(&self, shape: &Mlp, parameters: &[f32]) -> f64 {
        let (inputs, outputs) = self.widths;
        let mut pass = Pass::new(shape);
        let mut squares = 0.0;
        let chunks = self.observations.chunks(CHUNK * inputs).zip(self.actions.chunks(CHUNK * outputs));
        for (observations, actions) in chunks {
            let predicted = pass.forward(parameters, observations, actions.len() / outputs);
            let errors = predicted.iter().zip(actions);
            squares += errors.map(|(output, action)| f64::from(output - action).powi(2)).sum::<f64>();
        }
        (squares / self.actions.len() as f64).sqrt()
    }
}

/// Minimizes the mean square of the errors and returns the parameters.
fn fit(
    shape: &Mlp,
    samples: &Samples,
    config: &CloneConfig,
    progress: &mut dyn FnMut(usize) -> bool,
) -> Result<Vec<f32>> {
    let mut random = RandomStream::new(config.seed, 0);
    let mut parameters = orthogonal(shape, GAINS, &mut random);
    let (inputs, outputs) = samples.widths;
    let rows = config.batch_size.min(samples.len());
    let (mut pass, mut adam) = (Pass::new(shape), Adam::new(parameters.len(), EPSILON));
    let (mut observations, mut actions) = (vec![0.0; rows * inputs], vec![0.0; rows * outputs]);
    let mut gradients = vec![0.0; parameters.len()];
    for update in 0..config.updates {
        for row in 0..rows {
            let sample = random.below(samples.len());
            observations[row * inputs..][..inputs]
                .copy_from_slice(&samples.observations[sample * inputs..][..inputs]);
            actions[row * outputs..][..outputs]
                .copy_from_slice(&samples.actions[sample * outputs..][..outputs]);
        }
        let errors = pass.forward(&parameters, &observations, rows).iter().zip(&actions);
        let scale = 2.0 / actions.len() as f32;
        let of_outputs: Vec<f32> = errors.map(|(output, action)| scale * (output - action)).collect();
        gradients.fill(0.0);
        pass.backward(&parameters, &observations, &of_outputs, Some(&mut gradients), None);
        let left = 1.0 - update as f64 / config.updates as f64;
        adam.step(&mut parameters, &gradients, config.learning_rate * left);
        if !progress(update + 1) {
            return Err(Error::Interrupted);
        }
    }
    Ok(parameters)
}

#[cfg(test)]
mod tests {
    use b2b_agent::ObservationForm;

    use super::*;

    #[test]
    fn a_linear_policy_is_found_again() {
        let mut random = RandomStream::new(3, 0);
        let mut samples = Samples { widths: (3, 2), ..Samples::default() };
        for _ in 0..2000 {
            let row = [0, 1, 2].map(|_| 0.5 * random.normal() as f32);
            samples.observations.extend(row);
            samples.actions.extend([0.4 * row[0] - 0.2 * row[1], 0.3 * row[2] + 0.1]);
        }
        let config = CloneConfig {
            building_type: None,
            task: None,
            observation: ObservationForm::Raw.into(),
            hidden: vec![32],
            updates: 2000,
            batch_size: 64,
            learning_rate: 3e-3,
            seed: 0,
        };
        let shape = Mlp::new(3, &config.hidden, 2, Activation::Tanh);
        let mut updates = 0;
        let mut count = |update| {
            updates = update;
            true
        };
        let parameters = fit(&shape, &samples, &config, &mut count).unwrap();
        let error = samples.error(&shape, &parameters);
        assert!(updates == 2000 && error < 0.01, "{error}");
        assert_eq!(parameters, fit(&shape, &samples, &config, &mut |_| true).unwrap());
        assert!(matches!(fit(&shape, &samples, &config, &mut |_| false), Err(Error::Interrupted)));
    }
}
