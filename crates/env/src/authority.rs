//! Whether every actuator bites: what each is told, against what the engine then does.
//!
//! In a winter and in a summer day every actuator is taken up and down its range (low, middle, high, middle,
//! low, and zero for a flow), each value held for most of an hour, all systems at once:
//!
//! 1. air flows, with supply air at 20 °C;
//! 2. supply temperatures, at middle and at full flow;
//! 3. outdoor air of central air loops, and all dampers of a loop open;
//! 4. heating setpoints, into the next day: low, middle, low, high, low, two hours each.
//!
//! What is judged is the state at the end of every held step but the first, against these limits:
//!
//! - air flow: 1 % of the command; nothing at zero;
//! - supply air temperature: 0.2 K;
//! - outdoor air flow: 2 % of the command; nothing at zero;
//! - heating setpoint: raised, it raises the heat over what it is before and after at the low setpoint, and
//!   raises the zone's temperature too or holds it at the setpoint; a zone above its setpoint gets no heat, and one
//!   below it gets some.
//!
//! A miss counts as [`Verdict::AtCapacity`] only where the equipment shows that it has no more to give:
//!
//! - **supply temperature**: after each missed step the command is brought halfway to what was reached, for one
//!   step, and the outlet moves by less than a fifth of the change from the mean of the steps before and after
//!   (and a quarter of what it drifts between these): a coil with something left would follow. Where the nearer
//!   command is met at once, the coil is catching up as its inlet air comes closer (control that lags would not
//!   meet it), and must meet the command itself by the end of the hold. An outlet that never moves fails: some
//!   other command at the same flow and in the same season must be followed.
//! - **damper**: the terminals of the loop together are at the fan's design flow, and were asked for more.
//! - **outdoor air**: it is all of the supply air, and more was asked for; or it makes up for exhaust fans in the
//!   loop's zones, within their design flow, and less was asked for.
//! - **heating setpoint**: the zone is above it without any heat.

use std::fmt;
use std::path::Path;
use std::sync::Arc;

use b2b_building::hvac::{Actuator, Quantity, System};
use b2b_building::{PreparedBuilding, RunPeriod};
use b2b_energyplus::Library;
use serde::{Deserialize, Serialize};

use crate::Result;
use crate::env::{Env, Episode};
use crate::task::Task;

const STEPS_PER_HOUR: u32 = 12;
/// Steps of a hold; the first is for settling.
const HELD: usize = 9;
/// Steps that a probe of a miss at the end of a hold may add.
const PROBED: usize = 2;
/// Steps of a heating setpoint.
const HEATED: usize = 24;
/// Outlet movement over command movement under which a coil has nothing left to give, and the movement that
/// inlet air may cause, K.
const SATURATED: f64 = 0.2;
const DRIFT: f64 = 0.05;
/// How far halfway between two steps a decaying outlet may be off their mean, as a share of its decay.
const CURVATURE: f64 = 0.25;
/// Supply air while flows are tested, °C; while heating setpoints are tested.
const NEUTRAL_SUPPLY: f64 = 20.0;
const COOL_SUPPLY: f64 = 12.0;
/// Opening of all dampers that stays within the fan's design flow.
const OPEN_TOGETHER: f64 = 0.8;
/// A zone is at its heating setpoint within this, K.
const AT_SETPOINT: f64 = 0.5;
/// Least rise of the zone by a raised setpoint, K, and least heat that counts, W.
const RISE: f64 = 0.05;
const SOME_HEAT: f64 = 1.0;

/// What was measured on a building.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Report {
    /// Name of the building.
    pub building: String,
    /// One row an actuator, season, condition and level, in the order of the action.
    pub rows: Vec<Row>,
}

