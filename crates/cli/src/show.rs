//! `b2b show`: what a building is, and what can be seen and driven in it.

use anyhow::Result;
use b2b_building::description::ZoneDescription;
use b2b_building::hvac::Actuator;
use b2b_building::morphology::{Owner, Universe};
use b2b_building::{Conditioning, RunPeriod, Zone};
use b2b_dataset::BuildingName;
use b2b_env::{Env, Slot, Task};
use serde_json::{Value, json};

use crate::facts::{Facts, percent};
use crate::prepare::{Location, Prepared};
use crate::stdout;
use crate::table::Table;

/// Show what a building is, on one screen
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  b2b show OfficeSmall
  b2b show SingleFamilyHouse-0007 --zones
  b2b show OfficeSmall --actions           what can be driven, between which bounds
  b2b show Warehouse --place Fairbanks     equipment is sized for the place, and bounds with it")]
pub struct Arguments {
    /// Building type (`b2b list`), building of the dataset such as OfficeSmall-0042, or model file (.idf, .epJSON)
    #[arg(value_name = "BUILDING")]
    building: BuildingName,
    #[command(flatten)]
    location: Location,
    /// Show the zones
    #[arg(long)]
    zones: bool,
    /// Show every slot of the action
    #[arg(long)]
    actions: bool,
    /// Show every slot of the observation
    #[arg(long)]
    observations: bool,
    /// Show all of this
    #[arg(long)]
    all: bool,
    /// Print JSON: all of this, with the morphology
    #[arg(long)]
    json: bool,
}

/// Width that a line of parameters may have.
const WIDTH: usize = 96;

/// Runs the command.
pub fn show(arguments: &Arguments) -> Result<()> {
    let prepared = Prepared::new(&arguments.building, &arguments.location, arguments.json)?;
    let env = prepared.env(RunPeriod::WINTER, 12, Task::default())?;
    let facts = Facts::of(&prepared, &arguments.building, &arguments.location)?;
    if arguments.json {
        stdout::print_json(&json_of(&prepared, &env, &facts))
    } else {
        stdout::print(&text_of(arguments, &prepared, &env, &facts))
    }
}

fn text_of(arguments: &Arguments, prepared: &Prepared, env: &Env, facts: &Facts) -> String {
    let mut parts = vec![facts.title(), lines_text(&facts.lines()), facts.systems_text()];
    if !facts.parameters.is_empty() {
        let parameters: Vec<_> = facts.parameters.iter().map(|parameter| parameter.text()).collect();
        parts.push(wrapped(&parameters));
    }
    parts.push(lines_text(&facts.spaces(env)));
    let zones = zones_text(&prepared.building.zones, &facts.description.zones);
    let actions = actuators_text(prepared.building.actuators());
    let observations = slots_text(env.observation_space().slots());
    let details = [
        (arguments.zones, "Zones", zones),
        (arguments.actions, "Action", actions),
        (arguments.observations, "Observation", observations),
    ];
    let wanted = details.into_iter().filter(|(wanted, ..)| *wanted || arguments.all);
    parts.extend(wanted.map(|(_, title, text)| format!("{title}\n{text}")));
    parts.join("\n\n")
}

