//! `b2b dataset explore`: all buildings of the dataset on one page.
//!
//! The page has the values of each type by column, without columns that do not apply to it, which keeps it below 2 MB.

use std::path::{Path, PathBuf};

use b2b_building::BuildingType;
use b2b_dataset::manifest::{Kind, Manifest};
use serde_json::{Value, json};

/// File name of the page in a folder.
const NAME: &str = "dataset.html";
const PAGE: &str = include_str!("explore.html");
const SCRIPT: &str = include_str!("explore.js");

/// A parameter on the page: its column, name and unit.
type Parameter = (&'static str, &'static str, &'static str);

/// The parameters of buildings, in the order of the page.
const PARAMETERS: [Parameter; 32] = [
    ("floor_area", "floor area", "m²"),
    ("year", "year of construction", ""),
    ("vintage", "vintage", ""),
    ("storeys", "stories", ""),
    ("wall_u", "wall U-factor", "W/(m²·K)"),
    ("roof_u", "roof U-factor", "W/(m²·K)"),
    ("wall_resistance", "wall insulation", "m²·K/W"),
    ("attic_resistance", "attic insulation", "m²·K/W"),
    ("foundation_resistance", "foundation insulation", "m²·K/W"),
    ("window_u", "window U-factor", "W/(m²·K)"),
    ("window_shgc", "window SHGC", ""),
    ("window_to_wall", "window-to-wall ratio", ""),
    ("infiltration", "infiltration relative to the prototype", ""),
    ("air_changes_50", "air changes at 50 Pa", "1/h"),
    ("x_scale", "scale along x", ""),
    ("y_scale", "scale along y", ""),
    ("aspect", "length over width", ""),
    ("north_axis", "north axis", "°"),
    ("orientation", "orientation", "°"),
    ("foundation", "foundation", ""),
    ("garage", "garage", ""),
    ("occupants", "occupants", ""),
    ("appliance_use", "relative appliance use", ""),
    ("ventilation", "ventilation", "L/s"),
    ("heat_recovery", "heat recovery effectiveness", ""),
    ("heat_pump_cop", "heat pump COP", ""),
    ("heat_pump_cutoff", "heat pump cutoff", "°C"),
    ("heater", "furnace or backup heater", ""),
    ("heater_efficiency", "heater efficiency", ""),
    ("cooling_cop", "cooling COP", ""),
    ("heating_oversizing", "heating oversizing", ""),
    ("cooling_oversizing", "cooling oversizing", ""),
];
/// The parameters of the location.
const LOCATION: [Parameter; 3] = [
    ("place", "place", ""),
    ("climate_zone", "climate zone", ""),
    ("heating_degree_days", "heating degree days (18 °C)", "K·d"),
];

/// Parses the file to write: in a folder, `dataset.html`. Errors for another format than HTML.
pub fn file(text: &str) -> Result<PathBuf, String> {
    let out = Path::new(text);
    if out.is_dir() || out.extension().is_none() {
        Ok(out.join(NAME))
    } else {
        crate::arguments::page::path(text)
    }
}

/// Returns the page.
pub fn page(manifest: &Manifest) -> String {
    let template = PAGE.replace("{{SCRIPT}}", SCRIPT);
    b2b_page::fill(&template, &data(manifest))
}

fn data(manifest: &Manifest) -> Value {
    let parameter = |(column, name, unit): &Parameter| {
        let kind = manifest.columns.iter().find(|each| each.name == *column).map(|each| each.kind);
        let number = matches!(kind, Some(Kind::Number | Kind::Integer));
        json!({"column": column, "name": name, "unit": unit, "number": number})
    };
    let of_type = |building_type: BuildingType| {
        let name = building_type.name();
        let own: Vec<_> = manifest.rows.iter().filter(|row| row[index(manifest, "type")] == name).collect();
        let columns = LOCATION.iter().chain(&PARAMETERS);
        let mut values: serde_json::Map<_, _> = columns
            .map(|(column, ..)| ((*column).to_owned(), column_of(manifest, &own, column)))
            .filter(|(_, values)| values.iter().any(|value| !value.is_null()))
            .map(|(column, values)| (column, values.into()))
            .collect();
        if let Some(prototype) = &building_type.data().prototype {
            let area = prototype.conditioned_floor_area;
            let [x, y] = ["x_scale", "y_scale"].map(|column| column_of(manifest, &own, column));
            let areas = x.iter().zip(&y).map(|(x, y)| Some(area * x.as_f64()? * y.as_f64()?));
            let rounded = areas.map(|area| area.map(|area| (area * 10.0).round() / 10.0));
            values.insert("floor_area".to_owned(), rounded.collect::<Vec<_>>().into());
        }
        let [split, small] = ["split", "test_small"].map(|column| index(manifest, column));
        // 0 for train, 1 for test, 2 for the small test, which is part of test.
        let splits = own.iter().map(|row| match (row[split].as_str(), row[small].as_str()) {
            (_, "true") => 2,
            ("test", _) => 1,
            _ => 0,
        });
        values.insert("split".to_owned(), splits.collect::<Vec<_>>().into());
        json!({"name": name, "description": building_type.description(), "columns": values})
    };
    json!({
        "generator": b2b_dataset::GENERATOR_VERSION,
        "parameters": LOCATION.iter().chain(&PARAMETERS).map(parameter).collect::<Vec<_>>(),
        "types": BuildingType::ALL.map(of_type),
    })
}

/// Returns the values of a column in rows, `null` where it does not apply.
fn column_of(manifest: &Manifest, rows: &[&Vec<String>], column: &str) -> Vec<Value> {
    let index = index(manifest, column);
    let value = |cell: &String| match (cell.as_str(), manifest.columns[index].kind) {
        ("", _) => Value::Null,
        (text, Kind::Text) => text.into(),
        (text, Kind::Flag) => if text == "true" { "yes" } else { "no" }.into(),
        // Integers stay integers.
        (text, Kind::Number | Kind::Integer) => text.parse().unwrap_or(Value::Null),
    };
    rows.iter().map(|row| value(&row[index])).collect()
}

fn index(manifest: &Manifest, column: &str) -> usize {
    let index = manifest.columns.iter().position(|each| each.name == column);
    index.expect("a column of every manifest of the dataset")
}

#[cfg(test)]
mod tests {
    use super::*;
    use b2b_dataset::BUILDINGS_PER_TYPE;

    #[test]
    fn a_folder_gets_a_page_and_a_file_of_another_format_is_refused() {
        let folder = tempfile::Builder::new().suffix(".d").tempdir().unwrap();
        let dotted = folder.path().to_str().unwrap();
        assert_eq!(file(dotted), Ok(folder.path().join(NAME)));
        assert_eq!(file("new/folder"), Ok(Path::new("new/folder").join(NAME)));
        assert_eq!(file("buildings.html"), Ok(PathBuf::from("buildings.html")));
        assert!(file("data.csv").unwrap_err().contains(".html"));
    }

    #[test]
    fn the_page_needs_no_network_and_is_small() {
        for word in ["http://", "https://", "src=", "@import", "<link"] {
            assert!(!PAGE.contains(word) && !SCRIPT.contains(word), "{word}");
        }
        let page = page(&b2b_dataset::manifest(b2b_dataset::all()));
        assert!(page.len() < 2_000_000, "{}", page.len());
    }

    #[test]
    fn every_parameter_of_the_dataset_is_on_the_page() {
        let manifest = b2b_dataset::manifest(b2b_dataset::all());
        const ELSEWHERE: [&str; 5] = ["id", "generator", "type", "split", "test_small"];
        for column in &manifest.columns {
            let known = LOCATION.iter().chain(&PARAMETERS).any(|(name, ..)| *name == column.name);
            assert!(known || ELSEWHERE.contains(&column.name), "{}", column.name);
        }
        let data = data(&manifest);
        for building_type in data["types"].as_array().unwrap() {
            for (name, values) in building_type["columns"].as_object().unwrap() {
                assert_eq!(values.as_array().unwrap().len(), BUILDINGS_PER_TYPE as usize, "{name}");
            }
            assert!(building_type["columns"]["floor_area"][0].is_number(), "{}", building_type["name"]);
        }
    }
}
