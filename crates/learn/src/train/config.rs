//! The configuration of a training run, as a TOML file or as presets with changes.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use b2b_agent::{Acting, Interface, ObservationForm, ObservationOptions};
use b2b_building::{BuildingType, RunPeriod};
use b2b_climate::Place;
use b2b_dataset::{BuildingId, BuildingName, Placement, Row, Split};
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use super::one_or_many;
use super::policy::Policy;
use super::run::CONFIG;
use super::suggestion::with_suggestion;
use super::tasks::Tasks;
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
    /// Place of `buildings`, such as `Miami`. Empty: their own.
    pub place: String,
    /// Weather file (EPW) of `buildings` instead of a place. Empty: that of the place.
    pub weather: PathBuf,
    /// Whether a model file may run code and open files outside its folder. Only the caller sets it: no file may, and none has it.
    #[serde(skip_serializing)]
    pub allow_external: bool,
    /// Building type whose training split every episode's building is drawn from, or a list of types, in turn for the
    /// environments. Empty: `buildings`.
    #[serde(with = "one_or_many")]
    pub building_type: Vec<String>,
    /// ASHRAE 169 climate zones whose buildings are not drawn, such as `1A`, or `1` for 1A to 1C.
    pub excluded_climate_zones: Vec<String>,
    /// Episodes that an environment stays in a building that was drawn.
    pub building_episodes: u32,
    /// Benchmark problem, by name or JSON file, that the agent is for. It sets buildings, tasks, run period, steps per hour,
    /// steps and attributes, and none of them may go beyond its training side. Empty: none.
    pub problem: String,
    /// Task, such as `occupancy+energy0.5`, or several: every episode has another one. See [`Tasks`].
    pub task: Tasks,
    /// Run period: `winter`, `summer`, `full_year` or `MM-DD..MM-DD`.
    pub period: String,
    /// Zone time steps per hour, each one step.
    pub steps_per_hour: u32,
    /// Algorithm.
    pub algorithm: Algorithm,
    /// Kind of network: `{ kind = "flat" }` or `{ kind = "graph" }` with the options of [`GraphPolicy`](super::GraphPolicy).
    pub policy: Policy,
    /// What the agent observes: a form, `raw`, `roles` or `features`, or a table with `form`, `attributes` and `forecast`.
    pub observation: ObservationOptions,
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
    /// What a full stroke costs, averaged over the actuators, in the unit of the rewards that are learned from: with
    /// `scale_rewards`, the mean penalty per step of the reactive controllers. 0: travel is free. Scores do not count it.
    pub travel_cost: f32,
    /// Factor by which `travel_cost` grows after every evaluation in which actuators hunt: their travel is above its limit. 1: it does
    /// not grow.
    pub travel_cost_growth: f32,
    /// Whether a reward has a part for every zone and one for energy, and each action is credited with the parts that it
    /// affects.
    pub credit_by_zone: bool,
    /// Correlation of the exploration noise between consecutive steps, from 0 to 1.
    pub noise_correlation: f32,
    /// Whether environments come in pairs with the same episodes and opposite exploration noise, and the advantages of a pair are
    /// half its differences. Of an odd number of environments, the last one is alone.
    pub mirrored_noise: bool,
    /// Comfort penalty with exploration noise, over that without, that the noise is chosen for when training begins: the most
    /// noise that adds no more than the difference, or than a tenth of the penalty, to the penalty of a day in every environment.
    /// Without `credit_by_zone` all of the penalty counts as comfort. 0: the noise of `ppo.initial_log_std`.
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
    /// Whether training episodes leave these days out, where the run period has room for episodes of `window_days` beside them.
    pub held_out: bool,
    /// Buildings to evaluate on, at most this many of the training buildings.
    pub buildings: usize,
    /// Whether the agent is scored over the whole run period when training ends.
    pub whole_period: bool,
}

impl Default for TrainConfig {
    fn default() -> Self {
        Self {
            buildings: Vec::new(),
            place: String::new(),
            weather: PathBuf::new(),
            allow_external: false,
            building_type: Vec::new(),
            excluded_climate_zones: Vec::new(),
            building_episodes: 1,
            problem: String::new(),
            task: Tasks::default(),
            period: "winter".into(),
            steps_per_hour: 12,
            algorithm: Algorithm::Ppo,
            policy: Policy::Flat,
            observation: ObservationForm::Features.into(),
            acting: Acting::Direct,
            steps: 500_000,
            seed: 0,
            environments: 14,
            window_days: 0,
            window_starts: 1,
            scale_rewards: true,
            travel_cost: 0.0,
            travel_cost_growth: 1.0,
            credit_by_zone: false,
            noise_correlation: 0.0,
            mirrored_noise: false,
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
        Self { every: 50_000, days: 14, held_out: true, buildings: 4, whole_period: true }
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
            Algorithm::Sac => {
                let (credit_by_zone, mirrored_noise) = (false, false);
                Self { algorithm, credit_by_zone, mirrored_noise, noise_cost: 0.0, final_noise: 1.0, ..self }
            }
        }
    }

