//! Options without effect beside the others.

use toml::{Table, Value};

use super::file::Read;
use super::train_config::TrainConfig;
use crate::ppo::PpoConfig;

/// Why an option has no effect in a configuration; `None` if it has one.
type Why = fn(&TrainConfig) -> Option<&'static str>;

/// The options that can be without effect.
const OPTIONS: [(&str, Why); 7] = [
    ("ppo.actor_hidden", of_graph),
    ("ppo.critic_hidden", of_graph),
    ("ppo.activation", of_graph),
    ("ppo.initial_log_std", |config| {
        (config.noise.noise_cost > 0.0)
            .then_some("the initial noise follows from `noise_cost`, which must be 0")
    }),
    ("ppo.value_rate", |config| {
        let ppo = config.learner.options::<PpoConfig>()?;
        (!ppo.normalize_values).then_some("it is for `ppo.normalize_values`, which is false")
    }),
    ("travel_cost_growth", |config| {
        (config.rewards.travel_cost == 0.0).then_some("`travel_cost` is 0; give both")
    }),
    ("window_starts", |config| {
        (config.training_set.window_days == 0)
            .then_some("episodes are the whole run period; give `window_days`, too")
    }),
];

fn of_graph(config: &TrainConfig) -> Option<&'static str> {
    let remedy = "it is for other networks; graph networks have `policy.embedding` and `policy.feed_forward`";
    config.agent.policy.is_graph().then_some(remedy)
}

/// Returns those of [`OPTIONS`] that changes set to a value other than before and than the default.
pub(super) fn chosen(base: &Table, changes: &Table) -> Vec<&'static str> {
    let default = toml::from_str(&TrainConfig::default().to_toml()).expect("what is written can be read");
    let is_chosen = |option: &str| {
        of(changes, option)
            .is_some_and(|value| ![of(base, option), of(&default, option)].contains(&Some(value)))
    };
    OPTIONS.iter().map(|(option, _)| *option).filter(|option| is_chosen(option)).collect()
}

fn of<'a>(table: &'a Table, option: &str) -> Option<&'a Value> {
    match option.split_once('.') {
        None => table.get(option),
        Some((part, name)) => table.get(part)?.get(name),
    }
}

/// Checks that chosen options have an effect.
pub(super) fn check(config: &TrainConfig, chosen: &[&str]) -> Read<()> {
    for (option, why) in OPTIONS.iter().filter(|(option, _)| chosen.contains(option)) {
        if let Some(why) = why(config) {
            return Err(format!("`{option}` has no effect: {why}"));
        }
    }
    Ok(())
}
