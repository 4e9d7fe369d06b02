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
/// Steps of a day.
const DAY: usize = 288;

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

/// Called at the end of every step with the command of the step.
type Look<'a> = Box<dyn FnMut(&Reader, usize, Command) + 'a>;

/// A day under `command(step)`.
struct Trial<'a> {
    command: fn(usize) -> Command,
    look: Look<'a>,
}

impl<'a> Trial<'a> {
    fn new(command: fn(usize) -> Command, look: impl FnMut(&Reader, usize, Command) + 'a) -> Self {
        Self { command, look: Box::new(look) }
    }
}

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

    /// Simulates days from the 10th of a month, one for each trial. Asserts that there are no severe messages.
    fn play(&self, month: u32, trials: &mut [Trial<'_>]) {
        let last = 9 + trials.len() as u32;
        let period = RunPeriod::new(Date::new(month, 10).unwrap(), Date::new(month, last).unwrap());
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
                (trials[step / DAY].look)(&Reader(&simulation), step % DAY, now);
                step += 1;
            }
            now = match trials.get(step / DAY) {
                Some(trial) if event != Event::WarmupStep => (trial.command)(step % DAY),
                _ => MILD,
            };
            self.act(&mut simulation, now);
        }
        assert_eq!((step, simulation.message_count(Level::Severe)), (DAY * trials.len(), 0));
    }

    fn variables(&self) -> Vec<EngineVariable> {
        let central = self.loops.iter().flat_map(|l| [&l.supply_temperature, &l.outdoor_air]);
        let actuators = central.chain(self.terminals().flat_map(|t| [&t.damper, coil_setpoint(t)]));
        let zones = self.terminals().map(|t| temperature(&t.zone));
        actuators.map(|a| a.effect.clone()).chain(zones).collect()
    }

    fn act(&self, simulation: &mut Simulation, command: Command) {
        for air_loop in &self.loops {
            set(simulation, &air_loop.supply_temperature, command.supply_temperature);
            set(simulation, &air_loop.outdoor_air, command.outdoor_air * air_loop.fan_flow);
            for (terminal, opening) in air_loop.terminals.iter().zip(command.openings) {
                set(simulation, &terminal.damper, opening);
                set(simulation, coil_setpoint(terminal), command.heating_setpoint);
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

/// A damper sets its fraction of the terminal, and open dampers share the fan.
fn dampers(office: &Office) -> Trial<'_> {
    let command = |step: usize| match step % 8 {
        0 => Command { openings: [1.0; 5], ..MILD },
        1 => Command { openings: [0.0; 5], ..MILD },
        _ => Command { openings: scattered_openings(step), ..MILD },
    };
    let (mut limited, mut closed) = (0, 0);
    Trial::new(command, move |reader, step, command| {
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
        assert!(step < DAY - 1 || limited > 50 && closed > 100, "{limited} limited, {closed} closed");
    })
}

/// The command of step `step` of a day with supply temperatures from `lowest` to 40 °C, flows and shares of outdoor
/// air.
fn supply_command(lowest: f64, step: usize) -> Command {
    let cell = step / HOLD;
    Command {
        supply_temperature: [lowest, 40.0, 16.0, 20.0, 15.0, 30.0][cell % 6],
        openings: [[0.05, 0.3, 0.6][cell / 6 % 3]; 5],
        outdoor_air: [0.0, 0.1, 0.5, 1.0][cell / 18 % 4],
        heating_setpoint: 10.0,
    }
}

/// Supply temperature and outdoor air follow their commands.
fn supply(office: &Office, command: fn(usize) -> Command) -> Trial<'_> {
    Trial::new(command, |reader, step, command| {
        for air_loop in &office.loops {
            let wish = (command.outdoor_air * air_loop.fan_flow).min(reader.supply_flow(air_loop));
            let flow = reader.read(&air_loop.outdoor_air.effect);
            assert!((flow - wish).abs() <= 0.02 * wish, "{}: {flow}, not {wish}", air_loop.name);
            let (supply, wish) =
                (reader.read(&air_loop.supply_temperature.effect), command.supply_temperature);
            let settled = step % HOLD == HOLD - 1;
            assert!(
                !settled || (supply - wish).abs() < 0.2,
                "{}, step {step}: {supply}, not {wish}",
                air_loop.name
            );
        }
    })
}

/// Reheat holds the setpoint of each six hours, and is off below the zone.
fn reheat(office: &Office) -> Trial<'_> {
    const SIX_HOURS: usize = 72;
    let command = |step: usize| Command {
        heating_setpoint: [10.0, 22.0, 10.0, 10.0][step / SIX_HOURS],
        openings: [0.5; 5],
        ..MILD
    };
    let mut cold = 0;
    Trial::new(command, move |reader, step, command| {
        if step % SIX_HOURS != SIX_HOURS - 1 {
            return;
        }
        for terminal in office.terminals() {
            let zone = reader.read(&temperature(&terminal.zone));
            assert_eq!(reader.read(&coil_setpoint(terminal).effect), command.heating_setpoint);
            match command.heating_setpoint {
                10.0 => cold += usize::from(zone < 20.0),
                wish => assert!(zone > wish - 0.1, "{}: {zone} under {wish}", terminal.zone),
            }
        }
        assert!(step < DAY - 1 || cold >= 10, "without reheat zones fall: only {cold} did");
    })
}

/// Random actions leave all zones within 5 to 60 °C.
fn random(office: &Office) -> Trial<'_> {
    let command = |step| Command {
        supply_temperature: 10.0 + 45.0 * scatter(step),
        outdoor_air: scatter(step + 1),
        openings: scattered_openings(step),
        heating_setpoint: 10.0 + 20.0 * scatter(step + 2),
    };
    Trial::new(command, |reader, _, _| {
        for terminal in office.terminals() {
            let zone = reader.read(&temperature(&terminal.zone));
            assert!((5.0..60.0).contains(&zone), "{}: {zone}", terminal.zone);
        }
    })
}

/// The reheat setpoint of a terminal.
fn coil_setpoint(terminal: &Terminal) -> &Actuator {
    terminal.reheat.as_ref().expect("every terminal of the medium office reheats")
}

#[test]
fn dampers_supply_air_outdoor_air_and_reheat_follow_their_commands_in_winter() {
    let office = Office::new();
    let command = |step| supply_command(10.0, step);
    let mut trials = [dampers(&office), supply(&office, command), reheat(&office), random(&office)];
    office.play(WINTER, &mut trials);
}

#[test]
fn dampers_supply_air_and_outdoor_air_follow_their_commands_in_summer() {
    let office = Office::new();
    // Much hot outdoor air is beyond the cooling coil at the lowest temperatures.
    let command = |step| supply_command(14.0, step);
    office.play(SUMMER, &mut [dampers(&office), supply(&office, command), random(&office)]);
}

#[test]
fn an_office_with_other_names_and_fans_is_controllable() {
    let office = Office::of("RefBldgMediumOfficeNew2004_Chicago.idf");
    office.play(WINTER, &mut [random(&office)]);
}
