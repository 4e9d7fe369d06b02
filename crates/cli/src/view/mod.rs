//! `b2b view`: a page with the 3D geometry of a building, its systems as a graph and its description.
//!
//! [`solid`] and [`graph`] make the plots, `view.html` is the page around them. The page embeds Plotly's script and needs
//! no network.

mod graph;
mod solid;
mod style;
mod triangle;

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Result;
use b2b_building::RunPeriod;
use b2b_dataset::BuildingName;
use b2b_env::Task;
use plotly::Plot;
use serde_json::{Value, json};

use crate::arguments::location::Location;
use crate::facts::{Facts, SYSTEM_COLUMNS};
use crate::output_folder::OutputFolder;
use crate::prepare::Prepared;
use crate::stdout;

/// Draw a building: 3D geometry, systems as a graph, and description
///
/// Writes one HTML page that opens in any browser and needs no network.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  b2b view OfficeMedium
  b2b view SingleFamilyHouse-0007 --out house.html")]
pub struct Arguments {
    /// Building type (`b2b list`), dataset building such as OfficeSmall-0042, or model file (.idf, .epJSON)
    #[arg(value_name = "BUILDING")]
    building: BuildingName,
    #[command(flatten)]
    location: Location,
    /// HTML file to write [default: b2b-out/BUILDING-PLACE.html]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

const PAGE: &str = include_str!("view.html");
/// Runs the command.
pub fn view(arguments: &Arguments) -> Result<()> {
    let prepared = Prepared::new(&arguments.building, &arguments.location, false)?;
    let facts = Facts::of(&prepared, &arguments.building, &arguments.location)?;
    let default = || Path::new("b2b-out").join(format!("{}-{}.html", prepared.building.name, prepared.place));
    let path = arguments.out.clone().unwrap_or_else(default);
    let page = page(&prepared, &facts)?;
    OutputFolder::write_file(&path, |file| Ok(file.write_all(page.as_bytes())?))?;
    stdout::print(&path.display().to_string())
}

fn page(prepared: &Prepared, facts: &Facts) -> Result<String> {
    let building = &prepared.building;
    let env = prepared.env(RunPeriod::WINTER, 12, Task::default())?;
    let solid = solid::plot(building, &facts.description)?;
    let graph = graph::plot(&facts.morphology, &facts.description);
    let mut lines = facts.lines();
    lines.extend(facts.spaces(&env));
    let data = json!({
        "title": facts.title(),
        "facts": lines,
        "parameters": facts.parameters.iter().map(|p| [p.name.replace('_', " "), format!("{} {}", p.value, p.unit)]).collect::<Vec<_>>(),
        "systems": systems(facts),
        "zones": zones(facts),
        "solid": plot_json(&solid)?,
        "graph": plot_json(&graph)?,
        "graph_levels": graph::level_count(&facts.description),
    });
    // `<` would let a name end the script element.
    let data = data.to_string().replace('<', "\\u003c");
    Ok(PAGE.replace("{{PLOTLY}}", &plotly_script()).replace("{{DATA}}", &data))
}

fn plot_json(plot: &Plot) -> Result<Value> {
    Ok(serde_json::from_str(&plot.to_json())?)
}

/// Returns the element with Plotly's script, without the script for formulas that comes with it.
fn plotly_script() -> String {
    const END: &str = "</script>";
    let scripts = Plot::offline_js_sources();
    let end = scripts.find(END).map_or(scripts.len(), |at| at + END.len());
    scripts[..end].to_owned()
}

/// Returns the table of systems.
fn systems(facts: &Facts) -> Value {
    let systems = facts.description.systems.iter().map(|system| {
        let zones: Vec<_> =
            system.zones.iter().map(|zone| facts.description.zones[*zone].name.as_str()).collect();
        json!([
            system.name,
            system.kind.name(),
            zones.join(", "),
            positive(system.design_flow, 2),
            positive(system.heating_capacity / 1000.0, 1),
            positive(system.cooling_capacity / 1000.0, 1),
            positive(system.reheat_capacity / 1000.0, 1),
        ])
    });
    json!({"header": SYSTEM_COLUMNS, "rows": systems.collect::<Vec<_>>()})
}

/// Returns the table of zones.
fn zones(facts: &Facts) -> Value {
    let zones = facts.description.zones.iter().map(|zone| {
        let equipment = zone.equipment.unwrap_or_default();
        json!([
            zone.name,
            format!("{:.1}", zone.floor_area),
            format!("{:.0}", zone.volume),
            format!("{:.0} %", 100.0 * zone.exterior_wall_fraction),
            format!("{:.1} %", 100.0 * zone.window_to_wall),
            format!("{:.0} %", 100.0 * zone.ground_contact_fraction),
            format!("{:.2}", zone.infiltration),
            positive(equipment.design_flow, 2),
            positive(equipment.heating_capacity / 1000.0, 1),
            positive(equipment.cooling_capacity / 1000.0, 1),
        ])
    });
    let header = [
        "zone",
        "floor area (m²)",
        "volume (m³)",
        "exterior walls",
        "window/wall",
        "ground contact",
        "infiltration (1/h)",
        "air flow (kg/s)",
        "heating (kW)",
        "cooling (kW)",
    ];
    json!({"header": header, "rows": zones.collect::<Vec<_>>()})
}

/// Returns a number, or a dash for zero.
fn positive(value: f64, decimals: usize) -> String {
    if value > 0.0 { format!("{value:.decimals$}") } else { "–".into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_needs_no_network() {
        for mark in ["{{DATA}}", "{{PLOTLY}}"] {
            assert_eq!(PAGE.matches(mark).count(), 1);
        }
        for word in ["http://", "https://", "src=", "@import", "<link"] {
            assert!(!PAGE.contains(word), "{word}");
        }
    }

    #[test]
    fn the_page_embeds_plotly_as_one_script() {
        let script = plotly_script();
        assert!(script.starts_with("<script") && script.ends_with("</script>"));
        assert_eq!(script.matches("</script>").count(), 1);
        assert!(script.contains("mesh3d") && script.len() > 1_000_000);
    }
}
