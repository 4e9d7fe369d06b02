//! Central air loops of the medium office on the real engine: commands have the commanded effect.

use std::path::PathBuf;

use b2b_building::hvac::{Actuator, AirLoop, EngineVariable, Terminal};
use b2b_building::{Date, Model, PreparedBuilding, RunPeriod};
use b2b_energyplus::install::{Engine, Quiet};
use b2b_energyplus::{Event, Level, Library, Run, Simulation};

const DENVER: &str = "USA_CO_Denver-Aurora-Buckley.AFB.724695_TMY3.epw";
const WINTER: u32 = 1;
const SUMMER: u32 = 7;
/// Steps a command is held before its effect is read.
const HOLD: usize = 3;

/// The folder of the engine.
fn engine() -> PathBuf {
    Engine::ensure(&mut Quiet).unwrap().root
}

/// A command, the same for every air loop.
#[derive(Clone, Copy)]
struct Command {
    supply_temperature: f64,
    /// Fraction of the fan's design flow.
    outdoor_air: f64,
    /// Openings of the dampers, cyclically.
    openings: [f64; 5],
    heating_setpoint: f64,
}

const MILD: Command =
    Command { supply_temperature: 18.0, outdoor_air: 0.05, openings: [0.3; 5], heating_setpoint: 20.0 };

struct Office {
    library: Library,
    building: PreparedBuilding,
    loops: Vec<AirLoop>,
}

impl Office {
    fn new() -> Self {
        Self::of("ASHRAE901_OfficeMedium_STD2019_Denver.idf")
    }

    fn of(idf: &str) -> Self {
        let file = format!("{}energyplusapi{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
        let library = Library::load(&engine().join(file)).unwrap();
        let idf = engine().join("pyenergyplus/data/model").join(idf);
        let mut model = Model::read(&idf, &library).unwrap();
        let control = model.names("SimulationControl").remove(0);
        let control = model.require_mut("SimulationControl", &control).unwrap();
        control.insert("run_simulation_for_weather_file_run_periods".into(), "Yes".into());
        let building = PreparedBuilding::new("office", model, &Self::weather(), &library).unwrap();
        let loops = building.systems.iter().map(|system| match system.as_any().downcast_ref::<AirLoop>() {
            Some(air_loop) => air_loop.clone(),
            None => panic!("the medium office has central air loops, not {system:?}"),
        });
        Self { library, loops: loops.collect(), building }
    }

    fn weather() -> PathBuf {
        engine().join("pyenergyplus/data/weather").join(DENVER)
    }

    fn terminals(&self) -> impl Iterator<Item = &Terminal> {
        self.loops.iter().flat_map(|air_loop| &air_loop.terminals)
    }

    /// Two days from the 10th of a month under `command(step)`; `look` sees the end of every step with the
    /// command that it ran under. Returns how many severe messages there were.
    fn play(
        &self,
        month: u32,
        mut command: impl FnMut(usize) -> Command,
        mut look: impl FnMut(&Reader, usize, Command),
    ) -> usize {
        let period = RunPeriod::new(Date::new(month, 10).unwrap(), Date::new(month, 11).unwrap()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let input = folder.path().join("model.epJSON");
        std::fs::write(&input, self.building.model_for(period, 12).to_epjson()).unwrap();
        let mut run = Run::new(&input, Self::weather()).yield_in_warmup();
        for variable in self.variables() {
            run = run.request(&variable.name, &variable.key);
        }
        let mut simulation = run.start(&self.library).unwrap();
        let (mut step, mut now) = (0, MILD);
        while let Some(event) = simulation.advance().unwrap() {
            if event == Event::Step {
                look(&Reader(&simulation), step, now);
                step += 1;
            }
            now = if event == Event::WarmupStep { MILD } else { command(step) };
            self.act(&mut simulation, now);
        }
        simulation.message_count(Level::Severe)
    }

    fn variables(&self) -> Vec<EngineVariable> {
        let central = self.loops.iter().flat_map(|l| [&l.supply_temperature, &l.outdoor_air]);
        let actuators = central.chain(self.terminals().flat_map(|t| [&t.damper, &t.reheat]));
        let zones = self.terminals().map(|t| temperature(&t.zone));
        actuators.map(|a| a.effect.clone()).chain(zones).collect()
    }

    fn act(&self, simulation: &mut Simulation, command: Command) {
        for air_loop in &self.loops {
            set(simulation, &air_loop.supply_temperature, command.supply_temperature);
            set(simulation, &air_loop.outdoor_air, command.outdoor_air * air_loop.fan_flow);
            for (terminal, opening) in air_loop.terminals.iter().zip(command.openings) {
                set(simulation, &terminal.damper, opening);
                set(simulation, &terminal.reheat, command.heating_setpoint);
            }
        }
    }
}

fn temperature(zone: &str) -> EngineVariable {
    EngineVariable::new("Zone Mean Air Temperature", zone)
}

fn set(simulation: &mut Simulation, actuator: &Actuator, value: f64) {
    let handle = simulation.actuator(&actuator.component, &actuator.control, &actuator.key).unwrap();
    simulation.set(handle, value * actuator.scale);
}

struct Reader<'a>(&'a Simulation);

impl Reader<'_> {
    fn read(&self, variable: &EngineVariable) -> f64 {
        self.0.read(self.0.variable(&variable.name, &variable.key).unwrap())
    }

