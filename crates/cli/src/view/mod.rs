//! `b2b view`: a building in 3D, its systems as a graph and its facts, in one page that needs no network.
//!
//! The drawing is plotly's, whose script the crate embeds; [`solid`] and [`graph`] make the drawings, and `view.html` is
//! the page around them.

mod graph;
mod solid;
mod triangle;

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Result;
use b2b_building::RunPeriod;
use b2b_dataset::BuildingName;
use b2b_env::Task;
use plotly::color::{Rgb, Rgba};
use plotly::common::Font;
use plotly::{Layout, Plot};
use serde_json::{Value, json};

use crate::facts::Facts;
use crate::output_folder::OutputFolder;
use crate::prepare::{Location, Prepared};
use crate::stdout;

/// See a building in 3D, its systems as a graph, and its facts
///
/// Writes one HTML page that opens in any browser and needs no network.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  b2b view OfficeMedium
  b2b view SingleFamilyHouse-0007 --out house.html")]
pub struct Arguments {
    /// Building type (`b2b list`), or a building of the dataset such as OfficeSmall-0042
    #[arg(value_name = "BUILDING")]
    building: BuildingName,
    #[command(flatten)]
    location: Location,
    /// File to write [default: b2b-out/BUILDING-PLACE.html]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

const PAGE: &str = include_str!("view.html");
/// Colours of zones; more zones have colours between.
const PALETTE: [[u8; 3]; 10] = [
    [37, 99, 235],
    [228, 87, 46],
    [15, 157, 118],
    [147, 51, 234],
    [211, 155, 0],
    [8, 145, 178],
    [219, 39, 119],
    [101, 128, 15],
    [124, 92, 62],
    [91, 107, 140],
];

/// Runs the command.
pub fn view(arguments: &Arguments) -> Result<()> {
    let prepared = Prepared::new(&arguments.building, &arguments.location, false)?;
    let facts = Facts::of(&prepared, &arguments.building, &arguments.location)?;
    let default = || Path::new("b2b-out").join(format!("{}-{}.html", prepared.building.name, prepared.place));
    let path = arguments.out.clone().unwrap_or_else(default);
    let page = page(&prepared, &facts)?;
    write(&path, &page)?;
    stdout::print(&path.display().to_string())
}

/// The file appears whole or not at all.
fn write(path: &Path, page: &str) -> Result<()> {
    let Some(name) = path.file_name().filter(|_| !path.is_dir()) else {
        anyhow::bail!("{} is a folder: give --out a file", path.display());
    };
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let folder = OutputFolder::stage(folder)?;
    folder.write(&name.to_string_lossy(), |file| Ok(file.write_all(page.as_bytes())?))?;
    folder.keep()
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

/// The element with plotly's script. The one for formulas that comes with it is left out: there are none.
fn plotly_script() -> String {
    const END: &str = "</script>";
    let scripts = Plot::offline_js_sources();
    let end = scripts.find(END).map_or(scripts.len(), |at| at + END.len());
    scripts[..end].to_owned()
}

/// Header and rows.
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
    let header = ["system", "kind", "zones", "flow, kg/s", "heating, kW", "cooling, kW", "reheat, kW"];
    json!({"header": header, "rows": systems.collect::<Vec<_>>()})
}

/// Header and rows.
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
        "floor, m²",
        "volume, m³",
        "outer walls",
        "windows in them",
        "ground contact",
        "infiltration, 1/h",
        "flow, kg/s",
        "heating, kW",
        "cooling, kW",
    ];
    json!({"header": header, "rows": zones.collect::<Vec<_>>()})
}

/// A number, or a dash for none.
fn positive(value: f64, decimals: usize) -> String {
    if value > 0.0 { format!("{value:.decimals$}") } else { "–".into() }
}

/// Colour of a zone by its number.
fn color(number: usize) -> Rgb {
    let [red, green, blue] = PALETTE.get(number).copied().unwrap_or_else(|| {
        // Golden-angle steps around the wheel of colours, as the page of `b2b run` has them.
        let hue = (number as f64 * 137.5) % 360.0;
        let channel = |shift: f64| {
            let angle = ((hue + shift) / 60.0) % 6.0;
            let share = (2.0 - (angle - 2.0).abs()).clamp(0.0, 1.0);
            (90.0 + share * 130.0) as u8
        };
        [channel(120.0), channel(0.0), channel(240.0)]
    });
    Rgb::new(red, green, blue)
}

/// What both drawings have in common: the page's colours show through.
fn page_layout(layout: Layout) -> Layout {
    let clear = || Rgba::new(0, 0, 0, 0.0);
    layout
        .paper_background_color(clear())
        .plot_background_color(clear())
        .font(Font::new().family("system-ui, sans-serif").size(12).color(Rgb::new(120, 128, 140)))
        .auto_size(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_loads_nothing_from_elsewhere() {
        for mark in ["{{DATA}}", "{{PLOTLY}}"] {
            assert_eq!(PAGE.matches(mark).count(), 1);
        }
        for word in ["http://", "https://", "src=", "@import", "<link"] {
            assert!(!PAGE.contains(word), "{word}");
        }
    }

    #[test]
    fn plotly_comes_along_and_is_the_one_script_of_its_element() {
        let script = plotly_script();
        assert!(script.starts_with("<script") && script.ends_with("</script>"));
        assert_eq!(script.matches("</script>").count(), 1);
        assert!(script.contains("mesh3d") && script.len() > 1_000_000);
    }

    #[test]
    fn neighbouring_zones_differ_in_colour() {
        let colors: Vec<_> = (0..40).map(|zone| serde_json::to_string(&color(zone)).unwrap()).collect();
        assert!(colors.windows(2).all(|pair| pair[0] != pair[1]));
    }
}
