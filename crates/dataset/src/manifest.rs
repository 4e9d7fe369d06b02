//! The manifest: the table of buildings and their parameters.

use std::collections::BTreeMap;

use b2b_climate::Location;

use super::setting::FOUNDATIONS;
use super::{Building, GENERATOR_VERSION, Row};
use crate::commercial::CommercialParameters;
use crate::house::{Heater, Heating, House, HouseSample};

/// A column of a manifest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Column {
    /// Its name.
    pub name: &'static str,
    /// The type of its values.
    pub kind: Kind,
    /// Unit; empty for text and flags, 1 for ratios and counts.
    pub unit: &'static str,
}

/// The types of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Text without commas and quotes.
    Text,
    /// Decimal numbers.
    Number,
    /// Integers.
    Integer,
    /// `true` or `false`.
    Flag,
}

/// A table of buildings. A value that does not apply is empty.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Manifest {
    /// The columns.
    pub columns: Vec<Column>,
    /// The cells of each row, in the order of the columns.
    pub rows: Vec<Vec<String>>,
}

const fn column(name: &'static str, kind: Kind, unit: &'static str) -> Column {
    Column { name, kind, unit }
}

/// Name and location.
const HEAD: [Column; 6] = [
    column("id", Kind::Text, ""),
    column("generator", Kind::Text, ""),
    column("type", Kind::Text, ""),
    column("place", Kind::Text, ""),
    column("climate_zone", Kind::Text, ""),
    column("heating_degree_days", Kind::Integer, "K·d"),
];
/// Split.
const SPLIT: [Column; 2] = [column("split", Kind::Text, ""), column("test_small", Kind::Flag, "")];
/// Parameters of the commercial types, parameters shared with the house, and parameters of the house.
const PARAMETERS: [Column; 32] = [
    column("wall_u", Kind::Number, "W/m²K"),
    column("roof_u", Kind::Number, "W/m²K"),
    column("infiltration", Kind::Number, "1"),
    column("x_scale", Kind::Number, "1"),
    column("y_scale", Kind::Number, "1"),
    column("north_axis", Kind::Number, "°"),
    column("window_u", Kind::Number, "W/m²K"),
    column("window_shgc", Kind::Number, "1"),
    column("window_to_wall", Kind::Number, "1"),
    column("vintage", Kind::Text, ""),
    column("year", Kind::Integer, "1"),
    column("floor_area", Kind::Number, "m²"),
    column("storeys", Kind::Integer, "1"),
    column("aspect", Kind::Number, "1"),
    column("orientation", Kind::Number, "°"),
    column("foundation", Kind::Text, ""),
    column("garage", Kind::Flag, ""),
    column("wall_resistance", Kind::Number, "m²K/W"),
    column("attic_resistance", Kind::Number, "m²K/W"),
    column("foundation_resistance", Kind::Number, "m²K/W"),
    column("air_changes_50", Kind::Number, "1/h"),
    column("occupants", Kind::Number, "1"),
    column("appliance_use", Kind::Number, "1"),
    column("ventilation", Kind::Number, "L/s"),
    column("heat_recovery", Kind::Number, "1"),
    column("heat_pump_cop", Kind::Number, "1"),
    column("heat_pump_cutoff", Kind::Number, "°C"),
    column("heater", Kind::Text, ""),
    column("heater_efficiency", Kind::Number, "1"),
    column("cooling_cop", Kind::Number, "1"),
    column("heating_oversizing", Kind::Number, "1"),
    column("cooling_oversizing", Kind::Number, "1"),
];

/// Weather of a building outside the dataset.
const WEATHER: [Column; 1] = [column("weather_sha256", Kind::Text, "")];

fn columns() -> Vec<Column> {
    [&HEAD[..], &SPLIT, &PARAMETERS].concat()
}

/// Returns the manifest of buildings of the dataset.
pub fn manifest<'a>(rows: impl IntoIterator<Item = &'a Row>) -> Manifest {
    let columns = columns();
    let cells = |row: &Row| {
        let mut cells = cells(&row.id.to_string(), &row.building);
        cells.insert("split", row.split.to_string());
        cells.insert("test_small", row.test_small.to_string());
        cells
    };
    Manifest { rows: rows.into_iter().map(|row| in_order(cells(row), &columns)).collect(), columns }
}