    fn supply_flow(&self, air_loop: &AirLoop) -> f64 {
        air_loop.terminals.iter().map(|t| self.read(&t.damper.effect)).sum()
    }
}

/// Reproducible pseudo-random numbers in [0, 1).
fn scatter(seed: usize) -> f64 {
    let hash = (seed as u64).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    ((hash ^ (hash >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 11) as f64 / (1u64 << 53) as f64
}

fn scattered_openings(seed: usize) -> [f64; 5] {
    std::array::from_fn(|i| if scatter(seed + 7 * i) < 0.2 { 0.0 } else { scatter(seed + 11 * i + 3) })
}

#[test]
fn a_damper_sets_its_fraction_of_the_terminal_and_open_dampers_share_the_fan() {
    let office = Office::new();
    let (mut limited, mut closed) = (0, 0);
    for month in [WINTER, SUMMER] {
        let command = |step| match step % 8 {
            0 => Command { openings: [1.0; 5], ..MILD },
            1 => Command { openings: [0.0; 5], ..MILD },
            _ => Command { openings: scattered_openings(step), ..MILD },
        };
        office.play(month, command, |reader, _, command| {
            for air_loop in &office.loops {
                let wish = |(t, opening): (&Terminal, f64)| opening * t.damper.effect_scale;
                let wishes: Vec<f64> = air_loop.terminals.iter().zip(command.openings).map(wish).collect();
                let share = (air_loop.fan_flow / wishes.iter().sum::<f64>()).min(1.0);
                limited += usize::from(share < 1.0);
                for (terminal, wish) in air_loop.terminals.iter().zip(wishes) {
                    let flow = reader.read(&terminal.damper.effect);
                    let off = (flow - wish * share).abs();
                    assert!(off <= 0.01 * wish * share, "{}: {flow}, not {wish} x {share}", terminal.zone);
                    closed += usize::from(wish == 0.0);
                }
            }
        });
    }
    assert!(limited > 100 && closed > 100, "{limited} limited, {closed} closed");
}

#[test]
fn supply_temperature_and_outdoor_air_follow_their_commands() {
    let office = Office::new();
    let flows = [0.05, 0.3, 0.6];
    let shares = [0.0, 0.1, 0.5, 1.0];
    // Much hot outdoor air is beyond the cooling coil at the lowest temperatures.
    for (month, lowest) in [(WINTER, 10.0), (SUMMER, 14.0)] {
        let temperatures = [lowest, 40.0, 16.0, 20.0, 15.0, 30.0];
        let command = |step: usize| {
            let cell = step / HOLD;
            Command {
                supply_temperature: temperatures[cell % 6],
                openings: [flows[cell / 6 % 3]; 5],
                outdoor_air: shares[cell / 18 % 4],
                heating_setpoint: 10.0,
            }
        };
        office.play(month, command, |reader, step, command| {
            for air_loop in &office.loops {
                let wish = (command.outdoor_air * air_loop.fan_flow).min(reader.supply_flow(air_loop));
                let flow = reader.read(&air_loop.outdoor_air.effect);
                assert!((flow - wish).abs() <= 0.02 * wish, "{}: {flow}, not {wish}", air_loop.name);
                let supply = reader.read(&air_loop.supply_temperature.effect);
                let off = (supply - command.supply_temperature).abs();
                if step % HOLD == HOLD - 1 {
                    let wish = command.supply_temperature;
                    assert!(
                        off < 0.2,
                        "{} in month {month}, step {step}: {supply}, not {wish}",
                        air_loop.name
                    );
                }
            }
        });
    }
}

#[test]
fn reheat_holds_the_setpoint_and_is_off_below_the_zone() {
    let office = Office::new();
    let setpoints = [10.0, 22.0, 10.0];
    let six_hours = 72;
    let command = |step: usize| Command {
        heating_setpoint: setpoints[step / six_hours % 3],
        openings: [0.5; 5],
        ..MILD
    };
    let mut cold = 0;
    office.play(WINTER, command, |reader, step, command| {
        if step % six_hours != six_hours - 1 {
            return;
        }
        for terminal in office.terminals() {
            let zone = reader.read(&temperature(&terminal.zone));
            assert_eq!(reader.read(&terminal.reheat.effect), command.heating_setpoint);
            match command.heating_setpoint {
                10.0 => cold += usize::from(zone < 20.0),
                wish => assert!(zone > wish - 0.1, "{}: {zone} under {wish}", terminal.zone),
            }
        }
    });
    assert!(cold >= 10, "without reheat zones fall: only {cold} did");
}

#[test]
fn random_actions_cause_no_severe_errors() {
    play_at_random(&Office::new());
}

#[test]
fn an_office_with_other_names_and_fans_is_controllable() {
    play_at_random(&Office::of("RefBldgMediumOfficeNew2004_Chicago.idf"));
}

fn play_at_random(office: &Office) {
    for month in [WINTER, SUMMER] {
        let command = |step| Command {
            supply_temperature: 10.0 + 45.0 * scatter(step),
            outdoor_air: scatter(step + 1),
            openings: scattered_openings(step),
            heating_setpoint: 10.0 + 20.0 * scatter(step + 2),
        };
        let severe = office.play(month, command, |reader, _, _| {
            for terminal in office.terminals() {
                let zone = reader.read(&temperature(&terminal.zone));
                assert!((5.0..60.0).contains(&zone), "{}: {zone}", terminal.zone);
            }
        });
        assert_eq!(severe, 0);
    }
}