fn lines_text(lines: &[(&str, String)]) -> String {
    let line = |(name, value): &(&str, String)| format!("  {name:<12}  {value}");
    lines.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Items with dots between them, in lines of at most [`WIDTH`].
fn wrapped(items: &[String]) -> String {
    let mut lines = vec![String::from(" ")];
    for item in items {
        let last = lines.len() - 1;
        let width = lines[last].chars().count() + 3 + item.chars().count();
        if lines[last] == " " {
            lines[last] += &format!(" {item}");
        } else if width <= WIDTH {
            lines[last] += &format!(" · {item}");
        } else {
            lines.push(format!("  {item}"));
        }
    }
    lines.join("\n")
}

fn zones_text(zones: &[Zone], described: &[ZoneDescription]) -> String {
    let mut table = Table::new([
        "zone",
        "floor, m²",
        "volume, m³",
        "outer walls",
        "windows",
        "ground",
        "infiltration, 1/h",
        "equipment",
    ]);
    for (zone, described) in zones.iter().zip(described) {
        table.row([
            zone.name.clone(),
            format!("{:.1}", zone.floor_area),
            format!("{:.0}", described.volume),
            percent(described.exterior_wall_fraction),
            percent(described.window_to_wall),
            percent(described.ground_contact_fraction),
            format!("{:.2}", described.infiltration),
            equipment(zone).into(),
        ]);
    }
    table.text()
}

fn equipment(zone: &Zone) -> &'static str {
    match zone.conditioning {
        Conditioning::None if zone.own_controls => "under its own controls",
        Conditioning::None => "none",
        Conditioning::Heating => "heating",
        Conditioning::HeatingAndCooling => "heating and cooling",
    }
}

fn actuators_text<'a>(actuators: impl Iterator<Item = &'a Actuator>) -> String {
    let mut table = Table::new(["", "actuator", "low", "high", "unit", "engine actuator"]);
    for (index, actuator) in actuators.enumerate() {
        table.row([
            index.to_string(),
            actuator.name.clone(),
            bound(actuator.low),
            bound(actuator.high),
            actuator.quantity.unit().into(),
            engine_actuator(actuator),
        ]);
    }
    table.text()
}

fn engine_actuator(actuator: &Actuator) -> String {
    format!("{} / {} / {}", actuator.component, actuator.control, actuator.key)
}

fn slots_text(slots: &[Slot]) -> String {
    let mut table = Table::new(["", "slot", "low", "high", "unit", "source"]);
    for (index, slot) in slots.iter().enumerate() {
        table.row([
            index.to_string(),
            slot.name.clone(),
            bound(slot.low),
            bound(slot.high),
            slot.unit.into(),
            slot.source.into(),
        ]);
    }
    table.text()
}

/// Three decimals at most.
fn bound(value: f64) -> String {
    format!("{}", (value * 1000.0).round() / 1000.0)
}

fn json_of(prepared: &Prepared, env: &Env, facts: &Facts) -> Value {
    let building = &prepared.building;
    let node = |owner: Owner| facts.morphology.node_of(owner);
    let zone = |zone: &Zone| {
        json!({
            "name": zone.name,
            "floor_area_m2": zone.floor_area,
            "heating": zone.conditioning != Conditioning::None,
            "cooling": zone.conditioning == Conditioning::HeatingAndCooling,
            "own_controls": zone.own_controls,
        })
    };
    let slot = |slot: &Slot| {
        json!({
            "name": slot.name,
            "node": node(slot.owner),
            "quantity": slot.quantity,
            "unit": slot.unit,
            "low": slot.low,
            "high": slot.high,
            "source": slot.source,
        })
    };
    let actuator = |(owner, actuator): (Owner, &Actuator)| {
        json!({
            "name": actuator.name,
            "node": node(owner),
            "quantity": actuator.quantity,
            "unit": actuator.quantity.unit(),
            "low": actuator.low,
            "high": actuator.high,
            "engine_actuator": [actuator.component, actuator.control, actuator.key],
        })
    };
    json!({
        "building": building.name,
        "place": prepared.place,
        "conditioned_floor_area_m2": building.conditioned_floor_area,
        "zones": building.zones.iter().map(zone).collect::<Vec<_>>(),
        "action": building.owned_actuators().map(actuator).collect::<Vec<_>>(),
        "observation": env.observation_space().slots().iter().map(slot).collect::<Vec<_>>(),
        "parameters": facts.parameters_json(),
        "description": facts.description,
        "morphology": facts.morphology,
        "universe": Universe::new(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_are_wrapped_between_them() {
        let items = vec!["x".repeat(60), "y".repeat(40), "z".into()];
        let text = wrapped(&items);
        assert_eq!(text, format!("  {}\n  {} · z", "x".repeat(60), "y".repeat(40)));
    }
}
