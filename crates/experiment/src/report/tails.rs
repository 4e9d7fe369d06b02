//! What an agent's worst buildings have in common.

use std::collections::BTreeMap;

use b2b_building::BuildingType;
use b2b_dataset::manifest::{Kind, Manifest};
use b2b_dataset::{BuildingId, manifest, row};
use b2b_evaluate::statistics::{mean, score_text};
use serde_json::{Value, json};

use crate::definition::Experiment;
use crate::results::Results;

/// Minimum number of buildings of a type for their worst tenth to show something in common.
const MIN_BUILDINGS: usize = 20;
/// Minimum difference of a property that stands out, in standard deviations.
const STANDS_OUT: f64 = 2.0;
/// Maximum number of properties named.
const NAMED: usize = 3;

/// A property in which the worst buildings differ from the rest.
#[derive(Debug, PartialEq)]
struct Difference {
    text: String,
    /// Difference of the means in standard deviations of the mean of as many buildings drawn at random.
    z: f64,
}

/// Returns a table of the worst tenth of the test buildings of each agent and type; `None` with few buildings.
pub(super) fn table(experiment: &Experiment, results: &Results) -> Option<Value> {
    let mut rows = Vec::new();
    for policy in experiment.policies(&results.budget) {
        for building_type in &experiment.types {
            rows.extend(cells(results, &policy.name, *building_type));
        }
    }
    (!rows.is_empty()).then(|| {
        json!({
            "name": "Worst tenth",
            "title": "the tenth of the buildings with the highest scores, and the parameters whose means differ by at least two \
                      standard deviations; of twenty parameters, one does so by chance",
            "header": ["agent", "type", "buildings", "mean score", "of the worst tenth", "in common (all buildings)"],
            "rows": rows,
        })
    })
}

fn cells(results: &Results, agent: &str, building_type: BuildingType) -> Option<Vec<String>> {
    let mut scores: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for (_, row) in results.of(agent).filter(|(_, row)| row.info.building_type == building_type.name()) {
        if let Some(score) = row.score() {
            scores.entry(&row.info.building).or_default().push(score);
        }
    }
    let scored = scores.into_iter().filter_map(|(name, scores)| Some((mean(&scores), name.parse().ok()?)));
    let mut scored: Vec<(f64, BuildingId)> = scored.collect();
    if scored.len() < MIN_BUILDINGS {
        return None;
    }
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    let worst = scored.len().div_ceil(10);
    let buildings = manifest(scored.iter().map(|(_, id)| row(*id)));
    let all: Vec<f64> = scored.iter().map(|(score, _)| *score).collect();
    let common: Vec<String> = differences(&buildings, worst).into_iter().map(|found| found.text).collect();
    Some(vec![
        agent.to_owned(),
        building_type.to_string(),
        all.len().to_string(),
        score_text(mean(&all)),
        score_text(mean(&all[..worst])),
        if common.is_empty() { "nothing stands out".into() } else { common.join("; ") },
    ])
}

/// Returns the properties in which the first `worst` buildings of a manifest differ most from all.
fn differences(buildings: &Manifest, worst: usize) -> Vec<Difference> {
    let mut found = Vec::new();
    for (index, column) in buildings.columns.iter().enumerate() {
        let cells: Vec<&str> = buildings.rows.iter().map(|row| row[index].as_str()).collect();
        match column.kind {
            // How the dataset is split is not a property of a building.
            _ if ["id", "split", "test_small"].contains(&column.name) => {}
            Kind::Number | Kind::Integer => {
                let numbers: Option<Vec<f64>> = cells.iter().map(|cell| cell.parse().ok()).collect();
                let Some(numbers) = numbers else { continue };
                let Some(z) = z(&numbers, worst) else { continue };
                let (of_worst, of_all) = (mean(&numbers[..worst]), mean(&numbers));
                let unit = if column.unit == "1" { String::new() } else { format!(" {}", column.unit) };
                let text = format!("{} {of_worst:.3}{unit} ({of_all:.3})", column.name);
                found.push(Difference { text, z });
            }
            Kind::Text | Kind::Flag => {
                let mut values = cells.clone();
                values.sort_unstable();
                values.dedup();
                for value in values {
                    let is_value: Vec<f64> = cells.iter().map(|cell| f64::from(*cell == value)).collect();
                    let Some(z) = z(&is_value, worst).filter(|z| *z > 0.0) else { continue };
                    let [of_worst, of_all] =
                        [&is_value[..worst], &is_value].map(|shares| 100.0 * mean(shares));
                    let text = format!("{} {value} {of_worst:.0} % ({of_all:.0} %)", column.name);
                    found.push(Difference { text, z });
                }
            }
        }
    }
    found.retain(|difference| difference.z.abs() >= STANDS_OUT);
    found.sort_by(|a, b| b.z.abs().total_cmp(&a.z.abs()));
    found.truncate(NAMED);
    found
}

/// Returns the mean of the first values minus the mean of all values, in standard deviations of the mean of equally
/// many values drawn without replacement; `None` if all values are equal.
fn z(values: &[f64], first: usize) -> Option<f64> {
    let (mean_of_all, count) = (mean(values), values.len() as f64);
    let variance = values.iter().map(|value| (value - mean_of_all).powi(2)).sum::<f64>() / count;
    let drawn = first as f64;
    let of_mean = variance / drawn * (count - drawn) / (count - 1.0);
    (of_mean > 1e-12).then(|| (mean(&values[..first]) - mean_of_all) / of_mean.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_sets_the_worst_buildings_apart_is_named_first() {
        let mut rows: Vec<_> = b2b_dataset::rows(BuildingType::OfficeSmall)[..200].iter().collect();
        let infiltration = |row: &&b2b_dataset::Row| match &row.building {
            b2b_dataset::Building::Commercial { parameters, .. } => parameters.infiltration,
            b2b_dataset::Building::House(_) => unreachable!(),
        };
        rows.sort_by(|a, b| infiltration(b).total_cmp(&infiltration(a)));
        let found = differences(&manifest(rows), 20);
        assert!(found[0].text.starts_with("infiltration"), "{found:?}");
        assert!(found[0].z > 5.0 && found.len() <= NAMED, "{found:?}");
    }

    #[test]
    fn a_difference_is_in_standard_deviations_of_a_draw() {
        // Two of four drawn without replacement: the variance of their mean is 1.25 / 2 · 2 / 3.
        let expected = 1.0 / (1.25_f64 / 3.0).sqrt();
        assert!((z(&[4.0, 3.0, 1.0, 2.0], 2).unwrap() - expected).abs() < 1e-12);
        assert_eq!(z(&[1.0; 4], 2), None);
    }
}
