//! Guideline 36 under shifts that are linear in the weather and in what zones need: the simplest supervisor that is the
//! same in every building.
//!
//! Every hour, a point is shifted by a share of its limit: a constant, plus a weight times how cold it is outdoors,
//! plus weights times the mean outputs of the heating and cooling loops of its zones in the last hour. [`tune`] finds
//! the weights in many buildings at a time.

mod kind;
mod search;
mod surface;

use std::collections::BTreeMap;
use std::path::Path;

use b2b_building::morphology::Owner;
use b2b_env::{Controller, Decisions, Spaces};
use serde::{Deserialize, Serialize};

use crate::guideline36::{Guideline36, Guideline36Parameters, Shift, SupervisoryPoint};
use crate::parameter_set::read;
use crate::{Error, Result};
pub(crate) use kind::Kind;
pub use kind::{identity, rule_of};
pub use search::{Round, TriedEpisode, Tries, TunedWeights, WeightSearchOptions, run, tune};

/// Outdoor temperature above which it is not cold, °C, and the difference that counts as 1, K.
const COLD: [f64; 2] = [10.0, 20.0];

/// The weights of a kind of shift, as shares of its limits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Weights {
    /// Share at any inputs.
    pub constant: f64,
    /// Weight of (10 °C - outdoor temperature)/20 K, from 0 to 1.
    pub cold: f64,
    /// Weight of the mean output of the heating loops, 0 to 1.
    pub heating: f64,
    /// Weight of the mean output of the cooling loops, 0 to 1.
    pub cooling: f64,
}

/// Weights by the name of a shift. A shift without weights stays 0.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Rule(pub BTreeMap<String, Weights>);

impl Weights {
    /// Number of weights.
    const COUNT: usize = 4;

    fn share(&self, inputs: [f64; Self::COUNT]) -> f64 {
        let weights = [self.constant, self.cold, self.heating, self.cooling];
        weights.iter().zip(inputs).map(|(weight, input)| weight * input).sum()
    }
}

impl Rule {
    /// Reads a rule from a JSON file.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::ParameterFile`] with the reason.
    pub fn read(path: &Path) -> Result<Self> {
        let rule: Self = read(path)?;
        match rule.check() {
            Ok(()) => Ok(rule),
            Err(why) => Err(Error::ParameterFile { path: path.to_owned(), why }),
        }
    }

    /// Checks that every name is a shift's and every weight finite.
    fn check(&self) -> std::result::Result<(), String> {
        let known: Vec<&str> = [Shift::AIR_LOOP, Shift::UNIT, Shift::ZONE]
            .concat()
            .iter()
            .map(|each| each.described().0)
            .collect();
        if let Some(name) = self.0.keys().find(|name| !known.contains(&name.as_str())) {
            return Err(format!("unknown shift `{name}`; expected one of {}", known.join(", ")));
        }
        let is_finite = |own: &Weights| own.share([1.0; Weights::COUNT]).is_finite();
        match self.0.iter().find(|(_, own)| !is_finite(own)) {
            Some((name, _)) => Err(format!("a weight of `{name}` is not a finite number")),
            None => Ok(()),
        }
    }

    /// Returns the weights of each point.
    fn of(&self, points: &[SupervisoryPoint]) -> Vec<Weights> {
        let of =
            |point: &SupervisoryPoint| self.0.get(point.shift.described().0).copied().unwrap_or_default();
        points.iter().map(of).collect()
    }
}

/// The shares of their limits by which a rule shifts the points of a building.
#[derive(Clone, Debug)]
pub struct RuleShares {
    /// The weights of every point, by day; the last day's stay in effect.
    days: Vec<Vec<Weights>>,
    /// The heating and the cooling loops of each point's zones, as numbers of decisions.
    loops: Vec<[Vec<usize>; 2]>,
    /// Sum of each decision in the hour.
    sums: Vec<f64>,
    shares: Vec<f64>,
    outdoor: usize,
    steps_per_hour: usize,
    step: usize,
}

impl RuleShares {
    /// Creates the shares of a building's points under a rule for each day; the last one stays in effect.
    ///
    /// # Errors
    /// [`Error::Values`] for an unknown shift, a weight that is not finite, or no rule.
    pub fn new(spaces: &Spaces, guideline: &Guideline36, rules: &[Rule]) -> Result<Self> {
        let points = guideline.supervisory_points();
        rules.iter().try_for_each(Rule::check).map_err(|why| Error::Values { why })?;
        if rules.is_empty() {
            return Err(Error::Values { why: "there is no rule".to_owned() });
        }
        let decisions = guideline.record().map_or(0, |record| record.values.len());
        Ok(Self {
            days: rules.iter().map(|rule| rule.of(points)).collect(),
            loops: points.iter().map(|point| loops_of(spaces, guideline, point)).collect(),
            sums: vec![0.0; decisions],
            shares: vec![0.0; points.len()],
            outdoor: spaces.observation.outdoor_temperature(),
            steps_per_hour: spaces.episode.steps_per_hour as usize,
            step: 0,
        })
    }

    /// Begins an episode.
    pub fn reset(&mut self) {
        self.sums.fill(0.0);
        self.step = 0;
    }