    /// Returns the configuration with the changes of a TOML text. A text may name a preset of its own first, with
    /// `preset = "paper"`.
    ///
    /// # Errors
    /// What is wrong with the text: a value of the wrong type, or an unknown key with a suggestion.
    pub fn with_changes(&self, text: &str) -> std::result::Result<Self, String> {
        self.with_untrusted(toml::from_str(text).map_err(|error| error.to_string())?)
    }

    /// As [`TrainConfig::with_changes`], of a JSON object with the arguments of the caller, who may set `allow_external`.
    ///
    /// # Errors
    /// [`Error::Invalid`] with what is wrong.
    pub fn with_json(&self, text: &str) -> Result<Self> {
        let changes = serde_json::from_str(text).map_err(|error| Error::Invalid(error.to_string()))?;
        self.with_table(changes).map_err(Error::Invalid)
    }

    /// As [`TrainConfig::with_table`], of a file, which cannot permit anything.
    fn with_untrusted(&self, changes: Table) -> std::result::Result<Self, String> {
        match changes.get("allow_external") {
            None | Some(Value::Boolean(false)) => self.with_table(changes),
            Some(_) => Err("`allow_external` cannot be set in a file; remove it, and pass --allow-external \
                            (allow_external=True in Python) if you trust the author of the model"
                .to_owned()),
        }
    }

    fn with_table(&self, mut changes: Table) -> std::result::Result<Self, String> {
        let said = |error: Error| error.to_string();
        let (base, problem) = match changes.remove("preset") {
            // A preset is for no problem.
            Some(Value::String(name)) => (Self::preset(&name).map_err(said)?, self.problem.clone()),
            Some(other) => return Err(format!("`preset` is {other}; expected a name")),
            None => (self.clone(), String::new()),
        };
        let problem = changes.get("problem").and_then(Value::as_str).unwrap_or(&problem);
        let base = if problem.is_empty() {
            base
        } else {
            // Whether a problem has an agent of this kind depends on its network.
            let policy = changes.get("policy").cloned().map_or(Ok(base.policy.clone()), Value::try_into);
            let policy = policy.map_err(|error: toml::de::Error| with_suggestion(error.message()))?;
            Self { policy, ..base }.with_problem(problem).map_err(said)?
        };
        let algorithm = changes.get("algorithm").and_then(|name| name.as_str()?.parse().ok());
        let base = match algorithm {
            Some(algorithm) => base.with_algorithm(algorithm),
            None => base,
        };
        let mut all = Table::try_from(&base).map_err(|error| error.to_string())?;
        all.insert("allow_external".to_owned(), self.allow_external.into());
        merge(&mut all, changes);
        Value::Table(all).try_into().map_err(|error: toml::de::Error| with_suggestion(error.message()))
    }

    /// Returns the configuration with the changes of a file.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::ConfigFile`] with what is wrong.
    pub fn with_file(&self, path: &Path) -> Result<Self> {
        self.with_changes_of_file(path, |_| {})
    }

    /// As [`TrainConfig::with_file`], without the preset that the file names.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::ConfigFile`] with what is wrong.
    pub fn with_options_of_file(&self, path: &Path) -> Result<Self> {
        self.with_changes_of_file(path, |changes| drop(changes.remove("preset")))
    }

