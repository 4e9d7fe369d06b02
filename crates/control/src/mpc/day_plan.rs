//! The search over the hours of a day.
//!
//! Effects add up over points and hours. At a price of discomfort, every hour has a best level of every shift, so that
//! the search is for the lowest price at which the day has no more discomfort than under the guideline, apart from what
//! counts as none.

use b2b_env::PREVIEW_HOURS;

use super::drivers::Drivers;
use super::model::Model;
use crate::search::SAME_DISCOMFORT;

/// Highest price of discomfort, in the mean hour's cost per mean hour's discomfort.
const HIGHEST_PRICE: f64 = 1e3;
/// Bisections of the price.
const BISECTIONS: usize = 20;
/// Largest discomfort that may be added, relative to the guideline's: effects are known relative to it.
const LARGEST_PART: f64 = 0.5;

/// Predicted effects of a level in an hour.
#[derive(Clone, Copy, Debug, Default)]
struct Predicted {
    cost: f64,
    discomfort: f64,
}

/// The levels of a shift.
#[derive(Clone, Debug)]
struct Shifted {
    name: String,
    /// Its effects in the model.
    effects: Vec<usize>,
    /// The chosen effect of every hour; `None` is the guideline's choice.
    chosen: [Option<usize>; PREVIEW_HOURS],
}

/// Predictions and choices of a day.
#[derive(Clone, Debug)]
pub(super) struct DayPlan {
    shifts: Vec<Shifted>,
    /// By effect and hour; `None` for a level that is not known to save cost or discomfort.
    predicted: Vec<[Option<Predicted>; PREVIEW_HOURS]>,
    /// Discomfort that a day may add, relative to the mean hour's.
    allowed: f64,
}

impl DayPlan {
    pub(super) fn new(model: &Model) -> Self {
        let mut shifts: Vec<Shifted> = Vec::new();
        for (number, effect) in model.effects.iter().enumerate() {
            match shifts.iter_mut().find(|own| own.name == effect.shift) {
                Some(own) => own.effects.push(number),
                None => shifts.push(Shifted {
                    name: effect.shift.clone(),
                    effects: vec![number],
                    chosen: [None; PREVIEW_HOURS],
                }),
            }
        }
        let part = SAME_DISCOMFORT / model.deviation.max(SAME_DISCOMFORT / LARGEST_PART);
        let predicted = vec![[None; PREVIEW_HOURS]; model.effects.len()];
        Self { shifts, predicted, allowed: part * PREVIEW_HOURS as f64 }
    }

    /// Returns the number of a shift, if the model has effects of it.
    pub(super) fn shift(&self, name: &str) -> Option<usize> {
        self.shifts.iter().position(|own| own.name == name)
    }

    /// Predicts the effects of all levels in an hour from its drivers.
    pub(super) fn expect(&mut self, model: &Model, ahead: usize, of_day: usize, drivers: Drivers) {
        for (predicted, [cost, discomfort]) in self.predicted.iter_mut().zip(model.predict(of_day, drivers)) {
            let helps = cost < 0.0 || discomfort < 0.0;
            predicted[ahead] = helps.then_some(Predicted { cost, discomfort });
        }
    }

    /// Chooses the levels of every hour.
    pub(super) fn choose(&mut self) {
        if self.choose_at(0.0) <= self.allowed {
            return;
        }
        let [mut low, mut high] = [0.0, HIGHEST_PRICE];
        for _ in 0..BISECTIONS {
            let price = f64::midpoint(low, high);
            if self.choose_at(price) > self.allowed { low = price } else { high = price }
        }
        self.choose_at(high);
    }

    /// Chooses the levels at a price of discomfort. Returns the discomfort of the day.
    fn choose_at(&mut self, price: f64) -> f64 {
        let mut discomfort = 0.0;
        for shift in &mut self.shifts {
            for (hour, chosen) in shift.chosen.iter_mut().enumerate() {
                let mut lowest = 0.0;
                let mut own = 0.0;
                *chosen = None;
                for &effect in &shift.effects {
                    let Some(predicted) = self.predicted[effect][hour] else { continue };
                    let total = predicted.cost + price * predicted.discomfort;
                    if total < lowest {
                        (*chosen, lowest, own) = (Some(effect), total, predicted.discomfort);
                    }
                }
                discomfort += own;
            }
        }
        discomfort
    }

    /// Returns the value of a shift in the first hour, in its unit.
    pub(super) fn first(&self, model: &Model, shift: usize) -> f64 {
        self.shifts[shift].chosen[0].map_or(0.0, |effect| model.effects[effect].value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A plan of one shift with two levels, the same in all hours.
    fn plan(levels: [Predicted; 2]) -> DayPlan {
        let shift = Shifted { name: "a".to_owned(), effects: vec![0, 1], chosen: [None; PREVIEW_HOURS] };
        let predicted = levels.map(|own| [Some(own); PREVIEW_HOURS]).into();
        DayPlan { shifts: vec![shift], predicted, allowed: 0.0 }
    }

    #[test]
    fn the_cheapest_level_is_chosen_that_has_no_more_discomfort_than_the_guideline() {
        let cheap = Predicted { cost: -0.2, discomfort: 0.1 };
        let comfortable = Predicted { cost: -0.1, discomfort: 0.0 };
        let mut own = plan([cheap, comfortable]);
        own.choose();
        assert_eq!(own.shifts[0].chosen[0], Some(1));
        let mut own = plan([cheap, Predicted { cost: 0.1, discomfort: -0.3 }]);
        // The cheap level, if other hours make up for its discomfort.
        own.predicted[1][..12].fill(None);
        own.choose();
        assert_eq!(own.shifts[0].chosen[0], Some(0));
        let mut own = plan([cheap, comfortable]);
        own.allowed = 25.0 * cheap.discomfort;
        own.choose();
        assert_eq!(own.shifts[0].chosen[0], Some(0), "a little more is allowed");
        let mut own = plan([cheap, cheap]);
        own.choose();
        assert_eq!(own.shifts[0].chosen, [None; PREVIEW_HOURS], "the guideline");
    }
}
