//! The episodes of several policies, and the deviations in them.

use serde_json::json;

use super::chart::{Chart, color, distribution, hover_name, make_logarithmic, mean_diamond, range};
use crate::evaluation::{EpisodeInfo, Scored};

/// A policy with its episodes.
#[derive(Clone, Debug)]
pub struct Series<'a> {
    /// Name of the policy.
    pub name: &'a str,
    /// Its episodes.
    pub episodes: Vec<(&'a EpisodeInfo, &'a Scored)>,
}

/// Returns the hover labels of episodes.
pub fn labels(rows: &[(&EpisodeInfo, &Scored)]) -> Vec<String> {
    let label = |(info, scored): &(&EpisodeInfo, &Scored)| {
        let (score, rms) = (scored.score.unwrap_or(f64::NAN), scored.metrics.rms_deviation);
        let resolved = scored.resolved_score.unwrap_or(f64::NAN);
        format!("{}<br>score {score:.3}, resolved {resolved:.3}, RMS deviation {rms:.2} K", hover_name(info))
    };
    rows.iter().map(label).collect()
}

/// The smallest RMS deviation that is drawn, K: smaller ones are rounding errors, and would stretch the axis.
const LEAST_RMS: f64 = 1e-3;

/// Draws violins of RMS deviations with their means, as in the paper's figure.
pub fn rms_deviations(series: &[Series<'_>]) -> Chart {
    let rms = |(_, scored): &(&EpisodeInfo, &Scored)| scored.metrics.rms_deviation.max(LEAST_RMS);
    let mut data = Vec::new();
    for (number, Series { name, episodes }) in series.iter().enumerate() {
        let values: Vec<f64> = episodes.iter().map(rms).collect();
        data.push(distribution(name, &values, &labels(episodes), color(number)));
        data.push(mean_diamond(name, &values, color(number)));
    }
    let mut layout = json!({
        "xaxis": {"type": "category"},
        "yaxis": {"title": {"text": "RMS deviation (K)"}, "rangemode": "tozero", "zeroline": false},
    });
    let all = series.iter().flat_map(|series| &series.episodes).map(rms);
    make_logarithmic(&mut layout["yaxis"], range(&all.collect::<Vec<_>>()));
    Chart {
        title: "RMS deviation".into(),
        note: "from target, or beyond the band in operation; one point per episode, at 0.001 K or more; diamond: mean".into(),
        height: 340,
        wide: false,
        data: data.into(),
        layout,
    }
}