/// An actuator at one level.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Name of the actuator.
    pub actuator: String,
    /// What it drives.
    pub quantity: Quantity,
    /// Which day.
    pub season: Season,
    /// What the rest of its system did.
    pub condition: Condition,
    /// Where in its range.
    pub level: Level,
    /// Value given, in the unit of the quantity.
    pub command: f64,
    /// What came of it over the held steps, in the same unit; for a heating setpoint the zone's temperature, °C.
    pub lowest: f64,
    /// Mean of it.
    pub mean: f64,
    /// Highest.
    pub highest: f64,
    /// Greatest deviation: a share of the command for flows (of the highest command at zero), otherwise K.
    pub error: f64,
    /// What the error may be; infinite where heat is judged.
    pub tolerance: f64,
    /// Heat, W, where a heating setpoint is the command.
    pub heat: Option<f64>,
    /// The judgement.
    pub verdict: Verdict,
}

/// A day of the measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Season {
    /// From Monday 16 January.
    Winter,
    /// From Monday 17 July.
    Summer,
}

/// A place in the range of an actuator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// No flow.
    Zero,
    /// A fifth of the highest flow; otherwise the lowest value.
    Low,
    /// Three fifths of the highest flow; otherwise halfway.
    Middle,
    /// The highest value.
    High,
}

/// What the rest of the system does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Condition {
    /// Supply air at a neutral temperature.
    NeutralSupply,
    /// Half of the design flow.
    MiddleFlow,
    /// All of the design flow.
    FullFlow,
    /// Every damper of the loop open.
    AllOpen,
    /// Supply air below room temperature.
    CoolSupply,
}

/// The judgement on a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Within the tolerance.
    Follows,
    /// Out of tolerance, with the equipment shown to be at its limit.
    AtCapacity(Limit),
    /// Out of tolerance.
    Fails,
}

/// A limit of the equipment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Limit {
    /// A nearer command left the outlet where it was.
    Coil,
    /// The terminals take all that the fan gives.
    Fan,
    /// All of the supply air is outdoor air.
    SupplyFlow,
    /// Outdoor air makes up for exhaust fans.
    Exhaust,
    /// The zone is above the setpoint without heat.
    WarmZone,
}

/// Measures every actuator of a building.
///
/// # Errors
/// As [`Env::reset`] and [`Env::step`].
pub fn measure(library: &Library, building: &Arc<PreparedBuilding>, weather: &Path) -> Result<Report> {
    let mut rows = Vec::new();
    for season in [Season::Winter, Season::Summer] {
        rows.extend(measure_season(library, building, weather, season)?);
    }
    let order = |row: &Row| building.actuators().position(|a| a.name == row.actuator);
    rows.sort_by_key(order);
    Ok(Report { building: building.name.clone(), rows })
}

fn measure_season(
    library: &Library,
    building: &Arc<PreparedBuilding>,
    weather: &Path,
    season: Season,
) -> Result<Vec<Row>> {
    let episode = Episode {
        weather: weather.to_owned(),
        period: season.days(),
        steps_per_hour: STEPS_PER_HOUR,
        task: Task::default(),
    };
    let mut bench = Bench {
        env: Env::new(library.clone(), Arc::clone(building), episode)?.observe_effects(),
        building,
        season,
        readings: Vec::new(),
    };
    bench.env.reset()?;
    for hold in follow_holds(building) {
        bench.hold(&hold)?;
    }
    let mut rows = rows(&bench.readings);
    if building.actuators().any(|a| a.quantity == Quantity::HeatingSetpoint) {
        rows.extend(bench.heat()?);
    }
    Ok(rows)
}

impl Season {
    fn days(self) -> RunPeriod {
        let days = match self {
            Season::Winter => "01-16..01-17",
            Season::Summer => "07-17..07-18",
        };
        days.parse().expect("a run period in the calendar")
    }
}

impl Level {
    /// From bottom to top and back; a flow goes to zero and comes back from it too.
    const FLOWS: [Self; 7] =
        [Self::Low, Self::Middle, Self::High, Self::Middle, Self::Low, Self::Zero, Self::Low];
    const OTHERS: [Self; 5] = [Self::Low, Self::Middle, Self::High, Self::Middle, Self::Low];

