//! What the episodes of a benchmark run come to.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::evaluation::Row;
use crate::problem::Stage;
use crate::statistics::{
    Aggregate, Cluster, Interval, Share, aggregate_clusters, difference, median, profile,
};

/// Seed of the bootstrap.
const SEED: u64 = 0;

/// The measures of a run.
///
/// A *score* is that of a building under a task in a window: the mean over seeds of the return over that of the tuned
/// reactive controllers. Lower is better, and below 1 beats them. A stratum of the bootstrap is a type under a task in a
/// window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measures {
    /// Test environments without a step of training there.
    pub test: Aggregate,
    /// The same by stratum, where there are several.
    pub strata: Vec<Stratum>,
    /// Share of test scores at or below a score.
    pub profile: Vec<Share>,
    /// The scores that these are of.
    pub scores: Vec<Score>,
    /// On training buildings; `None` where it was not tested on any.
    pub train: Option<Aggregate>,
    /// Interquartile mean of the test less that of training buildings: above 0 is worse where it was not trained.
    pub generalisation_gap: Option<Interval>,
    /// When adapting; `None` for what does not adapt.
    pub adaptation: Option<Adaptation>,
}

/// Scores of one kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stratum {
    /// Type of the buildings.
    pub building_type: String,
    /// The task.
    pub task: String,
    /// The window.
    pub period: String,
    /// Their scores.
    pub scores: Aggregate,
}

/// The score of a building under a task in a window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// The building.
    pub building: String,
    /// The task.
    pub task: String,
    /// The window.
    pub period: String,
    /// Mean over seeds.
    pub score: f64,
}

/// What training on the test environments brings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Adaptation {
    /// Score of random actions less that before a step of training there, interquartile mean over buildings: how much better
    /// it begins than what knows nothing.
    pub jump_start: Interval,
    /// Scores after so many steps, from 0.
    pub curve: Vec<Point>,
    /// Steps after which half of the buildings are at the level of the reactive controllers or better; `None` when they never
    /// are.
    pub median_steps_to_baseline: Option<f64>,
    /// Share of buildings that ever are.
    pub reach_baseline: f64,
}

/// Scores after some steps of training.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Steps on each test environment.
    pub steps: u64,
    /// Scores then.
    pub scores: Aggregate,
}

/// The bounds of a profile: 0 to 3 by 0.05.
fn bounds() -> Vec<f64> {
    (0..=60).map(|step| f64::from(step) / 20.0).collect()
}

/// Where a score belongs, and its seeds.
struct Group {
    building: String,
    building_type: String,
    task: String,
    period: String,
    seeds: Cluster,
}

impl Measures {
    /// Of the rows of every stage. `None` when a stage has no score.
    pub fn of(stages: &[(Stage, Vec<Row>)]) -> Option<Self> {
        let groups =
            |wanted: Stage| stages.iter().find(|(stage, _)| *stage == wanted).map(|(_, rows)| groups(rows));
        let test = groups(Stage::Test)?;
        let clusters = strata(&test);
        let train = groups(Stage::Train).map(|groups| strata(&groups));
        let kinds = kinds(&test);
        let stratum = |(kind, scores): (&(String, String, String), &Vec<Cluster>)| {
            let (building_type, task, period) = kind.clone();
            let scores = aggregate_clusters(std::slice::from_ref(scores), SEED)?;
            Some(Stratum { building_type, task, period, scores })
        };
        let several = kinds.len() > 1;
        Some(Self {
            test: aggregate_clusters(&clusters, SEED)?,
            strata: if several {
                kinds.iter().zip(&clusters).filter_map(stratum).collect()
            } else {
                Vec::new()
            },
            profile: profile(&clusters, &bounds(), SEED),
            scores: test.iter().map(Group::score).collect(),
            generalisation_gap: train.as_ref().and_then(|train| difference(&clusters, train, SEED)),
            train: train.and_then(|train| aggregate_clusters(&train, SEED)),
            adaptation: Adaptation::of(stages, &test),
        })
    }
}

/// Aggregate and profile of scores by stratum, building and seed, as in [`Measures`]. `None` without any.
pub fn measures_of(strata: &[Vec<Cluster>]) -> Option<Value> {
    let test = aggregate_clusters(strata, SEED)?;
    Some(json!({"test": test, "profile": profile(strata, &bounds(), SEED)}))
}

impl Group {
    fn mean(&self) -> f64 {
        self.seeds.iter().sum::<f64>() / self.seeds.len() as f64
    }

