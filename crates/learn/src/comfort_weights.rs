//! Comfort as a constraint: for every evaluated building and run period a multiplier of the penalty of discomfort,
//! which grows while the agent, acting without noise, leaves more discomfort than it may, and falls while it leaves
//! less (Tessler et al. 2019).

use b2b_building::{BuildingType, Period};
use b2b_dataset::{BuildingName, Control};
use b2b_env::EpisodeConfig;

use crate::error::Result;

/// Discomfort added to both sides of a ratio, so that values near 0 count as equal, K·h per zone and day: half the free
/// allowance of a score at comfort.
const RESOLVED: f64 = 0.05;
/// Largest change of a multiplier by one evaluation at a rate of 1, as a factor.
const LARGEST_CHANGE: f64 = 2.0;
/// The multipliers of a run, relative to the task's own weight of discomfort.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ComfortWeights {
    /// Building and run period of each evaluation.
    held: Vec<(String, Period)>,
    weights: Vec<f32>,
}

impl ComfortWeights {
    /// Limits of a multiplier.
    pub const LIMITS: [f32; 2] = [0.03, 30.0];

    /// Returns multipliers for the buildings and run periods of evaluations, which begin at this value.
    pub fn new(held: Vec<(String, Period)>, first: f32) -> Self {
        Self { weights: vec![first; held.len()], held }
    }

    /// Returns the numbers of the evaluations whose multipliers count in an episode of a building: its own in the run
    /// period of the episode; for a building that is not evaluated, those of its type in this period; for a type that
    /// is not evaluated, all in this period. Empty if no evaluation is in this period.
    ///
    /// # Errors
    /// [`Error::Env`](crate::Error::Env) for an unreadable weather file.
    pub fn counting(&self, building: &str, episode: &EpisodeConfig) -> Result<Vec<usize>> {
        let mut known: Vec<(Period, bool)> = Vec::new();
        let mut in_period = Vec::new();
        for (number, (_, period)) in self.held.iter().enumerate() {
            let has_it = match known.iter().find(|(known, _)| known == period) {
                Some((_, has_it)) => *has_it,
                None => {
                    let days = period.in_weather(&episode.weather).map_err(b2b_env::Error::building)?;
                    let has_it = days.overlaps(episode.period);
                    known.push((*period, has_it));
                    has_it
                }
            };
            in_period.extend(has_it.then_some(number));
        }
        let those = |is_near: &dyn Fn(&str) -> bool| -> Vec<usize> {
            in_period.iter().copied().filter(|number| is_near(&self.held[*number].0)).collect()
        };
        let (building, _) = Control::split_name(building);
        let own = those(&|held| held == building);
        if !own.is_empty() {
            return Ok(own);
        }
        let of_type = type_of(building).map(|own| those(&|held| type_of(held) == Some(own)));
        Ok(of_type.filter(|of_type| !of_type.is_empty()).unwrap_or(in_period))
    }

    /// Returns the geometric mean of the multipliers of some evaluations; of all if there are none.
    pub fn of(&self, evaluations: &[usize]) -> f32 {
        match evaluations {
            [] => self.mean(),
            some => geometric_mean(&some.iter().map(|number| self.weights[*number]).collect::<Vec<_>>()),
        }
    }

    /// Returns the geometric mean of the multipliers.
    pub fn mean(&self) -> f32 {
        geometric_mean(&self.weights)
    }

    /// Returns the multipliers, in the order of the evaluations.
    pub fn weights(&self) -> &[f32] {
        &self.weights
    }

    /// Restores the multipliers of a checkpoint, unless it has a different number of them.
    pub fn set(&mut self, weights: &[f32]) {
        if weights.len() == self.weights.len() {
            self.weights.copy_from_slice(weights);
        }
    }

    /// Updates the multiplier of an evaluation, by its number, with the discomfort that it `reached` and what is
    /// `allowed`, K·h per zone and day.
    pub fn follow(&mut self, evaluation: usize, reached: f64, allowed: f64, rate: f64) {
        let weight = &mut self.weights[evaluation];
        *weight = Self::next(*weight, reached, allowed, rate);
    }