    fn of(self, actuator: &Actuator) -> f64 {
        let share = match (self, is_flow(actuator.quantity)) {
            (Self::Zero, _) | (Self::Low, false) => 0.0,
            (Self::Low, true) => 0.2,
            (Self::Middle, true) => 0.6,
            (Self::Middle, false) => 0.5,
            (Self::High, _) => 1.0,
        };
        actuator.low + share * (actuator.high - actuator.low)
    }
}

fn is_flow(quantity: Quantity) -> bool {
    !matches!(quantity, Quantity::SupplyAirTemperature | Quantity::HeatingSetpoint)
}

fn tolerance(quantity: Quantity) -> f64 {
    match quantity {
        Quantity::SupplyAirFlow | Quantity::DamperOpening => 0.01,
        Quantity::OutdoorAirFlow => 0.02,
        Quantity::SupplyAirTemperature => 0.2,
        Quantity::HeatingSetpoint => f64::INFINITY,
    }
}

/// Deviation of what came of a command: see [`Row::error`].
fn deviation(actuator: &Actuator, command: f64, effect: f64) -> f64 {
    let scale = match is_flow(actuator.quantity) {
        true if command > 0.0 => command,
        true => actuator.high,
        false => 1.0,
    };
    (effect - command).abs() / scale
}

/// Values for every actuator, and which of them are judged.
struct Hold {
    action: Vec<f64>,
    condition: Condition,
    judged: Vec<(usize, Level)>,
}

impl Hold {
    /// `give` says for each actuator its value or its level; a level is judged.
    fn new(
        building: &PreparedBuilding,
        condition: Condition,
        give: impl Fn(usize, &Actuator) -> Give,
    ) -> Self {
        let mut judged = Vec::new();
        let action = building.actuators().enumerate().map(|(i, actuator)| match give(i, actuator) {
            Give::Value(value) => value,
            Give::Judged(level) => {
                judged.push((i, level));
                level.of(actuator)
            }
        });
        Self { action: action.collect(), condition, judged }
    }
}

enum Give {
    Value(f64),
    Judged(Level),
}

/// Every hold whose commands are to be followed, in order.
fn follow_holds(building: &PreparedBuilding) -> Vec<Hold> {
    let mut holds: Vec<_> = (0..Level::FLOWS.len()).map(|turn| flow_hold(building, turn)).collect();
    for (condition, share) in [(Condition::MiddleFlow, 0.5), (Condition::FullFlow, 1.0)] {
        holds.extend(Level::OTHERS.map(|level| temperature_hold(building, condition, share, level)));
    }
    if building.systems.iter().any(|s| matches!(s, System::AirLoop(_))) {
        holds.extend(Level::FLOWS.map(|level| outdoor_air_hold(building, level)));
        holds.push(all_open_hold(building));
    }
    holds
}

/// Flows at their levels; the dampers of a loop take turns, so that together they stay within the fan's flow.
fn flow_hold(building: &PreparedBuilding, turn: usize) -> Hold {
    Hold::new(building, Condition::NeutralSupply, |i, actuator| match actuator.quantity {
        Quantity::SupplyAirFlow => Give::Judged(Level::FLOWS[turn]),
        Quantity::DamperOpening => Give::Judged(Level::FLOWS[(turn + i / 2) % Level::FLOWS.len()]),
        Quantity::OutdoorAirFlow => Give::Value(0.1 * actuator.high),
        Quantity::SupplyAirTemperature => Give::Value(NEUTRAL_SUPPLY),
        Quantity::HeatingSetpoint => Give::Value(actuator.low),
    })
}

fn temperature_hold(building: &PreparedBuilding, condition: Condition, share: f64, level: Level) -> Hold {
    Hold::new(building, condition, |_, actuator| match actuator.quantity {
        Quantity::SupplyAirFlow => Give::Value(share * actuator.high),
        Quantity::DamperOpening => Give::Value(share * OPEN_TOGETHER),
        Quantity::OutdoorAirFlow => Give::Value(0.2 * share * actuator.high),
        Quantity::SupplyAirTemperature => Give::Judged(level),
        Quantity::HeatingSetpoint => Give::Value(actuator.low),
    })
}

