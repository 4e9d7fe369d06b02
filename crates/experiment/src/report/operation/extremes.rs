//! The best and the worst episodes of each policy, with what they use more or less than the guideline.

use b2b_evaluate::EpisodeResult;
use b2b_evaluate::statistics::score_text;
use serde_json::{Value, json};

use super::comparison::GUIDELINE;
use super::figures::{Figures, HEADER};
use super::{Guideline, policies};
use crate::definition::Experiment;
use crate::folder::{Folder, JobResult};
use crate::results::Results;

/// Worst episodes of each policy.
const WORST: usize = 3;

/// An episode of a policy with its score and figures, and the guideline's.
pub(in crate::report) struct Extreme<'a> {
    /// `graph best`, `graph worst 1`, and so on.
    pub(in crate::report) name: String,
    job: &'a JobResult,
    row: &'a EpisodeResult,
    score: f64,
    own: Figures,
    guideline: Figures,
}

/// Returns each policy's best and worst episodes under the first task.
pub(in crate::report) fn extremes<'a>(experiment: &Experiment, results: &'a Results) -> Vec<Extreme<'a>> {
    let mut extremes = Vec::new();
    for policy in policies(experiment, results).iter().filter(|policy| *policy != GUIDELINE) {
        let mut episodes = episodes(experiment, results, policy);
        episodes.sort_by(|a, b| a.score.total_cmp(&b.score));
        let worst = episodes.split_off(episodes.len().min(1)).into_iter().rev().take(WORST).zip(1..);
        let named = |name: String, extreme| Extreme { name: format!("{policy} {name}"), ..extreme };
        extremes.extend(episodes.into_iter().map(|best| named("best".into(), best)));
        extremes.extend(worst.map(|(worst, rank)| named(format!("worst {rank}"), worst)));
    }
    extremes
}

/// Returns the table of each policy's best and worst episodes; `None` without any.
pub(super) fn table(experiment: &Experiment, results: &Results) -> Option<Value> {
    let rows: Vec<_> = extremes(experiment, results).iter().map(Extreme::cells).collect();
    let mut header =
        ["", "building", "place", "period", "score at comfort", "cost (%)"].map(str::to_owned).to_vec();
    header.extend(HEADER.map(str::to_owned));
    (!rows.is_empty()).then(|| {
        json!({
            "name": format!("Best and worst episodes, beyond {GUIDELINE}"),
            "title": format!(
                "from cost on, differences from {GUIDELINE} in the same two weeks; `b2b experiment report --draw` draws the \
                 episodes day by day"
            ),
            "header": header,
            "rows": rows,
        })
    })
}

/// Returns the episodes of a policy that have a score and ran under the guideline as well.
fn episodes<'a>(experiment: &Experiment, results: &'a Results, policy: &str) -> Vec<Extreme<'a>> {
    let Some(task) = experiment.tasks.first() else { return Vec::new() };
    let guideline = Guideline::of(results);
    let figures = |row: &EpisodeResult| Figures::of(row, vec![row.metrics()?.cost_tot?]);
    let all = results.of(policy).filter(|(_, row)| row.info.task == *task);
    let episode = |(job, row): (&'a JobResult, &'a EpisodeResult)| {
        let (own, guideline) = (figures(row)?, figures(guideline.same(row)?)?);
        Some(Extreme { name: String::new(), job, row, score: row.score()?, own, guideline })
    };
    all.filter_map(episode).collect()
}

impl Extreme<'_> {
    /// Returns the arguments of `b2b run` that draw the episode, given the folder of the experiment; `None` without the
    /// agent's folder.
    pub(in crate::report) fn arguments(&self, folder: &Folder) -> Option<Vec<String>> {
        let controller = match self.job.agent_sha256 {
            Some(_) => folder.keyed(&self.job.key).path().join(self.job.agent_folder()),
            None => self.job.agent.clone().into(),
        };
        let is_there = self.job.agent_sha256.is_none() || controller.join("agent.json").exists();
        let (info, controller) = (&self.row.info, controller.to_string_lossy());
        let arguments =
            [&info.building, "--task", &info.task, "--period", &info.period, "--controller", &controller];
        is_there.then(|| arguments.map(str::to_owned).to_vec())
    }

    fn cells(&self) -> Vec<String> {
        let info = &self.row.info;
        let mut cells: Vec<String> =
            [&self.name, &info.building, &info.place, &info.period].map(String::clone).to_vec();
        cells.push(score_text(self.score));
        cells.push(format!("{:+.1}", 100.0 * (self.own.costs[0] / self.guideline.costs[0] - 1.0)));
        let values = self.own.values().into_iter().zip(self.guideline.values());
        cells.extend(values.map(|(own, guideline)| format!("{:+.2}", own - guideline)));
        cells
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn the_shipped_agents_have_a_best_and_three_worst_episodes_which_can_be_drawn() {
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../results/supervision"));
        let (folder, experiment, budget) = Folder::open(path).unwrap();
        let results = Results::read(&folder, &experiment, &budget).unwrap();
        let extremes = extremes(&experiment, &results);
        let of = |policy: &'static str| extremes.iter().filter(move |each| each.job.agent == policy);
        let graph: Vec<&Extreme<'_>> = of("graph").collect();
        let names: Vec<&str> = graph.iter().map(|each| &each.name[..]).collect();
        assert_eq!(names, ["graph best", "graph worst 1", "graph worst 2", "graph worst 3"]);
        assert!(graph[0].score < 1.0 && graph[1].score >= graph[2].score && graph[2].score >= graph[3].score);
        assert_eq!(graph[1].arguments(&folder).unwrap()[0], graph[1].row.info.building);
        assert_eq!(of("mpc").next().unwrap().arguments(&folder).unwrap()[6], "mpc");
        assert!(of("flat").all(|each| each.arguments(&folder).is_none()), "agents that are not shipped");
        let table = table(&experiment, &results).unwrap();
        assert_eq!(table["rows"].as_array().unwrap().len(), extremes.len());
        // The cost of a best episode is below the guideline's.
        assert!(table["rows"][0][5].as_str().unwrap().starts_with('-'), "{}", table["rows"][0]);
    }
}
