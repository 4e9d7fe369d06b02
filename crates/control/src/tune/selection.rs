//! The choice among the best sets of a search, by buildings that the search did not use.

use super::outcome::{CellOutcome, relative_losses, worst_loss, worst_travel};
use super::plan::TuningPlan;
use crate::Measured;

/// The outcomes of a set of parameters: on the buildings of the search under `occupancy`, under `constant` if the plan
/// requires it, and on the validation buildings under each of [`TuningPlan::VALIDATION_SETPOINTS`].
#[derive(Clone, Debug, PartialEq)]
pub struct Cells {
    /// Outcomes on the buildings of the search.
    pub search: Vec<CellOutcome>,
    /// Outcomes on the same buildings with constant targets; empty unless [`TuningPlan::constant_targets`].
    pub constant: Vec<CellOutcome>,
    /// Outcomes on the buildings of the validation, each with one per setpoint mode.
    pub validation: Vec<Vec<CellOutcome>>,
}

impl Cells {
    fn all(&self) -> Vec<CellOutcome> {
        self.search.iter().chain(&self.constant).chain(self.validation.iter().flatten()).copied().collect()
    }

    /// The cells with setpoints by occupancy.
    fn by_occupancy(&self) -> Vec<CellOutcome> {
        let last = self.validation.iter().filter_map(|outcomes| outcomes.last());
        self.search.iter().chain(last).copied().collect()
    }

    /// Returns whether a set is eligible: actuators hunt in no cell, and in none is it clearly worse than the defaults.
    pub(super) fn is_eligible(&self, plan: &TuningPlan, defaults: &Self) -> bool {
        let (defaults, cells) = (defaults.all(), self.all());
        let limits = plan.limits();
        worst_travel(limits, &defaults, &cells) <= 1.0 && worst_loss(limits, plan, &defaults, &cells) <= 1.0
    }
}

/// Returns the index of the set with the lowest median relative loss over all cells among the eligible ones. The first
/// set is the defaults, which are always eligible.
pub(super) fn select(plan: &TuningPlan, sets: &[Cells]) -> usize {
    let defaults = sets[0].all();
    let score = |set: &Cells| median(relative_losses(plan, &defaults, &set.all()));
    let eligible = sets.iter().enumerate().filter(|(_, set)| set.is_eligible(plan, &sets[0]));
    let best = eligible.map(|(number, set)| (score(set), number)).min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or(0, |(_, number)| number)
}

/// Compares a set of parameters with the defaults over all cells.
pub fn measured(plan: &TuningPlan, defaults: &Cells, chosen: &Cells) -> Measured {
    let (default_cells, cells) = (defaults.all(), chosen.all());
    let relative = relative_losses(plan, &default_cells, &cells);
    let mean = |outcomes: &[CellOutcome], value: fn(&CellOutcome, &TuningPlan) -> f64| {
        outcomes.iter().map(|outcome| value(outcome, plan)).sum::<f64>() / outcomes.len().max(1) as f64
    };
    let travel =
        |outcomes: &[CellOutcome]| outcomes.iter().map(|outcome| outcome.daily_travel).fold(0.0, f64::max);
    Measured {
        worst_relative_loss: relative.iter().copied().fold(0.0, f64::max),
        relative_loss: median(relative),
        default_loss: mean(&default_cells, CellOutcome::loss),
        loss: mean(&cells, CellOutcome::loss),
        default_daily_travel: travel(&default_cells),
        daily_travel: travel(&cells),
        energy: mean(&chosen.by_occupancy(), |outcome, _| outcome.energy / outcome.steps.max(1) as f64),
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { 0.5 * (values[middle - 1] + values[middle]) }
}

#[cfg(test)]
mod tests {
    use super::super::tests::plan;
    use super::*;

    /// A set with these losses per step in the cells of two search and one validation building.
    fn cells(losses: [f64; 4], daily_travel: f64) -> Cells {
        let outcome =
            |temperature_penalty| CellOutcome { temperature_penalty, steps: 1, energy: 2.0, daily_travel };
        let [a, b, c, d] = losses.map(outcome);
        Cells { search: vec![a, b], constant: Vec::new(), validation: vec![vec![c, d]] }
    }

    #[test]
    fn the_least_median_is_selected_over_search_and_validation() {
        let sets = [
            cells([1.0, 2.0, 1.0, 2.0], 1.0),
            // Best only in the search.
            cells([0.1, 0.2, 1.0, 2.1], 1.0),
            cells([0.4, 0.8, 0.4, 0.8], 1.0),
        ];
        assert_eq!(select(&plan(0), &sets), 2);
        assert_eq!(select(&plan(0), &sets[..2]), 1);
        let measured = measured(&plan(0), &sets[0], &sets[2]);
        assert_eq!((measured.relative_loss, measured.default_loss, measured.energy), (0.4, 1.5, 2.0));
    }

    #[test]
    fn a_set_that_hunts_or_is_clearly_worse_in_one_cell_is_not_selected() {
        let defaults = cells([1.0, 2.0, 1.0, 2.0], 1.0);
        let hunting = cells([0.1, 0.2, 0.1, 0.2], 5.1);
        let worse_once = cells([0.1, 0.2, 0.1, 2.3], 1.0);
        assert_eq!(select(&plan(0), &[defaults.clone(), hunting, worse_once]), 0);
        // Twice the loss of the defaults, below what a sensor resolves.
        let [precise, as_precise] = [0.003, 0.006].map(|loss| cells([1.0, 1.0, 1.0, loss], 1.0));
        let better = Cells { search: cells([0.5, 0.5, 0.0, 0.0], 1.0).search, ..as_precise };
        assert_eq!(select(&plan(0), &[precise, better]), 1);
    }
}
