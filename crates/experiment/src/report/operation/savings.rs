//! What policies save against the guideline controller, at comfort.

use std::collections::{BTreeMap, BTreeSet};

use b2b_control::tune::travel_limit;
use b2b_evaluate::report::{Chart, Series, trade_offs};
use b2b_evaluate::statistics::{FEWEST, Interval, MARGIN, Sample, Verdict, mean, median, over_buildings};
use b2b_evaluate::{EpisodeResult, FREE_DISCOMFORT};
use serde_json::{Value, json};

use super::comparison::GUIDELINE;
use super::{Guideline, TOGETHER, policies};
use crate::definition::Experiment;
use crate::results::{Ran, Results, samples};

/// Name used instead of a type for all types.
const ALL: &str = "all";
/// Height of the chart of all episodes, pixels.
const HEIGHT: u32 = 460;

/// Returns a table over all periods and one by period.
pub(super) fn tables(experiment: &Experiment, results: &Results) -> Vec<Value> {
    let each: Vec<&str> = experiment.periods.iter().map(String::as_str).collect();
    [
        (format!("Savings against {GUIDELINE}"), vec![TOGETHER]),
        (format!("Savings against {GUIDELINE} by period"), each),
    ]
    .into_iter()
    .filter_map(|(name, periods)| table(experiment, results, &name, &periods))
    .collect()
}

/// Returns the chart of cost and discomfort of every episode.
pub(super) fn charts(experiment: &Experiment, results: &Results) -> Vec<Chart> {
    let others = others(experiment, results);
    let series = |name| {
        let episodes = results.of(name).filter_map(|(_, row)| Some((&row.info, row.scored()?)));
        Series { name, episodes: episodes.collect() }
    };
    trade_offs(&others.iter().map(|name| series(name)).collect::<Vec<_>>(), HEIGHT, true)
}

fn others(experiment: &Experiment, results: &Results) -> Vec<String> {
    let mut others = policies(experiment, results);
    others.retain(|policy| policy != GUIDELINE);
    others
}

fn table(experiment: &Experiment, results: &Results, name: &str, periods: &[&str]) -> Option<Value> {
    let types: Vec<&str> = experiment.types.iter().map(|each| each.name()).collect();
    let guideline = Guideline::of(results);
    let mut rows = Vec::new();
    for task in &experiment.tasks {
        for building_type in types.iter().copied().chain([ALL]) {
            for period in periods {
                for policy in others(experiment, results) {
                    let own = |row: &EpisodeResult, each: &str| {
                        row.info.task == *task
                            && row.info.building_type == each
                            && [&row.info.period[..], TOGETHER].contains(period)
                            && [each, ALL].contains(&building_type)
                    };
                    let of_type = |each: &&str| {
                        results.of(&policy).filter(|(_, row)| own(row, each)).collect::<Vec<_>>()
                    };
                    let episodes: Vec<Ran<'_>> = types.iter().flat_map(of_type).collect();
                    let names = [building_type, period, task, &policy].map(str::to_owned);
                    rows.extend(cells(&episodes, &guideline).map(|cells| [names.to_vec(), cells].concat()));
                }
            }
        }
    }
    (!rows.is_empty()).then(|| {
        json!({
            "name": name,
            "title": format!(
                "score at comfort: medians over buildings, each with its mean over periods and seeds, and 95 % bootstrap \
                 intervals over buildings within each type, and seeds; cost: likewise, each building with the sum over its periods, \
                 in which cheap periods count little; comfortable: at most {FREE_DISCOMFORT} K·h per \
                 zone and day of discomfort beyond the guideline's; beats: the score is more than {MARGIN} below 1, and all of its interval below 1; \
                 worse: above, likewise; fewer than {FEWEST} buildings have no verdict; hunting: episodes with more actuator travel than 5 \
                 strokes/day and than the guideline; raised: episodes in which the ventilation interlock raised an action"
            ),
            "header": ["type", "period", "task", "policy", "buildings", "score at comfort", "verdict", "cost (%)",
                       "comfortable (%)", "episodes", format!("below {:.2}", 1.0 - MARGIN),
                       format!("above {:.2}", 1.0 + MARGIN), "hunting", "raised"],
            "rows": rows,
        })
    })
}

/// Returns whether actuators travel more than the limit.
fn hunts(row: &EpisodeResult, guideline: &Guideline<'_>) -> bool {
    let travel = |row: &EpisodeResult| Some(row.metrics()?.daily_travel);
    let reference = guideline.same(row).and_then(travel).unwrap_or(0.0);
    travel(row).is_some_and(|own| own > travel_limit(reference))
}

