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