    fn with_changes_of_file(&self, path: &Path, edit: impl FnOnce(&mut Table)) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(at(path))?;
        let changes = toml::from_str(&text).map_err(|error| error.to_string());
        let changed = changes.and_then(|mut changes: Table| {
            edit(&mut changes);
            self.with_untrusted(changes)
        });
        changed.map_err(|why| Error::ConfigFile { path: path.to_owned(), why })
    }

    /// Returns the configuration of a run, from its folder, without `allow_external`.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::ConfigFile`] with what is wrong.
    pub fn of_run(folder: &Path) -> Result<Self> {
        let path = folder.join(CONFIG);
        let text = std::fs::read_to_string(&path).map_err(at(&path))?;
        // It has every option, also those that its problem set.
        let why = |error: toml::de::Error| with_suggestion(error.message());
        let config: Self =
            toml::from_str(&text).map_err(|error| Error::ConfigFile { path, why: why(error) })?;
        Ok(Self { allow_external: false, ..config })
    }

    /// Returns the configuration as a TOML text with every option.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("plain data always serializes")
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

    /// Returns the number of environments that have episodes of their own: with mirrored noise, pairs share theirs.
    pub(super) fn distinct_environments(&self) -> usize {
        if self.mirrored_noise { self.environments.div_ceil(2) } else { self.environments }
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

    /// Returns the buildings of a type that are drawn: its training split but for the climate zones that are excluded.
    pub(super) fn drawn(&self, building_type: BuildingType) -> impl Iterator<Item = BuildingId> {
        let is_excluded =
            |row: &Row| self.excluded_climate_zones.iter().any(|zone| row.is_in_climate_zone(zone));
        let rows = b2b_dataset::rows(building_type).iter();
        rows.filter(move |row| row.split == Split::Train && !is_excluded(row)).map(|row| row.id)
    }

    /// Returns what does not go together with graph networks, if something does not.
    pub(super) fn fault_of_graph(&self) -> Option<String> {
        if self.policy == Policy::Flat {
            return None;
        }
        let excluded = [
            ("algorithm", self.algorithm != Algorithm::Ppo, "it must be ppo"),
            ("observation", self.observation.form == ObservationForm::Roles, "it must be raw or features"),
            ("observation.attributes", self.observation.attributes, "use `policy.attributes`"),
            ("observation.forecast", self.observation.forecast > 0, "it must be 0"),
        ];
        let wrong = excluded.into_iter().find(|(_, is_wrong, _)| *is_wrong);
        let wrong = wrong.map(|(name, _, remedy)| format!("`{name}` with graph networks: {remedy}"));
        wrong.or_else(|| self.policy.fault())
    }

    /// Returns what the agent observes and how it acts.
    pub fn interface(&self) -> Interface {
        Interface { observation: self.observation, acting: self.acting, nodes: self.policy.nodes() }
    }

    /// Returns the site of `buildings`.
    ///
    /// # Errors
    /// [`Error::Invalid`] for an unknown place.
    pub fn placement(&self) -> Result<Placement> {
        let find = |name| Place::find(name).map_err(|error| Error::Invalid(error.to_string()));
        let place = (!self.place.is_empty()).then(|| find(&self.place)).transpose()?;
        let weather = (!self.weather.as_os_str().is_empty()).then(|| self.weather.clone());
        Ok(Placement { place, weather, allow_external: self.allow_external })
    }

    /// Returns the training buildings as a reader names them.
    pub fn buildings_text(&self) -> String {
        if !self.building_type.is_empty() {
            let types = self.building_type.join(", ");
            let excluded = match &self.excluded_climate_zones[..] {
                [] => String::new(),
                zones => format!(" outside of the climate zones {}", zones.join(", ")),
            };
            return format!("{types} of the training split{excluded}");
        }
        let site = match self.weather.file_stem() {
            Some(weather) => format!(" in {}", weather.display()),
            None if self.place.is_empty() => String::new(),
            None => format!(" in {}", self.place),
        };
        // A model is named by its file, not by its path.
        let name = |text: &String| text.parse().map_or(text.clone(), |name: BuildingName| name.to_string());
        format!("{}{site}", self.buildings.iter().map(name).collect::<Vec<_>>().join(", "))
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
    fn a_preset_of_the_command_line_precedes_that_of_a_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mine.toml");
        std::fs::write(&path, "preset = 'residual'\nseed = 7").unwrap();
        let paper = TrainConfig::preset("paper").unwrap();
        assert_eq!(paper.with_options_of_file(&path).unwrap(), TrainConfig { seed: 7, ..paper.clone() });
        let residual = TrainConfig::preset("residual").unwrap();
        assert_eq!(paper.with_file(&path).unwrap(), TrainConfig { seed: 7, ..residual });
    }

    #[test]
    fn only_the_caller_permits_a_model_to_run_code() {
        let allowed = TrainConfig::default().with_json(r#"{"allow_external": true}"#).unwrap();
        assert!(allowed.allow_external && allowed.with_changes("seed = 7").unwrap().allow_external);
        assert!(!allowed.to_toml().contains("allow_external"));
        TrainConfig::default().with_changes("allow_external = false").unwrap();
        let said = TrainConfig::default().with_changes("allow_external = true").unwrap_err();
        assert!(said.contains("pass --allow-external"), "{said}");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("config.toml");
        std::fs::write(&path, "allow_external = true").unwrap();
        for said in
            [TrainConfig::default().with_file(&path), TrainConfig::default().with_options_of_file(&path)]
        {
            let said = said.unwrap_err().to_string();
            assert!(said.contains("pass --allow-external"), "{said}");
        }
        assert!(!TrainConfig::of_run(folder.path()).unwrap().allow_external);
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
        assert_eq!((acting, observation), (Acting::Direct, ObservationForm::Raw.into()));
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
    fn buildings_of_excluded_climate_zones_are_not_drawn() {
        let all = TrainConfig { building_type: vec!["OfficeSmall".into()], ..TrainConfig::default() };
        let some = TrainConfig { excluded_climate_zones: vec!["5B".into(), "8".into()], ..all.clone() };
        let drawn = |config: &TrainConfig| config.drawn(BuildingType::OfficeSmall).collect::<Vec<_>>();
        let zone = |id: &BuildingId| b2b_dataset::row(*id).building.location().ashrae_zone().unwrap();
        assert_eq!(drawn(&all).len(), 900);
        assert!(drawn(&all).iter().any(|id| zone(id) == "5B"));
        assert!(drawn(&some).iter().all(|id| !["5B", "8"].contains(&zone(id))));
        assert!(drawn(&some).iter().any(|id| zone(id) == "5A"));
        assert_eq!(
            some.buildings_text(),
            "OfficeSmall of the training split outside of the climate zones 5B, 8"
        );
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
}