/// Formats percentages with a sign, and without a zero's.
fn percents(Interval { value, low, high }: Interval) -> String {
    let [value, low, high] = [value, low, high].map(|each| (10.0 * each).round() / 10.0 + 0.0);
    format!("{value:+.1} [{low:+.1}, {high:+.1}]")
}

/// Returns the cost of episodes beyond the mean of their building's baselines, % of it. Its mean over a building is what
/// all episodes there cost beyond their baselines together.
fn costs<'a>(episodes: &[Ran<'a>]) -> Vec<Sample<'a>> {
    let amounts = |row: &EpisodeResult| {
        let scored = row.scored()?;
        Some((scored.resource?, scored.baseline_resource?))
    };
    let mut baselines: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for (_, row) in episodes {
        let baseline = amounts(row).map(|(_, baseline)| baseline);
        baselines.entry(&row.info.building).or_default().extend(baseline);
    }
    let relative = |&(job, row): &Ran<'a>| {
        let (own, _) = amounts(row)?;
        let baseline = mean(&baselines[&row.info.building[..]]);
        (baseline > 0.0).then(|| job.sample(row, 100.0 * (own / baseline - 1.0)))
    };
    episodes.iter().filter_map(relative).collect()
}

/// Returns the figures of a row; `None` without a score.
fn cells(episodes: &[Ran<'_>], guideline: &Guideline<'_>) -> Option<Vec<String>> {
    let all = || episodes.iter().map(|(_, row)| *row).filter(|row| row.score().is_some());
    let scores: Vec<f64> = all().filter_map(EpisodeResult::score).collect();
    let score = over_buildings(&samples(episodes, |scored| scored.score), median)?;
    let buildings: BTreeSet<&str> = all().map(|row| &row.info.building[..]).collect();
    let count = |is_own: &dyn Fn(f64) -> bool| scores.iter().filter(|score| is_own(**score)).count();
    let uncomfortable = all().filter(|row| {
        row.scored().and_then(|own| own.is_uncomfortable(row.info.steps_per_hour)) == Some(true)
    });
    let hunting = all().filter(|row| hunts(row, guideline)).count();
    let raised =
        |row: &&EpisodeResult| row.metrics().is_some_and(|metrics| metrics.ventilation_overrides > 0);
    let comfortable = 1.0 - uncomfortable.count() as f64 / scores.len() as f64;
    Some(vec![
        buildings.len().to_string(),
        score.to_string(),
        if buildings.len() < FEWEST { "–".to_owned() } else { Verdict::of(score).to_string() },
        over_buildings(&costs(episodes), median).map_or_else(String::new, percents),
        format!("{:.0}", 100.0 * comfortable),
        scores.len().to_string(),
        count(&|score| score < 1.0 - MARGIN).to_string(),
        count(&|score| score > 1.0 + MARGIN).to_string(),
        hunting.to_string(),
        all().filter(raised).count().to_string(),
    ])
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::folder::Folder;

    #[test]
    fn the_shipped_results_of_operation_show_what_controllers_cost_beyond_the_guideline() {
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../results/operation"));
        let (folder, experiment, budget) = Folder::open(path).unwrap();
        let results = Results::read(&folder, &experiment, &budget).unwrap();
        let [together, by_period] = &tables(&experiment, &results)[..] else { panic!("two tables") };
        let rows = |table: &Value| table["rows"].as_array().unwrap().clone();
        assert_eq!((rows(together).len(), rows(by_period).len()), (7 * 2, 7 * 5 * 2));
        let last = &rows(together)[13];
        assert_eq!(
            (&last[0], &last[3], &last[4], &last[9]),
            (&json!("all"), &json!("reactive"), &json!("48"), &json!("240"))
        );
        // The reactive controllers hold the middle of the band day and night.
        assert_eq!((&last[8], &last[10], &last[11]), (&json!("100"), &json!("0"), &json!("240")));
        // Σ cost / Σ cost of the baseline of every building, by another way.
        let (_, episodes): (Vec<_>, Vec<_>) = results.of("reactive").unzip();
        let mut ratios: Vec<f64> = Vec::new();
        for building in episodes.iter().map(|row| &row.info.building).collect::<BTreeSet<_>>() {
            let own = episodes.iter().filter(|row| row.info.building == *building).copied();
            ratios.push(b2b_evaluate::relative_resource(own).unwrap());
        }
        ratios.sort_by(f64::total_cmp);
        let expected = format!("{:+.1} [", 100.0 * (median(&ratios) - 1.0));
        assert!(last[7].as_str().unwrap().starts_with(&expected), "{} {expected}", last[7]);
        assert_eq!(charts(&experiment, &results)[0].data.as_array().unwrap().len(), 3, "and the baseline");
    }
}
