//! The card of a corpus.

use std::collections::BTreeMap;

use super::definition::Definition;
use super::history::History;
use crate::offline::dataset::EpisodeMetadata;

/// Returns the description of a corpus for people, in Markdown.
pub(super) fn card(id: &str, name: &str, definition: &Definition, episodes: &[EpisodeMetadata]) -> String {
    let [observation, action] = definition.widths;
    let transitions: usize = episodes.iter().map(|episode| episode.total_steps).sum();
    format!(
        "# {id}\n\n\
         The corpus `{name}` of building2building: {transitions} transitions of 5 minutes, in {buildings} episodes of \
         a week in {all} buildings of {types} types, all from the training split of its dataset v1. Simulated with \
         EnergyPlus.\n\n\
         | type | task | policy | episodes | mean return |\n|---|---|---|--:|--:|\n{rows}\n\
         ## Files\n\n\
         - `data/N/part-0.parquet`: the steps of an episode in Minari's format, also plain Parquet. `observations` are \
         f32 in physical units, padded with zeros to {observation} values; `actions` are scaled to [-1, 1] between the \
         bounds of each actuator, and padded with zeros to {action}; `infos.expert_actions` are the actions of the \
         expert for the same observation. The last row has only an observation.\n\
         - `data/N/metadata.json`: building, task, period, policy, seed, widths without padding, and the graph.\n\
         - `graphs/*.json`: a building's nodes with attributes, its edges, and the node, quantity and bounds of every \
         value of an observation and an action. `universe.json` has the node types.\n\
         - `SHA256SUMS`: digests of all files.\n\n\
         ## Policies\n\n\
         `reactive` are the paper's tuned controllers, `guideline36` the sequences of ASHRAE Guideline 36, `own` the \
         model's own thermostats and schedules (without actuators, actions and labels are zeros), `random` uniform \
         actions. {agents}`+noiseX` adds noise, uniform within X of half of each actuator's range and held for an hour. The \
         expert is `reactive` in tasks with targets and `guideline36` in operation.\n\n\
         ## Use\n\n\
         ```python\nimport minari\n\ndataset = minari.load_dataset(\"{id}\")\n```\n\n\
         ```sh\nb2b collect --corpus {name} {id}      # rebuilds it, with the same bytes on the same machine\n```\n",
        buildings = episodes.len(),
        all = definition.all_buildings(),
        types = definition.types.len(),
        rows = rows(episodes),
        agents = agents(definition),
    )
}

/// Returns what the agents are.
fn agents(definition: &Definition) -> String {
    let history = |own: &History| {
        let History { name, stages, .. } = own;
        format!(
            "`{name}-Kof{stages}` is an agent after K of {stages} equal parts of its training (`corpus.json` has the \
             options), which began anew for each type; `agents/` has them. "
        )
    };
    definition.histories.iter().map(history).collect()
}

/// Returns the rows of the table: by type, task and policy.
fn rows(episodes: &[EpisodeMetadata]) -> String {
    let mut groups: BTreeMap<[&str; 3], (usize, f64)> = BTreeMap::new();
    for episode in episodes {
        let Some(of) = &episode.corpus else { continue };
        let (count, sum) = groups.entry([&of.building_type, &of.task, &episode.policy]).or_default();
        *count += 1;
        *sum += episode.episode_return;
    }
    let row = |([building_type, task, policy], (count, sum)): ([&str; 3], (usize, f64))| {
        format!("| {building_type} | `{task}` | `{policy}` | {count} | {:.0} |\n", sum / count as f64)
    };
    groups.into_iter().map(row).collect()
}