/// Returns the manifest of buildings outside the dataset, without a split and with the SHA-256 of users' weather files.
pub fn of_buildings<'a>(buildings: impl IntoIterator<Item = (&'a str, &'a Building)>) -> Manifest {
    let columns = [columns(), WEATHER.to_vec()].concat();
    let row = |(name, building): (&str, &Building)| in_order(cells(name, building), &columns);
    Manifest { rows: buildings.into_iter().map(row).collect(), columns }
}

impl Manifest {
    /// Adds the columns of [`of_buildings`], so that both kinds can be combined.
    #[must_use]
    pub fn with_weather(mut self) -> Self {
        self.columns.extend(WEATHER);
        self.rows.iter_mut().for_each(|row| row.resize(self.columns.len(), String::new()));
        self
    }

    /// Returns comma-separated values with a header. Numbers are in the shortest form that round-trips.
    pub fn to_csv(&self) -> String {
        let names: Vec<&str> = self.columns.iter().map(|column| column.name).collect();
        let mut text = names.join(",") + "\n";
        for row in &self.rows {
            text += &row.join(",");
            text.push('\n');
        }
        text
    }
}

/// The cells of a building by column.
type Cells = BTreeMap<&'static str, String>;

fn in_order(mut cells: Cells, columns: &[Column]) -> Vec<String> {
    let row = columns.iter().map(|column| cells.remove(column.name).unwrap_or_default()).collect();
    debug_assert!(cells.is_empty(), "no column for {cells:?}");
    row
}

fn cells(name: &str, building: &Building) -> Cells {
    let mut cells = Cells::from([
        ("id", name.to_owned()),
        ("generator", GENERATOR_VERSION.to_owned()),
        ("type", building.building_type().to_string()),
        ("place", building.place().to_owned()),
    ]);
    match building {
        Building::Commercial { parameters, .. } => {
            cells.insert("climate_zone", building.location().ashrae_zone().unwrap_or_default().to_owned());
            let values = parameters.values().map(|value| value.to_string());
            cells.extend(CommercialParameters::NAMES.into_iter().zip(values));
        }
        Building::House(sample) => cells.extend(house(sample)),
    }
    if let Location::File(file) = building.location() {
        cells.insert("weather_sha256", file.sha256.clone());
    }
    cells
}

fn house(sample: &HouseSample) -> Vec<(&'static str, String)> {
    let house = &sample.house;
    let mut cells = vec![
        ("vintage", sample.vintage.name().to_owned()),
        ("year", sample.year.to_string()),
        ("floor_area", house.floor_area.to_string()),
        ("storeys", house.storeys.to_string()),
        ("aspect", house.aspect.to_string()),
        ("orientation", house.orientation.to_string()),
        ("foundation", foundation(house).to_owned()),
        ("garage", house.garage.to_string()),
        ("wall_resistance", house.wall_resistance.to_string()),
        ("attic_resistance", house.attic_resistance.to_string()),
        ("foundation_resistance", house.foundation_resistance.to_string()),
        ("air_changes_50", house.air_changes_50.to_string()),
        ("window_to_wall", house.window_to_wall.to_string()),
        ("window_u", house.window_u.to_string()),
        ("window_shgc", house.window_shgc.to_string()),
        ("occupants", house.occupants.to_string()),
        ("appliance_use", house.appliance_use.to_string()),
        ("ventilation", house.ventilation.to_string()),
        ("heat_recovery", house.heat_recovery.to_string()),
        ("cooling_cop", house.cooling_cop.to_string()),
        ("heating_oversizing", house.heating_oversizing.to_string()),
        ("cooling_oversizing", house.cooling_oversizing.to_string()),
    ];
    if let Some(degree_days) = sample.location.heating_degree_days() {
        cells.push(("heating_degree_days", degree_days.round().to_string()));
    }
    if let Heating::HeatPump { cop, cutoff, .. } = house.heating {
        cells.push(("heat_pump_cop", cop.to_string()));
        cells.push(("heat_pump_cutoff", cutoff.to_string()));
    }
    match house.heating.heater() {
        Heater::Electric => cells.push(("heater", "electric".to_owned())),
        Heater::Fuel { efficiency } => {
            cells.push(("heater", "fuel".to_owned()));
            cells.push(("heater_efficiency", efficiency.to_string()));
        }
    }
    cells
}

fn foundation(house: &House) -> &'static str {
    FOUNDATIONS.into_iter().find(|(_, each)| *each == house.foundation).map_or("", |(word, _)| word)
}