fn outdoor_air_hold(building: &PreparedBuilding, level: Level) -> Hold {
    Hold::new(building, Condition::NeutralSupply, |_, actuator| match actuator.quantity {
        Quantity::SupplyAirFlow => Give::Value(0.5 * actuator.high),
        Quantity::DamperOpening => Give::Value(OPEN_TOGETHER),
        Quantity::OutdoorAirFlow => Give::Judged(level),
        Quantity::SupplyAirTemperature => Give::Value(NEUTRAL_SUPPLY),
        Quantity::HeatingSetpoint => Give::Value(actuator.low),
    })
}

fn all_open_hold(building: &PreparedBuilding) -> Hold {
    Hold::new(building, Condition::AllOpen, |_, actuator| match actuator.quantity {
        Quantity::SupplyAirFlow => Give::Value(0.5 * actuator.high),
        Quantity::DamperOpening => Give::Judged(Level::High),
        Quantity::OutdoorAirFlow => Give::Value(0.1 * actuator.high),
        Quantity::SupplyAirTemperature => Give::Value(NEUTRAL_SUPPLY),
        Quantity::HeatingSetpoint => Give::Value(actuator.low),
    })
}

fn heat_hold(building: &PreparedBuilding, level: Level) -> Hold {
    Hold::new(building, Condition::CoolSupply, |_, actuator| match actuator.quantity {
        Quantity::SupplyAirFlow => Give::Value(0.3 * actuator.high),
        Quantity::DamperOpening => Give::Value(OPEN_TOGETHER),
        Quantity::OutdoorAirFlow => Give::Value(0.1 * actuator.high),
        Quantity::SupplyAirTemperature => Give::Value(COOL_SUPPLY),
        Quantity::HeatingSetpoint => Give::Judged(level),
    })
}

/// What one actuator did in one hold.
#[derive(Clone)]
struct Reading {
    row: Row,
    steps: usize,
    last: f64,
    /// The command of the next step where it is not the row's: halfway to what was reached.
    nearer: Option<f64>,
    /// That command and what came of it.
    probed: Option<(f64, f64)>,
    /// Whether a nearer command has ever been met, has ever left the outlet in place, has ever moved it.
    caught_up: bool,
    held: bool,
    moves: bool,
    limit: Option<Limit>,
}

impl Reading {
    fn new(actuator: &Actuator, season: Season, condition: Condition, level: Level) -> Self {
        let row = Row {
            actuator: actuator.name.clone(),
            quantity: actuator.quantity,
            season,
            condition,
            level,
            command: level.of(actuator),
            lowest: f64::INFINITY,
            mean: 0.0,
            highest: f64::NEG_INFINITY,
            error: 0.0,
            tolerance: tolerance(actuator.quantity),
            heat: None,
            verdict: Verdict::Follows,
        };
        Self {
            row,
            steps: 0,
            last: f64::NAN,
            nearer: None,
            probed: None,
            caught_up: false,
            held: false,
            moves: false,
            limit: None,
        }
    }

    /// Takes in what came of a step, and has a missed supply temperature followed by a nearer command.
    fn see(&mut self, actuator: &Actuator, effect: f64) {
        if let Some(nearer) = self.nearer.take() {
            self.probed = Some((nearer, effect));
            return;
        }
        if let Some((nearer, outlet)) = self.probed.take() {
            let moved = (outlet - 0.5 * (self.last + effect)).abs();
            let little = SATURATED * (nearer - self.row.command).abs();
            let met = (outlet - nearer).abs() <= little;
            self.caught_up |= met;
            self.held |= !met;
            let drift = DRIFT + CURVATURE * (self.last - effect).abs();
            self.moves |= !met && moved > little + drift;
        }
        self.add(actuator, effect);
        let misses = deviation(actuator, self.row.command, effect) > self.row.tolerance;
        if misses && actuator.quantity == Quantity::SupplyAirTemperature {
            self.nearer = Some(0.5 * (self.row.command + effect));
        }
    }

