//! The paper's claims in its table of PPO agents, and in its text about the energy weight.

use b2b_evaluate::EpisodeResult;
use b2b_evaluate::statistics::{Sample, mean, median, score_text};

use super::claim::{Claim, Judged, Side, deviations_text};
use super::interval::measured;
use super::select::{log_resolved, log_score, median_of, trained};
use crate::absolute::{deviation, reactive_deviation};
use crate::paper;
use crate::results::{Ran, Results, samples};

/// Name of the agent with the paper's setting.
pub(super) const AGENT: &str = "paper";
/// Steps of the paper's trainings.
pub(super) const STEPS: u64 = 5_000_000;

/// Rows of the table whose published medians are all on one side of the baseline.
struct Rows {
    text: &'static str,
    building_type: &'static str,
    /// Selects rows by task and period.
    is_own: fn(task: &str, period: &str) -> bool,
    side: Side,
}

const WITHOUT_ENERGY: fn(&str) -> bool = |task| !task.contains('+');

const ROWS: [Rows; 7] = [
    Rows {
        text: "beats the reactive controllers in houses in winter (0.09 to 0.29; 8 of 8 in each task)",
        building_type: "SingleFamilyHouse",
        is_own: |_, period| period == "winter",
        side: Side::Below,
    },
    Rows {
        text: "does not beat them in houses in summer with constant targets (3.23 and 3.63; 0 of 8)",
        building_type: "SingleFamilyHouse",
        is_own: |task, period| period == "summer" && task.starts_with("constant"),
        side: Side::Above,
    },
    Rows {
        text: "beats them in small offices in summer with constant targets and no weight on energy (0.47; 8 of 8)",
        building_type: "OfficeSmall",
        is_own: |task, period| period == "summer" && task == "constant",
        side: Side::Below,
    },
    Rows {
        text: "beats them in medium offices with targets by occupancy in summer (0.31 and 0.30; 8 of 8)",
        building_type: "OfficeMedium",
        is_own: |task, period| period == "summer" && task.starts_with("occupancy"),
        side: Side::Below,
    },
    Rows {
        text: "does not beat them in medium offices in winter with constant targets and no weight on energy (2.80; 0 of 8)",
        building_type: "OfficeMedium",
        is_own: |task, period| period == "winter" && task == "constant",
        side: Side::Above,
    },
    Rows {
        text: "does not beat them in retail stores (1.97 to 2.98; 2 of 64)",
        building_type: "RetailStandalone",
        is_own: |_, _| true,
        side: Side::Above,
    },
    Rows {
        text: "does not beat them in warehouses in summer (1.88 to 2.56; 2 of 32)",
        building_type: "Warehouse",
        is_own: |_, period| period == "summer",
        side: Side::Above,
    },
];

const CAVEAT: &str = "the reactive controllers there are tuned for one task and a quarter of the buildings, the scaling of \
                      observations is not published, and the buildings are others";

pub(super) fn judge(results: &Results) -> Vec<Judged> {
    let all = trained(results, AGENT, STEPS);
    let mut judged: Vec<Judged> = ROWS.iter().map(|rows| of_rows(rows, &all)).collect();
    judged.push(same_side(&all));
    judged.push(no_degenerate_policy(&all));
    judged
}

fn of_rows(rows: &Rows, all: &[Ran<'_>]) -> Judged {
    let claim = Claim {
        text: format!("PPO {}", rows.text),
        quantity: "median score",
        side: rows.side,
        bound: 1.0,
        margin: 0.05,
        caveat: CAVEAT,
    };
    let is_own = |(_, row): &&Ran<'_>| {
        row.info.building_type == rows.building_type && (rows.is_own)(&row.info.task, &row.info.period)
    };
    let own: Vec<Ran<'_>> = all.iter().filter(is_own).copied().collect();
    let [score, resolved] =
        [log_score, log_resolved].map(|value| Some(measured(&samples(&own, value), median)?.exp()));
    let verdicts =
        [&score, &resolved].map(|measured| measured.as_ref().map(|measured| claim.verdict(measured)));
    let mut remark = deviations_text(median_of(&own, deviation), median_of(&own, reactive_deviation));
    if let (true, Some(resolved)) = (verdicts[0] != verdicts[1], &resolved) {
        remark += &format!("; near perfection: with 0.2 K added to both, {}", resolved.interval);
    }
    claim.judge(score, &remark)
}

