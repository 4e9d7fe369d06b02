//! The leaderboard: results by problem, on one page that needs no network.

mod charts;

use std::io::Write;

use serde_json::{Value, json};

use crate::entry::{
    Columns, EpisodeCurve, EpisodeDifference, Measures, Performance, PolicyDescription, RunResult, Stages,
    Stratum, mean_from_random, rows_of,
};
use crate::problem::Stage;
use b2b_evaluate::BuiltIn;
use b2b_evaluate::EpisodeResult;
use b2b_evaluate::RESOLUTION;
use b2b_evaluate::statistics::{Aggregate, score_text};

/// A result with its rows by stage.
type Ranked = (RunResult, Stages);

/// The score whose interquartile mean ranks the entries.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RankBy {
    /// The resolved score.
    #[default]
    Resolved,
    /// The paper's score.
    Paper,
}

impl RankBy {
    fn scores(self, performance: &Performance) -> &Aggregate {
        match self {
            Self::Resolved => &performance.resolved,
            Self::Paper => &performance.scores,
        }
    }
}

/// Writes the page.
///
/// # Errors
/// Errors of writing to the file.
pub fn write(file: &mut impl Write, results: &[Ranked], rank_by: RankBy) -> std::io::Result<()> {
    let mut by_hash: Vec<(String, Vec<&Ranked>)> = Vec::new();
    for entry in results {
        // Computed here, not taken from the result.
        let hash = entry.0.problem.hash();
        match by_hash.iter_mut().find(|(other, _)| *other == hash) {
            Some((_, board)) => board.push(entry),
            None => by_hash.push((hash, vec![entry])),
        }
    }
    let mut boards: Vec<Vec<&Ranked>> = by_hash.into_iter().map(|(_, board)| board).collect();
    let key = |board: &[&Ranked]| {
        let result = &board[0].0;
        (
            result.problem_changes.as_ref().is_none_or(|changes| !changes.is_empty()),
            // Operation first.
            !result.problem.test.tasks.iter().all(|task| task.is_operation()),
            result.problem.name.clone(),
        )
    };
    boards.sort_by_cached_key(|board| key(board));
    for board in &mut boards {
        let score = |entry: &Ranked| rank_by.scores(&entry.0.measures.test).interquartile_mean.value;
        board.sort_by(|a, b| score(a).total_cmp(&score(b)).then_with(|| a.0.name.cmp(&b.0.name)));
    }
    let data = json!({
        "title": "Leaderboard",
        "tiles": [tile("problem", boards.len()), tile("result", results.len())],
        "tables": [], "lost": [], "drawings": [],
        "sections": boards.iter().map(|board| section(board)).collect::<Vec<_>>(),
        "footer": footer(results, rank_by),
    });
    b2b_page::write_page(file, &data)
}

fn tile(what: &str, count: usize) -> Value {
    let plural = if count == 1 { "" } else { "s" };
    json!([format!("{what}{plural}"), count.to_string()])
}

fn section(board: &[&Ranked]) -> Value {
    let result = &board[0].0;
    let problem = &result.problem;
    let changed = match result.problem_changes.as_deref() {
        Some([]) => String::new(),
        Some(changes) => format!(" · modified: {}", changes.join(", ")),
        None => " · custom problem".to_owned(),
    };
    let windows: Vec<_> = problem.protocol.windows.iter().map(ToString::to_string).collect();
    let memory = match problem.protocol.consecutive() {
        [] => "",
        _ => " Policies keep their memory over all of them.",
    };
    let mut tables = vec![scores(board)];
    tables.extend(strata(board));
    tables.extend(adaptation(board));
    tables.extend(by_episode(board));
    tables.extend(differences(board));
    json!({
        "title": format!("{}, version {}{changed}", problem.name, problem.version),
        "note": format!("{}. {} Test buildings: {}. Run periods: {}.{memory} Attributes {}. Problem hash {}.", capital(&problem.family.to_string()), problem.question,
            problem.test.buildings, windows.join(", "), problem.protocol.attributes, &problem.hash()[..12]),
        "tables": tables, "drawings": charts::all(board),
    })
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().collect::<String>() + letters.as_str())
}

fn table(title: &str, header: &[&str], rows: Vec<Value>) -> Value {
    json!({"title": title, "header": header, "rows": rows})
}

/// Returns a remark on the policy of an entry: the base controller that its agents correct, or that it is an unverified
/// program.
fn remark(result: &RunResult) -> String {
    if result.external().is_some() {
        return " (own program, unverified)".to_owned();
    }
    match result.policies.get("test") {
        Some(PolicyDescription::Agents { base: Some(base), .. }) => format!(" (on {base})"),
        _ => String::new(),
    }
}

