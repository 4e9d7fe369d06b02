//! The paper's claims about the energy weight.

use std::collections::BTreeMap;

use b2b_env::Task;
use b2b_evaluate::statistics::{Sample, mean, median, score_text};
use b2b_evaluate::{EpisodeResult, Scored};

use super::claim::{Claim, Judged, Side};
use super::interval::measured;
use super::ppo::{AGENT, OFF_ENERGY, STEPS};
use super::select::{median_of, trained};
use crate::absolute::{deviation, energy};
use crate::results::{Ran, Results, samples};

const CAVEAT: &str =
    "the baseline energy that the weight is scaled by, and the buildings, are not the paper's";
/// The highest weight.
const HIGH: f64 = 5.0;

pub(super) fn judge(results: &Results) -> Vec<Judged> {
    let all = trained(results, AGENT, STEPS);
    let of_type = |name: &str| {
        all.iter().filter(|(_, row)| row.info.building_type == name).copied().collect::<Vec<_>>()
    };
    let (small, medium) = (of_type("OfficeSmall"), of_type("OfficeMedium"));
    vec![
        less_energy("The higher the weight, the lower the energy, in medium offices", &medium),
        less_energy("The higher the weight, the lower the energy, in small offices", &small),
        little_shift(&medium),
        degenerate(&small),
    ]
}

fn claim(text: &str, quantity: &'static str, bound: f64, margin: f64) -> Claim {
    Claim { text: text.into(), quantity, side: Side::Below, bound, margin, caveat: CAVEAT }
}

fn less_energy(text: &str, rows: &[Ran<'_>]) -> Judged {
    let claim = claim(text, "ratio of the energy at weight 5 to weight 0", 1.0, 0.05);
    let (mut fell, mut steps) = (0, 0);
    for values in series(rows, energy).values() {
        steps += values.len() - 1;
        fell += values.windows(2).filter(|pair| pair[1].1 < pair[0].1).count();
    }
    let ratio = |values: &[(f64, f64)]| {
        let (first, last) = (values.first()?, values.last()?);
        (first.0 == 0.0 && last.0 == HIGH && first.1 > 0.0).then(|| last.1 / first.1)
    };
    let ratios = changes(rows, energy, ratio);
    claim.judge(measured(&ratios, median), &format!("energy falls at {fell} of {steps} steps of the weight"))
}

fn little_shift(rows: &[Ran<'_>]) -> Judged {
    let claim = claim(
        "In medium offices the deviation from target does not shift much with the weight",
        "change of the RMS deviation from weight 0 to 5, either way (K)",
        0.5,
        0.1,
    );
    let shift = |values: &[(f64, f64)]| {
        let (first, last) = (values.first()?, values.last()?);
        (first.0 == 0.0 && last.0 == HIGH).then_some((last.1 - first.1).abs())
    };
    let shifts = changes(rows, deviation, shift);
    claim.judge(measured(&shifts, median), "")
}

fn degenerate(rows: &[Ran<'_>]) -> Judged {
    let claim = claim(
        "In small offices a high weight gives a degenerate policy, which turns HVAC off",
        "energy at weight 5 over the reactive controllers'",
        OFF_ENERGY,
        0.05,
    );
    let high: Vec<Ran<'_>> = rows.iter().filter(|(_, row)| weight(row) == Some(HIGH)).copied().collect();
    let remark = median_of(&high, deviation)
        .map(|deviation| format!("median RMS deviation {} K", score_text(deviation)));
    let relative = measured(&samples(&high, Scored::relative_energy), median);
    claim.judge(relative, &remark.unwrap_or_default())
}

/// Returns the change of a value with the weight in each building, for each kind of targets.
fn changes<'a>(
    rows: &[Ran<'a>],
    value: fn(&Scored) -> Option<f64>,
    change: impl Fn(&[(f64, f64)]) -> Option<f64>,
) -> Vec<Sample<'a>> {
    let sample = |([building, setpoints, period], values): ([&'a str; 3], Series)| {
        let case = [setpoints, period];
        Some(Sample { building_type: "", building, case, agent: building, seed: 0, score: change(&values)? })
    };
    series(rows, value).into_iter().filter_map(sample).collect()
}

/// Values with their weights, ordered by weight.
type Series = Vec<(f64, f64)>;

/// Returns the values of each building, kind of targets and run period: means over seeds.
fn series<'a>(rows: &[Ran<'a>], value: fn(&Scored) -> Option<f64>) -> BTreeMap<[&'a str; 3], Series> {
    let mut all: BTreeMap<[&str; 3], Series> = BTreeMap::new();
    for (_, row) in rows {
        let value = row.scored().and_then(value);
        if let (Some(weight), Some(value)) = (weight(row), value) {
            let setpoints = row.info.task.split('+').next().unwrap_or_default();
            let key = [&row.info.building[..], setpoints, &row.info.period];
            all.entry(key).or_default().push((weight, value));
        }
    }
    for values in all.values_mut() {
        values.sort_by(|a, b| a.0.total_cmp(&b.0));
        let of_weight = |seeds: &[(f64, f64)]| {
            (seeds[0].0, mean(&seeds.iter().map(|(_, value)| *value).collect::<Vec<_>>()))
        };
        *values = values.chunk_by(|a, b| a.0 == b.0).map(of_weight).collect();
    }
    all
}

fn weight(row: &EpisodeResult) -> Option<f64> {
    Some(row.info.task.parse::<Task>().ok()?.energy_weight)
}
