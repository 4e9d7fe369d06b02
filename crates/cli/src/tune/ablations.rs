//! `b2b tune ablations`: what the sequences of the guideline controller save.

use std::path::PathBuf;

use anyhow::Result;
use b2b_climate::TwoWeeks;
use b2b_dataset::BuildingId;
use b2b_evaluate::{Ablation, BuiltIn, EpisodeResult};
use serde::Serialize;

use super::two_weeks::two_weeks;
use crate::arguments::buildings::DatasetBuildings;
use crate::arguments::jobs::Jobs;
use crate::program;
use crate::scoring::evaluation::evaluation;
use crate::terminal::progress::Download;
use crate::terminal::stdout;
use crate::terminal::table::Table;

/// Measure what the sequences of the guideline controller save
///
/// Runs `guideline36` and four ablations of it over the five two-week periods: a fixed supply air temperature, a
/// minimum flow of 30 % of the design flow at every terminal, no optimum start, and no setback. For every building and
/// period, prints the change of HVAC energy, the change of its cost, and the discomfort. Every episode is kept: the
/// same command resumes an interrupted run.
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    #[command(flatten)]
    buildings: DatasetBuildings,
    #[command(flatten)]
    jobs: Jobs,
    /// Folder for the episodes
    #[arg(long, default_value = "b2b-ablations", value_name = "FOLDER")]
    out: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// An ablation in a building.
#[derive(Serialize)]
struct Effect {
    building: String,
    ablation: &'static str,
    /// Change of HVAC energy in each period, relative to the guideline controller's.
    energy: Vec<f64>,
    /// Change of the energy and of the cost of all periods.
    all: [f64; 2],
    /// Discomfort under the guideline controller and under the ablation, K·h per zone, mean over the periods.
    discomfort: [f64; 2],
}

/// Runs the command.
pub fn ablations(arguments: &Arguments) -> Result<()> {
    let ids = arguments.buildings.ids()?;
    let catalog = program::catalog(&mut Download::new(arguments.json))?;
    let evaluation = evaluation(&catalog, arguments.jobs.count()?);
    let whole = BuiltIn::guideline36();
    let folder = |name: &str| arguments.out.join(name.replace(" %", "").replace(' ', "-"));
    let whole = two_weeks(&evaluation, &ids, &whole, &folder("guideline36"), arguments.json)?;
    let mut effects = Vec::new();
    for ablation in Ablation::ALL {
        let rows = two_weeks(&evaluation, &ids, &ablation, &folder(ablation.label()), arguments.json)?;
        effects.extend(ids.iter().filter_map(|id| Effect::of(*id, ablation, &whole, &rows)));
    }
    effects.sort_by(|a, b| a.building.cmp(&b.building));
    stdout::print_result(arguments.json, &effects, || text(&effects))
}

impl Effect {
    /// Returns `None` if a row has no metrics of operation.
    fn of(
        id: BuildingId,
        ablation: Ablation,
        whole: &[EpisodeResult],
        rows: &[EpisodeResult],
    ) -> Option<Self> {
        let of_building = |rows: &[EpisodeResult]| -> Option<Vec<[f64; 3]>> {
            let own = rows.iter().filter(|row| row.info.building == id.to_string());
            let of_row = |row: &EpisodeResult| {
                let metrics = row.metrics()?;
                Some([metrics.ener_tot?, metrics.cost_tot?, metrics.tdis_tot?])
            };
            own.map(of_row).collect()
        };
        let (whole, ablated) = (of_building(whole)?, of_building(rows)?);
        let total = |rows: &[[f64; 3]], column: usize| rows.iter().map(|row| row[column]).sum::<f64>();
        let mean = |rows: &[[f64; 3]]| total(rows, 2) / rows.len().max(1) as f64;
        Some(Self {
            building: id.to_string(),
            ablation: ablation.label(),
            energy: whole.iter().zip(&ablated).map(|(whole, ablated)| ablated[0] / whole[0] - 1.0).collect(),
            all: [0, 1].map(|column| total(&ablated, column) / total(&whole, column) - 1.0),
            discomfort: [mean(&whole), mean(&ablated)],
        })
    }
}

fn text(effects: &[Effect]) -> String {
    let mut header = vec!["building".to_owned(), "ablation".to_owned()];
    header.extend(TwoWeeks::ALL.map(|weeks| format!("{} (%)", weeks.name())));
    header.extend(["all (%)", "cost (%)", "discomfort (K·h per zone)"].map(str::to_owned));
    let mut table = Table::with_header(header);
    for Effect { building, ablation, energy, all, discomfort: [whole, ablated] } in effects {
        let mut row = vec![building.clone(), (*ablation).to_owned()];
        row.extend(energy.iter().chain(all).map(|change| format!("{:+.1}", 100.0 * change)));
        row.push(format!("{whole:.2} → {ablated:.2}"));
        table.push(row);
    }
    table.text()
}
