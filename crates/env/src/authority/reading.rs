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
    /// The largest move of the outlet with a missed probe, beyond what a coil at capacity allows, K.
    moved: f64,
    /// All changes of the outlet between steps under the unchanged command, K.
    travel: f64,
    /// The outlet at the first step, °C.
    first: f64,
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
            moved: 0.0,
            travel: 0.0,
            first: f64::NAN,
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
            if !met {
                self.moved = self.moved.max(moved - little - drift);
            }
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
        match self.steps {
            0 => self.first = effect,
            _ => self.travel += (effect - self.last).abs(),
        }
        self.steps += 1;
        self.last = effect;
    }

    /// Returns whether every miss has been probed.
    pub(super) fn is_settled(&self) -> bool {
        self.nearer.is_none() && self.probed.is_none()
    }

    /// Returns [`Limit::Coil`] if the coil was shown to be at capacity, throughout or at first.
    pub(super) fn coil_limit(&self) -> Option<Limit> {
        let still = self.moved <= self.unrest();
        (still && (self.held || self.caught_up && self.ended_well())).then_some(Limit::Coil)
    }

    /// Returns how far the outlet moves back and forth while the command is the same, K: a plant that cycles moves it.
    fn unrest(&self) -> f64 {
        (0.5 * (self.travel - (self.last - self.first).abs())).max(0.0)
    }

    /// Returns whether the last response met the command.
    fn ended_well(&self) -> bool {
        (self.last - self.row.command).abs() <= self.row.tolerance
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

/// Returns one row per actuator, level and condition, over all holds. A coil is at capacity only if some hold at the
/// same flow ends at its command.
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
        readings.iter().any(|r| {
            r.row.actuator == reading.row.actuator
                && r.row.condition == reading.row.condition
                && r.ended_well()
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

#[cfg(test)]
mod tests {
    use b2b_building::hvac::EngineVariable;

    use super::*;

    /// The verdict on a supply temperature of 45 °C at full flow, for the outlet under each command, and on others at
    /// the same flow.
    fn verdict(outlet: impl Fn(usize, f64) -> f64, other: f64) -> Verdict {
        let effect = EngineVariable::new("", "");
        let quantity = Quantity::SupplyAirTemperature;
        let actuator = Actuator::of_schedule(String::new(), String::new(), quantity, [10.0, 45.0], effect);
        let new = |level| Reading::new(&actuator, Season::Winter, Condition::FullFlow, level);
        let [mut high, mut middle] = [Level::High, Level::Middle].map(new);
        for step in 1..11 {
            high.see(&actuator, outlet(step, high.nearer.unwrap_or(high.row.command)));
            middle.see(&actuator, other);
        }
        high.limit = high.coil_limit();
        rows(&[high, middle])[0].verdict
    }

    #[test]
    fn a_coil_whose_plant_cycles_is_at_capacity_and_one_that_moves_with_its_command_is_not() {
        let cycles = |step: usize, _| 40.3 + [0.0, 0.1, 0.7, 0.2, 0.9, 0.3, -0.1, 0.7, 0.0, -0.2][step - 1];
        assert_eq!(verdict(cycles, 27.5), Verdict::AtCapacity(Limit::Coil));
        let offset = |step: usize, sent: f64| 0.9 * sent + 0.3 * (step / 2 % 2) as f64;
        assert_eq!(verdict(offset, 27.5), Verdict::Fails, "it has capacity left");
        let lags = |step: usize, sent: f64| sent - 20.0 * 0.8_f64.powi(step as i32);
        assert_eq!(verdict(lags, 27.5), Verdict::Fails, "a slow control is not a limit");
    }

    #[test]
    fn an_outlet_at_capacity_must_end_at_some_other_command() {
        assert_eq!(verdict(|_, _| 40.0, 27.4), Verdict::AtCapacity(Limit::Coil));
        assert_eq!(verdict(|_, _| 40.0, 40.0), Verdict::Fails, "it never moves");
    }
}
