//! The page that compares several policies on the same episodes.

use std::io::Write;

use serde_json::{Value, json};

use super::chart::{Chart, hover_name};
use super::reward_chart::step_rewards;
use super::series::{Series, rms_deviations};
use super::trade_off::trade_offs;
use crate::evaluation::{
    EpisodeInfo, EpisodeResult, Scored, relative_energy, relative_resource, resource_heading,
};
use crate::scores::{DISCOMFORT_COST, FREE_DISCOMFORT, RESOLUTION};
use crate::statistics::{ratio_text, score_text};
use crate::summary::OperationComfort;
use crate::{Error, Result};

/// The episodes of a policy.
#[derive(Debug)]
pub struct Compared {
    /// Name of the policy on the page.
    pub name: String,
    /// Its episodes.
    pub rows: Vec<EpisodeResult>,
}

impl Compared {
    fn ran(&self) -> Vec<(&EpisodeInfo, &Scored)> {
        self.rows.iter().filter_map(|row| Some((&row.info, row.scored()?))).collect()
    }

    fn mean(&self, value: impl Fn(&Scored) -> f64) -> f64 {
        let ran = self.ran();
        // A sum of negative zeros would begin at -0.
        ran.iter().fold(0.0, |sum, (_, scored)| sum + value(scored)) / ran.len().max(1) as f64
    }

    /// Returns the mean of a score, unless it is unknown in an episode.
    fn score(&self, value: impl Fn(&Scored) -> Option<f64>) -> String {
        let ran = self.ran();
        let scores: Vec<f64> = ran.iter().filter_map(|(_, scored)| value(scored)).collect();
        match scores.len() == ran.len() && !ran.is_empty() {
            true => score_text(scores.iter().sum::<f64>() / scores.len() as f64),
            false => "–".to_owned(),
        }
    }
}

/// Writes the page.
///
/// # Errors
/// [`Error::OtherEpisodes`] unless all policies ran the same episodes, none of them lost; [`Error::Io`].
pub fn write(file: &mut impl Write, all: &[Compared]) -> Result<()> {
    check_same(all)?;
    let episodes = all.first().map_or(0, |compared| compared.rows.len());
    let series: Vec<_> =
        all.iter().map(|compared| Series { name: &compared.name, episodes: compared.ran() }).collect();
    let charts = [step_rewards(&series), rms_deviations(&series)].into_iter();
    let charts = charts.chain(trade_offs(&series, 340, false));
    let data = json!({
        "title": format!("{} policies on {episodes} episodes", all.len()),
        "tiles": [],
        "tables": [table(all)],
        "lost": [],
        "drawings": charts.map(Chart::json).collect::<Vec<_>>(),
        "footer": footer(all),
    });
    b2b_page::write_page(file, &data).map_err(|source| Error::Io { path: "comparison".into(), source })
}

fn check_same(all: &[Compared]) -> Result<()> {
    let Some(first) = all.first() else { return Ok(()) };
    for compared in all {
        if let Some(row) = compared.rows.iter().find(|row| row.outcome.is_err()) {
            let why = format!("{} was lost", hover_name(&row.info).replace("<br>", ", "));
            return Err(Error::OtherEpisodes { name: compared.name.clone(), why });
        }
        let key = |row: &EpisodeResult| {
            let EpisodeInfo { building, place, task_hash, period, steps_per_hour, seed, .. } = &row.info;
            (building.clone(), place.clone(), task_hash.clone(), period.clone(), *steps_per_hour, *seed)
        };
        let differs = |(ours, theirs): (&EpisodeResult, &EpisodeResult)| {
            (key(ours) != key(theirs)).then(|| theirs.info.clone())
        };
        let why = match first.rows.iter().zip(&compared.rows).find_map(differs) {
            Some(info) => {
                format!("{} is not an episode of {}", hover_name(&info).replace("<br>", ", "), first.name)
            }
            None if first.rows.len() != compared.rows.len() => {
                format!("it has {} episodes, {} has {}", compared.rows.len(), first.name, first.rows.len())
            }
            None => continue,
        };
        return Err(Error::OtherEpisodes { name: compared.name.clone(), why });
    }
    Ok(())
}

/// Returns whether all episodes are of operation tasks.
fn is_operation(all: &[Compared]) -> bool {
    let mut ran = all.iter().flat_map(|compared| compared.ran()).peekable();
    ran.peek().is_some() && ran.all(|(_, scored)| scored.metrics.tdis_tot.is_some())
}

fn footer(all: &[Compared]) -> String {
    match is_operation(all) {
        true => format!(
            "Means over episodes. Score at comfort: cost, or the task's other resource, divided by the guideline \
             controller's (the baseline), plus {DISCOMFORT_COST} days of that for every K·h per zone of discomfort beyond its own and {FREE_DISCOMFORT} K·h per day; \
             lower is better."
        ),
        false => format!(
            "Means over episodes. Score: the return divided by the baseline's return for the same building, task and days; \
             lower is better. Resolved score: the same after adding {RESOLUTION} K of RMS deviation to both. The baseline is the \
             reactive controllers; in tasks of operation it is the guideline controller, and both are the score at comfort."
        ),
    }
}