/// Returns the test episodes of a result.
fn test_rows((_, stages): &Ranked) -> &[EpisodeResult] {
    rows_of(stages, Stage::Test).unwrap_or_default()
}

/// Returns the test episodes under random actions, from a result of the random policy or a result that measures
/// adaptation.
fn random_rows<'a>(board: &[&'a Ranked]) -> &'a [EpisodeResult] {
    let random = BuiltIn::random().to_string();
    let has = |result: &RunResult, stage: Stage| match result.policies.get("test") {
        Some(PolicyDescription::BuiltIn { name }) if *name == random => stage == Stage::Test,
        _ => stage == Stage::Untrained,
    };
    let mut stages = board.iter().flat_map(|(result, stages)| stages.iter().map(move |each| (result, each)));
    let found = stages.find(|(result, (stage, _))| has(result, *stage));
    found.map_or(&[], |(_, (_, rows))| rows)
}

/// Returns the columns of the tables of a problem.
fn columns(board: &[&Ranked]) -> Columns {
    Columns::of(test_rows(board[0]))
}

/// Returns the names of the interquartile means of the scores.
fn score_names(columns: &Columns) -> Vec<String> {
    columns.scores().iter().map(|name| format!("{name}, interquartile mean")).collect()
}

fn scores(board: &[&Ranked]) -> Value {
    let (random, columns) = (random_rows(board), columns(board));
    let row = |(rank, entry): (usize, &&Ranked)| {
        let (result, rows) = (&entry.0, test_rows(entry));
        let Measures { test, generalization_gap, .. } = &result.measures;
        let mut cells = vec![format!("{}. {}{}", rank + 1, result.name, remark(result))];
        cells.extend(means(&columns, test));
        cells.extend([
            test.scores.median.to_string(),
            test.scores.mean.to_string(),
            score_text(test.scores.min),
            score_text(test.scores.max),
            mean_from_random(rows, random).map_or("–".to_owned(), |mean| mean.to_string()),
            test.scores.beats_baseline_text(),
        ]);
        cells.extend(columns.other_cells(&rows.iter().collect::<Vec<_>>()));
        cells.extend([
            generalization_gap.map_or("–".to_owned(), |gap| gap.to_string()),
            result.training_steps.map_or("–".to_owned(), |steps| steps.to_string()),
            result.description.clone().unwrap_or_default(),
        ]);
        Value::from(cells)
    };
    let names = score_names(&columns);
    let mut header = vec!["entry"];
    header.extend(names.iter().map(String::as_str));
    header.extend([
        "score, median",
        "score, mean",
        "score, min",
        "score, max",
        "random = 0, baseline = 1",
        "below 1 (%)",
    ]);
    header.extend(columns.others());
    header.extend(["generalization gap", "training steps", "description"]);
    table("lower is better, 1 is the baseline", &header, board.iter().enumerate().map(row).collect())
}

/// Returns the interquartile means of the scores.
fn means(columns: &Columns, performance: &Performance) -> Vec<String> {
    let mean = |scores: &Aggregate| scores.interquartile_mean.to_string();
    columns.score_cells(mean(&performance.resolved), mean(&performance.scores))
}

fn strata(board: &[&Ranked]) -> Option<Value> {
    let columns = columns(board);
    let row = |entry: &Ranked, Stratum { building_type, task, period, performance }: &Stratum| {
        let is_own = |row: &&EpisodeResult| {
            [&row.info.building_type, &row.info.task, &row.info.period] == [building_type, task, period]
        };
        let own: Vec<&EpisodeResult> = test_rows(entry).iter().filter(is_own).collect();
        let mut cells = [&entry.0.name, building_type, task, period].map(Clone::clone).to_vec();
        cells.extend(means(&columns, performance));
        cells.extend([
            score_text(performance.scores.min),
            score_text(performance.scores.max),
            performance.scores.beats_baseline_text(),
        ]);
        cells.extend(columns.other_cells(&own));
        Value::from(cells)
    };
    let of_entry =
        |entry: &&Ranked| entry.0.measures.strata.iter().map(|each| row(entry, each)).collect::<Vec<_>>();
    let rows: Vec<Value> = board.iter().flat_map(of_entry).collect();
    let names = score_names(&columns);
    let mut header = vec!["entry", "building type", "task", "run period"];
    header.extend(names.iter().map(String::as_str));
    header.extend(["score, min", "score, max", "below 1 (%)"]);
    header.extend(columns.others());
    (!rows.is_empty()).then(|| table("by building type and task", &header, rows))
}

