//! `b2b tune operation`: the cost scale and the weight of the rewards of operation.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Result;
use b2b_control::tune::TrainingBuildings;
use b2b_dataset::BuildingId;
use b2b_env::{CostScale, OPERATION_WEIGHT};
use b2b_evaluate::operation_reward::{Balance, Operation, Ranked, WEIGHTS, balances, cost_scales, rank};
use b2b_evaluate::{BuiltIn, EpisodeResult, Evaluation, Policy};
use serde_json::json;

use super::two_weeks::two_weeks;
use crate::arguments::buildings::Classes;
use crate::arguments::jobs::Jobs;
use crate::output_folder::OutputFolder;
use crate::program;
use crate::scoring::evaluation::evaluation;
use crate::terminal::progress::Download;
use crate::terminal::stdout;
use crate::terminal::table::Table;

/// Measure the scales of the rewards of operation, and rank controllers under several weights of discomfort
///
/// Runs the guideline controller in training buildings of each type and climate zone over the five two-week periods, at
/// constant prices. Its mean cost of an hour is the cost scale of the class, and the weight of discomfort is balanced
/// if discomfort is a tenth of its penalty. Other controllers run in one building of each type. Every episode is kept:
/// the same command resumes an interrupted run.
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Arguments {
    #[command(flatten)]
    classes: Classes,
    /// Number of training buildings per type and climate zone
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    buildings: u32,
    /// Random seed of the choice of buildings
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    jobs: Jobs,
    /// Folder for the episodes and cost_scale.json
    #[arg(long, default_value = "b2b-operation", value_name = "FOLDER")]
    out: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Name of the file with the scales.
const SCALES: &str = "cost_scale.json";
/// Controllers that are ranked along with the guideline.
const OTHERS: [&str; 4] = ["own", "reactive", "hold", "off"];

/// Runs the command.
pub fn operation(arguments: &Arguments) -> Result<()> {
    let (buildings, representatives) = arguments.draw()?;
    let catalog = program::catalog(&mut Download::new(arguments.json))?;
    let evaluation = evaluation(&catalog, arguments.jobs.count()?);
    let run = |ids: &[BuildingId], policy| arguments.run(&evaluation, ids, policy);
    let guideline = run(&buildings, BuiltIn::guideline36())?;
    let (scales, balances) = (cost_scales(&guideline), balances(&guideline));
    OutputFolder::write_file(&arguments.out.join(SCALES), |file| {
        serde_json::to_writer_pretty(&mut *file, &scales)?;
        Ok(writeln!(file)?)
    })?;
    let is_representative =
        |row: &&EpisodeResult| representatives.iter().any(|id| row.info.building == id.to_string());
    let mut all = vec![("guideline36", guideline.iter().filter(is_representative).cloned().collect())];
    for name in OTHERS {
        all.push((name, run(&representatives, name.parse()?)?));
    }
    let operations: Vec<Operation<'_>> =
        all.iter().map(|(policy, rows): &(&str, Vec<EpisodeResult>)| Operation { policy, rows }).collect();
    let ranked = rank(&operations, &scales);
    let summary = json!({
        "weight": OPERATION_WEIGHT, "cost_scales": scales, "balances": balances,
        "relative_weights": WEIGHTS, "ranked": ranked,
    });
    let file = arguments.out.join(SCALES);
    stdout::print_result(arguments.json, &summary, || text(&scales, &balances, &ranked, &file))
}

impl Arguments {
    /// Returns the training buildings of every class, and the first of each type, in climate zone 5 if it has zones.
    fn draw(&self) -> Result<(Vec<BuildingId>, Vec<BuildingId>)> {
        let (mut all, mut first) = (Vec::new(), Vec::<BuildingId>::new());
        for class in self.classes.list()? {
            let drawn = TrainingBuildings::draw(class, self.buildings as usize, 0, self.seed)?.search;
            // The middle of the climates, where there are several.
            let represents = class.climate_zone.is_none_or(|zone| zone == 5);
            first.extend(drawn.first().filter(|_| represents));
            all.extend(drawn);
        }
        Ok((all, first))
    }

    /// Returns the episodes of a controller.
    fn run(
        &self,
        evaluation: &Evaluation<'_>,
        ids: &[BuildingId],
        policy: BuiltIn,
    ) -> Result<Vec<EpisodeResult>> {
        two_weeks(evaluation, ids, &policy, &self.out.join(policy.name()), self.json)
    }
}

fn text(scales: &[CostScale], balances: &[Balance], ranked: &[Ranked], file: &Path) -> String {
    let mut classes = Table::new(["class", "cost of an hour (per 1000 m²)", "buildings"]);
    for CostScale { class, cost_scale, buildings } in scales {
        classes.row([class.to_string(), format!("{:.3}", 1000.0 * cost_scale), buildings.join(", ")]);
    }
    let mut shares = Table::new([
        "type",
        "discomfort (K·h per zone and day)",
        "share of the penalty (%)",
        "weight that makes it a tenth",
    ]);
    for Balance { building_type, discomfort_per_day, share, balanced_weight } in balances {
        shares.row([
            building_type.clone(),
            format!("{discomfort_per_day:.3}"),
            format!("{:.1}", 100.0 * share),
            format!("{balanced_weight:.1}"),
        ]);
    }
    let mut header =
        ["controller", "cost", "discomfort (K·h per zone and day)", "score"].map(str::to_owned).to_vec();
    header.extend(WEIGHTS.map(|weight| format!("penalty, weight {} (rank)", weight * OPERATION_WEIGHT)));
    let mut ranks = Table::with_header(header);
    for each in ranked {
        let mut row = vec![
            each.policy.clone(),
            format!("{:.2}", each.cost),
            format!("{:.2}", each.discomfort_per_day),
            each.score.map_or_else(|| "–".to_owned(), |score| format!("{score:.2}")),
        ];
        let penalties = each.penalties.iter().zip(each.ranks);
        row.extend(penalties.map(|(penalty, rank)| format!("{penalty:.2} ({rank})")));
        ranks.push(row);
    }
    format!("{}\n\n{}\n\n{}\n\n  {}", classes.text(), shares.text(), ranks.text(), file.display())
}
