//! The summary of an evaluation.

use std::collections::BTreeMap;

use b2b_control::Versions;
use b2b_env::{EpisodeMetrics, Term};
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};

use crate::evaluation::{EpisodeResult, relative_energy, relative_resource};
use crate::policy::Policy;
use crate::results::Results;
use crate::statistics::{Aggregate, Sample, aggregate};

/// The summary of an evaluation: the object that `b2b evaluate --json` prints.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Versions that the results depend on.
    pub versions: Versions,
    /// Name of the policy.
    pub policy: String,
    /// Number of episodes.
    pub episodes: usize,
    /// Lost episodes.
    #[serde(serialize_with = "lost_episodes")]
    pub lost: Vec<EpisodeResult>,
    /// Groups of episodes, one per task and run period.
    pub windows: Vec<Window>,
}

/// The episodes with the same task and run period.
#[derive(Clone, Debug, Serialize)]
pub struct Window {
    /// The task.
    pub task: String,
    /// The run period.
    pub period: String,
    /// Episodes by building type, in the order of the list.
    pub types: Vec<Group>,
    /// All episodes.
    pub all: Group,
}

/// Aggregates over a group of episodes.
#[derive(Clone, Debug, Serialize)]
pub struct Group {
    /// Name of the group.
    pub name: String,
    /// Aggregated scores of buildings, means over seeds, as in the paper; `None` if no episode has a score.
    pub scores: Option<Aggregate>,
    /// Aggregated resolved scores; `None` if no episode has one.
    pub resolved_scores: Option<Aggregate>,
    /// Root mean square deviation from target, mean over episodes, K.
    pub rms_deviation_k: f64,
    /// Share of occupied zone-hours below the comfort band, mean over the episodes with people; `None` without any.
    pub occupied_too_cold_share: Option<f64>,
    /// Share above the comfort band, as above.
    pub occupied_too_warm_share: Option<f64>,
    /// HVAC energy, mean over episodes, Wh/m².
    pub energy_wh_m2: f64,
    /// HVAC energy of each known end use under the name of its column, mean over episodes, Wh/m².
    #[serde(flatten)]
    pub end_uses: BTreeMap<&'static str, f64>,
    /// HVAC energy relative to the baseline; `None` if the baseline's is unknown.
    pub relative_energy: Option<f64>,
    /// The task's resource (energy, cost, emissions or peak demand) relative to the baseline; `None` if one is unknown.
    pub relative_resource: Option<f64>,
    /// Actuator travel, mean over episodes, full strokes/day.
    pub daily_travel: f64,
    /// Comfort in an operation task; `None` in a task with targets.
    #[serde(flatten)]
    pub comfort: Option<OperationComfort>,
}

/// Cost, peak and comfort in the episodes of an operation task.
#[derive(Clone, Debug, Serialize)]
pub struct OperationComfort {
    /// Cost, mean over episodes, currency/m².
    pub cost_tot: f64,
    /// Peak electric demand over a quarter of an hour, mean over episodes, kW/m².
    pub pele_tot: f64,
    /// Discomfort, mean over episodes, K·h per zone.
    pub discomfort_k_h: f64,
    /// The baseline's discomfort; `None` if unknown in an episode.
    pub baseline_discomfort_k_h: Option<f64>,
    /// Number of episodes whose discomfort exceeds the baseline's by more than the free allowance; see
    /// [`FREE_DISCOMFORT`](crate::FREE_DISCOMFORT).
    pub uncomfortable: usize,
}

impl Results {
    /// Summarizes the results.
    pub fn summary(&self, policy: &dyn Policy) -> Summary {
        let ran: Vec<&EpisodeResult> = self.rows.iter().filter(|row| row.outcome.is_ok()).collect();
        let windows = grouped(&ran, |row| (row.info.task.clone(), row.info.period.clone()));
        Summary {
            versions: Versions::current(),
            policy: policy.name(),
            episodes: self.rows.len(),
            lost: self.rows.iter().filter(|row| row.outcome.is_err()).cloned().collect(),
            windows: windows
                .into_iter()
                .map(|((task, period), rows)| Window::of(task, period, &rows))
                .collect(),
        }
    }
}

/// Writes what identifies each lost episode, and why it was lost.
fn lost_episodes<S: Serializer>(lost: &[EpisodeResult], serializer: S) -> Result<S::Ok, S::Error> {
    struct Entry<'a>(&'a EpisodeResult);

    impl Serialize for Entry<'_> {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            let EpisodeResult { info, outcome } = self.0;
            let mut entry = serializer.serialize_struct("lost", 5)?;
            entry.serialize_field("building", &info.building)?;
            entry.serialize_field("task", &info.task)?;
            entry.serialize_field("period", &info.period)?;
            entry.serialize_field("seed", &info.seed)?;
            entry.serialize_field("why", &outcome.as_ref().err().map(|lost| &lost.reason))?;
            entry.end()
        }
    }

    serializer.collect_seq(lost.iter().map(Entry))
}

impl Window {
    fn of(task: String, period: String, rows: &[&EpisodeResult]) -> Self {
        let types = grouped(rows, |row| type_label(&row.info.building_type).to_owned());
        let all = Group::of("all".to_owned(), rows);
        let types = types.into_iter().map(|(name, rows)| Group::of(name, &rows)).collect();
        Self { task, period, types, all }
    }
}

