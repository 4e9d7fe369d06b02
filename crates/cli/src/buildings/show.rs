//! `b2b show`: a description of a building and of its observation and action spaces.

use anyhow::Result;
use b2b_building::hvac::Actuator;
use b2b_building::morphology::{Owner, Universe};
use b2b_building::{Conditioning, RunPeriod, Zone};
use b2b_dataset::BuildingName;
use b2b_env::{Env, Slot, Task};
use serde_json::{Value, json};

use crate::arguments::location::Location;
use crate::buildings::facts::{Facts, Served};
use crate::program::prepare::Prepared;
use crate::terminal::stdout;
use crate::terminal::table::Table;

/// Describe a building: envelope, systems, observation and action spaces
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  b2b show OfficeSmall
  b2b show SingleFamilyHouse-0007 --zones
  b2b show OfficeSmall --actions           every actuator with its bounds
  b2b show OfficeSmall --observations --task occupancy   what an agent observes in a task
  b2b show Warehouse --place Fairbanks     sized for another climate, with other bounds")]
pub struct Arguments {
    /// Building type (`b2b list`), dataset building such as OfficeSmall-0042, or model file (.idf, .epJSON)
    #[arg(value_name = "BUILDING")]
    building: BuildingName,
    #[command(flatten)]
    location: Location,
    /// Task that the observation is for (see `b2b run --help`)
    #[arg(long, default_value = "operate", value_name = "TASK", value_parser = Task::from_text)]
    task: Task,
    /// List the zones
    #[arg(long)]
    zones: bool,
    /// List the actuators: the slots of the action
    #[arg(long)]
    actions: bool,
    /// List the slots of the observation
    #[arg(long)]
    observations: bool,
    /// List zones, actuators and observation
    #[arg(long)]
    all: bool,
    /// Print everything as JSON, including the morphology graph
    #[arg(long)]
    json: bool,
}

/// Maximum width of a line of parameters.
const WIDTH: usize = 96;

/// Runs the command.
pub fn show(arguments: &Arguments) -> Result<()> {
    let prepared = Prepared::new(&arguments.building, &arguments.location, arguments.json)?;
    let env = prepared.env(RunPeriod::WINTER, 12, arguments.task.clone())?;
    let facts = Facts::of(&prepared, &arguments.building, &arguments.location)?;
    if arguments.json {
        return stdout::print_json(&json_of(&prepared, &env, &facts));
    }
    stdout::print(&text_of(arguments, &prepared, &env, &facts))
}

fn text_of(arguments: &Arguments, prepared: &Prepared, env: &Env, facts: &Facts) -> String {
    let mut parts = vec![facts.title(), lines_text(&facts.lines()), facts.systems(Served::Counted).text()];
    if !facts.parameters.is_empty() {
        let parameters: Vec<_> = facts.parameters.iter().map(|parameter| parameter.text()).collect();
        parts.push(wrapped(&parameters));
    }
    parts.push(lines_text(&facts.spaces(env)));
    let zones = facts.zones().text();
    let actions = actuators_text(prepared.building.actuators());
    let observations = slots_text(env.observation_space().slots());
    let details = [
        (arguments.zones, "Zones", zones),
        (arguments.actions, "Action", actions),
        (arguments.observations, "Observation", observations),
    ];
    let requested = details.into_iter().filter(|(requested, ..)| *requested || arguments.all);
    parts.extend(requested.map(|(_, title, text)| format!("{title}\n{text}")));
    parts.join("\n\n")
}

fn lines_text(lines: &[(&str, String)]) -> String {
    let line = |(name, value): &(&str, String)| format!("  {name:<12}  {value}");
    lines.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Joins items with dots, in lines of at most [`WIDTH`] characters.
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

fn actuators_text<'a>(actuators: impl Iterator<Item = &'a Actuator>) -> String {
    let mut table = Table::new(["index", "actuator", "low", "high", "unit", "EnergyPlus actuator"]);
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
    let mut table = Table::new(["index", "slot", "low", "high", "unit", "source"]);
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

/// Returns a bound with at most three decimals.
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
    fn lines_break_only_between_items() {
        let items = vec!["x".repeat(60), "y".repeat(40), "z".into()];
        let text = wrapped(&items);
        assert_eq!(text, format!("  {}\n  {} · z", "x".repeat(60), "y".repeat(40)));
    }
}