    fn score(&self) -> Score {
        let Self { building, task, period, .. } = self;
        Score { building: building.clone(), task: task.clone(), period: period.clone(), score: self.mean() }
    }

    fn kind(&self) -> (String, String, String) {
        (self.building_type.clone(), self.task.clone(), self.period.clone())
    }
}

impl Adaptation {
    fn of(stages: &[(Stage, Vec<Row>)], test: &[Group]) -> Option<Self> {
        let untrained =
            stages.iter().find(|(stage, _)| *stage == Stage::Untrained).map(|(_, rows)| groups(rows))?;
        let adapted = stages.iter().filter_map(|(stage, rows)| match stage {
            Stage::Adapted(steps) => Some((*steps, groups(rows))),
            _ => None,
        });
        let adapted: Vec<_> = adapted.collect();
        let better = |(before, group): (&Group, &Group)| Group {
            building: group.building.clone(),
            building_type: group.building_type.clone(),
            task: group.task.clone(),
            period: group.period.clone(),
            seeds: vec![before.mean() - group.mean()],
        };
        let better: Vec<_> = untrained.iter().zip(test).map(better).collect();
        let mut curve = vec![Point { steps: 0, scores: aggregate_clusters(&strata(test), SEED)? }];
        for (steps, groups) in &adapted {
            curve.push(Point { steps: *steps, scores: aggregate_clusters(&strata(groups), SEED)? });
        }
        let mut steps: Vec<f64> = test
            .iter()
            .enumerate()
            .map(|(number, group)| {
                let after = |(steps, groups): &(u64, Vec<Group>)| Some((*steps, groups.get(number)?.mean()));
                let all = std::iter::once((0, group.mean())).chain(adapted.iter().filter_map(after));
                all.into_iter()
                    .find(|(_, score)| *score <= 1.0)
                    .map_or(f64::INFINITY, |(steps, _)| steps as f64)
            })
            .collect();
        steps.sort_by(f64::total_cmp);
        let reached = steps.iter().filter(|steps| steps.is_finite()).count();
        Some(Self {
            jump_start: aggregate_clusters(&strata(&better), SEED)?.interquartile_mean,
            curve,
            median_steps_to_baseline: Some(median(&steps)).filter(|steps| steps.is_finite()),
            reach_baseline: reached as f64 / steps.len() as f64,
        })
    }
}

/// The scores of rows, seeds together, in the order of the rows.
fn groups(rows: &[Row]) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for row in rows {
        let (record, Some(score)) = (&row.record, row.score) else { continue };
        // Seeds of a building follow each other.
        let known = groups.iter_mut().rev().find(|group| {
            group.building == record.building && group.task == record.task && group.period == record.period
        });
        match known {
            Some(group) => group.seeds.push(score),
            None => groups.push(Group {
                building: record.building.clone(),
                building_type: record.building_type.clone(),
                task: record.task.clone(),
                period: record.period.clone(),
                seeds: vec![score],
            }),
        }
    }
    groups
}

/// The kinds of scores, in the order in which they come first.
fn kinds(groups: &[Group]) -> Vec<(String, String, String)> {
    let mut kinds = Vec::new();
    for kind in groups.iter().map(Group::kind) {
        if !kinds.contains(&kind) {
            kinds.push(kind);
        }
    }
    kinds
}

