//! How far policies get from the guideline's cost to the best known one, which `foresight` finds.

use b2b_evaluate::statistics::{mean, median};
use serde_json::{Value, json};

use super::comparison::GUIDELINE;
use super::figures::Figures;
use super::{buildings, policies};
use crate::definition::Experiment;
use crate::results::Results;

/// The controller with the best known costs.
const BEST: &str = "foresight";

/// An episode under the guideline, under the best known schedule, and under the other policies that ran it: the mean cost
/// over seeds.
struct Episode {
    period: String,
    guideline: Figures,
    best: Figures,
    others: Vec<Option<f64>>,
}

/// Returns the table of savings and the share of them that policies reach, by type and period; `None` without the
/// best known costs.
pub(super) fn table(experiment: &Experiment, results: &Results) -> Option<Value> {
    experiment.kept_controllers().find(|controller| *controller == BEST)?;
    let mut others = policies(experiment, results);
    others.retain(|policy| ![GUIDELINE, BEST].contains(&&policy[..]));
    let mut rows = Vec::new();
    let mut all = Vec::new();
    for building_type in &experiment.types {
        let episodes = episodes(experiment, results, &others, building_type.name());
        for period in &experiment.periods {
            let own: Vec<&Episode> = episodes.iter().filter(|episode| episode.period == *period).collect();
            rows.extend(cells(building_type.name(), period, &own, others.len()));
        }
        rows.extend(cells(building_type.name(), "all", &episodes.iter().collect::<Vec<_>>(), others.len()));
        all.extend(episodes);
    }
    rows.extend(cells("all", "all", &all.iter().collect::<Vec<_>>(), others.len()));
    let mut header: Vec<String> = [
        "type",
        "period",
        "episodes",
        "saving of foresight (%)",
        "lowest",
        "highest",
        "discomfort, guideline36 (K·h per zone)",
        "discomfort, foresight",
        "episodes beyond the free discomfort",
    ]
    .map(str::to_owned)
    .to_vec();
    header.extend(others.iter().map(|policy| format!("share of the saving, {policy} (%)")));
    Some(json!({
        "name": "Savings of foresight, and the share that others reach",
        "title": "medians over the episodes; shares are of the cost that foresight saves",
        "header": header,
        "rows": rows,
    }))
}

/// Returns the episodes of a type that ran under the guideline and under the best known schedule.
fn episodes(
    experiment: &Experiment,
    results: &Results,
    others: &[String],
    building_type: &str,
) -> Vec<Episode> {
    let of = |policy: &str| buildings(experiment, results, policy, building_type);
    let (bests, others): (Vec<_>, Vec<_>) = (of(BEST), others.iter().map(|other| of(other)).collect());
    let mut episodes = Vec::new();
    for (building, periods) in of(GUIDELINE) {
        for guideline in periods {
            let same = |all: &[(String, Vec<Figures>)]| -> Vec<Figures> {
                let own = all.iter().filter(|(name, _)| *name == building).flat_map(|(_, periods)| periods);
                own.filter(|figures| figures.period == guideline.period).cloned().collect()
            };
            let Some(best) = same(&bests).pop() else { continue };
            let others = others.iter().map(|other| cost(&same(other))).collect();
            episodes.push(Episode { period: guideline.period.clone(), guideline, best, others });
        }
    }
    episodes
}

/// Returns a row of medians; `None` without an episode.
fn cells(building_type: &str, period: &str, episodes: &[&Episode], others: usize) -> Option<Vec<String>> {
    let middle = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        median(&values)
    };
    let mut savings: Vec<f64> =
        episodes.iter().map(|episode| 100.0 * episode.saving(episode.best.costs[0])).collect();
    savings.sort_by(f64::total_cmp);
    let (least, most) = (savings.first()?, savings.last()?);
    let discomfort = |of: fn(&Episode) -> &Figures| {
        middle(episodes.iter().map(|episode| of(episode).discomfort).collect())
    };
    let uncomfortable = episodes.iter().filter(|episode| episode.best.uncomfortable).count();
    let mut cells = vec![building_type.to_owned(), period.to_owned(), episodes.len().to_string()];
    cells.extend([median(&savings), *least, *most].map(|percent| format!("{percent:.1}")));
    cells.push(format!("{:.2}", discomfort(|episode| &episode.guideline)));
    cells.push(format!("{:.2}", discomfort(|episode| &episode.best)));
    cells.push(if uncomfortable == 0 {
        String::new()
    } else {
        format!("{uncomfortable} of {}", episodes.len())
    });
    for other in 0..others {
        let share = |episode: &&Episode| {
            let way = episode.saving(episode.best.costs[0]);
            let gone = episode.saving(episode.others[other]?);
            (way > 0.0).then(|| 100.0 * gone / way)
        };
        let shares: Vec<f64> = episodes.iter().filter_map(share).collect();
        cells.push(if shares.is_empty() { String::new() } else { format!("{:.0}", middle(shares)) });
    }
    Some(cells)
}

/// Returns the mean cost under the first task; `None` without an episode.
fn cost(seeds: &[Figures]) -> Option<f64> {
    let costs: Vec<f64> = seeds.iter().map(|figures| figures.costs[0]).collect();
    (!costs.is_empty()).then(|| mean(&costs))
}

impl Episode {
    /// Returns the share of the guideline's cost under the first task that another cost saves.
    fn saving(&self, cost: f64) -> f64 {
        1.0 - cost / self.guideline.costs[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_policy_halfway_between_the_guideline_and_the_best_goes_half_of_the_way() {
        let at = |cost: f64| Figures { costs: vec![cost], discomfort: cost, ..Figures::default() };
        let episode = |guideline: f64, best: f64, other: Option<f64>| Episode {
            period: "mixed".into(),
            guideline: at(guideline),
            best: at(best),
            others: vec![other],
        };
        let all = [episode(2.0, 1.0, Some(1.5)), episode(1.0, 0.9, Some(1.0)), episode(1.0, 0.8, None)];
        let row = cells("type", "mixed", &all.iter().collect::<Vec<_>>(), 1).unwrap();
        assert_eq!(row[2..6], ["3", "20.0", "10.0", "50.0"]);
        assert_eq!(row[9], "25", "the median of 50 and 0 %");
        assert!(cells("type", "mixed", &[], 1).is_none());
    }
}
