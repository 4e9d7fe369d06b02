//! The classes and fields that refer to something outside a model, compared with the engine's schema.

use std::collections::BTreeSet;

use b2b_building::import::external::{CODE, FILES};
use b2b_energyplus::install::{Engine, Quiet};
use ciborium::Value;

/// Words in the name of a field or in its note that suggest a file.
const WORDS: [&str; 6] = ["file", "path", "director", "library", "command", "script"];

/// Fields whose name or note has such a word, but which the engine does not open.
const HARMLESS: [(&str, &str); 11] = [
    ("AirLoopHVAC", "demand_side_outlet_node_name"),
    ("AirLoopHVAC", "supply_side_inlet_node_name"),
    ("AirLoopHVAC:ReturnPath", "return_air_path_outlet_node_name"),
    ("AirLoopHVAC:SupplyPath", "supply_air_path_inlet_node_name"),
    ("AirLoopHVAC:UnitarySystem", "outdoor_dry_bulb_temperature_sensor_node_name"),
    ("Curve:ExponentialSkewNormal", "name"),
    ("Curve:Sigmoid", "name"),
    ("Output:Table:Annual", "filter"),
    ("Output:Table:ReportPeriod", "name"),
    ("Parametric:FileNameSuffix", "suffix_for_file_name_in_run"),
    ("RunPeriod", "name"),
];

/// Returns the schema: a CBOR map in the data of the library that begins with `$schema`.
fn schema() -> Value {
    let engine = Engine::ensure(&mut Quiet).unwrap();
    let library = std::fs::read(engine.library).unwrap();
    let key = b"\x67$schema";
    let at = library.windows(key.len()).position(|bytes| bytes == key).expect("the schema");
    // The byte before the first key is the size of the map.
    ciborium::from_reader(&library[at - 1..]).unwrap()
}

fn entries(value: &Value) -> impl Iterator<Item = (&str, &Value)> {
    value.as_map().into_iter().flatten().map(|(key, value)| (key.as_text().unwrap_or(""), value))
}

fn get<'a>(value: &'a Value, key: &str) -> Option<&'a Value> {
    entries(value).find(|(name, _)| *name == key).map(|(_, value)| value)
}

/// Calls `f` with every field of free text below a part of the schema.
fn texts<'a>(value: &'a Value, f: &mut impl FnMut(&'a str, &'a Value)) {
    for (name, field) in entries(value) {
        let is = |key: &str, text: &str| get(field, key).and_then(Value::as_text) == Some(text);
        let is_text = is("type", "string") || get(field, "anyOf").is_some();
        if is_text && !["enum", "data_type"].iter().any(|key| get(field, key).is_some()) {
            f(name, field);
        }
        texts(field, f);
    }
}

#[test]
fn every_field_of_the_schema_that_names_a_file_is_known() {
    let schema = schema();
    let classes = get(&schema, "properties").unwrap();
    assert!(entries(classes).count() > 800, "the whole schema");
    let runs_code = |class: &str| {
        CODE.iter()
            .any(|(root, _)| class.strip_prefix(root).is_some_and(|r| r.is_empty() || r.starts_with(':')))
    };
    let mut found = BTreeSet::new();
    for (class, definition) in entries(classes).filter(|(class, _)| !runs_code(class)) {
        texts(definition, &mut |field, definition| {
            let note = get(definition, "note").and_then(Value::as_text).unwrap_or("");
            let text = format!("{field} {note}").to_lowercase();
            if WORDS.iter().any(|word| text.contains(word)) {
                found.insert((class, field));
            }
        });
    }
    let files = FILES.iter().map(|(class, field, _)| (*class, *field));
    let known: BTreeSet<_> = files.chain(HARMLESS).collect();
    assert_eq!(found, known);
}

#[test]
fn every_class_that_runs_code_is_in_the_schema() {
    let schema = schema();
    let classes: Vec<&str> = entries(get(&schema, "properties").unwrap()).map(|(class, _)| class).collect();
    for (root, _) in CODE {
        assert!(classes.iter().any(|class| class.starts_with(root)), "{root}");
    }
}