fn strata(groups: &[Group]) -> Vec<Vec<Cluster>> {
    let of = |kind: &(String, String, String)| {
        groups.iter().filter(|group| group.kind() == *kind).map(|group| group.seeds.clone()).collect()
    };
    kinds(groups).iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::Episode;
    use crate::{BuiltIn, Subject};

    /// Rows of 11 small and 6 medium offices with two seeds each, whose scores are a function of where they are.
    fn rows(score: impl Fn(usize, u64) -> f64) -> Vec<Row> {
        let places = (0..17).flat_map(|number| [0, 1].map(|seed| (number, seed)));
        let row = |(number, seed): (usize, u64)| {
            let building_type = if number < 11 { "OfficeSmall" } else { "OfficeMedium" };
            let episode = Episode {
                subject: Subject::at_home(format!("{building_type}-{}", number + 1).parse().unwrap()),
                task: "constant".parse().unwrap(),
                period: "01-01..01-02".parse().unwrap(),
                seed,
                steps_per_hour: 12,
            };
            let lost = Row::lost(&episode, &BuiltIn::Random, String::new());
            Row { score: Some(score(number, seed)), lost: None, ..lost }
        };
        places.map(row).collect()
    }

    fn noise(number: usize, seed: u64) -> f64 {
        ((number as f64 + 1.0) * 12.9898 + seed as f64 * 78.233).sin().abs()
    }

    /// The mean over seeds of each building, by another way than the groups of the module.
    fn means(score: impl Fn(usize, u64) -> f64) -> Vec<f64> {
        (0..17).map(|number| 0.5 * score(number, 0) + 0.5 * score(number, 1)).collect()
    }

    /// As numpy and scipy define it, from ranks: 17 scores lose 4 at either end.
    fn trimmed(scores: &[f64]) -> f64 {
        let rank = |score: f64| scores.iter().filter(|other| **other < score).count();
        let kept: Vec<f64> = scores.iter().copied().filter(|score| (4..13).contains(&rank(*score))).collect();
        assert_eq!(kept.len(), 9);
        kept.iter().sum::<f64>() / 9.0
    }

    fn near(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }

    #[test]
    fn measures_are_those_of_an_independent_computation() {
        let test = |number, seed| 0.5 + noise(number, seed);
        let train = |number, seed| 0.3 + noise(number + 40, seed);
        let untrained = |number, seed| 3.0 + noise(number + 80, seed);
        // A third of the buildings is below 1 after 100 steps, all of them but two after 200.
        let first =
            |number: usize, seed| if number.is_multiple_of(3) { 0.9 } else { 1.1 + noise(number, seed) };
        let second = |number: usize, _| if number < 2 { 1.5 } else { 0.8 };
        let stages = [
            (Stage::Test, rows(test)),
            (Stage::Train, rows(train)),
            (Stage::Untrained, rows(untrained)),
            (Stage::Adapted(100), rows(first)),
            (Stage::Adapted(200), rows(second)),
        ];
        let measures = Measures::of(&stages).unwrap();
        let scores = means(test);
        near(measures.test.mean.value, scores.iter().sum::<f64>() / 17.0);
        near(measures.test.interquartile_mean.value, trimmed(&scores));
        let below = |score: f64| scores.iter().filter(|other| **other < score).count();
        near(measures.test.median.value, *scores.iter().find(|score| below(**score) == 8).unwrap());
        near(measures.test.beats_baseline.value, below(1.0) as f64 / 17.0);
        assert_eq!(
            (measures.scores.len(), measures.strata.len(), measures.strata[1].scores.episodes),
            (17, 2, 6)
        );
        near(measures.scores[12].score, scores[12]);
        let at = |bound: f64| {
            measures.profile.iter().find(|point| (point.score - bound).abs() < 1e-12).unwrap().share
        };
        near(at(1.2).value, scores.iter().filter(|score| **score <= 1.2).count() as f64 / 17.0);
        near(measures.generalisation_gap.unwrap().value, trimmed(&scores) - trimmed(&means(train)));

        let adaptation = measures.adaptation.unwrap();
        let better: Vec<f64> =
            means(untrained).iter().zip(&scores).map(|(before, after)| before - after).collect();
        near(adaptation.jump_start.value, trimmed(&better));
        let steps = |number: usize| match number {
            _ if scores[number] <= 1.0 => 0.0,
            _ if number.is_multiple_of(3) => 100.0,
            0 | 1 => f64::INFINITY,
            _ => 200.0,
        };
        let reach = (0..17).filter(|number| steps(*number) < f64::INFINITY).count();
        near(adaptation.reach_baseline, reach as f64 / 17.0);
        let earlier = |bound: f64| (0..17).filter(|number| steps(*number) < bound).count();
        let median = [0.0, 100.0, 200.0].into_iter().rfind(|bound| earlier(*bound) <= 8).unwrap();
        assert_eq!(adaptation.median_steps_to_baseline, Some(median));
        let curve: Vec<_> = adaptation.curve.iter().map(|point| point.steps).collect();
        assert_eq!(curve, [0, 100, 200]);
    }

    #[test]
    fn what_never_reaches_the_baseline_has_no_number_of_steps() {
        let stages = [
            (Stage::Test, rows(|_, _| 2.0)),
            (Stage::Untrained, rows(|_, _| 3.0)),
            (Stage::Adapted(5), rows(|_, _| 1.5)),
        ];
        let adaptation = Measures::of(&stages).unwrap().adaptation.unwrap();
        assert_eq!((adaptation.median_steps_to_baseline, adaptation.reach_baseline), (None, 0.0));
        assert_eq!(adaptation.jump_start.value, 1.0);
        assert_eq!(Measures::of(&[]), None);
    }
}
