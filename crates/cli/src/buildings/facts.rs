//! The description of a building, shared by `b2b show` and `b2b view`.

use std::sync::Arc;

use anyhow::Result;
use b2b_building::description::{Description, SystemDescription, leakage};
use b2b_building::morphology::Owner;
use b2b_building::{Conditioning, Morphology, PreparedBuilding, Zone};
use b2b_dataset::{BuildingName, manifest};
use b2b_env::Env;
use serde_json::{Map, Value};

use crate::arguments::location::Location;
use crate::program::prepare::Prepared;
use crate::terminal::table::Table;

/// The description of a prepared building.
pub struct Facts {
    building: Arc<PreparedBuilding>,
    /// Geometry, envelope and systems.
    pub description: Description,
    /// Graph of zones and systems.
    pub morphology: Morphology,
    /// Name of the place.
    pub place: String,
    /// Parameters of the dataset; empty for other buildings.
    pub parameters: Vec<Parameter>,
    /// One-line description.
    summary: &'static str,
}

/// A parameter of a building of the dataset.
pub struct Parameter {
    /// Name of the parameter.
    pub name: &'static str,
    /// Value.
    pub value: String,
    /// Unit; empty for text and dimensionless numbers.
    pub unit: &'static str,
}

/// How a table lists the zones served by a system.
#[derive(Clone, Copy)]
pub enum Served {
    /// A single zone by name, several by their count.
    Counted,
    /// All zones by name.
    Named,
}

impl Facts {
    /// Describes a prepared building.
    pub fn of(prepared: &Prepared, name: &BuildingName, location: &Location) -> Result<Self> {
        let description =
            Description::of(&prepared.building, &prepared.weather, location.placement().origin(name))?;
        let summary = match name {
            BuildingName::Type(building_type) => building_type.description(),
            BuildingName::Id(id) => id.building_type().description(),
            BuildingName::Model(_) => "imported model",
        };
        Ok(Self {
            building: Arc::clone(&prepared.building),
            morphology: Morphology::of(&prepared.building, &description),
            description,
            place: prepared.place.clone(),
            parameters: parameters(name),
            summary,
        })
    }

    /// Returns the name and the place.
    pub fn title(&self) -> String {
        format!("{} in {}", self.description.name, self.place)
    }

    /// Returns the description as labeled lines.
    pub fn lines(&self) -> Vec<(&'static str, String)> {
        let Description { location, envelope, origin, .. } = &self.description;
        let u = |u: Option<f64>| u.map_or("U unknown".to_owned(), |u| format!("U {u:.2} W/(m²·K)"));
        let mut windows = vec![u(envelope.window_u)];
        windows.extend(envelope.window_shgc.map(|shgc| format!("SHGC {shgc:.2}")));
        windows.push(format!("{} of the exterior walls", percent(envelope.window_to_wall)));
        if envelope.skylight_to_roof > 0.0 {
            windows.push(format!("skylights {} of the roof", percent(envelope.skylight_to_roof)));
        }
        let leak = format!(
            "{:.2} air changes/h at a temperature difference of {} K and a wind speed of {} m/s",
            envelope.infiltration,
            leakage::TEMPERATURE_DIFFERENCE,
            leakage::WIND,
        );
        let climate = format!(
            "{:.0} heating degree days (18 °C), {:.0} cooling degree days (10 °C)",
            location.heating_degree_days, location.cooling_degree_days
        );
        let mut lines =
            vec![("type", self.summary.to_owned()), ("place", self.place_line()), ("climate", climate)];
        // The zone that it was built for; the weather's may differ.
        let zone =
            origin.climate_zone.as_ref().map_or(String::new(), |zone| format!(", climate zone {zone}"));
        match (origin.year, &origin.vintage) {
            (Some(year), Some(vintage)) => lines.push(("vintage", format!("{year} ({vintage})"))),
            (Some(year), None) => lines.push(("vintage", format!("ASHRAE 90.1-{year}{zone}"))),
            _ => {}
        }
        lines.extend([
            ("size", self.size_line()),
            ("zones", self.zones_line()),
            ("walls", u(envelope.wall_u)),
            ("roof", u(envelope.roof_u)),
            ("windows", if envelope.window_to_wall > 0.0 { windows.join(", ") } else { "none".into() }),
            ("infiltration", leak),
        ]);
        lines
    }

    fn place_line(&self) -> String {
        let location = &self.description.location;
        let side = |degrees: f64, [positive, negative]: [&str; 2]| {
            format!("{:.1}° {}", degrees.abs(), if degrees < 0.0 { negative } else { positive })
        };
        format!(
            "{}, {} {}, elevation {:.0} m",
            self.place,
            side(location.latitude, ["N", "S"]),
            side(location.longitude, ["E", "W"]),
            location.elevation,
        )
    }

    fn size_line(&self) -> String {
        let description = &self.description;
        let [x, y, z] = description.size;
        let levels = description.levels;
        let mut text = format!(
            "{:.0} m² on {levels} level{}, {x:.1} × {y:.1} × {z:.1} m",
            description.conditioned_floor_area,
            if levels == 1 { "" } else { "s" },
        );
        if description.north_axis != 0.0 {
            text += &format!(", rotated {:.0}° from north", description.north_axis);
        }
        text
    }

    fn zones_line(&self) -> String {
        let zones = &self.building.zones;
        let conditioned = zones.iter().filter(|zone| zone.conditioning != Conditioning::None).count();
        let own_controls = zones.iter().filter(|zone| zone.own_controls).count();
        let unconditioned = zones.len() - conditioned - own_controls;
        let mut text = format!("{conditioned} conditioned");
        for (count, what) in [(own_controls, "with their own controls"), (unconditioned, "unconditioned")] {
            if count > 0 {
                text += &format!(", {count} {what}");
            }
        }
        text
    }

