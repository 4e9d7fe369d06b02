//! Response of one actuator during a hold, and whether its equipment was at capacity.

use b2b_building::hvac::{Actuator, Quantity};

use super::report::{Condition, Level, Limit, Row, Season, Verdict, is_flow};

/// Ratio of outlet change to command change below which a coil is at capacity.
const SATURATED: f64 = 0.2;
/// Outlet change that inlet air may cause, K.
const DRIFT: f64 = 0.05;
/// Largest deviation of a decaying outlet from the mean of its neighboring steps, as a share of the decay.
const CURVATURE: f64 = 0.25;

fn tolerance(quantity: Quantity) -> f64 {
    match quantity {
        Quantity::SupplyAirFlow | Quantity::DamperOpening => 0.01,
        Quantity::OutdoorAirFlow => 0.02,
        Quantity::SupplyAirTemperature => 0.2,
        Quantity::HeatingSetpoint | Quantity::CoolingSetpoint => f64::INFINITY,
    }
}

/// Returns the deviation of a response from its command: see [`Row::error`].
fn deviation(actuator: &Actuator, command: f64, effect: f64) -> f64 {
    let scale = match is_flow(actuator.quantity) {
        true if command > 0.0 => command,
        true => actuator.high,
        false => 1.0,
    };
    (effect - command).abs() / scale
}

/// Response of one actuator in one hold.
#[derive(Clone)]
pub(super) struct Reading {
    pub(super) row: Row,
    steps: usize,
    pub(super) last: f64,
    /// Command of the next step while a miss is probed: halfway to the reached value.
    pub(super) nearer: Option<f64>,
    /// The last probe: its command and the response.
    probed: Option<(f64, f64)>,
    /// Whether any probe was met.
    caught_up: bool,
    /// Whether any probe was missed.
    held: bool,
    /// Whether any missed probe moved the outlet.
    moves: bool,
    pub(super) limit: Option<Limit>,
}

impl Reading {
    pub(super) fn new(actuator: &Actuator, season: Season, condition: Condition, level: Level) -> Self {
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
            message: None,
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

    /// Records the response of a step; a missed supply temperature is probed with a nearer command.
    pub(super) fn see(&mut self, actuator: &Actuator, effect: f64) {
        if let Some(nearer) = self.nearer.take() {
            self.probed = Some((nearer, effect));
            return;
        }
        if let Some((nearer, outlet)) = self.probed.take() {
            // Coils that share a plant may change the other way: what one does not need, another gets.
            let toward = (nearer - self.row.command).signum();
            let moved = toward * (outlet - 0.5 * (self.last + effect));
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

    pub(super) fn add(&mut self, actuator: &Actuator, effect: f64) {
        let row = &mut self.row;
        row.lowest = row.lowest.min(effect);
        row.highest = row.highest.max(effect);
        row.mean = (row.mean * self.steps as f64 + effect) / (self.steps + 1) as f64;
        row.error = row.error.max(deviation(actuator, row.command, effect));
        self.steps += 1;
        self.last = effect;
    }

    /// Returns whether every miss has been probed.
    pub(super) fn is_settled(&self) -> bool {
        self.nearer.is_none() && self.probed.is_none()
    }

    /// Returns [`Limit::Coil`] if the coil was shown to be at capacity, throughout or at first.
    pub(super) fn coil_limit(&self) -> Option<Limit> {
        let ended_well = (self.last - self.row.command).abs() <= self.row.tolerance;
        (!self.moves && (self.held || self.caught_up && ended_well)).then_some(Limit::Coil)
    }

    fn misses(&self) -> bool {
        self.row.error > self.row.tolerance
    }

    /// Merges another hold of the same row. A limit found for one miss does not excuse another.
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

    pub(super) fn judge(&self) -> Verdict {
        match self.limit {
            _ if !self.misses() => Verdict::Follows,
            Some(limit) => Verdict::AtCapacity(limit),
            None => Verdict::Fails,
        }
    }
}

/// Returns one row per actuator, level and condition, over all holds. A coil is at capacity only if it follows some other
/// command.
pub(super) fn rows(readings: &[Reading]) -> Vec<Row> {
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
