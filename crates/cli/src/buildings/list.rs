//! `b2b list`: building types, places and tariffs.

use anyhow::Result;
use b2b_building::{BuildingType, RunPeriod};
use b2b_climate::PLACES;
use b2b_dataset::BuildingName;
use b2b_env::Task;
use b2b_env::tariff::Tariff;
use serde_json::{Value, json};

use crate::arguments::location::Location;
use crate::program::prepare::Prepared;
use crate::terminal::stdout;
use crate::terminal::table::Table;

/// List building types, places or tariffs
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  b2b list
  b2b list --sizes         with the sizes of observation and action
  b2b list places --json
  b2b list tariffs         for --task operate+TARIFF")]
pub struct Arguments {
    /// Items to list
    #[arg(value_enum, value_name = "types|places|tariffs", hide_possible_values = true, default_value_t = Subject::Types)]
    subject: Subject,
    /// Include the number of zones and the sizes of observation and action (takes about a second per type)
    #[arg(long)]
    sizes: bool,
    /// Task that the sizes are for (see `b2b run --help`)
    #[arg(long, requires = "sizes", default_value = "operate", value_name = "TASK", value_parser = Task::from_text)]
    task: Task,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// The subject of the list.
#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum Subject {
    /// Building types
    Types,
    /// Places with weather files
    Places,
    /// Tariffs for tasks
    Tariffs,
}

/// The size of the environment of a type.
struct Sizes {
    zones: usize,
    observation: usize,
    action: usize,
}

/// Runs the command.
pub fn list(arguments: &Arguments) -> Result<()> {
    match (arguments.subject, arguments.json) {
        (Subject::Places, true) => stdout::print_json(&places_json()),
        (Subject::Places, false) => stdout::print(&places_text()),
        (Subject::Tariffs, json) => tariffs(json),
        (Subject::Types, _) => types(arguments),
    }
}

fn types(arguments: &Arguments) -> Result<()> {
    let mut types = Vec::new();
    for each in BuildingType::ALL {
        let Arguments { task, json: quiet, .. } = arguments;
        let sizes = arguments.sizes.then(|| sizes(each, task, *quiet)).transpose()?;
        types.push((each, sizes));
    }
    if arguments.json {
        return stdout::print_json(
            &types.iter().map(|(each, sizes)| type_json(*each, sizes)).collect::<Vec<_>>(),
        );
    }
    stdout::print(&types_text(&types, arguments.sizes))
}

fn sizes(building_type: BuildingType, task: &Task, quiet: bool) -> Result<Sizes> {
    let prepared = Prepared::new(&BuildingName::Type(building_type), &Location::default(), quiet)?;
    let env = prepared.env(RunPeriod::WINTER, 12, task.clone())?;
    Ok(Sizes {
        zones: prepared.building.controlled_zones().count(),
        observation: env.observation_space().len(),
        action: env.action_space().len(),
    })
}

fn types_text(types: &[(BuildingType, Option<Sizes>)], with_sizes: bool) -> String {
    let mut plain = Table::new(["type", "default place", "description"]);
    let mut sized = Table::new(["type", "default place", "zones", "observation", "action", "description"]);
    for (each, sizes) in types {
        let [name, place, description] = [each.name(), each.home(), each.description()].map(str::to_owned);
        match sizes {
            None => plain.row([name, place, description]),
            Some(Sizes { zones, observation, action }) => {
                let [zones, observation, action] = [zones, observation, action].map(usize::to_string);
                sized.row([name, place, zones, observation, action, description]);
            }
        }
    }
    if with_sizes { sized.text() } else { plain.text() }
}

fn type_json(building_type: BuildingType, sizes: &Option<Sizes>) -> Value {
    let mut object = json!({
        "type": building_type.name(),
        "description": building_type.description(),
        "default_place": building_type.home(),
    });
    if let Some(Sizes { zones, observation, action }) = sizes {
        object["controlled_zones"] = json!(zones);
        object["observation_size"] = json!(observation);
        object["action_size"] = json!(action);
    }
    object
}

fn places_text() -> String {
    let mut table =
        Table::new(["place", "climate zone", "weather station (WMO)", "package of the weather file"]);
    for place in &PLACES {
        let cells = [place.name, place.ashrae_zone, place.wmo, place.package.name];
        table.row(cells.map(str::to_owned));
    }
    table.text()
}

fn places_json() -> Value {
    let place = |place: &b2b_climate::Place| {
        json!({
            "place": place.name,
            "ashrae_climate_zone": place.ashrae_zone,
            "wmo_station": place.wmo,
            "weather_file": place.file_name,
            "package": place.package.name,
        })
    };
    PLACES.iter().map(place).collect()
}

fn tariffs(json: bool) -> Result<()> {
    let tariffs = Tariff::names().map(Tariff::named).collect::<Result<Vec<_>, _>>()?;
    if json {
        let tariff = |tariff: &Tariff| {
            let Tariff { name, title, place, currency, .. } = tariff;
            json!({"tariff": name, "title": title, "place": place, "currency": currency})
        };
        return stdout::print_json(&tariffs.iter().map(tariff).collect::<Value>());
    }
    let mut table = Table::new(["tariff", "currency", "place", "title"]);
    for Tariff { name, currency, place, title, .. } in tariffs {
        table.row([name, currency, place, title]);
    }
    stdout::print(&table.text())
}
