//! The configuration of a training run, as a TOML file or as presets with changes.

use std::path::Path;
use std::str::FromStr;

use b2b_agent::{Acting, Interface, ObservationForm};
use b2b_building::{BuildingType, RunPeriod};
use b2b_dataset::BuildingName;
use b2b_env::Task;
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use super::one_or_many;
use super::policy::Policy;
use super::suggestion::with_suggestion;
use crate::error::{Error, Result, at};
use crate::ppo::PpoConfig;
use crate::sac::SacConfig;

/// The presets by name: TOML files of what differs from the defaults.
const PRESETS: [(&str, &str); 3] = [
    ("graph", include_str!("../../data/graph.toml")),
    ("paper", include_str!("../../data/paper.toml")),
    ("residual", include_str!("../../data/residual.toml")),
];

/// A training algorithm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Algorithm {
    /// Proximal policy optimization: see [`crate::ppo`].
    #[default]
    Ppo,
    /// Soft actor-critic: see [`crate::sac`].
    Sac,
}

impl FromStr for Algorithm {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match text {
            "ppo" => Ok(Self::Ppo),
            "sac" => Ok(Self::Sac),
            _ => Err(format!("unknown algorithm `{text}`; expected ppo or sac")),
        }
    }
}

/// Which agent of a run its folder has in the end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Keep {
    /// The one with the best score in the evaluations during training.
    #[default]
    Best,
    /// The last one.
    Last,
}

/// The configuration of a training run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TrainConfig {
    /// Training buildings by name, in turn for the environments. Empty: those of `building_type` in the training split.
    pub buildings: Vec<String>,
    /// Building type whose training split every episode's building is drawn from, or a list of types, in turn for the
    /// environments. Empty: `buildings`.
    #[serde(with = "one_or_many")]
    pub building_type: Vec<String>,
    /// Episodes that an environment stays in a building that was drawn.
    pub building_episodes: u32,
    /// Task, such as `occupancy+energy0.5`.
    pub task: String,
    /// Run period: `winter`, `summer`, `full_year` or `MM-DD..MM-DD`.
    pub period: String,
    /// Zone time steps per hour, each one step.
    pub steps_per_hour: u32,
    /// Algorithm.
    pub algorithm: Algorithm,
    /// Kind of network: `{ kind = "flat" }` or `{ kind = "graph" }` with the options of [`GraphPolicy`](super::GraphPolicy).
    pub policy: Policy,
    /// Form of the agent's observations: `raw`, `roles` or `features`.
    pub observation: ObservationForm,
    /// How the agent acts: `{ kind = "direct" }` or `{ kind = "residual", authority = 0.5 }`.
    pub acting: Acting,
    /// Environment steps, all environments together.
    pub steps: u64,
    /// Random seed.
    pub seed: u64,
    /// Number of environments.
    pub environments: usize,
    /// Days of a training episode, which begins on one of `window_starts` days of the run period. 0: the whole run period.
    pub window_days: u32,
    /// Number of first days of training episodes.
    pub window_starts: u32,
    /// Whether rewards are divided by the mean penalty of the reactive controllers in the building, so that a mean reward of -1
    /// is the baseline's.
    pub scale_rewards: bool,
    /// Whether a reward has a part for every zone and one for energy, and each action is credited with the parts that it
    /// affects.
    pub credit_by_zone: bool,
    /// Correlation of the exploration noise between consecutive steps, from 0 to 1.
    pub noise_correlation: f32,
    /// Mean penalty with exploration noise, over that without, that the noise is chosen for when training begins: the most noise
    /// of which a short trial costs no more. 0: that of `ppo.initial_log_std`.
    pub noise_cost: f64,
    /// Exploration noise at the end of the run, as a share of that at its beginning: it falls exponentially in between, so that
    /// the agent ends at what is good without noise. 1: it is learned with the rest instead.
    pub final_noise: f64,
    /// Agent that the run's folder has in the end.
    pub keep: Keep,
    /// Evaluations during training.
    pub evaluation: EvaluationConfig,
    /// Steps between checkpoints; 0 for none but at the end.
    pub checkpoint_every: u64,
    /// Options of PPO.
    pub ppo: PpoConfig,
    /// Options of SAC.
    pub sac: SacConfig,
}

