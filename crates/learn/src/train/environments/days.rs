//! The days of the run periods used for training episodes and for evaluations during training.

use b2b_building::{Period, RunPeriod};
use b2b_env::EpisodeConfig;

use crate::error::Result;
use crate::train::config::TrainConfig;

/// Returns the days of evaluations during training in a run period: a window in its middle, or all of two weeks chosen
/// from the weather.
pub(crate) fn evaluated(config: &TrainConfig, period: Period) -> Period {
    match period {
        Period::Days(days) => window(config, days).into(),
        Period::TwoWeeks(_) => period,
    }
}

/// Returns the parts of a run period for training episodes: before and after the evaluation window, where there is room
/// for an episode; all of it if the window is not held out or neither part has room.
pub(crate) fn trained(config: &TrainConfig, period: Period) -> Vec<Period> {
    let Period::Days(days) = period else { return vec![period] };
    let before = first_evaluated(config, days);
    let after = before + config.evaluation.days;
    let parts = [(0, before), (after, days.days().saturating_sub(after))];
    let is_held_out =
        config.evaluation.held_out && config.evaluation.every > 0 && config.training_set.window_days > 0;
    let has_room = |(_, days): &(u32, u32)| is_held_out && *days >= config.training_set.window_days;
    let parts: Vec<Period> =
        parts.into_iter().filter(has_room).map(|(first, count)| days.part(first, count).into()).collect();
    if parts.is_empty() { vec![period] } else { parts }
}

/// Returns whether training leaves out the days of evaluations.
pub(crate) fn are_held_out(config: &TrainConfig) -> Result<bool> {
    let periods = config.training_set.periods()?;
    let days = |period: Period| match period {
        Period::Days(days) => Some(days),
        Period::TwoWeeks(_) => None,
    };
    // Two weeks chosen from the weather may be anywhere.
    let Some(evaluated) = periods.iter().map(|period| days(*period)).collect::<Option<Vec<_>>>() else {
        return Ok(false);
    };
    // The days of one run period may be trained on in another.
    let is_apart = |part: RunPeriod| evaluated.iter().all(|period| !part.overlaps(window(config, *period)));
    let parts = periods.iter().flat_map(|period| trained(config, *period));
    Ok(parts.filter_map(days).all(is_apart))
}

/// Returns the run period to which an episode belongs.
///
/// # Errors
/// [`Error::Invalid`](crate::Error::Invalid) for an unknown period; [`Error::Env`](crate::Error::Env) for an unreadable
/// weather file.
pub(crate) fn period_of(config: &TrainConfig, episode: &EpisodeConfig) -> Result<Period> {
    let periods = config.training_set.periods()?;
    for period in &periods[..periods.len() - 1] {
        let days = period.in_weather(&episode.weather).map_err(b2b_env::Error::building)?;
        if days.overlaps(episode.period) {
            return Ok(*period);
        }
    }
    Ok(periods[periods.len() - 1])
}

/// Returns the window of evaluations in the middle of days of the year.
fn window(config: &TrainConfig, period: RunPeriod) -> RunPeriod {
    let days = config.evaluation.days.max(1);
    period.part(first_evaluated(config, period), days.min(period.days()))
}

fn first_evaluated(config: &TrainConfig, period: RunPeriod) -> u32 {
    period.days().saturating_sub(config.evaluation.days) / 2
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::config::{EvaluationConfig, TrainingSet};

    fn days(period: &str, window_days: u32, evaluation: EvaluationConfig) -> (String, Vec<String>) {
        let training_set = TrainingSet { period: period.into(), window_days, ..TrainingSet::default() };
        let config = TrainConfig { training_set, evaluation, ..TrainConfig::default() };
        let period = period.parse().unwrap();
        let trained = trained(&config, period).iter().map(ToString::to_string).collect();
        (evaluated(&config, period).to_string(), trained)
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
        config.training_set.period = "winter,summer".into();
        assert!(are_held_out(&config).unwrap());
        config.training_set.period = "winter,01-01..02-28".into();
        assert!(!are_held_out(&config).unwrap(), "each trains on the days of the other");
        config.training_set.period = "winter,peak-heating".into();
        assert!(!are_held_out(&config).unwrap(), "two weeks are trained on and evaluated");
        assert_eq!(of("peak-heating", 14), ("peak-heating".into(), vec!["peak-heating".into()]));
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
