//! Fields and the engine's descriptions of their sizes.
//!
//! Most descriptions are the name of the field. Others say the same in other words:
//! `Supply Air Flow Rate During Cooling Operation` is `cooling_supply_air_flow_rate`. Within an object, the pairs with
//! the most words in common belong together. Fields with given values take part, so that an autosized field does not
//! take the size of another.

use std::collections::BTreeSet;

/// Smallest share of common words in all words of a pair.
const SIMILAR: f64 = 0.4;
/// Score advantage of a field that the engine sizes: a given one is reported as `User-Specified`.
const ADVANTAGE: f64 = 1e-6;
/// Two pairs with shares as near as this are ambiguous.
const EQUAL: f64 = 1e-9;

/// Returns the epJSON field that a description names: without `Design Size` and a unit in brackets, in snake case.
/// `User-Specified …` and `Initial Design Size …` keep their prefix and therefore match no field.
pub(super) fn field_name(description: &str) -> String {
    let description = description.strip_prefix("Design Size ").unwrap_or(description);
    let description = description.split(['[', '(']).next().unwrap_or_default();
    let words = description.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    words.map(str::to_ascii_lowercase).collect::<Vec<_>>().join("_")
}

/// Returns pairs of a field and a description, as indices. Descriptions are given as names of fields; a field comes
/// with whether the engine sizes it. Pairs of the same name come first, then pairs with the most words in common; of
/// fields with equally many, the one that the engine sizes; ambiguous ones are left out.
pub(super) fn pairs(fields: &[(&str, bool)], descriptions: &[&str]) -> Vec<(usize, usize)> {
    let mut scores: Vec<(f64, usize, usize)> = Vec::new();
    for (f, &(field, is_sized)) in fields.iter().enumerate() {
        for (d, &description) in descriptions.iter().enumerate() {
            let score = if field == description { f64::INFINITY } else { similarity(field, description) };
            if score >= SIMILAR {
                scores.push((score + if is_sized { ADVANTAGE } else { 0.0 }, f, d));
            }
        }
    }
    scores.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut found: Vec<(usize, usize)> = Vec::new();
    while let Some(&(score, f, d)) = scores.first() {
        let is_rival = |other: &(f64, usize, usize)| score.is_finite() && (score - other.0).abs() < EQUAL;
        let several_fields = scores.iter().any(|other| other.1 != f && other.2 == d && is_rival(other));
        let several_descriptions = scores.iter().any(|other| other.1 == f && other.2 != d && is_rival(other));
        if !several_fields && !several_descriptions {
            found.push((f, d));
        }
        // `Supply Air Flow Rate` fits the flows of cooling and of heating alike and is neither.
        let drops_field = several_descriptions || !several_fields;
        let drops_description = several_fields || !several_descriptions;
        scores.retain(|other| !(drops_field && other.1 == f || drops_description && other.2 == d));
    }
    found
}

/// Returns the share of common words in all words of two names; 0 if their numbers differ.
fn similarity(a: &str, b: &str) -> f64 {
    let words = |name: &'_ str| name.split('_').map(str::to_owned).collect::<BTreeSet<_>>();
    let (a, b) = (words(a), words(b));
    let numbers = |words: &BTreeSet<String>| {
        words.iter().filter(|word| word.parse::<u32>().is_ok()).cloned().collect::<Vec<_>>()
    };
    if numbers(&a) != numbers(&b) {
        return 0.0;
    }
    let common = a.intersection(&b).count() as f64;
    common / a.union(&b).count() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn description_of<'a>(field: &str, fields: &[&str], descriptions: &[&'a str]) -> Option<&'a str> {
        let names: Vec<String> = descriptions.iter().map(|text| field_name(text)).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let fields: Vec<_> = fields.iter().map(|name| (*name, true)).collect();
        let is_field = |(f, _): &&(usize, usize)| fields[*f].0 == field;
        pairs(&fields, &names).iter().find(is_field).map(|(_, d)| descriptions[*d])
    }

    #[test]
    fn a_description_names_its_field() {
        assert_eq!(field_name("Design Size Maximum Air Flow Rate"), "maximum_air_flow_rate");
        assert_eq!(field_name("Design Size maximum_flow_rate"), "maximum_flow_rate");
        assert_eq!(field_name("Design Size U-Factor Times Area Value [W/K]"), "u_factor_times_area_value");
        assert_eq!(field_name("Design Flow Rate"), "design_flow_rate");
    }

    #[test]
    fn other_words_for_the_same_belong_together() {
        let flows = [
            "Supply Air Flow Rate During Cooling Operation",
            "Supply Air Flow Rate During Heating Operation",
            "Supply Air Flow Rate When No Cooling or Heating is Needed",
        ];
        let fields =
            ["no_load_supply_air_flow_rate", "cooling_supply_air_flow_rate", "heating_supply_air_flow_rate"];
        let with_another = [&["Supply Air Flow Rate"], &flows[..]].concat();
        for (field, flow) in fields.iter().zip([flows[2], flows[0], flows[1]]) {
            assert_eq!(description_of(field, &fields, &flows), Some(flow));
            assert_eq!(description_of(field, &fields, &with_another), Some(flow));
        }
        let tower =
            ["Fan Power at Design Air Flow Rate", "U-Factor Times Area Value at Design Air Flow Rate"];
        let fields = ["design_u_factor_times_area_value", "design_fan_power"];
        assert_eq!(description_of(fields[0], &fields, &tower), Some(tower[1]));
        assert_eq!(description_of(fields[1], &fields, &tower), Some(tower[0]));
    }

    #[test]
    fn a_size_belongs_to_the_field_that_the_engine_sizes() {
        let pump = [("design_maximum_flow_rate", true), ("design_minimum_flow_rate", false)];
        assert_eq!(pairs(&pump, &["design_flow_rate"]), [(0, 0)]);
        let both = pump.map(|(field, _)| (field, true));
        assert_eq!(pairs(&both, &["design_flow_rate"]), []);
    }

    #[test]
    fn other_numbers_and_few_common_words_do_not_belong_together() {
        let speeds = ["speed_1_gross_rated_sensible_heat_ratio"];
        assert_eq!(description_of(speeds[0], &speeds, &["Speed 2 Rated Sensible Heat Ratio"]), None);
        let field = ["maximum_hot_water_or_steam_flow_rate"];
        assert_eq!(
            description_of(field[0], &field, &["Maximum Flow per Zone Floor Area during Reheat"]),
            None
        );
    }
}
