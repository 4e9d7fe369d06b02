//! Houses drawn from the Québec stock, under the reactive controller in EnergyPlus.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use b2b_building::{PreparedBuilding, RunPeriod};
use b2b_climate::{Location, Region, Site};
use b2b_control::{Controller, Reactive, ReactiveParameters};
use b2b_dataset::Preparation;
use b2b_dataset::house::{DIMENSIONS, Foundation, Heater, Heating, HouseSample, house};
use b2b_energyplus::install::{Cache, Engine, Quiet};
use b2b_energyplus::{Level, Library};
use b2b_env::{Env, EpisodeConfig, Task};

const STEPS_PER_HOUR: u32 = 12;

fn library() -> Library {
    Library::load(&Engine::ensure(&mut Quiet).unwrap().library).unwrap()
}

/// Quasi-random points: the steps of the coordinates are incommensurable.
fn sample(index: usize) -> HouseSample {
    let step = |dimension: usize| 0.618 * (2.0 + dimension as f64).sqrt();
    let point: [f64; DIMENSIONS] = std::array::from_fn(|d| (0.5 + index as f64 * step(d)).fract());
    HouseSample::from_unit(&point).unwrap()
}

/// Six houses, with every foundation and system, in regions from mild to cold.
fn houses() -> Vec<HouseSample> {
    let fuel = Heater::Fuel { efficiency: 0.8 };
    let pump = |backup| Heating::HeatPump { cop: 3.6, cutoff: -12.0, backup };
    let kinds = [
        ("Montérégie", Foundation::Basement, false, pump(Heater::Electric)),
        ("Saguenay-Lac-Saint-Jean", Foundation::Crawlspace, true, pump(fuel)),
        ("Côte-Nord", Foundation::Slab, true, Heating::Furnace(Heater::Electric)),
        ("Laurentides", Foundation::Basement, true, Heating::Furnace(fuel)),
        ("Gaspésie-Îles-de-la-Madeleine", Foundation::Crawlspace, false, Heating::Furnace(fuel)),
        ("Montréal", Foundation::Basement, false, pump(fuel)),
    ];
    let make = |(index, (region, foundation, garage, heating))| {
        let mut sample = sample(index);
        sample.location = Location::Region(Region::find(region).unwrap());
        (sample.house.foundation, sample.house.garage, sample.house.heating) = (foundation, garage, heating);
        sample
    };
    kinds.into_iter().enumerate().map(make).collect()
}

fn weather(sample: &HouseSample) -> PathBuf {
    sample.location.weather(&Cache::from_env().unwrap(), &mut Quiet).unwrap()
}

fn prepared(sample: &HouseSample, weather: &Path, library: &Library) -> Arc<PreparedBuilding> {
    let model = house(&sample.house, &Site::read(weather).unwrap()).unwrap();
    Arc::new(Preparation::new("house", model).run(weather, library).unwrap())
}

/// Runs a period under the controller. Returns the lowest and the highest temperature of the heated zone.
fn extremes(
    building: &Arc<PreparedBuilding>,
    weather: &Path,
    period: RunPeriod,
    library: &Library,
) -> (f64, f64) {
    let task = Task::default();
    let episode = EpisodeConfig { weather: weather.to_owned(), period, steps_per_hour: STEPS_PER_HOUR, task };
    let mut env = Env::new(library.clone(), building.clone(), episode).unwrap();
    let mut controller =
        Reactive::new(building, env.observation_space(), STEPS_PER_HOUR, &ReactiveParameters::default());
    let mut observation = env.reset().unwrap().to_vec();
    let mut action = vec![0.0; env.action_space().len()];
    let (mut low, mut high) = (observation[0], observation[0]);
    loop {
        controller.act(&observation, &mut action);
        let step = env.step(&action).unwrap();
        observation.copy_from_slice(step.observation);
        assert!(observation.iter().all(|value| value.is_finite()));
        low = low.min(observation[0]);
        high = high.max(observation[0]);
        if step.truncated {
            break;
        }
    }
    assert_eq!(env.message_count(Level::Severe), 0, "{}", env.messages());
    (low, high)
}

#[test]
fn drawn_houses_stay_warm_in_january_and_cool_in_july() {
    let library = library();
    for sample in houses() {
        let weather = weather(&sample);
        let building = prepared(&sample, &weather, &library);
        let zones = 2
            + usize::from(sample.house.foundation == Foundation::Crawlspace)
            + usize::from(sample.house.garage);
        assert_eq!(building.zones.len(), zones);
        assert_eq!(building.actuators().count(), 2);
        let run = |period: &str| extremes(&building, &weather, period.parse().unwrap(), &library);
        let (winter, summer) = (run("01-14..01-15"), run("07-14..07-15"));
        println!("{} {:?}: {winter:.1?} {summer:.1?}", sample.location.name(), sample.house.heating);
        assert!(winter.0 >= 12.0 && winter.1 <= 30.0, "{sample:?}: {winter:?}");
        assert!(summer.0 >= 12.0 && summer.1 <= 32.0, "{sample:?}: {summer:?}");
    }
}

/// The engine runs a winter and a summer week of morphed weather without a severe message.
#[test]
fn a_house_runs_a_week_on_morphed_weather() {
    let library = library();
    let mut sample = sample(3);
    sample.location = Location::Region(Region::find("Saguenay-Lac-Saint-Jean").unwrap());
    let weather = weather(&sample);
    let building = prepared(&sample, &weather, &library);
    for week in ["01-08..01-14", "07-08..07-14"] {
        let (low, high) = extremes(&building, &weather, week.parse().unwrap(), &library);
        assert!(low >= 12.0 && high <= 32.0, "{week}: {low} {high}");
    }
}