    /// Returns the share of each point, from -1 to 1, in the step after an observation. Call it once per step.
    pub fn next(&mut self, points: &[SupervisoryPoint], observation: &[f64]) -> &[f64] {
        if self.step.is_multiple_of(self.steps_per_hour) {
            self.decide(points, observation);
        }
        self.step += 1;
        &self.shares
    }

    /// Takes what the sequences decided in a step.
    pub fn follow(&mut self, guideline: &Guideline36) {
        if let Some(record) = guideline.record() {
            self.sums.iter_mut().zip(&record.values).for_each(|(sum, value)| *sum += value);
        }
    }

    /// Sets the shares for the next hour.
    fn decide(&mut self, points: &[SupervisoryPoint], observation: &[f64]) {
        let day = (self.step / (24 * self.steps_per_hour)).min(self.days.len() - 1);
        let cold = ((COLD[0] - observation[self.outdoor]) / COLD[1]).clamp(0.0, 1.0);
        let points = points.iter().zip(&self.days[day]).zip(&self.loops);
        for (share, ((point, weights), loops)) in self.shares.iter_mut().zip(points) {
            let mean = |loops: &[usize]| {
                let sum: f64 = loops.iter().map(|decision| self.sums[*decision]).sum();
                sum / (loops.len().max(1) * self.steps_per_hour) as f64
            };
            let own = weights.share([1.0, cold, mean(&loops[0]), mean(&loops[1])]).clamp(-1.0, 1.0);
            *share = within_band(point.shift, own);
        }
        self.sums.fill(0.0);
    }
}

/// The guideline's sequences under a rule.
#[derive(Clone, Debug)]
pub struct LinearSupervisor {
    guideline: Guideline36,
    shares: RuleShares,
    values: Vec<f64>,
}

impl LinearSupervisor {
    /// Creates the sequences of a building under a rule for each day; the last one stays in effect.
    ///
    /// # Errors
    /// Same as [`RuleShares::new`].
    pub fn new(spaces: &Spaces, rules: &[Rule]) -> Result<Self> {
        let guideline = Guideline36::new(spaces, &Guideline36Parameters::default());
        let shares = RuleShares::new(spaces, &guideline, rules)?;
        Ok(Self { values: vec![0.0; guideline.supervisory_points().len()], shares, guideline })
    }
}

/// Returns a share that keeps setpoints within their band: outside, they only trade comfort for cost.
fn within_band(shift: Shift, share: f64) -> f64 {
    match shift {
        Shift::HeatingSetpoint => share.max(0.0),
        Shift::CoolingSetpoint => share.min(0.0),
        _ => share,
    }
}

/// Returns the decisions of the heating and the cooling loops of the zones that a point acts on.
fn loops_of(spaces: &Spaces, guideline: &Guideline36, point: &SupervisoryPoint) -> [Vec<usize>; 2] {
    let building = &spaces.building;
    let zones: Vec<usize> = match point.owner {
        Owner::Zone(zone) => vec![zone],
        Owner::AirLoop(system) => {
            let layout = building.laid_out_systems().nth(system).map(|(_, layout)| layout);
            layout.map_or_else(Vec::new, |layout| layout.zones.iter().map(|zone| zone.index).collect())
        }
        _ => Vec::new(),
    };
    let slots = guideline.record().map_or(&[][..], Decisions::slots);
    ["heating loop", "cooling loop"].map(|what| {
        let number = |zone: &usize| {
            let name = format!("{} {what}", building.zones[*zone].name);
            slots.iter().position(|slot| slot.name == name)
        };
        zones.iter().filter_map(number).collect()
    })
}

impl Controller for LinearSupervisor {
    fn reset(&mut self) {
        self.guideline.reset();
        self.shares.reset();
    }

    fn act(&mut self, observation: &[f64], action: &mut [f64]) {
        let points = self.guideline.supervisory_points();
        let shares = self.shares.next(points, observation);
        for (value, (point, share)) in self.values.iter_mut().zip(points.iter().zip(shares)) {
            *value = point.value(*share);
        }
        self.guideline.supervise(&self.values);
        self.guideline.act(observation, action);
        self.shares.follow(&self.guideline);
    }

    fn record(&self) -> Option<&Decisions> {
        self.guideline.record()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_is_the_sum_of_the_weighted_inputs() {
        let weights = Weights { constant: 0.1, cold: 0.5, heating: 1.0, cooling: -2.0 };
        assert!((weights.share([1.0, 2.0, 0.5, 0.25]) - 1.1).abs() < 1e-12);
        assert_eq!(within_band(Shift::HeatingSetpoint, -0.5), 0.0);
        assert_eq!(within_band(Shift::CoolingSetpoint, 0.5), 0.0);
        assert_eq!(within_band(Shift::SupplyTemperature, 0.5), 0.5);
    }

    #[test]
    fn a_rule_names_shifts_and_has_finite_weights() {
        let rule = |text: &str| serde_json::from_str::<Rule>(text).unwrap();
        rule(r#"{"earlier start": {"cold": 0.5}}"#).check().unwrap();
        let said = rule(r#"{"earlier strat": {}}"#).check().unwrap_err();
        assert!(said.contains("unknown shift `earlier strat`") && said.contains("earlier start"), "{said}");
        let weights = Weights { cold: f64::NAN, ..Weights::default() };
        let said = Rule([("earlier start".to_owned(), weights)].into()).check().unwrap_err();
        assert!(said.contains("not a finite number"), "{said}");
    }
}
