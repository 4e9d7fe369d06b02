//! The text report of a result.

use b2b_benchmark::entry::{Columns, EpisodePoint, Measures, Performance, RunResult, Score, Stages, rows_of};
use b2b_benchmark::problem::Stage;
use b2b_evaluate::EpisodeResult;
use b2b_evaluate::statistics::{Aggregate, score_text};

use crate::terminal::table::Table;

/// Returns the text report.
pub fn text(result: &RunResult, stages: &Stages) -> String {
    let modified = match result.problem_changes.as_deref() {
        Some([]) => String::new(),
        Some(changes) => format!(", modified: {}", changes.join(", ")),
        None => ", custom problem".to_owned(),
    };
    let tables = Tables {
        measures: &result.measures,
        stages,
        columns: Columns::of(rows_of(stages, Stage::Test).unwrap_or_default()),
    };
    format!(
        "{} on {}{modified}\n{}: interquartile means (lower is better, baseline = 1)\n\n{}\n\n{}\n\n{}  \
         [95 % confidence intervals: bootstrap over buildings within each type, and over seeds]",
        result.name,
        result.problem.name,
        tables.columns.scores().join(" and "),
        tables.scores(),
        tables.aggregates(),
        generalization_text(&result.measures),
    )
}

/// A group of episodes.
struct Group<'a> {
    name: String,
    /// `None` if only the scores are known.
    performance: Option<&'a Performance>,
    scores: &'a Aggregate,
    rows: Vec<&'a EpisodeResult>,
}

struct Tables<'a> {
    measures: &'a Measures,
    stages: &'a Stages,
    columns: Columns,
}

impl<'a> Tables<'a> {
    fn rows(&self, stage: Stage) -> Vec<&'a EpisodeResult> {
        rows_of(self.stages, stage).unwrap_or_default().iter().collect()
    }

    fn scores(&self) -> String {
        let mut header = vec!["building", "task", "period"];
        header.extend(self.columns.scores());
        header.extend(self.columns.others());
        let mut table = Table::with_header(header.into_iter().map(str::to_owned).collect());
        for Score { building, task, period, score, resolved_score, .. } in &self.measures.scores {
            let mut own = self.rows(Stage::Test);
            own.retain(|row| {
                [&row.info.building, &row.info.task, &row.info.period] == [building, task, period]
            });
            let mut cells = [building, task, period].map(Clone::clone).to_vec();
            cells.extend(self.columns.score_cells(score_text(*resolved_score), score_text(*score)));
            cells.extend(self.columns.other_cells(&own));
            table.push(cells);
        }
        table.text()
    }

    fn aggregates(&self) -> String {
        let mut header = vec!["environments", "scores"];
        header.extend(self.columns.scores());
        header.extend(["median", "mean", "min", "max", "below 1 (%)"]);
        header.extend(self.columns.others());
        let mut table = Table::with_header(header.into_iter().map(str::to_owned).collect());
        for Group { name, performance, scores, rows } in self.groups() {
            let resolved = performance.map(|all| all.resolved.interquartile_mean.to_string());
            let resolved = resolved.unwrap_or_else(|| "–".to_owned());
            let mut cells = vec![name, scores.episodes.to_string()];
            cells.extend(self.columns.score_cells(resolved, scores.interquartile_mean.to_string()));
            cells.extend([
                scores.median.to_string(),
                scores.mean.to_string(),
                score_text(scores.min),
                score_text(scores.max),
                scores.beats_baseline_text(),
            ]);
            cells.extend(self.columns.other_cells(&rows));
            table.push(cells);
        }
        table.text()
    }

    fn groups(&self) -> Vec<Group<'a>> {
        let Measures { strata, test, train, upper_bound, adaptation, by_episode, .. } = self.measures;
        let of = |name: String, performance: &'a Performance, rows: Vec<&'a EpisodeResult>| Group {
            name,
            performance: Some(performance),
            scores: &performance.scores,
            rows,
        };
        let mut groups = Vec::new();
        for stratum in strata {
            let mut own = self.rows(Stage::Test);
            own.retain(|row| {
                [&row.info.building_type, &row.info.task, &row.info.period]
                    == [&stratum.building_type, &stratum.task, &stratum.period]
            });
            let name = format!("{}, {}, {}", stratum.building_type, stratum.task, stratum.period);
            groups.push(of(name, &stratum.performance, own));
        }
        let whole = [
            ("test", Some(test), Stage::Test),
            ("train", train.as_ref(), Stage::Train),
            ("test, specialists (upper bound)", upper_bound.as_ref(), Stage::UpperBound),
        ];
        for (name, performance, stage) in whole {
            let Some(performance) = performance else { continue };
            groups.push(of(name.to_owned(), performance, self.rows(stage)));
        }
        for point in adaptation.iter().flat_map(|adaptation| adaptation.curve.iter().skip(1)) {
            let name = format!("test, after {} steps", point.steps);
            let rows = self.rows(Stage::Adapted(point.steps));
            groups.push(Group { name, performance: None, scores: &point.scores, rows });
        }
        let points = by_episode.iter().flat_map(|curve| &curve.points);
        for (number, EpisodePoint { days_before, performance, period }) in points.enumerate() {
            let name = format!("test, episode {}, after {days_before} days in the building", number + 1);
            let mut own = self.rows(Stage::Test);
            own.retain(|row| row.info.period == *period);
            groups.push(of(name, performance, own));
        }
        groups
    }
}

fn generalization_text(measures: &Measures) -> String {
    let mut text = String::new();
    if let Some(gap) = measures.generalization_gap {
        text += &format!("  generalization gap {}\n", gap);
    }
    if let Some(adaptation) = &measures.adaptation {
        let steps = match adaptation.median_steps_to_baseline {
            Some(steps) => format!("{steps:.0}"),
            None => "never".to_owned(),
        };
        let jump_start = adaptation.jump_start;
        text += &format!("  jump-start {jump_start}; median steps to reach the baseline: {steps}\n");
    }
    if let Some(curve) = &measures.by_episode {
        text += &format!("  first minus last episode in a building, resolved score: {}\n", curve.improvement);
    }
    text
}
