//! Figures with units, shown next to scores: RMS deviation and energy, of agents and of the reactive controllers.

use b2b_evaluate::statistics::median;
use b2b_evaluate::{EpisodeResult, Scored};

/// A figure of an episode, if it has one.
pub(crate) type Figure = fn(&Scored) -> Option<f64>;

/// Returns the RMS deviation from target, K.
pub(crate) fn deviation(scored: &Scored) -> Option<f64> {
    Some(scored.metrics.rms_deviation)
}

/// Returns the HVAC energy of the run period, kWh/m².
pub(crate) fn energy(scored: &Scored) -> Option<f64> {
    Some(scored.metrics.energy() / 1000.0)
}

/// Returns the RMS deviation of the reactive controllers in the same episode, K, computed from their return without the
/// energy penalty.
pub(crate) fn reactive_deviation(scored: &Scored) -> Option<f64> {
    let comfort = -scored.baseline_return? * comfort_share(scored)?;
    Some((comfort.max(0.0) / scored.metrics.steps.max(1) as f64).sqrt())
}

/// Returns the HVAC energy of the reactive controllers in the same episode, kWh/m².
pub(crate) fn reactive_energy(scored: &Scored) -> Option<f64> {
    Some(scored.baseline_energy? / 1000.0)
}

/// Returns the share of comfort in the reactive controllers' penalty. Where it is 0, an agent can only gain by saving
/// energy.
pub(crate) fn comfort_share(scored: &Scored) -> Option<f64> {
    Some(1.0 + scored.energy_penalty_of_baseline()? / scored.baseline_return?)
}

/// Returns the median of a figure as a cell.
pub(crate) fn median_text(rows: &[&EpisodeResult], figure: Figure) -> String {
    let values = values(rows, figure);
    if values.is_empty() { "–".to_owned() } else { figure_text(median(&values)) }
}

/// Returns the median of a figure as a cell, with the range if there are several.
pub(crate) fn range_text(rows: &[&EpisodeResult], figure: Figure) -> String {
    let median = median_text(rows, figure);
    match values(rows, figure)[..] {
        [low, .., high] => format!("{median} ({} to {})", figure_text(low), figure_text(high)),
        _ => median,
    }
}

/// Returns the values of a figure in ascending order.
fn values(rows: &[&EpisodeResult], figure: Figure) -> Vec<f64> {
    let mut values: Vec<f64> = rows.iter().filter_map(|row| figure(row.scored()?)).collect();
    values.sort_by(f64::total_cmp);
    values
}

/// Returns a figure with two decimals, and three below 0.1.
pub(crate) fn figure_text(figure: f64) -> String {
    if figure < 0.0995 { format!("{figure:.3}") } else { format!("{figure:.2}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use b2b_env::{EpisodeMetrics, Term};

    #[test]
    fn the_reactive_deviation_is_their_return_without_the_penalty_on_energy() {
        // A penalty of 2 per Wh/m²; theirs is 200 of 600, and 400 K² over 100 steps are 2 K.
        let mut metrics = EpisodeMetrics { steps: 100, energy_penalty: 100.0, ..EpisodeMetrics::default() };
        metrics.terms.set(Term::Electricity, 50.0);
        metrics.terms.set(Term::Gas, 0.0);
        let scored = Scored {
            metrics,
            baseline_return: Some(-600.0),
            baseline_energy: Some(100.0),
            ..Scored::default()
        };
        assert!((reactive_deviation(&scored).unwrap() - 2.0).abs() < 1e-12);
        assert_eq!((energy(&scored), reactive_energy(&scored)), (Some(0.05), Some(0.1)));
        assert_eq!(reactive_deviation(&Scored::default()), None);
    }
}