    /// Returns a table with a row per system.
    pub fn systems(&self, served: Served) -> Table {
        let mut table = Table::new([
            "system",
            "type",
            "zones",
            "air flow (kg/s)",
            "heating (kW)",
            "cooling (kW)",
            "reheat (kW)",
        ]);
        for system in &self.description.systems {
            table.row([
                system.name.clone(),
                system.kind.name.into(),
                self.served(system, served),
                positive(system.design_flow, 2),
                kilowatts(system.heating_capacity),
                kilowatts(system.cooling_capacity),
                kilowatts(system.reheat_capacity),
            ]);
        }
        table
    }

    /// Returns the zones that a system serves.
    fn served(&self, system: &SystemDescription, served: Served) -> String {
        let names: Vec<_> =
            system.zones.iter().map(|zone| self.description.zones[*zone].name.as_str()).collect();
        match served {
            Served::Counted if names.len() > 1 => format!("{} zones", names.len()),
            _ => names.join(", "),
        }
    }

    /// Returns a table with a row per zone.
    pub fn zones(&self) -> Table {
        let mut table = Table::new([
            "zone",
            "floor area (m²)",
            "volume (m³)",
            "exterior walls",
            "window/wall",
            "ground contact",
            "infiltration (1/h)",
            "equipment",
            "air flow (kg/s)",
            "heating (kW)",
            "cooling (kW)",
        ]);
        for (zone, described) in self.building.zones.iter().zip(&self.description.zones) {
            let sizes = described.equipment.unwrap_or_default();
            table.row([
                zone.name.clone(),
                format!("{:.1}", zone.floor_area),
                format!("{:.0}", described.volume),
                percent(described.exterior_wall_fraction),
                percent(described.window_to_wall),
                percent(described.ground_contact_fraction),
                format!("{:.2}", described.infiltration),
                equipment(zone).into(),
                positive(sizes.design_flow, 2),
                kilowatts(sizes.heating_capacity),
                kilowatts(sizes.cooling_capacity),
            ]);
        }
        table
    }

    /// Returns the sizes of observation and action by kind of owner.
    pub fn spaces(&self, env: &Env) -> [(&'static str, String); 2] {
        let kind = |owner: Owner| match owner {
            Owner::Zone(_) => "zone",
            Owner::AirLoop(_) => "air loop",
            Owner::Weather => "weather",
            Owner::Calendar => "calendar",
            Owner::Energy => "energy",
        };
        let observation = env.observation_space().slots().iter().map(|slot| kind(slot.owner));
        let action = env.action_space().owners().iter().map(|owner| kind(*owner));
        [("observation", counted(observation)), ("action", counted(action))]
    }

    /// Returns the parameters as a JSON object, with numbers as numbers.
    pub fn parameters_json(&self) -> Value {
        let value = |parameter: &Parameter| {
            let number = parameter.value.parse::<f64>().ok().map(Value::from);
            (parameter.name.to_owned(), number.unwrap_or_else(|| parameter.value.clone().into()))
        };
        Value::Object(self.parameters.iter().map(value).collect::<Map<_, _>>())
    }
}

impl Parameter {
    /// Returns name, value and unit.
    pub fn text(&self) -> String {
        format!("{} {} {}", self.name.replace('_', " "), self.value, self.unit).trim_end().to_owned()
    }
}

fn parameters(name: &BuildingName) -> Vec<Parameter> {
    let BuildingName::Id(id) = name else { return Vec::new() };
    let mut table = manifest([b2b_dataset::row(*id)]);
    let cells = table.rows.pop().unwrap_or_default();
    let columns = table.columns.iter().zip(cells).filter(|(_, cell)| !cell.is_empty());
    // Omits what other lines show.
    let redundant =
        |name: &str| matches!(name, "id" | "type" | "place" | "climate_zone" | "heating_degree_days");
    columns
        .filter(|(column, _)| !redundant(column.name))
        .map(|(column, value)| Parameter {
            name: column.name,
            value,
            unit: if column.unit == "1" { "" } else { column.unit },
        })
        .collect()
}

/// Returns counts by kind, such as `8 values: 6 zone, 2 weather`.
fn counted<'a>(kinds: impl Iterator<Item = &'a str>) -> String {
    let mut counts: Vec<(&str, usize)> = Vec::new();
    let mut total = 0;
    for kind in kinds {
        total += 1;
        match counts.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, count)) => *count += 1,
            None => counts.push((kind, 1)),
        }
    }
    let counts: Vec<_> = counts.into_iter().map(|(kind, count)| format!("{count} {kind}")).collect();
    format!("{total} values: {}", counts.join(", "))
}

fn equipment(zone: &Zone) -> &'static str {
    match zone.conditioning {
        Conditioning::None if zone.own_controls => "own controls",
        Conditioning::None => "none",
        Conditioning::Heating => "heating only",
        Conditioning::HeatingAndCooling => "heating and cooling",
    }
}

/// Returns a number, or a dash for zero.
fn positive(value: f64, decimals: usize) -> String {
    if value > 0.0 { format!("{value:.decimals$}") } else { "–".into() }
}

fn kilowatts(watts: f64) -> String {
    positive(watts / 1000.0, 1)
}

/// Returns a fraction as a percentage.
fn percent(fraction: f64) -> String {
    let percent = 100.0 * fraction;
    if percent < 9.95 { format!("{percent:.1} %") } else { format!("{percent:.0} %") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_counted_by_kind_in_order_of_appearance() {
        assert_eq!(counted(["zone", "weather", "zone"].into_iter()), "3 values: 2 zone, 1 weather");
    }
}