impl Group {
    fn of(name: String, rows: &[&EpisodeResult]) -> Self {
        let aggregated = |score: fn(&EpisodeResult) -> Option<f64>| {
            let samples = rows.iter().filter_map(|row| Some(Sample::of(&row.info, score(row)?)));
            aggregate(&samples.collect::<Vec<_>>())
        };
        let metrics = || rows.iter().filter_map(|row| row.metrics());
        let mean = |value: fn(&EpisodeMetrics) -> f64| mean_of(metrics().map(value)).unwrap_or_default();
        let end_use = |term: Term| {
            let column = term.entry().column.as_ref()?.name;
            Some((column, mean_of(metrics().filter_map(|metrics| metrics.terms.get(term)))?))
        };
        Self {
            name,
            scores: aggregated(EpisodeResult::score),
            resolved_scores: aggregated(EpisodeResult::resolved_score),
            rms_deviation_k: mean(|metrics| metrics.rms_deviation),
            occupied_too_cold_share: mean_of(metrics().filter_map(|metrics| metrics.occupied_too_cold)),
            occupied_too_warm_share: mean_of(metrics().filter_map(|metrics| metrics.occupied_too_warm)),
            energy_wh_m2: mean(EpisodeMetrics::energy),
            end_uses: Term::END_USES.into_iter().filter_map(end_use).collect(),
            relative_energy: relative_energy(rows.iter().copied()),
            relative_resource: relative_resource(rows.iter().copied()),
            daily_travel: mean(|metrics| metrics.daily_travel),
            comfort: OperationComfort::of(rows.iter().copied()),
        }
    }

    /// Returns the number of buildings with a score.
    pub fn buildings(&self) -> usize {
        self.scores.as_ref().map_or(0, |scores| scores.episodes)
    }
}

impl OperationComfort {
    /// Returns the comfort of some episodes; `None` if one was lost or is not of operation.
    pub fn of<'a>(rows: impl Iterator<Item = &'a EpisodeResult>) -> Option<Self> {
        let (mut own, mut baseline, mut uncomfortable) = (Vec::new(), Vec::new(), 0);
        let (mut costs, mut peaks) = (Vec::new(), Vec::new());
        for row in rows {
            let scored = row.scored()?;
            own.push(scored.metrics.tdis_tot?);
            costs.push(scored.metrics.cost_tot?);
            peaks.push(scored.metrics.pele_tot.unwrap_or(0.0));
            baseline.push(scored.baseline_discomfort);
            uncomfortable += usize::from(scored.is_uncomfortable(row.info.steps_per_hour) == Some(true));
        }
        let baseline: Option<Vec<f64>> = baseline.into_iter().collect();
        Some(Self {
            cost_tot: mean_of(costs.into_iter())?,
            pele_tot: mean_of(peaks.into_iter())?,
            discomfort_k_h: mean_of(own.into_iter())?,
            baseline_discomfort_k_h: baseline.and_then(|baseline| mean_of(baseline.into_iter())),
            uncomfortable,
        })
    }

    /// Returns the number of uncomfortable episodes as a mark; empty if there are none.
    pub fn mark(&self) -> String {
        if self.uncomfortable == 0 { String::new() } else { format!("! {}", self.uncomfortable) }
    }
}

/// Returns the mean of some values; `None` without any.
fn mean_of(values: impl Iterator<Item = f64>) -> Option<f64> {
    let values: Vec<f64> = values.collect();
    // A sum of negative zeros would begin at -0.
    (!values.is_empty()).then(|| values.iter().fold(0.0, |sum, value| sum + value) / values.len() as f64)
}

/// Returns the name of a building type in results; users' models have no type.
pub fn type_label(building_type: &str) -> &str {
    if building_type.is_empty() { "own models" } else { building_type }
}

/// Groups rows by a key, in order of first appearance.
fn grouped<'a, K: PartialEq>(
    rows: &[&'a EpisodeResult],
    key: impl Fn(&EpisodeResult) -> K,
) -> Vec<(K, Vec<&'a EpisodeResult>)> {
    let mut groups: Vec<(K, Vec<&EpisodeResult>)> = Vec::new();
    for row in rows {
        let key = key(row);
        match groups.iter_mut().find(|(known, _)| *known == key) {
            Some((_, rows)) => rows.push(row),
            None => groups.push((key, vec![row])),
        }
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::{EpisodeInfo, EpisodePlan, Lost};
    use crate::{BuiltIn, Subject};

    #[test]
    fn a_lost_episode_is_written_with_what_identifies_it_and_the_reason() {
        let episode = EpisodePlan {
            subject: Subject::at_home("OfficeSmall-42".parse().unwrap()),
            task: "constant".parse().unwrap(),
            period: "01-01..01-02".parse().unwrap(),
            seed: 7,
            steps_per_hour: 12,
        };
        let lost = Lost { reason: "it crashed".into() };
        let row = EpisodeResult { info: EpisodeInfo::of(&episode, &BuiltIn::random()), outcome: Err(lost) };
        let summary = Results { rows: vec![row] }.summary(&BuiltIn::random());
        let json = serde_json::to_string(&summary).unwrap();
        let expected = r#""lost":[{"building":"OfficeSmall-0042","task":"constant","period":"01-01..01-02","seed":7,"why":"it crashed"}]"#;
        assert!(json.contains(expected), "{json}");
        let said = "OfficeSmall-0042, constant, 01-01..01-02, seed 7: it crashed";
        assert_eq!(summary.lost[0].to_string(), said);
    }
}
