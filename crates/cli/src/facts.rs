//! What a building is, for people: the same facts on a screen and on a page.

use anyhow::Result;
use b2b_building::description::{Description, SystemDescription, leakage};
use b2b_building::morphology::Owner;
use b2b_building::{Conditioning, Morphology};
use b2b_dataset::{BuildingName, manifest};
use b2b_env::Env;
use serde_json::{Map, Value};

use crate::prepare::{Location, Prepared};
use crate::table::Table;

/// A building, described.
pub struct Facts {
    /// What it is.
    pub description: Description,
    /// Its graph.
    pub morphology: Morphology,
    /// Name of its place.
    pub place: String,
    /// Its row in the dataset, if it has one.
    pub parameters: Vec<Parameter>,
    /// One line for people.
    what: &'static str,
}

/// A cell of the dataset's table that is not empty.
pub struct Parameter {
    /// Name of the column.
    pub name: &'static str,
    /// The value.
    pub value: String,
    /// Its unit; empty for words and plain numbers.
    pub unit: &'static str,
}

impl Facts {
    /// Describes a prepared building.
    pub fn of(prepared: &Prepared, name: &BuildingName, location: &Location) -> Result<Self> {
        let description =
            Description::of(&prepared.building, &prepared.weather, location.placement().origin(name))?;
        let what = match name {
            BuildingName::Type(building_type) => building_type.description(),
            BuildingName::Id(id) => id.building_type().description(),
            BuildingName::Model(_) => "imported model",
        };
        Ok(Self {
            morphology: Morphology::of(&prepared.building, &description),
            description,
            place: prepared.place.clone(),
            parameters: parameters(name),
            what,
        })
    }

    /// Its name and its place.
    pub fn title(&self) -> String {
        format!("{} in {}", self.description.name, self.place)
    }

    /// Named facts, a line each.
    pub fn lines(&self) -> Vec<(&'static str, String)> {
        let Description { location, envelope, origin, .. } = &self.description;
        let u = |u: Option<f64>| u.map_or("U not given".to_owned(), |u| format!("U {u:.2} W/m²K"));
        let mut windows = vec![u(envelope.window_u)];
        windows.extend(envelope.window_shgc.map(|shgc| format!("SHGC {shgc:.2}")));
        windows.push(format!("{} of the outer walls", percent(envelope.window_to_wall)));
        if envelope.skylight_to_roof > 0.0 {
            windows.push(format!("skylights {} of the roof", percent(envelope.skylight_to_roof)));
        }
        let leak = format!(
            "{:.2} air changes an hour at {} K and {} m/s",
            envelope.infiltration,
            leakage::TEMPERATURE_DIFFERENCE,
            leakage::WIND,
        );
        let climate = format!(
            "{:.0} heating K·d below 18 °C, {:.0} cooling K·d above 10 °C",
            location.heating_degree_days, location.cooling_degree_days
        );
        let climate = match &origin.climate_zone {
            Some(zone) => format!("zone {zone}, {climate}"),
            None => climate,
        };
        let mut lines =
            vec![("type", self.what.to_owned()), ("place", self.place_line()), ("climate", climate)];
        match (origin.year, &origin.vintage) {
            (Some(year), Some(vintage)) => lines.push(("built", format!("{year} ({vintage})"))),
            (Some(year), None) => lines.push(("built", format!("after ASHRAE 90.1-{year}"))),
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
            "{}, {} {}, {:.0} m above the sea",
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
            text += &format!(", turned {:.0}° from north", description.north_axis);
        }
        text
    }

    fn zones_line(&self) -> String {
        let zones = &self.description.zones;
        let other = zones.iter().filter(|zone| zone.conditioning == Conditioning::None).count();
        match other {
            0 => format!("{} conditioned", zones.len()),
            _ => format!("{} conditioned, {other} without equipment", zones.len() - other),
        }
    }

    /// The systems, a row each.
    pub fn systems_text(&self) -> String {
        let mut table =
            Table::new(["system", "kind", "zones", "flow, kg/s", "heating, kW", "cooling, kW", "reheat, kW"]);
        for system in &self.description.systems {
            let kw = |watts: f64| if watts > 0.0 { format!("{:.1}", watts / 1000.0) } else { "–".into() };
            let flow = system.design_flow;
            table.row([
                system.name.clone(),
                system.kind.name().into(),
                self.served(system),
                if flow > 0.0 { format!("{flow:.2}") } else { "–".into() },
                kw(system.heating_capacity),
                kw(system.cooling_capacity),
                kw(system.reheat_capacity),
            ]);
        }
        table.text()
    }

    /// The zone that a system serves, or how many.
    fn served(&self, system: &SystemDescription) -> String {
        match system.zones[..] {
            [zone] => self.description.zones[zone].name.clone(),
            _ => format!("{} zones", system.zones.len()),
        }
    }

    /// What is seen and driven, in short: how many values of which kind.
    pub fn spaces(&self, env: &Env) -> [(&'static str, String); 2] {
        let kind = |owner: Owner| match owner {
            Owner::Zone(_) => "zones",
            Owner::AirLoop(_) => "air loops",
            Owner::Weather => "weather",
            Owner::Calendar => "calendar",
            Owner::Energy => "energy",
        };
        let seen = env.observation_space().slots().iter().map(|slot| kind(slot.owner));
        let driven = env.action_space().owners().iter().map(|owner| kind(*owner));
        [("observation", counted(seen)), ("action", counted(driven))]
    }

    /// The parameters as a JSON object: numbers where they are numbers.
    pub fn parameters_json(&self) -> Value {
        let value = |parameter: &Parameter| {
            let number = parameter.value.parse::<f64>().ok().map(Value::from);
            (parameter.name.to_owned(), number.unwrap_or_else(|| parameter.value.clone().into()))
        };
        Value::Object(self.parameters.iter().map(value).collect::<Map<_, _>>())
    }
}

impl Parameter {
    /// Name, value and unit.
    pub fn text(&self) -> String {
        format!("{} {} {}", self.name.replace('_', " "), self.value, self.unit).trim_end().to_owned()
    }
}

fn parameters(name: &BuildingName) -> Vec<Parameter> {
    let BuildingName::Id(id) = name else { return Vec::new() };
    let mut table = manifest([b2b_dataset::row(*id)]);
    let cells = table.rows.pop().unwrap_or_default();
    let columns = table.columns.iter().zip(cells).filter(|(_, cell)| !cell.is_empty());
    // What the other facts tell already.
    let told = |name: &str| matches!(name, "id" | "type" | "place" | "climate_zone" | "heating_degree_days");
    columns
        .filter(|(column, _)| !told(column.name))
        .map(|(column, value)| Parameter {
            name: column.name,
            value,
            unit: if column.unit == "1" { "" } else { column.unit },
        })
        .collect()
}

/// `13 values: 6 zones, 2 weather`.
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
    let counts: Vec<_> = counts.into_iter().map(|(kind, count)| format!("{count} of {kind}")).collect();
    format!("{total} values: {}", counts.join(", "))
}

/// A share for people.
pub fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent < 9.95 { format!("{percent:.1} %") } else { format!("{percent:.0} %") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_counted_by_kind_in_the_order_they_come() {
        assert_eq!(counted(["zones", "weather", "zones"].into_iter()), "3 values: 2 of zones, 1 of weather");
    }
}
