//! The action space: one value per actuator, in physical units.

use b2b_building::PreparedBuilding;
use b2b_building::hvac::Quantity;
use b2b_building::morphology::Owner;

use crate::{Error, Result};

/// Names, units and bounds of the action, one entry per actuator.
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

    /// Returns the space of the actuators at these indices, in this order.
    pub fn select(&self, actuators: &[usize]) -> Self {
        let bounds = |values: &[f64]| actuators.iter().map(|&index| values[index]).collect();
        Self {
            names: actuators.iter().map(|&index| self.names[index].clone()).collect(),
            owners: actuators.iter().map(|&index| self.owners[index]).collect(),
            quantities: actuators.iter().map(|&index| self.quantities[index]).collect(),
            low: bounds(&self.low),
            high: bounds(&self.high),
        }
    }

    /// Returns a space without actuators.
    #[cfg(test)]
    pub(crate) fn empty() -> Self {
        Self { names: vec![], owners: vec![], quantities: vec![], low: vec![], high: vec![] }
    }

    /// Number of actuators.
    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// Returns whether there are no actuators.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    /// Names of the actuators, for example `Core_ZN supply air flow`.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Part of the building to which each actuator belongs.
    pub fn owners(&self) -> &[Owner] {
        &self.owners
    }

    /// Quantity that each actuator controls; gives its unit.
    pub fn quantities(&self) -> &[Quantity] {
        &self.quantities
    }

    /// Lower bounds.
    pub fn low(&self) -> &[f64] {
        &self.low
    }

    /// Upper bounds.
    pub fn high(&self) -> &[f64] {
        &self.high
    }

    /// Returns the action with every actuator in the middle of its range.
    pub fn middle(&self) -> Vec<f64> {
        self.low.iter().zip(&self.high).map(|(low, high)| (low + high) / 2.0).collect()
    }

    /// Checks the length of an action and that all values are finite.
    ///
    /// # Errors
    /// [`Error::ActionLength`]; [`Error::ActionNotFinite`] with the name of the actuator.
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

    /// Converts an action from [-1, 1] to physical units in place: see [`rescale`].
    pub fn rescale(&self, action: &mut [f64]) {
        for ((value, low), high) in action.iter_mut().zip(&self.low).zip(&self.high) {
            *value = rescale(*value, *low, *high);
        }
    }

    /// Writes the given action, clamped to the bounds, to `applied`. Returns the number of clamped values.
    ///
    /// # Errors
    /// The errors of [`ActionSpace::check`], before anything is written.
    pub fn clamp_into(&self, given: &[f64], applied: &mut [f64]) -> Result<usize> {
        self.check(given)?;
        let mut clamped = 0;
        for (i, value) in given.iter().enumerate() {
            applied[i] = value.clamp(self.low[i], self.high[i]);
            clamped += usize::from(applied[i] != *value);
        }
        Ok(clamped)
    }
}

/// Maps a value from [-1, 1] to [`low`, `high`], exact at both ends. Values outside are extrapolated.
pub fn rescale(value: f64, low: f64, high: f64) -> f64 {
    let share = (value + 1.0) / 2.0;
    low * (1.0 - share) + high * share
}

/// Maps a value from its bounds to [-1, 1], the inverse of [`rescale`]; 0 if the bounds are equal.
pub fn unscale(value: f64, low: f64, high: f64) -> f64 {
    if high > low { 2.0 * (value - low) / (high - low) - 1.0 } else { 0.0 }
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
    fn values_out_of_bounds_are_clamped_and_counted() {
        let mut applied = [0.0; 2];
        assert_eq!(space().clamp_into(&[0.7, 20.0], &mut applied).unwrap(), 1);
        assert_eq!(applied, [0.5, 20.0]);
    }

    #[test]
    fn rescaling_maps_minus_one_and_one_to_the_bounds_exactly() {
        for (value, expected) in [(-1.0, [0.0, 10.0]), (0.0, [0.25, 27.5]), (1.0, [0.5, 45.0])] {
            let mut action = [value; 2];
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
    fn the_error_for_a_value_that_is_not_finite_names_the_actuator() {
        let error = space().clamp_into(&[0.1, f64::NAN], &mut [0.0; 2]).unwrap_err().to_string();
        assert!(error.contains("`supply`") && error.contains("NaN") && error.contains("°C"), "{error}");
        assert!(space().clamp_into(&[f64::INFINITY, 20.0], &mut [0.0; 2]).is_err());
    }

    #[test]
    fn an_action_of_the_wrong_length_is_rejected() {
        let error = space().clamp_into(&[0.1], &mut [0.0; 2]).unwrap_err().to_string();
        assert!(error.contains('1') && error.contains('2'), "{error}");
    }
}