    fn add(&mut self, actuator: &Actuator, effect: f64) {
        let row = &mut self.row;
        row.lowest = row.lowest.min(effect);
        row.highest = row.highest.max(effect);
        row.mean = (row.mean * self.steps as f64 + effect) / (self.steps + 1) as f64;
        row.error = row.error.max(deviation(actuator, row.command, effect));
        self.steps += 1;
        self.last = effect;
    }

    /// Whether every miss has been followed up.
    fn is_settled(&self) -> bool {
        self.nearer.is_none() && self.probed.is_none()
    }

    /// Whether the coil has shown that it is, or at first was, at its limit.
    fn coil_limit(&self) -> Option<Limit> {
        let ended_well = (self.last - self.row.command).abs() <= self.row.tolerance;
        (!self.moves && (self.held || self.caught_up && ended_well)).then_some(Limit::Coil)
    }

    fn misses(&self) -> bool {
        self.row.error > self.row.tolerance
    }

    /// Takes another hold of the same row in. A miss that is explained does not explain another.
    fn merge(&mut self, other: &Self) {
        let (misses, steps) = (self.misses() || other.misses(), self.steps + other.steps);
        self.limit = match (self.misses(), other.misses()) {
            (true, false) => self.limit,
            (false, true) => other.limit,
            _ => self.limit.and(other.limit),
        }
        .filter(|_| misses);
        let (row, other_row) = (&mut self.row, &other.row);
        let mean = row.mean * self.steps as f64 + other_row.mean * other.steps as f64;
        row.mean = mean / steps as f64;
        row.lowest = row.lowest.min(other_row.lowest);
        row.highest = row.highest.max(other_row.highest);
        row.error = row.error.max(other_row.error);
        self.steps = steps;
    }

    fn judge(&self) -> Verdict {
        match self.limit {
            _ if !self.misses() => Verdict::Follows,
            Some(limit) => Verdict::AtCapacity(limit),
            None => Verdict::Fails,
        }
    }
}

/// A building in a season, under test.
struct Bench<'a> {
    env: Env,
    building: &'a PreparedBuilding,
    season: Season,
    readings: Vec<Reading>,
}