/// Evaluations during training: deterministic episodes on a window of the run period, in processes of their own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EvaluationConfig {
    /// Steps between evaluations; 0 for none.
    pub every: u64,
    /// Days of the window, in the middle of the run period.
    pub days: u32,
    /// Buildings to evaluate on, at most this many of the training buildings.
    pub buildings: usize,
}

impl Default for TrainConfig {
    fn default() -> Self {
        Self {
            buildings: Vec::new(),
            building_type: Vec::new(),
            building_episodes: 1,
            task: "constant".into(),
            period: "winter".into(),
            steps_per_hour: 12,
            algorithm: Algorithm::Ppo,
            policy: Policy::Flat,
            observation: ObservationForm::Features,
            acting: Acting::Direct,
            steps: 500_000,
            seed: 0,
            environments: 14,
            window_days: 0,
            window_starts: 1,
            scale_rewards: true,
            credit_by_zone: false,
            noise_correlation: 0.0,
            noise_cost: 0.0,
            final_noise: 1.0,
            keep: Keep::Best,
            evaluation: EvaluationConfig::default(),
            checkpoint_every: 100_000,
            ppo: PpoConfig::default(),
            sac: SacConfig::default(),
        }
    }
}

impl Default for EvaluationConfig {
    fn default() -> Self {
        Self { every: 50_000, days: 14, buildings: 4 }
    }
}

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
            let names: Vec<_> = Self::presets().collect();
            Error::Invalid(format!("unknown preset `{name}`; expected {}", names.join(" or ")))
        })?;
        Self::default().with_changes(text).map_err(Error::Invalid)
    }

    /// Returns the configuration with an algorithm, and without what is for another one.
    #[must_use]
    pub fn with_algorithm(self, algorithm: Algorithm) -> Self {
        match algorithm {
            Algorithm::Ppo => Self { algorithm, ..self },
            Algorithm::Sac => Self { algorithm, credit_by_zone: false, noise_cost: 0.0, ..self },
        }
    }

    /// Returns the configuration with the changes of a TOML text. A text may name a preset of its own first, with
    /// `preset = "paper"`.
    ///
    /// # Errors
    /// What is wrong with the text: a value of the wrong type, or an unknown key with a suggestion.
    pub fn with_changes(&self, text: &str) -> std::result::Result<Self, String> {
        self.with_table(toml::from_str(text).map_err(|error| error.to_string())?)
    }

    /// As [`TrainConfig::with_changes`], of a JSON object.
    ///
    /// # Errors
    /// [`Error::Invalid`] with what is wrong.
    pub fn with_json(&self, text: &str) -> Result<Self> {
        let changes = serde_json::from_str(text).map_err(|error| Error::Invalid(error.to_string()))?;
        self.with_table(changes).map_err(Error::Invalid)
    }

    fn with_table(&self, mut changes: Table) -> std::result::Result<Self, String> {
        let base = match changes.remove("preset") {
            Some(Value::String(name)) => Self::preset(&name).map_err(|error| error.to_string())?,
            Some(other) => return Err(format!("`preset` is {other}; expected a name")),
            None => self.clone(),
        };
        let algorithm = changes.get("algorithm").and_then(|name| name.as_str()?.parse().ok());
        let base = match algorithm {
            Some(algorithm) => base.with_algorithm(algorithm),
            None => base,
        };
        let mut all = Table::try_from(&base).map_err(|error| error.to_string())?;
        merge(&mut all, changes);
        Value::Table(all).try_into().map_err(|error: toml::de::Error| with_suggestion(error.message()))
    }

    /// Returns the configuration with the changes of a file.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::ConfigFile`] with what is wrong.
    pub fn with_file(&self, path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(at(path))?;
        self.with_changes(&text).map_err(|why| Error::ConfigFile { path: path.to_owned(), why })
    }

    /// Returns the configuration as a TOML text with every option.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("plain data always serializes")
    }

    /// Checks that the values go together.
    ///
    /// # Errors
    /// [`Error::Invalid`] for the first that does not, and those of the algorithm's own options.
    pub fn check(&self) -> Result<()> {
        self.ppo.check()?;
        self.sac.check()?;
        let days = self.run_period()?.days();
        self.named()?;
        self.task()?;
        let wrong = match () {
            () if self.environments == 0 => "`environments` is 0; expected at least 1".to_owned(),
            () if self.credit_by_zone && self.algorithm == Algorithm::Sac => {
                "`credit_by_zone` is for ppo; with sac it must be false".to_owned()
            }
            () if self.steps == 0 => "`steps` is 0; expected at least 1".to_owned(),
            () if self.window_days > days => {
                format!("`window_days` is {}; the run period has {days} days", self.window_days)
            }
            () if !(0.0..1.0).contains(&self.noise_correlation) => {
                format!("`noise_correlation` is {}; expected 0 to less than 1", self.noise_correlation)
            }
            () if self.noise_cost != 0.0 && !(self.noise_cost > 1.0 && self.noise_cost.is_finite()) => {
                format!("`noise_cost` is {}; expected more than 1, or 0 for none", self.noise_cost)
            }
            () if !(self.final_noise > 0.0 && self.final_noise <= 1.0) => {
                format!("`final_noise` is {}; expected more than 0, at most 1", self.final_noise)
            }
            () if self.noise_cost != 0.0 && self.algorithm == Algorithm::Sac => {
                "`noise_cost` is for ppo; with sac it must be 0".to_owned()
            }
            () if self.evaluation.every > 0 && self.evaluation.days == 0 => {
                "`evaluation.days` is 0; expected at least 1".to_owned()
            }
            () if self.buildings.is_empty() == self.building_type.is_empty() => {
                "expected either `buildings` or `building_type`".to_owned()
            }
            () if self.building_episodes == 0 => "`building_episodes` is 0; expected at least 1".to_owned(),
            () if self.policy == Policy::Flat && self.building_type.len() > 1 => {
                "several building types are for graph networks; choose the preset graph, or one type"
                    .to_owned()
            }
            () if self.fault_of_graph().is_some() => self.fault_of_graph().unwrap_or_default(),
            () => match self.acting {
                Acting::Residual { authority } if !(authority > 0.0 && authority <= 1.0) => {
                    format!("`authority` is {authority}; expected more than 0, at most 1")
                }
                _ => return self.building_types().map(|_| ()),
            },
        };
        Err(Error::Invalid(wrong))
    }

    /// Returns the task.
    ///
    /// # Errors
    /// [`Error::Env`].
    pub fn task(&self) -> Result<Task> {
        Ok(self.task.parse()?)
    }

    /// Returns the run period.
    ///
    /// # Errors
    /// [`Error::Invalid`].
    pub fn run_period(&self) -> Result<RunPeriod> {
        self.period.parse().map_err(|error: b2b_building::Error| Error::Invalid(error.to_string()))
    }

    /// Returns the names of the training buildings; empty for those of a type.
    ///
    /// # Errors
    /// [`Error::Building`].
    pub fn named(&self) -> Result<Vec<BuildingName>> {
        Ok(self.buildings.iter().map(|name| name.parse()).collect::<b2b_dataset::Result<_>>()?)
    }

    /// Returns the building types whose buildings are drawn; none for named buildings.
    ///
    /// # Errors
    /// [`Error::Invalid`].
    pub fn building_types(&self) -> Result<Vec<BuildingType>> {
        let parsed = |name: &String| {
            name.parse().map_err(|error: b2b_building::Error| Error::Invalid(error.to_string()))
        };
        self.building_type.iter().map(parsed).collect()
    }

    /// Returns what does not go together with graph networks, if something does not.
    fn fault_of_graph(&self) -> Option<String> {
        if self.policy == Policy::Flat {
            return None;
        }
        let excluded = [
            ("algorithm", self.algorithm != Algorithm::Ppo, "it must be ppo"),
            ("observation", self.observation == ObservationForm::Roles, "it must be raw or features"),
            ("credit_by_zone", self.credit_by_zone, "it must be false"),
        ];
        let wrong = excluded.into_iter().find(|(_, is_wrong, _)| *is_wrong);
        let wrong = wrong.map(|(name, _, remedy)| format!("`{name}` with graph networks: {remedy}"));
        wrong.or_else(|| self.policy.fault())
    }

    /// Returns what the agent observes and how it acts.
    pub fn interface(&self) -> Interface {
        Interface { observation: self.observation, acting: self.acting, nodes: self.policy.nodes() }
    }

    /// Returns the training buildings as a reader names them.
    pub fn buildings_text(&self) -> String {
        if self.building_type.is_empty() {
            self.buildings.join(", ")
        } else {
            format!("{} of the training split", self.building_type.join(", "))
        }
    }
}

