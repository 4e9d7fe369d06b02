//! The days of the run period used for training episodes and for evaluations during training.

use b2b_building::RunPeriod;

use crate::error::Result;
use crate::train::config::TrainConfig;

/// Returns the window of evaluations during training: days in the middle of the run period.
pub(crate) fn evaluated(config: &TrainConfig) -> Result<RunPeriod> {
    let (period, days) = (config.training_set.run_period()?, config.evaluation.days.max(1));
    Ok(period.part(first_evaluated(config)?, days.min(period.days())))
}

/// Returns the parts of the run period for training episodes: before and after the evaluation window, where there is
/// room for an episode; all of it if the window is not held out or neither part has room.
pub(crate) fn trained(config: &TrainConfig) -> Result<Vec<RunPeriod>> {
    let period = config.training_set.run_period()?;
    let (before, days) = (first_evaluated(config)?, config.evaluation.days);
    let after = before + days;
    let parts = [(0, before), (after, period.days().saturating_sub(after))];
    let is_held_out =
        config.evaluation.held_out && config.evaluation.every > 0 && config.training_set.window_days > 0;
    let has_room = |(_, days): &(u32, u32)| is_held_out && *days >= config.training_set.window_days;
    let parts: Vec<RunPeriod> =
        parts.into_iter().filter(has_room).map(|(first, days)| period.part(first, days)).collect();
    Ok(if parts.is_empty() { vec![period] } else { parts })
}

/// Returns whether training leaves out the days of evaluations.
pub(crate) fn are_held_out(config: &TrainConfig) -> Result<bool> {
    let evaluated = evaluated(config)?;
    Ok(trained(config)?.into_iter().all(|part| !part.overlaps(evaluated)))
}

fn first_evaluated(config: &TrainConfig) -> Result<u32> {
    Ok(config.training_set.run_period()?.days().saturating_sub(config.evaluation.days) / 2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::config::{EvaluationConfig, TrainingSet};

    fn days(period: &str, window_days: u32, evaluation: EvaluationConfig) -> (String, Vec<String>) {
        let training_set = TrainingSet { period: period.into(), window_days, ..TrainingSet::default() };
        let config = TrainConfig { training_set, evaluation, ..TrainConfig::default() };
        let trained = trained(&config).unwrap().iter().map(ToString::to_string).collect();
        (evaluated(&config).unwrap().to_string(), trained)
    }

    #[test]
    fn training_leaves_out_the_days_of_evaluations_where_there_is_room() {
        let of = |period, window| days(period, window, EvaluationConfig::default());
        let (evaluated, trained) = of("winter", 14);
        assert_eq!(
            (evaluated.as_str(), trained),
            ("02-08..02-21", vec!["01-01..02-07".into(), "02-22..03-31".into()])
        );
        let mut config = TrainConfig::default();
        config.training_set.window_days = 14;
        assert!(are_held_out(&config).unwrap());
        config.training_set.period = "01-01..01-31".into();
        assert!(!are_held_out(&config).unwrap());
        config.training_set.period = "11-15..02-15".into();
        assert!(are_held_out(&config).unwrap(), "also in a period that passes New Year");
        // Neither side has fourteen days.
        assert_eq!(of("01-01..01-31", 14).1, ["01-01..01-31"]);
        assert_eq!(of("01-01..01-10", 14).0, "01-01..01-10");
        // An episode of the whole run period leaves no other days.
        assert_eq!(of("winter", 0).1, ["winter"]);
        let seen = EvaluationConfig { held_out: false, ..EvaluationConfig::default() };
        assert_eq!(days("winter", 14, seen).1, ["winter"]);
        let none = EvaluationConfig { every: 0, ..EvaluationConfig::default() };
        assert_eq!(days("winter", 14, none).1, ["winter"]);
    }
}
