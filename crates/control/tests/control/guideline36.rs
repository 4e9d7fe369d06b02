//! The sequences of Guideline 36 on the engine, with the band of an office: 21 to 24 °C from 6:00 to 20:00 on weekdays, 15.6 to
//! 28 °C otherwise.

use std::sync::Arc;

use b2b_building::{BuildingType, Conditioning};
use b2b_climate::{Place, Site};
use b2b_control::guideline36::{NextBand, SiteInput, ZoneInput};
use b2b_control::{Controller, Guideline36, Guideline36Parameters, kind};
use b2b_dataset::{Preparation, archetype};
use b2b_energyplus::install::{Engine, Quiet};
use b2b_energyplus::{Level, Library};
use b2b_env::{Env, EpisodeConfig, Term};

const STEP: f64 = 1.0 / 12.0;
const DAY: usize = 288;
/// Monday to Wednesday.
const WINTER: &str = "01-08..01-10";
const SUMMER: &str = "07-09..07-11";

fn env(building_type: BuildingType, period: &str) -> Env {
    let engine = Engine::ensure(&mut Quiet).unwrap();
    let library = Library::load(&engine.library).unwrap();
    let weather = Place::find(building_type.home()).unwrap().epw(&mut Quiet).unwrap();
    let site = Site::read(&weather).unwrap();
    let model = archetype::base_model(building_type, &engine, &library, &site).unwrap();
    let building = Preparation::new(building_type.name(), model).run(&weather, &library).unwrap();
    let (period, task) = (period.parse().unwrap(), "occupancy".parse().unwrap());
    let episode = EpisodeConfig { weather, period, steps_per_hour: 12, task };
    Env::new(library, Arc::new(building), episode).unwrap()
}

/// Returns whether the band of occupied hours holds in a step of a weekday.
fn is_open(step: usize) -> bool {
    (6 * 12..20 * 12).contains(&(step % DAY))
}

fn band(open: bool, cools: bool) -> [f64; 2] {
    let [heating, cooling] = if open { [21.0, 24.0] } else { [15.6, 28.0] };
    [heating, if cools { cooling } else { f64::INFINITY }]
}

/// What an episode came to.
#[derive(Debug)]
struct Outcome {
    /// Kelvin-hours outside the band, mean over the zones with heating and cooling.
    discomfort: f64,
    heating: f64,
    cooling: f64,
    /// Changes of mode per system and day.
    switches: f64,
    severe: usize,
    clamped: usize,
    overrides: usize,
}

fn run(building_type: BuildingType, period: &str) -> Outcome {
    let mut env = env(building_type, period);
    let spaces = Arc::clone(env.spaces());
    let values = kind("guideline36").unwrap().tuned(&spaces.building, &spaces.episode.task);
    let parameters: Guideline36Parameters = serde_json::from_value(values).unwrap();
    let mut control = Guideline36::new(&spaces, &parameters);
    let zones: Vec<usize> = spaces.controlled_zones().collect();
    let cools = |zone: &usize| spaces.building.zones[*zone].conditioning == Conditioning::HeatingAndCooling;
    let mut action = vec![0.0; spaces.action.len()];
    let mut observation = env.reset().unwrap().to_vec();
    let (mut discomfort, mut switches, mut modes) = (0.0, 0, Vec::new());
    for step in 0..env.episode_steps() {
        let points: Vec<ZoneInput> = zones
            .iter()
            .enumerate()
            .map(|(controlled, zone)| {
                point(step, observation[*zone], cools(zone), {
                    let slot = spaces.observation.occupancy(controlled);
                    slot.is_some_and(|slot| observation[slot] > 0.5)
                })
            })
            .collect();
        let outdoor_temperature = observation[spaces.observation.outdoor_temperature()];
        control.act_on(SiteInput { outdoor_temperature, ..SiteInput::default() }, &points, &mut action);
        observation.copy_from_slice(env.step(&action).unwrap().observation);
        for zone in zones.iter().filter(|zone| cools(zone)) {
            let ([low, high], at) = (band(is_open(step), true), observation[*zone]);
            discomfort += (low - at).max(at - high).max(0.0) * STEP;
        }
        let now: Vec<f64> = decided(&control, " mode");
        switches += modes.iter().zip(&now).filter(|(before, now)| before != now).count();
        modes = now;
    }
    let metrics = env.metrics();
    Outcome {
        discomfort: discomfort / zones.iter().filter(|zone| cools(zone)).count() as f64,
        heating: metrics.total(Term::Heating),
        cooling: metrics.total(Term::Cooling),
        switches: switches as f64 / (modes.len() * env.episode_steps() / DAY) as f64,
        severe: env.message_count(Level::Severe),
        clamped: metrics.clamped_actions,
        overrides: metrics.ventilation_overrides,
    }
}

fn point(step: usize, temperature: f64, cools: bool, people: bool) -> ZoneInput {
    let [heating, cooling] = band(is_open(step), cools);
    let later = (1..DAY).find(|later| is_open(step + later) != is_open(step));
    let next = later.map(|later| {
        let [heating, cooling] = band(is_open(step + later), cools);
        NextBand { hours: later as f64 * STEP, heating, cooling }
    });
    ZoneInput { temperature, heating, cooling, people, next }
}

/// Three winter and three summer days of each type.
#[test]
fn every_type_stays_in_its_band_with_little_heating_in_summer() {
    for building_type in BuildingType::ALL {
        for (period, hours) in [(WINTER, 8.0), (SUMMER, 3.0)] {
            let outcome = run(building_type, period);
            println!("{building_type} {period}: {outcome:?}");
            let label = format!("{building_type} {period}: {outcome:?}");
            assert_eq!((outcome.severe, outcome.clamped, outcome.overrides), (0, 0, 0), "{label}");
            assert!(outcome.discomfort < hours, "{label}");
            assert!(outcome.switches < 12.0, "{label}");
            if period == SUMMER {
                assert!(outcome.heating < 0.03 * outcome.cooling, "{label}");
            }
        }
    }
}

/// The values of the decisions whose names end with a word.
fn decided(control: &Guideline36, word: &str) -> Vec<f64> {
    let decisions = control.record().unwrap();
    let named = decisions.slots().iter().zip(&decisions.values);
    named.filter(|(slot, _)| slot.name.ends_with(word)).map(|(_, value)| *value).collect()
}
