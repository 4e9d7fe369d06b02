//! An agent above the sequences of Guideline 36: it shifts what they choose, and they run the equipment.

use b2b_control::guideline36::SupervisoryPoint;
use b2b_control::linear_supervisor::{RuleShares, rule_of};
use b2b_control::{Controller, Guideline36, Guideline36Parameters};
use b2b_env::Spaces;

use crate::acting::Acting;

/// Guideline 36 under the actions of an agent. An action of 0 leaves its points to the guideline, or to the rule of
/// `linear-supervisor`; actions are added to its shares of their limits.
#[derive(Clone, Debug)]
pub struct Supervisor {
    guideline: Guideline36,
    rule: Option<RuleShares>,
    names: Vec<String>,
    /// The supervisory points that it shifts, by their indices.
    shifted: Vec<usize>,
    /// The action of each of them.
    actions: Vec<usize>,
    /// Shares of their limits and values of all supervisory points.
    shares: Vec<f64>,
    values: Vec<f64>,
    observation: Vec<f64>,
    action: Vec<f64>,
}

impl Supervisor {
    /// Creates a supervisor with an action for every point that it shifts, or for every kind of shift. With `by_node`,
    /// no two points share an action.
    pub(crate) fn new(acting: Acting, by_node: bool, spaces: &Spaces) -> Self {
        let shared = !by_node && matches!(acting, Acting::Supervisory { shared: true, .. });
        let guideline = Guideline36::new(spaces, &Guideline36Parameters::default());
        let mut names: Vec<String> = Vec::new();
        let mut action = |point: &SupervisoryPoint| {
            let name = if shared { point.shift.described().0 } else { &point.name };
            let known = names.iter().position(|known| known == name);
            known.unwrap_or_else(|| {
                names.push(name.to_owned());
                names.len() - 1
            })
        };
        let points = guideline.supervisory_points();
        let shifted: Vec<usize> =
            (0..points.len()).filter(|&index| acting.sets(points[index].shift)).collect();
        let actions: Vec<usize> = shifted.iter().map(|&index| action(&points[index])).collect();
        let rule = acting.starts_from_rule().then(|| {
            let rule = [rule_of(&spaces.building)];
            RuleShares::new(spaces, &guideline, &rule).expect("a test reads the shipped rules")
        });
        Self {
            rule,
            shares: vec![0.0; points.len()],
            values: vec![0.0; points.len()],
            observation: vec![0.0; spaces.observation.len()],
            action: vec![0.0; spaces.action.len()],
            guideline,
            names,
            shifted,
            actions,
        }
    }

    /// Returns the names of the actions.
    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    /// Returns the points that it shifts.
    pub(crate) fn points(&self) -> impl Iterator<Item = &SupervisoryPoint> {
        self.shifted.iter().map(|&index| &self.guideline.supervisory_points()[index])
    }

    /// Returns the sequences.
    pub(crate) fn guideline(&self) -> &Guideline36 {
        &self.guideline
    }

    /// Returns the decisions behind the last action, in the order of the guideline's record.
    pub(crate) fn decisions(&self) -> &[f64] {
        self.guideline.record().map_or(&[], |decisions| &decisions.values)
    }

    /// Begins an episode.
    pub(crate) fn reset(&mut self) {
        self.guideline.reset();
        if let Some(rule) = &mut self.rule {
            rule.reset();
        }
    }

    /// Takes the next observation of the environment.
    pub(crate) fn observe(&mut self, observation: &[f64]) {
        self.observation.copy_from_slice(observation);
    }

    /// Returns the action of the sequences, in physical units, for an action of the agent in [-1, 1].
    pub(crate) fn act(&mut self, row: &[f32]) -> &[f64] {
        let points = self.guideline.supervisory_points();
        match &mut self.rule {
            Some(rule) => self.shares.copy_from_slice(rule.next(points, &self.observation)),
            None => self.shares.fill(0.0),
        }
        for (&index, &action) in self.shifted.iter().zip(&self.actions) {
            self.shares[index] += f64::from(row[action]);
        }
        for (value, (point, share)) in self.values.iter_mut().zip(points.iter().zip(&self.shares)) {
            *value = point.value(*share);
        }
        self.guideline.supervise(&self.values);
        self.guideline.act(&self.observation, &mut self.action);
        if let Some(rule) = &mut self.rule {
            rule.follow(&self.guideline);
        }
        &self.action
    }
}
