//! The page that compares several policies on the same episodes.

use std::io::Write;

use serde_json::{Value, json};

use super::chart::{Chart, hover_name};
use super::reward_chart::step_rewards;
use super::series::{Series, rms_deviations};
use super::trade_off::energy_and_comfort;
use crate::evaluation::{EpisodeInfo, Row, Scored, relative_energy};
use crate::statistics::score_text;
use crate::{Error, Result};

/// The episodes of a policy.
#[derive(Debug)]
pub struct Compared {
    /// Name of the policy on the page.
    pub name: String,
    /// Its episodes.
    pub rows: Vec<Row>,
}

impl Compared {
    fn ran(&self) -> Vec<(&EpisodeInfo, &Scored)> {
        self.rows.iter().filter_map(|row| Some((&row.info, row.outcome.as_ref().ok()?))).collect()
    }
}

/// Writes the page.
///
/// # Errors
/// [`Error::OtherEpisodes`] unless all policies ran the same episodes, none of them lost.
pub fn write(file: &mut impl Write, all: &[Compared]) -> Result<()> {
    check_same(all)?;
    let episodes = all.first().map_or(0, |compared| compared.rows.len());
    let series: Vec<_> =
        all.iter().map(|compared| Series { name: &compared.name, episodes: compared.ran() }).collect();
    let charts = [step_rewards(&series), rms_deviations(&series), energy_and_comfort(&series, 340, false)];
    let data = json!({
        "title": format!("{} policies on {episodes} episodes", all.len()),
        "tiles": [],
        "tables": [table(all)],
        "lost": [],
        "drawings": charts.map(Chart::json),
        "footer": "Means over episodes. Score: the return divided by the reactive controllers' return for the same building, \
                   task and days; lower is better. Resolved score: the same after adding 0.2 K of RMS deviation to both.",
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
        let key = |row: &Row| {
            let EpisodeInfo { building, place, task_hash, period, steps_per_hour, seed, .. } = &row.info;
            (building.clone(), place.clone(), task_hash.clone(), period.clone(), *steps_per_hour, *seed)
        };
        let differs = |(ours, theirs): (&Row, &Row)| (key(ours) != key(theirs)).then(|| theirs.info.clone());
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

fn table(all: &[Compared]) -> Value {
    let row = |compared: &Compared| {
        let ran = compared.ran();
        let mean = |value: &dyn Fn(&Scored) -> f64| {
            ran.iter().map(|(_, scored)| value(scored)).sum::<f64>() / ran.len().max(1) as f64
        };
        let score = |value: fn(&Scored) -> Option<f64>| {
            let scores: Vec<f64> = ran.iter().filter_map(|(_, scored)| value(scored)).collect();
            match scores.len() == ran.len() && !ran.is_empty() {
                true => score_text(scores.iter().sum::<f64>() / scores.len() as f64),
                false => "–".to_owned(),
            }
        };
        let energy = relative_energy(&compared.rows);
        json!([
            compared.name,
            format!("{:.1}", mean(&|scored| scored.metrics.episode_return)),
            score(|scored| scored.resolved_score),
            score(|scored| scored.score),
            format!("{:.2}", mean(&|scored| scored.metrics.rms_deviation)),
            energy.map_or("–".to_owned(), |ratio| format!("{ratio:.2}")),
            format!("{:.2}", mean(&|scored| scored.metrics.energy() / 1000.0)),
            format!("{:.1}", mean(&|scored| scored.metrics.daily_travel)),
        ])
    };
    json!({
        "title": "means over episodes",
        "header": ["policy", "return", "resolved score", "score", "RMS deviation (K)", "energy / baseline",
                   "HVAC energy (kWh/m²)", "actuator travel (strokes/day)"],
        "rows": all.iter().map(row).collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BuiltIn, Episode, Subject};

    fn compared(name: &str, numbers: &[u32]) -> Compared {
        let row = |number: &u32| {
            let episode = Episode {
                subject: Subject::at_home(format!("OfficeSmall-{number}").parse().unwrap()),
                task: "constant".parse().unwrap(),
                period: "01-01..01-02".parse().unwrap(),
                seed: 0,
                steps_per_hour: 12,
            };
            Row { info: EpisodeInfo::of(&episode, &BuiltIn::random()), outcome: Ok(Scored::default()) }
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
}