/// Judges whether medians are on the published side of 1, row by row.
fn same_side(all: &[Ran<'_>]) -> Judged {
    let claim = Claim {
        text: "Rows of the table in which PPO's median beats the baseline are those in which it does as published".into(),
        quantity: "share of rows on the published side",
        side: Side::Above,
        bound: 0.75,
        margin: 0.05,
        caveat: CAVEAT,
    };
    let mut rows: Vec<[&str; 3]> = all.iter().map(|(_, row)| place(row)).collect();
    rows.sort_unstable();
    rows.dedup();
    let agrees = |place: &[&str; 3]| {
        let published = paper::score(place[0], place[1], place[2])?.median;
        let own: Vec<Ran<'_>> = all.iter().filter(|(_, row)| self::place(row) == *place).copied().collect();
        let here = median_of(&own, |scored| scored.score)?;
        Some((place.join(", "), f64::from((published < 1.0) == (here < 1.0))))
    };
    let agreeing: Vec<(String, f64)> = rows.iter().filter_map(agrees).collect();
    let agreeing: Vec<Sample<'_>> = agreeing
        .iter()
        .map(|(row, score)| Sample {
            building_type: "",
            building: row,
            case: [""; 2],
            agent: "",
            seed: 0,
            score: *score,
        })
        .collect();
    let remark = format!("rows of the table instead of buildings: {}", agreeing.len());
    claim.judge(measured(&agreeing, mean), &remark)
}

fn place(row: &EpisodeResult) -> [&str; 3] {
    [&row.info.building_type, &row.info.task, &row.info.period]
}

/// Judges whether no agent with a weight on energy is degenerate.
fn no_degenerate_policy(all: &[Ran<'_>]) -> Judged {
    let claim = Claim {
        text: "An energy weight of 0.5 yields no degenerate policy in any building, winter or summer".into(),
        quantity: "share of degenerate policies",
        side: Side::Below,
        bound: 0.02,
        margin: 0.0,
        caveat: CAVEAT,
    };
    let own: Vec<Ran<'_>> = all.iter().filter(|(_, row)| !WITHOUT_ENERGY(&row.info.task)).copied().collect();
    let degenerate = samples(&own, |scored| {
        let is_off = scored.relative_energy()? < OFF_ENERGY && scored.metrics.rms_deviation > OFF_DEVIATION;
        Some(f64::from(is_off))
    });
    let remark = format!(
        "degenerate: energy below {OFF_ENERGY} of the reactive controllers' and RMS deviation above {} K",
        score_text(OFF_DEVIATION)
    );
    claim.judge(measured(&degenerate, mean), &remark)
}

/// A policy is degenerate if its energy is below this fraction of the reactive controllers', and its RMS deviation
/// above this, K.
pub(super) const OFF_ENERGY: f64 = 0.25;
const OFF_DEVIATION: f64 = 2.0;

#[cfg(test)]
mod tests {
    use super::super::claim::Verdict;
    use super::*;
    use crate::definition::Experiment;

    #[test]
    fn every_group_of_rows_is_published_on_one_side() {
        let ppo = Experiment::named("ppo").unwrap();
        for rows in ROWS {
            let mut count = 0;
            for task in &ppo.tasks {
                for period in &ppo.periods {
                    if (rows.is_own)(task, period) {
                        let median = paper::score(rows.building_type, task, period).unwrap().median;
                        assert_eq!(median < 1.0, rows.side == Side::Below, "{} {task} {period}", rows.text);
                        count += 1;
                    }
                }
            }
            assert!(count > 0);
        }
    }

    #[test]
    fn without_trainings_of_the_papers_steps_there_are_no_results() {
        let judged =
            judge(&Results::none(Experiment::named("ppo").unwrap().budget("quick").unwrap().clone()));
        assert!(judged.iter().all(|each| each.verdict == Verdict::NoResults), "{judged:?}");
    }
}