fn table(all: &[Compared]) -> Value {
    let (header, rows): (Vec<String>, Vec<_>) = match is_operation(all) {
        true => (operation_columns(all).into(), all.iter().map(operation_row).collect()),
        false => (COLUMNS.map(str::to_owned).into(), all.iter().map(tracking_row).collect()),
    };
    json!({"title": "means over episodes", "header": header, "rows": rows})
}

const COLUMNS: [&str; 8] = [
    "policy",
    "return",
    "resolved score",
    "score",
    "RMS deviation (K)",
    "energy / baseline",
    "HVAC energy (kWh/m²)",
    "actuator travel (strokes/day)",
];

/// Returns the columns of operation: score at comfort first.
fn operation_columns(all: &[Compared]) -> [String; 10] {
    let tasks = all.iter().flat_map(|compared| &compared.rows).map(|row| &row.info.task[..]);
    [
        "policy",
        "score at comfort",
        "cost (per m²)",
        &resource_heading(tasks),
        "discomfort (K·h per zone)",
        "baseline's discomfort",
        "episodes beyond the free discomfort",
        "peak demand (W/m²)",
        "HVAC energy (kWh/m²)",
        "actuator travel (strokes/day)",
    ]
    .map(str::to_owned)
}

fn tracking_row(compared: &Compared) -> Vec<String> {
    vec![
        compared.name.clone(),
        format!("{:.1}", compared.mean(|scored| scored.metrics.episode_return)),
        compared.score(|scored| scored.resolved_score),
        compared.score(|scored| scored.score),
        format!("{:.2}", compared.mean(|scored| scored.metrics.rms_deviation)),
        ratio_text(relative_energy(&compared.rows)),
        format!("{:.2}", compared.mean(|scored| scored.metrics.energy() / 1000.0)),
        format!("{:.1}", compared.mean(|scored| scored.metrics.daily_travel)),
    ]
}

fn operation_row(compared: &Compared) -> Vec<String> {
    let comfort = OperationComfort::of(compared.rows.iter());
    let number = |value: fn(&OperationComfort) -> f64, decimals: usize| {
        comfort.as_ref().map_or("–".to_owned(), |comfort| format!("{:.decimals$}", value(comfort)))
    };
    vec![
        compared.name.clone(),
        compared.score(|scored| scored.score),
        number(|comfort| comfort.cost_tot, 3),
        ratio_text(relative_resource(&compared.rows)),
        number(|comfort| comfort.discomfort_k_h, 2),
        ratio_text(comfort.as_ref().and_then(|comfort| comfort.baseline_discomfort_k_h)),
        comfort.as_ref().map_or_else(String::new, OperationComfort::mark),
        number(|comfort| 1000.0 * comfort.pele_tot, 1),
        format!("{:.2}", compared.mean(|scored| scored.metrics.energy() / 1000.0)),
        format!("{:.1}", compared.mean(|scored| scored.metrics.daily_travel)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BuiltIn, EpisodePlan, Subject};

    fn compared(name: &str, numbers: &[u32]) -> Compared {
        let row = |number: &u32| {
            let episode = EpisodePlan {
                subject: Subject::at_home(format!("OfficeSmall-{number}").parse().unwrap()),
                task: "constant".parse().unwrap(),
                period: "01-01..01-02".parse().unwrap(),
                seed: 0,
                steps_per_hour: 12,
            };
            EpisodeResult {
                info: EpisodeInfo::of(&episode, &BuiltIn::random()),
                outcome: Ok(Scored::default()),
            }
        };
        Compared { name: name.into(), rows: numbers.iter().map(row).collect() }
    }

    #[test]
    fn policies_are_compared_on_the_same_episodes_alone() {
        let mut page = Vec::new();
        write(&mut page, &[compared("a", &[1, 2]), compared("b", &[1, 2])]).unwrap();
        assert!(String::from_utf8(page).unwrap().contains("2 policies on 2 episodes"));
        for (other, word) in [(&[1, 3][..], "OfficeSmall-0003"), (&[1][..], "1 episodes")] {
            let pair = [compared("a", &[1, 2]), compared("b", other)];
            let said = write(&mut Vec::new(), &pair).unwrap_err().to_string();
            assert!(said.contains("`b`") && said.contains(word), "{said}");
        }
    }
    #[test]
    fn policies_of_operation_are_compared_by_cost_at_comfort() {
        let mut own = compared("own", &[1]);
        own.rows[0].info.task = "operate+carbon1".into();
        let scored = own.rows[0].outcome.as_mut().unwrap();
        scored.score = Some(1.25);
        (scored.resource, scored.baseline_resource) = (Some(3.0), Some(4.0));
        (scored.metrics.cost_tot, scored.metrics.tdis_tot) = (Some(3.0), Some(2.5));
        let table = table(&[own]);
        assert_eq!(table["rows"][0].as_array().unwrap()[..5], ["own", "1.250", "3.000", "0.75", "2.50"]);
        assert_eq!(
            table["header"].as_array().unwrap()[1..4],
            ["score at comfort", "cost (per m²)", "carbon / baseline"]
        );
    }
}