impl Bench<'_> {
    fn hold(&mut self, hold: &Hold) -> Result<()> {
        let actuators: Vec<_> = self.building.actuators().collect();
        let judged =
            |(i, level): &(usize, Level)| Reading::new(actuators[*i], self.season, hold.condition, *level);
        let mut readings: Vec<_> = hold.judged.iter().map(judged).collect();
        let mut action = hold.action.clone();
        for step in 0..HELD + PROBED {
            if step >= HELD && readings.iter().all(Reading::is_settled) {
                break;
            }
            for ((i, _), reading) in hold.judged.iter().zip(&readings) {
                action[*i] = reading.nearer.unwrap_or(reading.row.command);
            }
            self.env.step(&action)?;
            for ((i, _), reading) in hold.judged.iter().zip(&mut readings) {
                if (1..HELD).contains(&step) || !reading.is_settled() {
                    reading.see(actuators[*i], self.effect(*i, actuators[*i]));
                }
            }
        }
        for ((i, _), reading) in hold.judged.iter().zip(&mut readings) {
            reading.limit = reading.coil_limit().or(self.flow_limit(*i, &reading.row));
        }
        self.readings.append(&mut readings);
        Ok(())
    }

    /// What an actuator drives, in the unit of its command.
    fn effect(&self, i: usize, actuator: &Actuator) -> f64 {
        self.env.effect(i).unwrap_or(f64::NAN) / actuator.effect_scale
    }

    /// The limit that an air loop's flows are at.
    fn flow_limit(&self, i: usize, row: &Row) -> Option<Limit> {
        let mut first = 0;
        for system in &self.building.systems {
            let actuators = system.actuators();
            let range = first..first + actuators.len();
            first = range.end;
            let System::AirLoop(air_loop) = system else { continue };
            if !range.contains(&i) {
                continue;
            }
            let dampers = range.zip(actuators).filter(|(_, a)| a.quantity == Quantity::DamperOpening);
            let supplied: f64 = dampers.map(|(i, _)| self.env.effect(i).unwrap_or(f64::NAN)).sum();
            let reaches = |flow: f64, limit: f64, tolerance: f64| (flow / limit - 1.0).abs() <= tolerance;
            return match row.quantity {
                Quantity::DamperOpening => reaches(supplied, air_loop.fan_flow, 0.01).then_some(Limit::Fan),
                Quantity::OutdoorAirFlow => {
                    let outdoor = self.env.effect(i).unwrap_or(f64::NAN);
                    let makes_up = outdoor > row.command && outdoor <= 1.02 * air_loop.exhaust_flow;
                    let all = reaches(outdoor, supplied, 0.02).then_some(Limit::SupplyFlow);
                    all.or(makes_up.then_some(Limit::Exhaust))
                }
                _ => None,
            };
        }
        None
    }

    /// Raises and lowers the heating setpoints, and judges them by heat and zone temperature.
    fn heat(&mut self) -> Result<Vec<Row>> {
        const LEVELS: [Level; 5] = [Level::Low, Level::Middle, Level::Low, Level::High, Level::Low];
        let zones = heated_zones(self.building);
        let actuators: Vec<_> = self.building.actuators().collect();
        let mut rows: Vec<Vec<Row>> = Vec::new();
        for level in LEVELS {
            let hold = heat_hold(self.building, level);
            let read =
                |&(i, _): &(usize, usize)| Reading::new(actuators[i], self.season, hold.condition, level);
            let mut readings: Vec<_> = zones.iter().map(read).collect();
            for _ in 0..HEATED {
                let step = self.env.step(&hold.action)?;
                for (&(i, slot), reading) in zones.iter().zip(&mut readings) {
                    reading.add(actuators[i], step.observation[slot]);
                }
            }
            let ended = |(&(i, _), reading): (&(usize, usize), Reading)| {
                let heat = self.env.heat(i);
                Row {
                    mean: reading.last,
                    heat,
                    error: (reading.last - reading.row.command).abs(),
                    ..reading.row
                }
            };
            rows.push(zones.iter().zip(readings).map(ended).collect());
        }
        Ok((0..zones.len())
            .flat_map(|zone| judge_heat([0, 1, 2, 3, 4].map(|hold| &rows[hold][zone])))
            .collect())
    }
}

/// The actuators that are heating setpoints, each with the slot of its zone's temperature.
fn heated_zones(building: &PreparedBuilding) -> Vec<(usize, usize)> {
    let slot = |zone: &str| building.zones.iter().position(|z| z.name.eq_ignore_ascii_case(zone));
    let zone_of = |name: &str| {
        building.systems.iter().find_map(|system| match system {
            System::HeatingOnly(heater) if heater.setpoint.name == name => slot(&heater.zone),
            System::AirLoop(air_loop) => {
                let terminal = air_loop.terminals.iter().find(|t| t.reheat.name == name)?;
                slot(&terminal.zone)
            }
            _ => None,
        })
    };
    building.actuators().enumerate().filter_map(|(i, a)| Some((i, zone_of(&a.name)?))).collect()
}

/// Rows of the holds low, middle, low, high, low: every raise is judged against its neighbours.
fn judge_heat(holds: [&Row; 5]) -> [Row; 3] {
    let [before, middle, between, high, after] = holds;
    let raised = |row: &Row, low: [&Row; 2]| Row { verdict: judge_raise(row, low), ..row.clone() };
    let low = Row { verdict: judge_idle(before), ..before.clone() };
    [low, raised(middle, [before, between]), raised(high, [between, after])]
}

/// A raised setpoint raises heat and temperature, unless the zone is above it and gets no heat.
fn judge_raise(row: &Row, low: [&Row; 2]) -> Verdict {
    let base = |value: fn(&Row) -> f64| 0.5 * (value(low[0]) + value(low[1]));
    let heat = |row: &Row| row.heat.unwrap_or(0.0);
    let rises = row.mean > base(|row| row.mean) + RISE;
    let holds = (row.mean - row.command).abs() <= AT_SETPOINT;
    if heat(row) > base(heat) + SOME_HEAT && (rises || holds) {
        Verdict::Follows
    } else if heat(row) < SOME_HEAT && row.mean > row.command {
        Verdict::AtCapacity(Limit::WarmZone)
    } else {
        Verdict::Fails
    }
}