/// Puts the values of one table over those of another. A table with a `kind` is replaced as a whole.
fn merge(base: &mut Table, changes: Table) {
    for (key, value) in changes {
        match (base.get_mut(&key), value) {
            (Some(Value::Table(into)), Value::Table(from)) if !from.contains_key("kind") => merge(into, from),
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_is_complete_and_valid() {
        for name in TrainConfig::presets() {
            let preset = TrainConfig::preset(name).unwrap();
            let named = TrainConfig { buildings: vec!["OfficeSmall-0042".into()], ..preset };
            named.check().unwrap();
            assert_eq!(TrainConfig::default().with_changes(&named.to_toml()).unwrap(), named);
        }
        let said = TrainConfig::preset("papper").unwrap_err().to_string();
        assert!(said.contains("unknown preset `papper`; expected graph or paper or residual"), "{said}");
    }

    #[test]
    fn the_preset_of_the_paper_has_the_numbers_of_its_table() {
        let TrainConfig { ppo, environments, acting, observation, .. } =
            TrainConfig::preset("paper").unwrap();
        assert_eq!((ppo.learning_rate, ppo.batch_size, ppo.n_steps, ppo.epochs), (5e-5, 336, 672, 5));
        assert_eq!((ppo.target_kl, ppo.gamma, ppo.gae_lambda), (Some(0.02), 0.98, 0.95));
        assert_eq!((ppo.clip_range, ppo.entropy_coefficient, ppo.value_coefficient), (0.2, 0.01, 0.5));
        assert_eq!((ppo.max_grad_norm, ppo.initial_log_std, environments), (0.5, -1.0, 14));
        assert_eq!((ppo.actor_hidden, ppo.critic_hidden), (vec![256, 256], vec![256, 256]));
        assert_eq!((acting, observation), (Acting::Direct, ObservationForm::Raw));
    }

    #[test]
    fn an_unknown_key_is_an_error_with_a_suggestion() {
        let base = TrainConfig::default();
        let said = base.with_changes("enviroments = 3").unwrap_err();
        assert!(
            said.contains("unknown field `enviroments`") && said.contains("did you mean `environments`?"),
            "{said}"
        );
        let said = base.with_changes("[ppo]\ngama = 0.9").unwrap_err();
        assert!(said.contains("did you mean `gamma`?"), "{said}");
        let said = base.with_changes("steps = \"many\"").unwrap_err();
        assert!(said.contains("many"), "{said}");
        let changed = base.with_changes("preset = \"paper\"\nseed = 7\n[ppo]\ngamma = 0.9").unwrap();
        assert_eq!((changed.seed, changed.ppo.gamma, changed.ppo.epochs), (7, 0.9, 5));
    }

    #[test]
    fn a_preset_with_sac_leaves_out_what_is_for_ppo() {
        let residual = TrainConfig::preset("residual").unwrap();
        let changes = "buildings = [\"OfficeSmall-0042\"]\nalgorithm = \"sac\"";
        let sac = residual.with_changes(changes).unwrap();
        sac.check().unwrap();
        assert_eq!(sac.algorithm, Algorithm::Sac);
        let error =
            residual.with_changes(&format!("{changes}\nnoise_cost = 2.0")).unwrap().check().unwrap_err();
        assert!(error.to_string().contains("noise_cost"), "{error}");
    }

    #[test]
    fn values_that_do_not_go_together_are_errors() {
        let valid = TrainConfig { buildings: vec!["OfficeSmall-0042".into()], ..TrainConfig::default() };
        let error = |config: TrainConfig| config.check().unwrap_err().to_string();
        assert!(error(TrainConfig { environments: 0, ..valid.clone() }).contains("environments"));
        assert!(error(TrainConfig { window_days: 100, ..valid.clone() }).contains("window_days"));
        assert!(error(TrainConfig { buildings: Vec::new(), ..valid.clone() }).contains("building_type"));
        assert!(error(TrainConfig { task: "warm".into(), ..valid.clone() }).contains("warm"));
        let acting = Acting::Residual { authority: 1.5 };
        assert!(error(TrainConfig { acting, ..valid }).contains("authority"));
    }
}
