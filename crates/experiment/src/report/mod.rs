//! The page of an experiment: tables and charts, compared with the paper's results.

mod adaptation;
mod content;
mod group;
mod operation;
mod scores;
mod step_times;
mod tails;
mod transfer;
mod weights;

use std::io::Write;

use b2b_benchmark::{RankBy, leaderboard};
use b2b_evaluate::report::{Chart, Series, step_rewards};
use serde_json::json;

use self::content::Content;
use crate::claims;
use crate::definition::{Experiment, REACTIVE, ReportKind};
use crate::estimate::duration_text;
use crate::folder::Folder;
use crate::results::Results;

/// Writes the page of an experiment.
///
/// # Errors
/// The errors of the writer.
pub fn write(file: &mut impl Write, experiment: &Experiment, results: &Results) -> std::io::Result<()> {
    let Some(content) = content(experiment, results) else {
        let entries: Vec<_> = results.done.iter().filter_map(|done| done.entry.clone()).collect();
        return leaderboard::write(file, &entries, RankBy::default());
    };
    let jobs = results.done.len() + results.failed.len() + results.missing.len();
    let mut tiles = vec![
        ("budget".to_owned(), results.budget.name.clone()),
        ("jobs done".to_owned(), format!("{} of {jobs}", results.done.len())),
    ];
    if results.steps() > 0 {
        tiles.push(("training steps".to_owned(), thousands(results.steps())));
    }
    tiles.push(("time of all jobs".to_owned(), duration_text(results.time())));
    tiles.extend(content.tiles);
    let failed = results.failed.iter().map(|(job, error)| format!("{job}: {error}"));
    let data = json!({
        "title": experiment.title,
        "lead": experiment.question,
        "tiles": tiles,
        "tables": content.tables,
        "lost": failed.collect::<Vec<_>>(),
        "drawings": content.charts.into_iter().map(Chart::json).collect::<Vec<_>>(),
        "footer": format!("{} {}", in_the_paper(&experiment.paper), content.notes),
    });
    b2b_page::write_page(file, &data)
}

/// Returns the best and the worst episodes of the policies of an experiment of operation, each with a name and the
/// arguments with which `b2b run` draws it; `None` for an agent that is not in the experiment's folder. Other experiments
/// have none.
pub fn drawings(
    folder: &Folder,
    experiment: &Experiment,
    results: &Results,
) -> Vec<(String, Option<Vec<String>>)> {
    if experiment.report != ReportKind::Operation {
        return Vec::new();
    }
    let extremes = operation::extremes(experiment, results).into_iter();
    extremes.map(|each| (each.name.replace(' ', "-"), each.arguments(folder))).collect()
}

/// Returns the tables and charts of an experiment; `None` for a leaderboard.
fn content(experiment: &Experiment, results: &Results) -> Option<Content> {
    let mut content = match experiment.report {
        ReportKind::Board => return None,
        ReportKind::Scores => scores::content(experiment, results),
        ReportKind::StepRewards => rewards(experiment, results),
        ReportKind::Adaptation => adaptation::content(experiment, results),
        ReportKind::Transfer => transfer::content(experiment, results),
        ReportKind::Weights => weights::content(experiment, results),
        ReportKind::Operation => operation::content(experiment, results),
        ReportKind::StepTimes => step_times::content(results),
    };
    if matches!(experiment.report, ReportKind::Adaptation | ReportKind::Transfer) {
        content.tables.extend(tails::table(experiment, results));
    }
    content.tables.extend(claims_table(experiment, results));
    Some(content)
}

/// Returns the table of the paper's claims; `None` if it makes none about the experiment.
fn claims_table(experiment: &Experiment, results: &Results) -> Option<serde_json::Value> {
    let judged = claims::judge(experiment, results);
    let row = |each: &claims::Judged| {
        [each.claim.clone(), each.verdict.to_string(), each.measured.clone(), each.reason.clone()]
    };
    (!judged.is_empty()).then(|| {
        json!({
            "name": "Claims of the paper",
            "title": claims::RULE,
            "header": ["claim", "here", "measured", "reason"],
            "rows": judged.iter().map(row).collect::<Vec<_>>(),
        })
    })
}

/// Returns the sentence that names the result in the paper, if it has one.
fn in_the_paper(result: &str) -> String {
    match result.strip_prefix("not in the paper") {
        Some(rest) => format!("Not in the paper{rest}."),
        None => format!("In the paper: {result}."),
    }
}

fn rewards(experiment: &Experiment, results: &Results) -> Content {
    let mut names = vec![REACTIVE.to_owned()];
    names.extend(experiment.policies(&results.budget).into_iter().map(|policy| policy.name));
    let charts = experiment.tasks.iter().map(|task| {
        let episodes = |name: &str| {
            let own = results.of(name).filter(|(_, row)| row.info.task == *task);
            own.filter_map(|(_, row)| Some((&row.info, row.scored()?))).collect::<Vec<_>>()
        };
        let series: Vec<_> =
            names.iter().map(|name| Series { name: &name[..], episodes: episodes(name) }).collect();
        let chart = step_rewards(&series);
        Chart { title: format!("{}: {task}", chart.title), ..chart }
    });
    Content { charts: charts.collect(), ..Content::default() }
}

/// Returns a number with thousands separators.
fn thousands(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_says_whether_the_paper_has_its_result() {
        assert_eq!(in_the_paper("Table 1"), "In the paper: Table 1.");
        assert_eq!(in_the_paper("not in the paper, which has houses"), "Not in the paper, which has houses.");
    }

    #[test]
    fn thousands_are_separated() {
        assert_eq!([0, 999, 1000, 384_000_000].map(thousands), ["0", "999", "1,000", "384,000,000"]);
    }
}
