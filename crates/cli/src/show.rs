//! `b2b show`: what can be seen and driven in a building.

use anyhow::Result;
use b2b_building::hvac::Actuator;
use b2b_building::{Conditioning, RunPeriod, Zone};
use b2b_env::{Env, Slot, Task};
use serde_json::{Value, json};

use crate::prepare::{BuildingName, Location, Prepared};
use crate::stdout;
use crate::table::Table;

/// Show the zones, the action and the observation of a building
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  b2b show OfficeSmall
  b2b show SingleFamilyHouse-0007
  b2b show Warehouse --place Fairbanks     equipment is sized for the place, and bounds with it")]
pub struct Arguments {
    /// Building type (`b2b list`), building of the dataset such as OfficeSmall-0042, or model file (.idf, .epJSON)
    #[arg(value_name = "BUILDING")]
    building: BuildingName,
    #[command(flatten)]
    location: Location,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn show(arguments: &Arguments) -> Result<()> {
    let prepared = Prepared::new(&arguments.building, &arguments.location, arguments.json)?;
    let env = prepared.env(RunPeriod::WINTER, 12, Task::default())?;
    if arguments.json {
        stdout::print_json(&json_of(&prepared, &env))
    } else {
        stdout::print(&text_of(&prepared, &env))
    }
}

fn text_of(prepared: &Prepared, env: &Env) -> String {
    let building = &prepared.building;
    format!(
        "{} in {}: {:.0} m² conditioned floor area\n\nZones\n{}\n\nAction: {} values\n{}\n\nObservation: {} values\n{}",
        building.name,
        prepared.place,
        building.conditioned_floor_area,
        zones_text(&building.zones),
        env.action_space().len(),
        actuators_text(building.actuators()),
        env.observation_space().len(),
        slots_text(env.observation_space().slots()),
    )
}

fn zones_text(zones: &[Zone]) -> String {
    let mut table = Table::new(["zone", "floor, m²", "equipment"]);
    for zone in zones {
        table.row([zone.name.clone(), format!("{:.1}", zone.floor_area), equipment(zone).into()]);
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

fn json_of(prepared: &Prepared, env: &Env) -> Value {
    let building = &prepared.building;
    let zone = |zone: &Zone| {
        json!({
            "name": zone.name,
            "floor_area_m2": zone.floor_area,
            "heating": zone.conditioning != Conditioning::None,
            "cooling": zone.conditioning == Conditioning::HeatingAndCooling,
            "own_controls": zone.own_controls,
        })
    };
    let slot = |slot: &Slot| json!({"name": slot.name, "unit": slot.unit, "low": slot.low, "high": slot.high, "source": slot.source});
    let actuator = |actuator: &Actuator| {
        json!({
            "name": actuator.name,
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
        "action": building.actuators().map(actuator).collect::<Vec<_>>(),
        "observation": env.observation_space().slots().iter().map(slot).collect::<Vec<_>>(),
    })
}
