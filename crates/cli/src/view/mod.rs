//! `b2b view`: a page with the 3D geometry of a building, its systems as a graph and its description.
//!
//! [`solid`] and [`graph`] create the plots; `view.html` is the page around them. The page embeds Plotly's script and
//! needs no network.

mod graph;
mod solid;
mod style;
mod triangle;

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Result;
use b2b_building::RunPeriod;
use b2b_dataset::BuildingName;
use plotly::Plot;
use serde_json::{Value, json};

use crate::arguments::location::Location;
use crate::arguments::task;
use crate::buildings::facts::{Facts, Served};
use crate::output_folder::OutputFolder;
use crate::program::prepare::Prepared;
use crate::terminal::stdout;

/// Draw a building: 3D geometry, systems as a graph, and description
///
/// Writes one HTML page that opens in any browser and needs no network.
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    after_help = "\
Examples:
  b2b view OfficeMedium
  b2b view SingleFamilyHouse-0007 --out house.html"
)]
pub struct Arguments {
    /// Building type (`b2b list`), dataset building such as OfficeSmall-0042, or model file (.idf, .epJSON)
    #[arg(value_name = "BUILDING")]
    building: BuildingName,
    #[command(flatten)]
    location: Location,
    /// HTML file to write [default: b2b-out/BUILDING-PLACE.html]
    #[arg(long, value_name = "FILE", value_parser = crate::arguments::page::path)]
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
    let env = prepared.env(RunPeriod::WINTER, 12, task::usual())?;
    let solid = solid::plot(building, &facts.description)?;
    let graph = graph::plot(&facts.morphology, &facts.description);
    let mut lines = facts.lines();
    lines.extend(facts.spaces(&env));
    let data = json!({
        "title": facts.title(),
        "facts": lines,
        "parameters": facts.parameters.iter().map(|p| [p.name.replace('_', " "), format!("{} {}", p.value, p.unit)]).collect::<Vec<_>>(),
        "systems": facts.systems(Served::Named).json(),
        "zones": facts.zones().json(),
        "solid": plot_json(&solid)?,
        "graph": plot_json(&graph)?,
        "graph_levels": graph::level_count(&facts.description),
    });
    Ok(b2b_page::fill(PAGE, &data))
}

fn plot_json(plot: &Plot) -> Result<Value> {
    Ok(serde_json::from_str(&plot.to_json())?)
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
}