/// Above its setpoint a zone gets no heat; below it gets some.
fn judge_idle(row: &Row) -> Verdict {
    let heated = row.heat.unwrap_or(0.0) > SOME_HEAT;
    match row.mean - row.command {
        above if above > AT_SETPOINT && heated => Verdict::Fails,
        above if above < -AT_SETPOINT && !heated => Verdict::Fails,
        _ => Verdict::Follows,
    }
}

/// One row for all holds of an actuator at a level under a condition. A coil is at capacity only if it follows
/// something else.
fn rows(readings: &[Reading]) -> Vec<Row> {
    let mut merged: Vec<Reading> = Vec::new();
    for reading in readings {
        let same = |r: &&mut Reading| {
            let key = |r: &Reading| (r.row.actuator.clone(), r.row.condition, r.row.level);
            key(r) == key(reading)
        };
        match merged.iter_mut().find(same) {
            Some(known) => known.merge(reading),
            None => merged.push(reading.clone()),
        }
    }
    let alive = |reading: &Reading| {
        merged.iter().any(|r| {
            r.row.actuator == reading.row.actuator && r.row.condition == reading.row.condition && !r.misses()
        })
    };
    let judged = merged.iter().map(|reading| {
        let verdict = match reading.judge() {
            Verdict::AtCapacity(Limit::Coil) if !alive(reading) => Verdict::Fails,
            verdict => verdict,
        };
        Row { verdict, ..reading.row.clone() }
    });
    judged.collect()
}

impl Report {
    /// The rows with a verdict of this kind.
    pub fn failures(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|row| row.verdict == Verdict::Fails)
    }
}

/// A table, one line a row.
impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.rows.iter().map(|row| row.actuator.chars().count()).max().unwrap_or(8);
        writeln!(
            f,
            "{:width$} season with         level   command   lowest     mean  highest    error    limit heat/W  verdict",
            "actuator",
        )?;
        for row in &self.rows {
            writeln!(f, "{:width$} {row}", row.actuator)?;
        }
        let count = |wanted: fn(&Verdict) -> bool| self.rows.iter().filter(|r| wanted(&r.verdict)).count();
        write!(
            f,
            "{}: {} follow, {} at capacity, {} fail",
            self.building,
            count(|v| *v == Verdict::Follows),
            count(|v| matches!(v, Verdict::AtCapacity(_))),
            count(|v| *v == Verdict::Fails),
        )
    }
}

/// The cells after the actuator's name.
impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:6} {:12} {:6} ", word(&self.season), word(&self.condition), word(&self.level))?;
        for value in [self.command, self.lowest, self.mean, self.highest] {
            write!(f, "{value:8.3} ")?;
        }
        match is_flow(self.quantity) {
            true => write!(f, "{:7.2}% {:7.0}% ", 100.0 * self.error, 100.0 * self.tolerance)?,
            false if self.tolerance.is_finite() => {
                write!(f, "{:6.2} K {:6.1} K ", self.error, self.tolerance)?
            }
            false => write!(f, "{:6.2} K {:>8} ", self.error, "-")?,
        }
        match self.heat {
            Some(heat) => write!(f, "{heat:6.0} ")?,
            None => write!(f, "{:>6} ", "-")?,
        }
        match self.verdict {
            Verdict::Follows => f.write_str(" follows"),
            Verdict::AtCapacity(limit) => write!(f, " at capacity: {}", word(&limit)),
            Verdict::Fails => f.write_str(" FAILS"),
        }
    }
}

/// The name of an enum's value as it is serialised, with spaces.
fn word(value: &impl Serialize) -> String {
    let name = serde_json::to_value(value).ok();
    name.as_ref().and_then(|n| n.as_str()).unwrap_or("?").replace('_', " ")
}
