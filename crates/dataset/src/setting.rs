//! Settings of a sample: parameters that are fixed or drawn from a range.

use std::str::FromStr;

use b2b_building::{BuildingType, Parameter};

use crate::commercial::CommercialParameters;
use crate::house::{Foundation, NUMBERS};
use crate::{Error, Result};

/// Parameters of a house that are integers or words.
const HOUSE_CHOICES: [&str; 4] = ["year", "storeys", "foundation", "garage"];
/// Parameters of the heating system of a house.
const HEATING: [&str; 4] = ["heater", "heater_efficiency", "heat_pump_cop", "heat_pump_cutoff"];

/// A parameter, by its name in the manifest, with a value or a range: `infiltration=0.5..1.2`, `storeys=2` or
/// `foundation=slab`.
///
/// A range is sampled uniformly; for a house this replaces the distribution of the stock.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    name: String,
    /// The value, as given.
    text: String,
    /// Both ends, equal for a fixed number; `None` for text.
    range: Option<[f64; 2]>,
}

impl Setting {
    /// Creates a setting for a parameter drawn from a range, or fixed if both ends are equal.
    pub fn range(name: &str, low: f64, high: f64) -> Self {
        let text = if low == high { low.to_string() } else { format!("{low}..{high}") };
        Self { name: name.to_owned(), text, range: Some([low, high]) }
    }

    /// Returns the names of the parameters of a type.
    pub fn names(building_type: BuildingType) -> Vec<&'static str> {
        if building_type == BuildingType::SingleFamilyHouse {
            let numbers = NUMBERS.map(|number| number.name());
            return HOUSE_CHOICES.into_iter().chain(numbers).chain(HEATING).collect();
        }
        CommercialParameters::NAMES.to_vec()
    }

    /// Returns the number at a relative position in the range, rounded to `decimals` unless it is fixed or no rounded
    /// number is in the range.
    pub(super) fn number(&self, share: f64, decimals: i32, bound: Parameter) -> Result<f64> {
        let [low, high] = self.within(bound)?;
        if low == high {
            return Ok(low);
        }
        let value = low + share * (high - low);
        let near = rounded_within(value, decimals, low, high);
        Ok(if (low..=high).contains(&near) { near } else { value })
    }

    /// Returns the integer at a relative position in the range, both ends included.
    pub(super) fn whole(&self, share: f64, bound: Parameter) -> Result<u32> {
        let [low, high] = self.within(bound)?;
        if low.fract() != 0.0 || high.fract() != 0.0 {
            return Err(self.wrong(format!("expected whole numbers from {} to {}", bound.low, bound.high)));
        }
        Ok((low + share * (high - low + 1.0)).min(high) as u32)
    }

    /// Returns whether the value is a word.
    pub(super) fn is(&self, word: &str) -> bool {
        self.text.eq_ignore_ascii_case(word)
    }

    /// Returns the value of a word.
    pub(super) fn word<T: Copy>(&self, words: &[(&str, T)]) -> Result<T> {
        words.iter().find(|(word, _)| self.is(word)).map(|(_, value)| *value).ok_or_else(|| {
            let words: Vec<_> = words.iter().map(|(word, _)| *word).collect();
            self.wrong(format!("expected {}", words.join(" or ")))
        })
    }

    fn within(&self, bound: Parameter) -> Result<[f64; 2]> {
        let Parameter { low, high, .. } = bound;
        let range = self.range.ok_or_else(|| {
            self.wrong(format!("expected a number from {low} to {high}, or a range such as {low}..{high}"))
        })?;
        range.iter().try_for_each(|end| bound.check(*end))?;
        if range[0] > range[1] {
            return Err(self.wrong("expected the lower end first".to_owned()));
        }
        Ok(range)
    }

    /// Returns an error with what to do.
    pub(super) fn wrong(&self, remedy: String) -> Error {
        Error::Setting { name: self.name.clone(), text: self.text.clone(), remedy }
    }
}

impl FromStr for Setting {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let (name, value) = text
            .split_once('=')
            .map(|(name, value)| (name.trim(), value.trim()))
            .ok_or_else(|| Error::Setting {
                name: text.to_owned(),
                text: String::new(),
                remedy: "expected NAME=VALUE or NAME=LOW..HIGH".to_owned(),
            })?;
        let (low, high) = value.split_once("..").unwrap_or((value, value));
        let range = low.parse().ok().zip(high.parse().ok()).map(|(low, high)| [low, high]);
        Ok(Self { name: name.to_owned(), text: value.to_owned(), range })
    }
}

/// Checks that every setting names a parameter of the type, without repetition.
pub(super) fn check(settings: &[Setting], building_type: BuildingType) -> Result<()> {
    let known = Setting::names(building_type);
    for (index, setting) in settings.iter().enumerate() {
        if !known.contains(&setting.name.as_str()) {
            return Err(unknown(&setting.name, building_type, &known));
        }
        if settings[..index].iter().any(|other| other.name == setting.name) {
            return Err(setting.wrong("it was given twice".to_owned()));
        }
    }
    Ok(())
}

