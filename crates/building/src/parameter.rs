//! Declared parameters: a name, a unit and bounds, and tables of them over the fields of a type.

use std::fmt;

use serde::Serialize;

/// A number with a name, a unit and bounds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Parameter {
    /// Its name.
    pub name: &'static str,
    /// Its unit; 1 for a ratio or a count.
    pub unit: &'static str,
    /// The lowest value.
    pub low: f64,
    /// The highest value.
    pub high: f64,
}

impl Parameter {
    /// A parameter of this name and unit between two bounds.
    pub const fn new(name: &'static str, unit: &'static str, low: f64, high: f64) -> Self {
        Self { name, unit, low, high }
    }

    /// Checks that a value is a number within the bounds.
    ///
    /// # Errors
    /// [`OutOfBounds`] when it is not.
    pub fn check(&self, value: f64) -> Result<(), OutOfBounds> {
        // A comparison with NaN is false.
        if (self.low..=self.high).contains(&value) {
            return Ok(());
        }
        Err(OutOfBounds { parameter: *self, value })
    }

    /// Returns the value at a share of the way from the lowest (0) to the highest (1).
    pub fn at(&self, share: f64) -> f64 {
        (self.low + share * (self.high - self.low)).clamp(self.low, self.high)
    }
}

/// A value that is not a number within the bounds of its parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutOfBounds {
    /// The parameter.
    pub parameter: Parameter,
    /// Its value.
    pub value: f64,
}

impl std::error::Error for OutOfBounds {}

impl fmt::Display for OutOfBounds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Parameter { name, unit, low, high } = self.parameter;
        write!(f, "parameter `{name}` is {}; expected a number from {low} to {high}", self.value)?;
        if unit == "1" { Ok(()) } else { write!(f, " {unit}") }
    }
}

/// A parameter that is a field of `T`: one row of a table of parameters.
#[derive(Debug)]
pub struct Field<T> {
    /// Name, unit and bounds.
    pub parameter: Parameter,
    field: fn(&mut T) -> &mut f64,
}

// A derived implementation would require `T: Clone` and `T: Copy`.
impl<T> Clone for Field<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Field<T> {}

impl<T: Clone> Field<T> {
    /// The field that `field` returns, as a parameter.
    pub const fn new(parameter: Parameter, field: fn(&mut T) -> &mut f64) -> Self {
        Self { parameter, field }
    }

    /// Returns the value of the field.
    pub fn of(&self, whole: &T) -> f64 {
        *(self.field)(&mut whole.clone())
    }

    /// Sets the field, without a check.
    pub fn set(&self, whole: &mut T, value: f64) {
        *(self.field)(whole) = value;
    }

    /// Checks that the value of the field is a number within the bounds.
    ///
    /// # Errors
    /// [`OutOfBounds`] when it is not.
    pub fn check(&self, whole: &T) -> Result<(), OutOfBounds> {
        self.parameter.check(self.of(whole))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AREA: Parameter = Parameter::new("floor_area", "m²", 40.0, 1000.0);

    #[test]
    fn a_value_out_of_bounds_is_named_with_bounds_and_unit() {
        for value in [39.0, 1001.0, f64::NAN, f64::INFINITY] {
            let error = AREA.check(value).unwrap_err().to_string();
            let words = ["`floor_area`", &value.to_string(), "40", "1000 m²"];
            assert!(words.iter().all(|word| error.contains(word)), "{error}");
        }
        AREA.check(40.0).unwrap();
        let ratio = Parameter::new("ratio", "1", 0.0, 0.5).check(1.0).unwrap_err().to_string();
        assert!(ratio.ends_with("from 0 to 0.5"), "{ratio}");
    }

    #[test]
    fn the_ends_of_the_unit_interval_are_the_bounds() {
        assert_eq!([0.0, 0.5, 1.0].map(|share| AREA.at(share)), [40.0, 520.0, 1000.0]);
    }

    #[test]
    fn a_field_is_read_set_and_checked() {
        let width: Field<[f64; 2]> = Field::new(Parameter::new("width", "m", 0.0, 1.0), |size| &mut size[1]);
        let mut size = [0.0, 0.5];
        width.set(&mut size, 2.0);
        assert_eq!((width.of(&size), width.check(&size).is_err()), (2.0, true));
    }
}
