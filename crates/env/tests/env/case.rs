//! A prepared building with its engine and weather.
#![allow(dead_code, reason = "every test file takes what it needs")]

use std::path::PathBuf;
use std::sync::Arc;

use b2b_building::hvac::{KINDS, Kind, Unsupported};
use b2b_building::{BuildingType, Class, Controls, Model, PreparedBuilding, import};
use b2b_climate::{Place, Site};
use b2b_dataset::Preparation;
use b2b_energyplus::Library;
use b2b_energyplus::install::{Engine, Quiet};
use b2b_env::{ActionSpace, Env, EpisodeConfig, Task, Term, Trajectory};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const CHICAGO: &str = "USA_IL_Chicago-OHare.Intl.AP.725300_TMY3.epw";

/// A building at a place.
pub struct Case {
    pub library: Library,
    pub building: Arc<PreparedBuilding>,
    pub weather: PathBuf,
}

impl Case {
    pub fn at_home(building_type: BuildingType) -> Self {
        Self::at(building_type, building_type.home())
    }

    pub fn at(building_type: BuildingType, place: &str) -> Self {
        let engine = Engine::ensure(&mut Quiet).unwrap();
        let library = Library::load(&engine.library).unwrap();
        let weather = Place::find(place).unwrap().epw(&mut Quiet).unwrap();
        let site = Site::read(&weather).unwrap();
        let model = b2b_dataset::archetype::base_model(building_type, &engine, &library, &site).unwrap();
        Self::prepare(building_type.name(), model, false, weather, library)
    }

    /// A model shipped with the engine, imported as a user's model, under weather shipped with the engine.
    pub fn imported(model: &str, weather: &str) -> Self {
        Self::imported_after(model, weather, |_| ())
    }

    /// Like [`Case::imported`], after a change to the model.
    pub fn imported_after(model: &str, weather: &str, change: impl FnOnce(&mut Model)) -> Self {
        Self::imported_with(&KINDS, model, weather, change)
    }

    /// Like [`Case::imported_after`], with these kinds of systems.
    pub fn imported_with(
        kinds: &[Kind],
        model: &str,
        weather: &str,
        change: impl FnOnce(&mut Model),
    ) -> Self {
        let engine = Engine::ensure(&mut Quiet).unwrap();
        let library = Library::load(&engine.library).unwrap();
        let models = engine.models.unwrap();
        let weather = models.parent().unwrap().join("weather").join(weather);
        let mut read = import::read(&models.join(model), &library, false).unwrap();
        change(&mut read);
        let left_alone = Unsupported::LeftAlone;
        let building = PreparedBuilding::with_kinds(model, read, &weather, &library, kinds, left_alone);
        Self { library, building: Arc::new(building.unwrap()), weather }
    }

    /// A building type at its home, whose zones are controlled through their setpoints.
    pub fn under_setpoints(building_type: BuildingType) -> Self {
        let engine = Engine::ensure(&mut Quiet).unwrap();
        let library = Library::load(&engine.library).unwrap();
        let weather = Place::find(building_type.home()).unwrap().epw(&mut Quiet).unwrap();
        let site = Site::read(&weather).unwrap();
        let model = b2b_dataset::archetype::base_model(building_type, &engine, &library, &site).unwrap();
        let class = Some(Class::new(building_type, None));
        let preparation = Preparation::new(building_type.name(), model);
        let preparation = Preparation { class, controls: Controls::Setpoints, ..preparation };
        Self::of(preparation, weather, library)
    }

    /// A user's model in Chicago, under these controls.
    pub fn of_user(model: &serde_json::Value, controls: Controls) -> Self {
        let engine = Engine::ensure(&mut Quiet).unwrap();
        let weather = engine.models.unwrap().parent().unwrap().join("weather").join(CHICAGO);
        Self::of_user_in(model, controls, weather)
    }

    /// A user's model in a weather file, under these controls.
    pub fn of_user_in(model: &serde_json::Value, controls: Controls, weather: PathBuf) -> Self {
        let engine = Engine::ensure(&mut Quiet).unwrap();
        let library = Library::load(&engine.library).unwrap();
        let model = Model::from_epjson(&model.to_string(), "user.epJSON".as_ref()).unwrap();
        let preparation = Preparation { own: true, controls, ..Preparation::new("user", model) };
        Self::of(preparation, weather, library)
    }

    fn prepare(name: &str, model: Model, own: bool, weather: PathBuf, library: Library) -> Self {
        Self::of(Preparation { own, ..Preparation::new(name, model) }, weather, library)
    }

    /// Prepares a model, or takes it from the cache, where the tests of other processes find it.
    fn of(preparation: Preparation, weather: PathBuf, library: Library) -> Self {
        let building = preparation.run(&weather, &library).unwrap();
        Self { library, building: Arc::new(building), weather }
    }

    /// Creates an environment over days such as `01-01..01-07`, at 12 steps per hour.
    pub fn env(&self, period: &str) -> Env {
        self.env_for(period, "constant")
    }

    /// Like [`Case::env`], for a task given as text.
    pub fn env_for(&self, period: &str, task: &str) -> Env {
        self.env_with(period, task.parse().unwrap())
    }

    pub fn env_with(&self, period: &str, task: Task) -> Env {
        self.try_env(period, task).unwrap()
    }

    pub fn try_env(&self, period: &str, task: Task) -> b2b_env::Result<Env> {
        let (weather, period) = (self.weather.clone(), period.parse().unwrap());
        let episode = EpisodeConfig { weather, period, steps_per_hour: 12, task };
        Env::new(self.library.clone(), Arc::clone(&self.building), episode)
    }
}

/// Uniform random actions, the same for the same seed.
pub struct Dice {
    random: ChaCha8Rng,
    low: Vec<f64>,
    high: Vec<f64>,
    action: Vec<f64>,
}

impl Dice {
    pub fn new(space: &ActionSpace, seed: u64) -> Self {
        Self {
            random: ChaCha8Rng::seed_from_u64(seed),
            low: space.low().to_vec(),
            high: space.high().to_vec(),
            action: vec![0.0; space.len()],
        }
    }

    pub fn roll(&mut self) -> &[f64] {
        for ((value, low), high) in self.action.iter_mut().zip(&self.low).zip(&self.high) {
            *value = self.random.random_range(*low..=*high);
        }
        &self.action
    }
}

/// An episode under random actions, observed step by step.
pub fn random_episode(env: &mut Env, seed: u64) -> Trajectory {
    random_episode_from(env, seed).1
}

/// Like [`random_episode`], with the observation before the first step.
pub fn random_episode_from(env: &mut Env, seed: u64) -> (Vec<f64>, Trajectory) {
    let mut dice = Dice::new(env.action_space(), seed);
    let mut trajectory = Trajectory::for_episode(env.spaces());
    let first = env.reset().unwrap().to_vec();
    loop {
        let step = env.step(dice.roll()).unwrap();
        trajectory.push(&step);
        if step.truncated {
            return (first, trajectory);
        }
    }
}

/// Asserts that the energy of an episode is what the engine's meters say.
pub fn energy_is_the_engines(env: &Env) {
    let meters = env.engine_meters().unwrap();
    for (ours, engine) in
        [Term::Electricity, Term::Gas].map(|term| env.metrics().total(term)).into_iter().zip(meters)
    {
        assert!((ours - engine).abs() <= 1e-9 * engine, "{ours} Wh/m², the engine says {engine}");
    }
}