fn unknown(name: &str, building_type: BuildingType, known: &[&'static str]) -> Error {
    let likeness = |known: &&'static str| strsim::jaro_winkler(known, name);
    let near = known.iter().copied().max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
    Error::UnknownParameter {
        name: name.to_owned(),
        building_type,
        near: near.filter(|near| likeness(near) > 0.8),
        known: known.join(", "),
    }
}

/// The setting of a parameter.
pub(super) fn of<'a>(settings: &'a [Setting], name: &str) -> Option<&'a Setting> {
    settings.iter().find(|setting| setting.name == name)
}

/// Foundations by name.
pub(super) const FOUNDATIONS: [(&str, Foundation); 3] =
    [("basement", Foundation::Basement), ("slab", Foundation::Slab), ("crawlspace", Foundation::Crawlspace)];

/// Rounds to a number of decimals. The result is the number that its decimal text parses to, because integers and
/// powers of ten are exact and division rounds correctly.
pub(super) fn rounded(value: f64, decimals: i32) -> f64 {
    let scale = power_of_ten(decimals);
    (value * scale).round() / scale
}

/// [`rounded`], or the adjacent number that is within the bounds.
pub(super) fn rounded_within(value: f64, decimals: i32, low: f64, high: f64) -> f64 {
    let (near, scale) = (rounded(value, decimals), power_of_ten(decimals));
    if near < low {
        (value * scale).ceil() / scale
    } else if near > high {
        (value * scale).floor() / scale
    } else {
        near
    }
}

fn power_of_ten(decimals: i32) -> f64 {
    (0..decimals).fold(1.0, |power, _| power * 10.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::house::House;

    const BOUND: Parameter = Parameter::new("infiltration", "1", 0.5, 1.5);

    fn setting(text: &str) -> Setting {
        text.parse().unwrap()
    }

    #[test]
    fn numbers_ranges_and_words_are_parsed_and_drawn() {
        assert_eq!(setting("infiltration=0.71234567").number(0.9, 2, BOUND).unwrap(), 0.71234567);
        let range = setting("infiltration = 0.6..0.8");
        assert_eq!(range, Setting { text: "0.6..0.8".into(), ..Setting::range("infiltration", 0.6, 0.8) });
        assert_eq!([0.0, 0.5, 1.0].map(|share| range.number(share, 4, BOUND).unwrap()), [0.6, 0.7, 0.8]);
        // Narrower than its decimals.
        let narrow = setting("infiltration=0.60001..0.60002");
        assert_eq!(narrow.number(0.0, 4, BOUND).unwrap(), 0.60001);
        let storeys = House::STOREYS;
        assert_eq!(
            [0.0, 0.49, 0.51, 1.0].map(|u| setting("storeys=1..2").whole(u, storeys).unwrap()),
            [1, 1, 2, 2]
        );
        assert_eq!(setting("foundation=Slab").word(&FOUNDATIONS).unwrap(), Foundation::Slab);
    }

    #[test]
    fn a_value_out_of_bounds_is_rejected_with_name_value_and_bounds() {
        for (text, words) in [
            ("infiltration=1.6", ["`infiltration`", "1.6", "1.5"]),
            ("infiltration=0.4..1", ["`infiltration`", "0.4", "0.5"]),
            ("infiltration=0.6..inf", ["`infiltration`", "inf", "1.5"]),
            ("infiltration=nan", ["`infiltration`", "NaN", "1.5"]),
            ("infiltration=1..0.6", ["`infiltration`", "1..0.6", "lower end first"]),
            ("infiltration=low", ["`infiltration`", "`low`", "0.5..1.5"]),
            ("infiltration=", ["`infiltration`", "``", "0.5..1.5"]),
        ] {
            let said = setting(text).number(0.5, 4, BOUND).unwrap_err().to_string();
            assert!(words.iter().all(|word| said.contains(word)), "{text}: {said}");
        }
        let said = "infiltration".parse::<Setting>().unwrap_err().to_string();
        assert!(said.contains("NAME=VALUE"), "{said}");
        let said = setting("foundation=rock").word(&FOUNDATIONS).unwrap_err().to_string();
        assert!(said.contains("basement or slab or crawlspace"), "{said}");
        let storeys = House::STOREYS;
        let said = setting("storeys=1.5").whole(0.5, storeys).unwrap_err().to_string();
        assert!(said.contains("whole numbers from 1 to 2"), "{said}");
    }

    #[test]
    fn the_error_of_an_unknown_name_suggests_a_similar_one() {
        let said = |text: &str, of| check(&[setting(text)], of).unwrap_err().to_string();
        let text = said("window_to_wall_ratio=0.4", BuildingType::Warehouse);
        assert!(text.contains("did you mean window_to_wall?") && text.contains("infiltration"), "{text}");
        let text = said("floor_area=100", BuildingType::Warehouse);
        assert!(text.contains("Warehouse") && !text.contains("did you mean"), "{text}");
        let text = said("roof_u=1", BuildingType::SingleFamilyHouse);
        assert!(text.contains("wall_resistance"), "{text}");
        let twice = ["storeys=1", "storeys=2"].map(setting);
        assert!(check(&twice, BuildingType::SingleFamilyHouse).unwrap_err().to_string().contains("twice"));
    }

    #[test]
    fn rounding_stays_within_bounds() {
        assert_eq!(rounded_within(1.635264, 3, 1.635264, 2.0), 1.636);
        assert_eq!(rounded_within(1.9999, 3, 1.0, 1.9999), 1.999);
        assert_eq!(rounded_within(1.2344, 3, 1.0, 2.0), 1.234);
    }
}