fn adaptation(board: &[&Ranked]) -> Option<Value> {
    let mut rows = Vec::new();
    for (result, _) in board {
        let Some(adaptation) = &result.measures.adaptation else { continue };
        let steps = adaptation.median_steps_to_baseline;
        let last = adaptation.curve.last();
        rows.push(json!([
            result.name,
            adaptation.jump_start.to_string(),
            steps.map_or("never".to_owned(), |steps| format!("{steps:.0}")),
            format!("{:.0}", 100.0 * adaptation.reach_baseline),
            last.map_or(String::new(), |point| point.steps.to_string()),
            last.map_or(String::new(), |point| point.scores.interquartile_mean.to_string()),
        ]));
    }
    let header = [
        "entry",
        "jump-start",
        "steps to baseline, median",
        "reaches baseline (%)",
        "last adaptation test (steps)",
        "score in the last test, interquartile mean",
    ];
    (!rows.is_empty()).then(|| table("adaptation", &header, rows))
}

/// Returns the header of a table by episode in a building.
fn header_of_episodes(curve: &EpisodeCurve, last: &str) -> Vec<String> {
    let days = curve.points.iter().map(|point| format!("after {} days", point.days_before));
    std::iter::once("entry".to_owned()).chain(days).chain([last.to_owned()]).collect()
}

/// Returns the scores of every entry by episode in a building.
fn by_episode(board: &[&Ranked]) -> Option<Value> {
    let curves = board.iter().filter_map(|(result, _)| Some((result, result.measures.by_episode.as_ref()?)));
    let curves: Vec<_> = curves.collect();
    let (_, first) = curves.first()?;
    let header = header_of_episodes(first, "first minus last");
    let row = |(result, curve): &(&RunResult, &EpisodeCurve)| {
        let scores = curve.points.iter().map(|point| point.performance.resolved.interquartile_mean);
        let cells = scores.chain([curve.improvement]).map(|each| Value::from(each.to_string()));
        Value::from_iter(std::iter::once(Value::from(result.name.clone())).chain(cells))
    };
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let title = "resolved score by days in the building, interquartile mean";
    Some(table(title, &header, curves.iter().map(row).collect()))
}

/// Returns the scores by episode of every entry minus the first entry's.
fn differences(board: &[&Ranked]) -> Option<Value> {
    let [first, others @ ..] = board else { return None };
    let row = |entry: &&Ranked| {
        let curve = entry.0.measures.by_episode.as_ref()?;
        let EpisodeDifference { all, points } =
            EpisodeDifference::of(curve, test_rows(entry), test_rows(first))?;
        let cells = points.into_iter().chain([all]).map(|each| Value::from(each.to_string()));
        Some(Value::from_iter(std::iter::once(Value::from(entry.0.name.clone())).chain(cells)))
    };
    let rows: Vec<Value> = others.iter().filter_map(row).collect();
    let header = header_of_episodes(first.0.measures.by_episode.as_ref()?, "all episodes");
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let title =
        format!("resolved score minus {}'s, paired by building and seed, interquartile mean", first.0.name);
    (!rows.is_empty()).then(|| table(&title, &header, rows))
}

fn footer(results: &[Ranked], rank_by: RankBy) -> String {
    let ranked = match rank_by {
        RankBy::Resolved => "resolved score",
        RankBy::Paper => "score",
    };
    let mut versions: Vec<String> = Vec::new();
    for (result, _) in results {
        let line = result.versions.to_string();
        if !versions.contains(&line) {
            versions.push(line);
        }
    }
    let several = if versions.len() > 1 { "Results of different versions are not comparable: " } else { "" };
    format!(
        "Entries are ranked by the interquartile mean of the {ranked}. Score: the return of a building under a task divided by \
         the tuned reactive controllers' return (the baseline) for the same days, as in the paper, mean over seeds. Resolved \
         score: the same after adding {RESOLUTION} K of RMS deviation, the accuracy of an air temperature sensor, to both. In operation, both are the score at comfort: cost relative to Guideline 36's, plus a penalty for more discomfort. In brackets: 95 % bootstrap confidence intervals over buildings within each type, \
         and over seeds. Random = 0, baseline = 1: the share of the way from random actions to the baseline, above 1 for \
         entries that beat it, interquartile mean; shown if the board has a result of the random policy. Unverified: the policy is the author's own program, so `b2b benchmark verify` cannot run its episodes again. Generalization gap: interquartile mean on test minus that on training buildings. {several}{}.",
        versions.join("; ")
    )
}
