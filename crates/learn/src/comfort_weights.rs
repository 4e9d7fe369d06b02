//! Comfort as a constraint: for every evaluated building a multiplier of the penalty of discomfort, which grows while the agent,
//! acting without noise, leaves more discomfort than it may, and falls while it leaves less (Tessler et al. 2019).

/// Discomfort below which there is nothing to tell apart, K·h per zone and day: half of what a score at comfort grants.
const RESOLVED: f64 = 0.05;
/// Largest change of a multiplier by one evaluation, as a factor.
const LARGEST_CHANGE: f64 = 2.0;
/// Limits of a multiplier.
const LIMITS: [f32; 2] = [0.03, 30.0];

/// The multipliers of a run, relative to the task's own weight of discomfort.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ComfortWeights {
    buildings: Vec<String>,
    weights: Vec<f32>,
}

impl ComfortWeights {
    /// Returns multipliers of 1 for the buildings of evaluations.
    pub fn new(buildings: Vec<String>) -> Self {
        Self { weights: vec![1.0; buildings.len()], buildings }
    }

    /// Returns the multiplier in a building: its own, or the geometric mean of all in a building that is not evaluated.
    pub fn of(&self, building: &str) -> f32 {
        let each = self.buildings.iter().zip(&self.weights);
        let own: Vec<f32> = each.filter(|(name, _)| *name == building).map(|(_, weight)| *weight).collect();
        geometric_mean(if own.is_empty() { &self.weights } else { &own })
    }

    /// Returns the geometric mean of the multipliers.
    pub fn mean(&self) -> f32 {
        geometric_mean(&self.weights)
    }

    /// Returns the multipliers, in the order of the evaluations.
    pub fn weights(&self) -> &[f32] {
        &self.weights
    }

    /// Restores the multipliers of a checkpoint; none leave them as they are.
    pub fn set(&mut self, weights: &[f32]) {
        if weights.len() == self.weights.len() {
            self.weights.copy_from_slice(weights);
        }
    }

    /// Follows an evaluation, by its number, that left `reached` of an `allowed` discomfort, K·h per zone and day.
    pub fn follow(&mut self, evaluation: usize, reached: f64, allowed: f64, rate: f64) {
        let excess = (reached + RESOLVED) / (allowed + RESOLVED);
        let change = excess.clamp(1.0 / LARGEST_CHANGE, LARGEST_CHANGE).powf(rate);
        if change.is_finite() {
            let weight = &mut self.weights[evaluation];
            *weight = (*weight * change as f32).clamp(LIMITS[0], LIMITS[1]);
        }
    }
}

/// Returns the geometric mean; 1 of nothing.
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

    #[test]
    fn a_multiplier_grows_with_too_much_discomfort_and_falls_with_less_than_allowed() {
        let mut weights = ComfortWeights::new(vec!["A".into(), "B".into()]);
        weights.follow(0, 0.35, 0.15, 1.0);
        weights.follow(1, 0.0, 0.15, 0.5);
        assert_eq!(weights.weights(), [2.0, 0.5f32.sqrt()]);
        assert_eq!((weights.of("A"), weights.of("B")), (2.0, 0.5f32.sqrt()));
        assert!((weights.of("C") - 2f32.powf(0.25)).abs() < 1e-6, "a building between both");
        weights.follow(0, f64::NAN, 0.15, 1.0);
        (0..99).for_each(|_| weights.follow(0, 9.0, 0.0, 1.0));
        assert_eq!(weights.of("A"), 30.0);
        assert_eq!(ComfortWeights::default().of("A"), 1.0, "no constraint");
    }
}
