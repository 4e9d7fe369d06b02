//! Measures of adaptation to the test environments.

use serde::{Deserialize, Serialize};

use super::result::rows_of;
use super::scores::{SeedScores, by_building, samples};
use crate::problem::Stage;
use b2b_evaluate::EpisodeResult;
use b2b_evaluate::statistics::{Aggregate, Interval, aggregate, median};

/// The effect of training on the test environments.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Adaptation {
    /// Jump-start: score of random actions minus the zero-shot score, interquartile mean over buildings.
    pub jump_start: Interval,
    /// Scores by number of training steps, from 0.
    pub curve: Vec<Point>,
    /// Steps after which half of the buildings reach the level of the reactive controllers; `None` if they never do.
    pub median_steps_to_baseline: Option<f64>,
    /// Share of buildings that ever reach that level.
    pub reach_baseline: f64,
}

/// Scores after a number of training steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Training steps on each test environment.
    pub steps: u64,
    /// The scores.
    pub scores: Aggregate,
}

impl Adaptation {
    /// Returns the measures of the stages; `None` without an untrained stage. `test` has the zero-shot scores.
    pub(super) fn of(stages: &[(Stage, Vec<EpisodeResult>)], test: &[SeedScores<'_>]) -> Option<Self> {
        let untrained = by_building(rows_of(stages, Stage::Untrained)?, EpisodeResult::score);
        let adapted = stages.iter().filter_map(|(stage, rows)| match stage {
            Stage::Adapted(steps) => Some((*steps, by_building(rows, EpisodeResult::score))),
            _ => None,
        });
        let adapted: Vec<_> = adapted.collect();
        let improvements: Vec<_> = test.iter().filter_map(|test| test.improvement(&untrained)).collect();
        let mut curve = vec![Point { steps: 0, scores: aggregate(&samples(test))? }];
        for (steps, groups) in &adapted {
            curve.push(Point { steps: *steps, scores: aggregate(&samples(groups))? });
        }
        let steps = steps_to_baseline(test, &adapted);
        let reached = steps.iter().filter(|steps| steps.is_finite()).count();
        Some(Self {
            jump_start: aggregate(&samples(&improvements))?.interquartile_mean,
            curve,
            median_steps_to_baseline: Some(median(&steps)).filter(|steps| steps.is_finite()),
            reach_baseline: reached as f64 / steps.len() as f64,
        })
    }
}

/// Returns the steps after which each building's score is first 1 or less, sorted; infinite if it never is.
fn steps_to_baseline(test: &[SeedScores<'_>], adapted: &[(u64, Vec<SeedScores<'_>>)]) -> Vec<f64> {
    let first = |(number, group): (usize, &SeedScores<'_>)| {
        let after = |(steps, groups): &(u64, Vec<SeedScores<'_>>)| Some((*steps, groups.get(number)?.mean()));
        let mut scores = std::iter::once((0, group.mean())).chain(adapted.iter().filter_map(after));
        scores.find(|(_, score)| *score <= 1.0).map_or(f64::INFINITY, |(steps, _)| steps as f64)
    };
    let mut steps: Vec<f64> = test.iter().enumerate().map(first).collect();
    steps.sort_by(f64::total_cmp);
    steps
}
