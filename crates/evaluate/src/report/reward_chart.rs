//! The distributions of the rewards of single steps, several policies in one chart.

use serde_json::json;

use super::chart::{Chart, color};
use super::histogram;
use super::series::Series;
use crate::evaluation::StepRewards;
use crate::summary::type_label;

/// Number of quantiles that represent a distribution.
const QUANTILES: usize = 300;
/// Share of the steps beyond the axis on either side.
const CUT: f64 = 0.002;

/// Draws a violin per policy and building type, as in the paper's figures; every episode has the same weight.
pub fn step_rewards(series: &[Series<'_>]) -> Chart {
    let mut types: Vec<&str> = Vec::new();
    for (info, _) in series.iter().flat_map(|series| &series.episodes) {
        if !types.contains(&info.building_type.as_str()) {
            types.push(&info.building_type);
        }
    }
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut data = Vec::new();
    for (number, Series { name, episodes }) in series.iter().enumerate() {
        let (mut x, mut y) = (Vec::new(), Vec::new());
        for building_type in &types {
            let own = episodes.iter().filter(|(info, _)| info.building_type == *building_type);
            let values = quantiles(&pooled(own.map(|(_, scored)| &scored.step_rewards)));
            let cut = (CUT * values.len() as f64).ceil() as usize;
            low = values.get(cut).map_or(low, |value| low.min(*value));
            high = values.iter().rev().nth(cut).map_or(high, |value| high.max(*value));
            x.extend(values.iter().map(|_| type_label(building_type)));
            y.extend(values);
        }
        data.push(json!({
            "type": "violin", "x": x, "y": y, "name": name, "points": false, "hoverinfo": "name", "spanmode": "hard",
            "line": {"color": color(number), "width": 1.2}, "box": {"visible": true, "width": 0.15},
            "scalemode": "width", "offsetgroup": name,
        }));
    }
    let ticks: Vec<i32> = (low.floor() as i32..=high.ceil() as i32).collect();
    let labels: Vec<String> = ticks.iter().map(|tick| format!("−10<sup>{tick}</sup>")).collect();
    let layout = json!({
        "violinmode": "group", "xaxis": {"type": "category"},
        "yaxis": {"title": {"text": "reward of a step"}, "range": [high + 0.1, low - 0.1], "zeroline": false,
                  "tickvals": ticks, "ticktext": labels},
    });
    Chart {
        title: "Per-step rewards".into(),
        note: "logarithmic, higher is better; rewards above −10⁻⁶ are drawn there; box: quartiles and median; every \
               episode has the same weight"
            .into(),
        height: 380,
        wide: types.len() > 2,
        data: data.into(),
        layout,
    }
}

/// Returns the sum of some histograms, each divided by its number of steps.
fn pooled<'a>(histograms: impl Iterator<Item = &'a StepRewards>) -> Vec<f64> {
    let mut shares: Vec<f64> = Vec::new();
    for StepRewards { counts } in histograms {
        shares.resize(shares.len().max(counts.len()), 0.0);
        let total = f64::from(counts.iter().sum::<u32>().max(1));
        for (share, count) in shares.iter_mut().zip(counts) {
            *share += f64::from(*count) / total;
        }
    }
    shares
}

/// Returns evenly spaced quantiles of a histogram, as decimal logarithms of penalties.
fn quantiles(shares: &[f64]) -> Vec<f64> {
    if shares.iter().sum::<f64>() == 0.0 {
        return Vec::new();
    }
    histogram::quantiles(shares, QUANTILES).map(|(bin, _)| StepRewards::log10_middle(bin)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_episode_has_the_same_weight() {
        let histogram = |counts: [u32; 3]| StepRewards { counts: counts.to_vec() };
        let (long, short) = (histogram([100, 0, 0]), histogram([0, 0, 1]));
        let values = quantiles(&pooled([&long, &short].into_iter()));
        let lowest = values.iter().filter(|value| **value == StepRewards::log10_middle(0)).count();
        assert_eq!((values.len(), lowest), (QUANTILES, QUANTILES / 2));
        assert_eq!(quantiles(&[]), Vec::<f64>::new());
    }
}
