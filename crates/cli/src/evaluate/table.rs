//! The text tables of an evaluation.

use b2b_evaluate::statistics::{Aggregate, ratio_text, score_text};
use b2b_evaluate::{Group, OperationComfort, Window, resource_heading};

use crate::terminal::table::Table;

/// Returns the scores of one run period and task.
pub(super) fn window_text(policy: &str, window: &Window) -> String {
    let several = window.types.len() > 1;
    let groups = || window.types.iter().chain(several.then_some(&window.all));
    let buildings: usize = window.types.iter().map(Group::buildings).sum();
    let (scores, table) = match window.all.comfort {
        Some(_) => ("score at comfort (lower is better, guideline36 = 1)", operation(groups(), &window.task)),
        None => (
            "resolved and normalized score: interquartile means (lower is better, reactive controllers = 1)",
            tracking(groups()),
        ),
    };
    format!(
        "{policy}, {buildings} buildings, {}, task {}\n{scores}\n\n{table}\n\n  [95 % confidence intervals: bootstrap over buildings \
         within each type, and over seeds]\n\n",
        window.period, window.task,
    )
}

fn tracking<'a>(groups: impl Iterator<Item = &'a Group>) -> String {
    let mut table = Table::new([
        "type",
        "buildings",
        "resolved score",
        "score",
        "median",
        "mean",
        "min",
        "max",
        "below 1 (%)",
        "RMS deviation (K)",
        "energy / baseline",
        "HVAC energy (kWh/m²)",
        "actuator travel (strokes/day)",
        "task's resource / baseline",
        "occupied hours too cold (%)",
        "occupied hours too warm (%)",
    ]);
    for group in groups {
        let text = |scores: &Option<Aggregate>, of: fn(&Aggregate) -> String| {
            scores.as_ref().map_or("–".to_owned(), of)
        };
        let cell = |of: fn(&Aggregate) -> String| text(&group.scores, of);
        table.row([
            group.name.clone(),
            group.buildings().to_string(),
            text(&group.resolved_scores, |scores| scores.interquartile_mean.to_string()),
            cell(|scores| scores.interquartile_mean.to_string()),
            cell(|scores| scores.median.to_string()),
            cell(|scores| scores.mean.to_string()),
            cell(|scores| score_text(scores.min)),
            cell(|scores| score_text(scores.max)),
            cell(Aggregate::beats_baseline_text),
            format!("{:.2}", group.rms_deviation_k),
            ratio_text(group.relative_energy),
            format!("{:.2}", group.energy_wh_m2 / 1000.0),
            format!("{:.1}", group.daily_travel),
            ratio_text(group.relative_resource),
            percent(group.occupied_too_cold_share),
            percent(group.occupied_too_warm_share),
        ]);
    }
    table.text()
}

fn percent(share: Option<f64>) -> String {
    share.map_or("–".to_owned(), |share| format!("{:.1}", 100.0 * share))
}

/// Returns the table of a task of operation: score at comfort first, and a mark where episodes are less comfortable.
fn operation<'a>(groups: impl Iterator<Item = &'a Group>, task: &str) -> String {
    let resource = resource_heading([task]);
    let mut table = Table::new([
        "type",
        "buildings",
        "score at comfort",
        "median",
        "below 1 (%)",
        &resource,
        "energy / baseline",
        "discomfort (K·h per zone)",
        "baseline's",
        "peak demand (W/m²)",
        "too uncomfortable",
        "HVAC energy (kWh/m²)",
    ]);
    for group in groups {
        let cell = |of: fn(&Aggregate) -> String| group.scores.as_ref().map_or("–".to_owned(), of);
        let comfort = group.comfort.as_ref();
        table.row([
            group.name.clone(),
            group.buildings().to_string(),
            cell(|scores| scores.interquartile_mean.to_string()),
            cell(|scores| scores.median.to_string()),
            cell(Aggregate::beats_baseline_text),
            ratio_text(group.relative_resource),
            ratio_text(group.relative_energy),
            ratio_text(comfort.map(|comfort| comfort.discomfort_k_h)),
            ratio_text(comfort.and_then(|comfort| comfort.baseline_discomfort_k_h)),
            comfort.map_or("–".to_owned(), |comfort| format!("{:.1}", 1000.0 * comfort.pele_tot)),
            comfort.map_or_else(String::new, OperationComfort::mark),
            format!("{:.2}", group.energy_wh_m2 / 1000.0),
        ]);
    }
    table.text()
}
