//! The chart of deviations from target over all steps.

use serde_json::{Value, json};

use super::chart::{Chart, color, horizontal_line};
use super::histogram;
use crate::evaluation::Deviations;
use crate::statistics::quantile;

/// Number of quantiles that represent a distribution.
const QUANTILES: usize = 400;

/// The distribution of deviations in some episodes, each with the same weight.
#[derive(Clone, Debug)]
pub struct StepDeviations {
    /// Its category on the axis.
    pub category: String,
    /// Its series.
    pub series: String,
    /// Number of the series, for its color.
    pub number: usize,
    /// Share of each bin of [`Deviations`].
    shares: Vec<f64>,
}

impl StepDeviations {
    /// Returns an empty distribution.
    pub fn empty(category: String, series: String, number: usize) -> Self {
        Self { category, series, number, shares: vec![0.0; Deviations::empty().counts.len()] }
    }

    /// Adds an episode.
    pub fn add(&mut self, episode: &Deviations) {
        let total = episode.counts.iter().sum::<u64>() as f64;
        if total > 0.0 {
            self.shares
                .iter_mut()
                .zip(&episode.counts)
                .for_each(|(share, count)| *share += *count as f64 / total);
        }
    }

    /// Returns whether there are no deviations.
    pub fn is_empty(&self) -> bool {
        self.shares.iter().all(|share| *share == 0.0)
    }

    /// Returns the share of the steps in the outermost bins, which hold everything beyond the histogram.
    fn beyond(&self) -> f64 {
        let ends = self.shares.first().into_iter().chain(self.shares.last());
        ends.sum::<f64>() / self.shares.iter().sum::<f64>()
    }

    /// Returns evenly spaced quantiles, linear within the bins, K.
    fn quantiles(&self) -> Vec<f64> {
        let value =
            |(bin, within): (usize, f64)| Deviations::middle(bin) + (within - 0.5) * Deviations::WIDTH;
        histogram::quantiles(&self.shares, QUANTILES).map(value).collect()
    }
}

/// Draws violins over evenly spaced quantiles of all steps, side by side where a category has several series.
pub fn step_deviations(title: String, all: &[StepDeviations]) -> Chart {
    let mut extent: f64 = 0.5;
    let mut data = Vec::new();
    let beyond = all.iter().map(StepDeviations::beyond).fold(0.0, f64::max);
    let several = all.windows(2).any(|pair| pair[0].category == pair[1].category);
    for (index, each) in all.iter().enumerate() {
        let values = each.quantiles();
        // 99 % of the steps are within the range of the axis.
        extent = extent.max(-quantile(&values, 0.005)).max(quantile(&values, 0.995));
        let first = all[..index].iter().all(|before| before.series != each.series);
        let mut violin = json!({
            "type": "violin", "y": values, "x0": each.category, "name": each.series, "points": false, "hoverinfo": "y+name",
            "legendgroup": each.series, "offsetgroup": each.series, "showlegend": first,
            "line": {"color": color(each.number), "width": 1.2}, "spanmode": "hard",
            "meanline": {"visible": true}, "box": {"visible": true, "width": 0.12},
        });
        if !several {
            violin["width"] = 0.85.into();
        }
        data.push(violin);
    }
    let range = [-1.1 * extent, 1.1 * extent];
    let mut layout = json!({
        "yaxis": {"title": {"text": "deviation (K)"}, "range": range, "zeroline": false},
        "xaxis": {"type": "category"}, "shapes": [horizontal_line(0.0)], "showlegend": several,
    });
    if several {
        layout["violinmode"] = "group".into();
    }
    Chart {
        title,
        note: format!(
            "zone temperature minus target, or beyond the band in operation; zones with heating and cooling, every \
             building weighted equally; 99 % of the steps are within the axis{}",
            if beyond > 0.0 {
                format!(
                    "; beyond ±10 K, counted as 10 K: up to {:.1} % of the steps of one violin",
                    100.0 * beyond
                )
            } else {
                String::new()
            }
        ),
        height: 340,
        wide: false,
        data: Value::from(data),
        layout,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(values: impl Iterator<Item = f64>) -> StepDeviations {
        let (mut all, mut episode) =
            (StepDeviations::empty("0.5".into(), "paper".into(), 0), Deviations::empty());
        values.for_each(|value| episode.add(value));
        all.add(&episode);
        all
    }

    #[test]
    fn deviations_beyond_the_histogram_are_counted() {
        assert_eq!(of([-30.0, 0.0, 1.0, 12.0].into_iter()).beyond(), 0.5);
    }

    #[test]
    fn every_episode_has_the_same_weight() {
        let mut all = of([0.0].into_iter());
        let mut long = Deviations::empty();
        (0..99).for_each(|_| long.add(1.0));
        all.add(&long);
        let values = all.quantiles();
        assert_eq!(values.iter().filter(|value| **value < 0.5).count(), QUANTILES / 2);
    }

    #[test]
    fn quantiles_of_a_histogram_match_its_values() {
        let values = of((0..1000).map(|step| -1.0 + f64::from(step) / 500.0)).quantiles();
        assert_eq!(values.len(), QUANTILES);
        assert!(values.is_sorted());
        for (share, expected) in [(0.0, -1.0), (0.25, -0.5), (0.5, 0.0), (1.0, 1.0)] {
            assert!((quantile(&values, share) - expected).abs() < 0.02, "{share}");
        }
    }
}
