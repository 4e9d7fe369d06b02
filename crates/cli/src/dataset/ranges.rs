//! Ranges of the parameters of the dataset, next to the requirements of the building code.

use std::ops::RangeInclusive;

use b2b_building::BuildingType;
use b2b_dataset::Building;
use b2b_dataset::commercial::{CommercialParameters, Prescriptive};
use b2b_dataset::house::{HouseSample, NUMBERS, Vintage};

use crate::terminal::table::Table;

/// Thermal climate zones of the building code.
const ZONES: RangeInclusive<char> = '1'..='8';

/// Returns the tables of commercial buildings and of houses.
pub fn text() -> anyhow::Result<String> {
    Ok(format!("{}\n\n{}", commercial()?, houses()))
}

/// Returns a row per commercial type and climate zone: minimum and maximum over its buildings, and the code value.
fn commercial() -> anyhow::Result<String> {
    let mut table = Table::new([
        "type",
        "zone",
        "buildings",
        "wall U (code)",
        "roof U (code)",
        "window U (code)",
        "SHGC (code)",
        "window/wall ratio",
        "infiltration",
        "x, y scale",
    ]);
    for building_type in BuildingType::ALL.into_iter().filter(|each| *each != BuildingType::SingleFamilyHouse)
    {
        for zone in ZONES {
            let buildings = in_zone(building_type, zone);
            // The envelope is the same for every letter.
            let code = Prescriptive::of(&format!("{zone}A"))?;
            let of = |value: &dyn Fn(&CommercialParameters) -> f64| {
                buildings.iter().map(|each| value(each)).collect()
            };
            let with_code = |values: Vec<f64>, code: f64| format!("{} ({code:.2})", range(&values, 2));
            let scales = buildings.iter().flat_map(|each| [each.x_scale, each.y_scale]).collect::<Vec<_>>();
            table.row([
                building_type.name().to_owned(),
                zone.to_string(),
                buildings.len().to_string(),
                with_code(of(&|each| each.wall_u), code.wall_u),
                with_code(of(&|each| each.roof_u), code.roof_u),
                with_code(of(&|each| each.window_u), code.window_u),
                with_code(of(&|each| each.window_shgc), code.window_shgc),
                range(&of(&|each| each.window_to_wall), 3),
                range(&of(&|each| each.infiltration), 2),
                range(&scales, 2),
            ]);
        }
    }
    Ok(table.text())
}

fn in_zone(building_type: BuildingType, zone: char) -> Vec<&'static CommercialParameters> {
    let commercial = b2b_dataset::rows(building_type).iter().filter_map(|row| match &row.building {
        Building::Commercial { location, parameters, .. } => {
            location.ashrae_zone().is_some_and(|own| own.starts_with(zone)).then_some(parameters)
        }
        Building::House(_) => None,
    });
    commercial.collect()
}

/// Returns a row per parameter and a column per vintage.
fn houses() -> String {
    let vintages = Vintage::ALL.map(of_vintage);
    let [a, b, c, d, e] = Vintage::ALL.map(Vintage::name);
    let mut table = Table::new(["SingleFamilyHouse", a, b, c, d, e]);
    let row = |name: &str, cell: &dyn Fn(&[&HouseSample]) -> String| {
        let [a, b, c, d, e] = vintages.each_ref().map(|houses| cell(houses));
        [name.to_owned(), a, b, c, d, e]
    };
    table.row(row("houses", &|houses| houses.len().to_string()));
    for number in &NUMBERS {
        let decimals = number.decimals.min(2) as usize;
        table.row(row(number.name(), &|houses| {
            let values: Vec<f64> = houses.iter().map(|each| number.field.of(&each.house)).collect();
            range(&values, decimals)
        }));
    }
    table.text()
}

fn of_vintage(vintage: Vintage) -> Vec<&'static HouseSample> {
    let rows = b2b_dataset::rows(BuildingType::SingleFamilyHouse).iter();
    rows.filter_map(|row| match &row.building {
        Building::House(sample) => (sample.vintage == vintage).then_some(sample),
        Building::Commercial { .. } => None,
    })
    .collect()
}

/// Formats minimum and maximum.
fn range(values: &[f64], decimals: usize) -> String {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    format!("{low:.decimals$}-{high:.decimals$}")
}