    /// Returns the multiplier after an evaluation: see [`ComfortWeights::follow`].
    pub fn next(weight: f32, reached: f64, allowed: f64, rate: f64) -> f32 {
        let excess = (reached + RESOLVED) / (allowed + RESOLVED);
        let change = excess.clamp(1.0 / LARGEST_CHANGE, LARGEST_CHANGE).powf(rate);
        match change.is_finite() {
            true => (weight * change as f32).clamp(Self::LIMITS[0], Self::LIMITS[1]),
            false => weight,
        }
    }
}

/// Returns the type of a building; none for a model file.
fn type_of(building: &str) -> Option<BuildingType> {
    match building.parse().ok()? {
        BuildingName::Type(building_type) => Some(building_type),
        BuildingName::Id(id) => Some(id.building_type()),
        BuildingName::Model(_) => None,
    }
}

/// Returns the geometric mean; 1 without values.
fn geometric_mean(weights: &[f32]) -> f32 {
    match weights {
        [] => 1.0,
        [one] => *one,
        all => (all.iter().map(|weight| weight.ln()).sum::<f32>() / all.len() as f32).exp(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn episode(days: &str) -> EpisodeConfig {
        let weather = std::path::PathBuf::from("none.epw");
        EpisodeConfig {
            weather,
            period: days.parse().unwrap(),
            steps_per_hour: 12,
            task: b2b_env::Task::default(),
        }
    }

    #[test]
    fn a_multiplier_grows_with_too_much_discomfort_and_falls_with_less_than_allowed() {
        let winter = |name: &str| (name.to_owned(), Period::WINTER);
        let mut weights = ComfortWeights::new(vec![winter("A"), winter("B")], 1.0);
        weights.follow(0, 0.35, 0.15, 1.0);
        weights.follow(1, 0.0, 0.15, 0.5);
        assert_eq!(weights.weights(), [2.0, 0.5f32.sqrt()]);
        let of = |weights: &ComfortWeights, name: &str| {
            weights.of(&weights.counting(name, &episode("01-08..01-21")).unwrap())
        };
        assert_eq!((of(&weights, "A"), of(&weights, "B")), (2.0, 0.5f32.sqrt()));
        assert!((of(&weights, "C") - 2f32.powf(0.25)).abs() < 1e-6, "a building between both");
        weights.follow(0, f64::NAN, 0.15, 1.0);
        (0..99).for_each(|_| weights.follow(0, 9.0, 0.0, 1.0));
        assert_eq!(of(&weights, "A"), 30.0);
        assert_eq!(of(&ComfortWeights::default(), "A"), 1.0, "no constraint");
    }

    #[test]
    fn a_building_of_an_evaluated_type_has_the_multiplier_of_its_type() {
        let held = ["OfficeMedium-0021", "Warehouse-0021"].map(|name| (name.to_owned(), Period::WINTER));
        let mut weights = ComfortWeights::new(held.into(), 1.0);
        weights.follow(0, 0.0, 0.05, 1.0);
        let of = |name: &str| weights.of(&weights.counting(name, &episode("01-08..01-21")).unwrap());
        assert_eq!([of("OfficeMedium-0500"), of("Warehouse-0500")], [0.5, 1.0]);
        assert!((of("OfficeSmall-0500") - 0.5f32.sqrt()).abs() < 1e-6, "of all types");
    }

    #[test]
    fn every_run_period_has_its_own_multiplier() {
        let held = |days: &str| ("A".to_owned(), days.parse().unwrap());
        let mut weights = ComfortWeights::new(vec![held("winter"), held("summer")], 1.0);
        weights.follow(1, 0.35, 0.15, 1.0);
        for (building, days, expected) in
            [("A", "01-08..01-21", 1.0), ("A", "07-08..07-21", 2.0), ("B", "07-08..07-21", 2.0)]
        {
            let counting = weights.counting(building, &episode(days)).unwrap();
            assert_eq!(weights.of(&counting), expected, "{building} {days}");
        }
        let apart = weights.counting("A", &episode("04-20..04-21")).unwrap();
        assert!((weights.of(&apart) - 2f32.sqrt()).abs() < 1e-6, "a period that is not evaluated");
    }
}
