//! The figures of an episode.

use b2b_env::{EpisodeMetrics, Term};
use b2b_evaluate::{EpisodeResult, Scored};

use crate::definition::Experiment;
use crate::folder::JobResult;
use crate::results::Results;

/// Names of [`Figures::values`] with their units.
pub(super) const HEADER: [&str; 7] = [
    "energy (kWh/m²)",
    "heating (kWh/m²)",
    "cooling (kWh/m²)",
    "fans (kWh/m²)",
    "other (kWh/m²)",
    "discomfort (K·h per zone)",
    "peak (W/m²)",
];

/// The figures of one or several episodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Figures {
    /// Period.
    pub(super) period: String,
    /// Days.
    pub(super) days: f64,
    /// Cost under each task of the experiment, currency/m²; NaN where the episode was lost.
    pub(super) costs: Vec<f64>,
    /// HVAC energy by end use: heating, cooling, fans and the others, kWh/m².
    pub(super) end_uses: [f64; 4],
    /// Discomfort, K·h per zone.
    pub(super) discomfort: f64,
    /// Peak electric demand, W/m².
    pub(super) peak: f64,
    /// Whether discomfort exceeds the baseline's by more than the free allowance.
    pub(super) uncomfortable: bool,
}

impl Figures {
    /// Returns the figures of a policy's episodes: one for all tasks of a job, building and period, in the order in which
    /// they ran. Energy and comfort come from the first task.
    pub(super) fn of_episodes(
        experiment: &Experiment,
        results: &Results,
        policy: &str,
        is_own: impl Fn(&JobResult, &EpisodeResult) -> bool,
    ) -> Vec<Self> {
        let rows: Vec<(&JobResult, &EpisodeResult)> =
            results.of(policy).filter(|(job, row)| is_own(job, row)).collect();
        let first = rows.iter().filter(|(_, row)| Some(&row.info.task) == experiment.tasks.first());
        let figures = |(job, row): &(&JobResult, &EpisodeResult)| {
            let cost = |task: &String| {
                let info = &row.info;
                let same = rows.iter().find(|(other_job, other)| {
                    let other = &other.info;
                    let is_same = other.building == info.building && other.period == info.period;
                    other_job.key == job.key && other.task == *task && is_same
                });
                same.and_then(|(_, row)| row.metrics()?.cost_tot).unwrap_or(f64::NAN)
            };
            Self::of(row, experiment.tasks.iter().map(cost).collect())
        };
        first.filter_map(figures).collect()
    }

    /// Returns the figures of an episode; `None` if it was lost or has no bands.
    pub(super) fn of(row: &EpisodeResult, costs: Vec<f64>) -> Option<Self> {
        let scored: &Scored = row.scored()?;
        let metrics = &scored.metrics;
        let steps_per_hour = row.info.steps_per_hour;
        Some(Self {
            period: row.info.period.clone(),
            days: metrics.steps as f64 / (24.0 * f64::from(steps_per_hour)),
            costs,
            end_uses: end_uses(metrics),
            discomfort: metrics.tdis_tot?,
            peak: 1000.0 * metrics.pele_tot.unwrap_or(0.0),
            uncomfortable: scored.is_uncomfortable(steps_per_hour).unwrap_or(false),
        })
    }

    /// Returns the figures of several periods together; `None` if there are none.
    pub(super) fn together(periods: &[Self]) -> Option<Self> {
        let (first, rest) = periods.split_first()?;
        let mut sum = first.clone();
        for each in rest {
            sum.days += each.days;
            sum.costs.iter_mut().zip(&each.costs).for_each(|(sum, cost)| *sum += cost);
            sum.end_uses.iter_mut().zip(each.end_uses).for_each(|(sum, energy)| *sum += energy);
            sum.discomfort += each.discomfort;
            sum.peak = sum.peak.max(each.peak);
            sum.uncomfortable |= each.uncomfortable;
        }
        Some(sum)
    }

    /// Returns the HVAC energy, kWh/m².
    pub(super) fn energy(&self) -> f64 {
        self.end_uses.iter().sum()
    }

    /// Returns the values under [`HEADER`].
    pub(super) fn values(&self) -> [f64; HEADER.len()] {
        let [heating, cooling, fans, others] = self.end_uses;
        [self.energy(), heating, cooling, fans, others, self.discomfort, self.peak]
    }
}

/// Returns heating, cooling, fans and the other end uses, kWh/m²; NaN if they are unknown.
fn end_uses(metrics: &EpisodeMetrics) -> [f64; 4] {
    let of = |term: Term| metrics.terms.get(term).unwrap_or(f64::NAN) / 1000.0;
    let named = [Term::Heating, Term::Cooling, Term::Fans];
    let others = Term::END_USES.into_iter().filter(|term| !named.contains(term)).map(of).sum();
    let [heating, cooling, fans] = named.map(of);
    [heating, cooling, fans, others]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn energy_of_several_periods_is_a_sum_and_peak_the_largest() {
        let period = |scale: f64| Figures {
            days: 14.0,
            costs: vec![scale],
            end_uses: [scale; 4],
            discomfort: scale,
            peak: 10.0 * scale,
            ..Figures::default()
        };
        let sum = Figures::together(&[period(1.0), period(3.0), period(2.0)]).unwrap();
        assert_eq!((sum.days, sum.costs[0], sum.energy()), (42.0, 6.0, 24.0));
        assert_eq!((sum.discomfort, sum.peak), (6.0, 30.0));
        assert_eq!(Figures::together(&[]), None);
    }
}
