//! The action: one value per actuator, in physical units.

use b2b_building::PreparedBuilding;
use b2b_building::hvac::Quantity;
use b2b_building::morphology::Owner;

use crate::{Error, Result};

/// Names, units and bounds of the action, in its order.
#[derive(Clone, Debug)]
pub struct ActionSpace {
    names: Vec<String>,
    owners: Vec<Owner>,
    quantities: Vec<Quantity>,
    low: Vec<f64>,
    high: Vec<f64>,
}

impl ActionSpace {
    pub(crate) fn of(building: &PreparedBuilding) -> Self {
        let of = |value: fn(&b2b_building::hvac::Actuator) -> f64| building.actuators().map(value).collect();
        Self {
            names: building.actuators().map(|a| a.name.clone()).collect(),
            owners: building.owned_actuators().map(|(owner, _)| owner).collect(),
            quantities: building.actuators().map(|a| a.quantity).collect(),
            low: of(|a| a.low),
            high: of(|a| a.high),
        }
    }

    /// These actuators alone, by their numbers and in this order.
    pub fn select(&self, actuators: &[usize]) -> Self {
        let numbers = |values: &[f64]| actuators.iter().map(|&number| values[number]).collect();
        Self {
            names: actuators.iter().map(|&number| self.names[number].clone()).collect(),
            owners: actuators.iter().map(|&number| self.owners[number]).collect(),
            quantities: actuators.iter().map(|&number| self.quantities[number]).collect(),
            low: numbers(&self.low),
            high: numbers(&self.high),
        }
    }

    /// A space without actuators.
    #[cfg(test)]
    pub(crate) fn empty() -> Self {
        Self { names: vec![], owners: vec![], quantities: vec![], low: vec![], high: vec![] }
    }

    /// Number of actuators.
    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// Whether there is nothing to drive.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    /// Names, for example `Core_ZN supply air flow`.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The part of the building that each actuator belongs to.
    pub fn owners(&self) -> &[Owner] {
        &self.owners
    }

    /// What each actuator drives; gives its unit.
    pub fn quantities(&self) -> &[Quantity] {
        &self.quantities
    }

    /// Lowest values.
    pub fn low(&self) -> &[f64] {
        &self.low
    }

    /// Highest values.
    pub fn high(&self) -> &[f64] {
        &self.high
    }

    /// Whether an action can be carried out.
    ///
    /// # Errors
    /// [`Error::ActionLength`]; [`Error::ActionNotFinite`] naming the actuator.
    pub fn check(&self, given: &[f64]) -> Result<()> {
        if given.len() != self.len() {
            return Err(Error::ActionLength { given: given.len(), expected: self.len() });
        }
        if let Some(i) = given.iter().position(|v| !v.is_finite()) {
            return Err(Error::ActionNotFinite {
                actuator: self.names[i].clone(),
                value: given[i],
                low: self.low[i],
                high: self.high[i],
                unit: self.quantities[i].unit(),
            });
        }
        Ok(())
    }

    /// Makes shares of the bounds, -1 for the lowest and 1 for the highest value, an action in physical units. What is
    /// beyond is clamped later, as any action is; a value without an actuator stays as it is.
    pub fn rescale(&self, action: &mut [f64]) {
        for ((value, low), high) in action.iter_mut().zip(&self.low).zip(&self.high) {
            let share = (*value + 1.0) / 2.0;
            // Exact at both ends.
            *value = low * (1.0 - share) + high * share;
        }
    }

    /// Writes the action that is carried out for the one given: every value within its bounds. Returns how
    /// many values were out of bounds.
    ///
    /// # Errors
    /// As [`ActionSpace::check`], before anything is written to the engine.
    pub fn clamp_into(&self, given: &[f64], carried_out: &mut [f64]) -> Result<usize> {
        self.check(given)?;
        let mut outside = 0;
        for (i, value) in given.iter().enumerate() {
            carried_out[i] = value.clamp(self.low[i], self.high[i]);
            outside += usize::from(carried_out[i] != *value);
        }
        Ok(outside)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn space() -> ActionSpace {
        ActionSpace {
            names: vec!["fan".into(), "supply".into()],
            owners: vec![Owner::Zone(0); 2],
            quantities: vec![Quantity::SupplyAirFlow, Quantity::SupplyAirTemperature],
            low: vec![0.0, 10.0],
            high: vec![0.5, 45.0],
        }
    }

    #[test]
    fn an_action_out_of_bounds_is_clamped_and_counted() {
        let mut done = [0.0; 2];
        assert_eq!(space().clamp_into(&[0.7, 20.0], &mut done).unwrap(), 1);
        assert_eq!(done, [0.5, 20.0]);
    }

    #[test]
    fn shares_of_the_bounds_reach_them_and_not_beyond() {
        for (share, expected) in [(-1.0, [0.0, 10.0]), (0.0, [0.25, 27.5]), (1.0, [0.5, 45.0])] {
            let mut action = [share; 2];
            space().rescale(&mut action);
            assert_eq!(action, expected);
            assert_eq!(space().clamp_into(&action, &mut [0.0; 2]).unwrap(), 0);
        }
    }

    #[test]
    fn selected_actuators_keep_their_names_and_bounds() {
        let flow = space().select(&[0]);
        assert_eq!(
            (flow.names(), flow.low(), flow.high()),
            (&["fan".to_owned()][..], &[0.0][..], &[0.5][..])
        );
        assert_eq!(space().select(&[1, 0]).quantities()[0], Quantity::SupplyAirTemperature);
    }

    #[test]
    fn a_nan_is_refused_by_name() {
        let error = space().clamp_into(&[0.1, f64::NAN], &mut [0.0; 2]).unwrap_err().to_string();
        assert!(error.contains("`supply`") && error.contains("NaN") && error.contains("°C"), "{error}");
        assert!(space().clamp_into(&[f64::INFINITY, 20.0], &mut [0.0; 2]).is_err());
    }

    #[test]
    fn an_action_of_the_wrong_length_is_refused() {
        let error = space().clamp_into(&[0.1], &mut [0.0; 2]).unwrap_err().to_string();
        assert!(error.contains('1') && error.contains('2'), "{error}");
    }
}
