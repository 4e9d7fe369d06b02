//! Running sums over an episode: key performance indicators modeled on BOPTEST's.

pub(crate) mod episode_metrics;
pub(crate) mod kpis;
pub(crate) mod oscillation;

use serde::{Deserialize, Serialize};

use self::kpis::Kpis;
use crate::reward::{Reward, StepView, ZoneStep};
use crate::terms::{Term, Totals};
use crate::zones::ControlledZone;

/// Absolute predicted mean vote up to which people are comfortable (ASHRAE 55).
pub(crate) const NEUTRAL_VOTE: f64 = 0.5;

/// Deviation of one zone from its target over an episode.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ZoneMetrics {
    /// Index of the zone in the model and of its temperature in the observation.
    pub slot: usize,
    /// Whether it has both heating and cooling.
    pub fully_conditioned: bool,
    /// Steps in sustained oscillation: see [`Metrics::oscillating_share`].
    pub oscillating_steps: usize,
    /// Thermal discomfort: the penalized deviation outside the task's comfort band, integrated over time, K h.
    pub discomfort: f64,
    squares: f64,
    penalized_squares: f64,
    absolutes: f64,
    steps_outside: usize,
    /// Steps with a penalized deviation outside the comfort band.
    penalized_steps_outside: usize,
    /// Steps in which the zone was occupied, and of these the ones below and above the comfort band.
    occupied_steps: usize,
    cold_steps: usize,
    warm_steps: usize,
}

/// Sums over the steps of an episode, which [`EpisodeMetrics`](crate::EpisodeMetrics) summarizes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Metrics {
    /// Steps completed.
    pub steps: usize,
    /// Sum of the rewards.
    pub episode_return: f64,
    /// Sum of the temperature penalties.
    pub temperature_penalty: f64,
    /// Sum of the energy penalties.
    pub energy_penalty: f64,
    /// Energy, cost, emissions, peaks and the other terms: see [`Metrics::total`].
    pub(crate) terms: Totals,
    /// Travel of each actuator, full strokes: 1 is from the lower bound to the upper bound.
    pub travel: Vec<f64>,
    /// Action values that were out of bounds and clamped.
    pub clamped_actions: usize,
    /// Steps in which the ventilation interlock raised an action.
    pub ventilation_overrides: usize,
    /// The controlled zones, in model order.
    pub zones: Vec<ZoneMetrics>,
    /// Outdoor air (L/s) and number of people, over the systems with people in their zones and summed over the steps.
    outdoor_air: [f64; 2],
    /// Indicators of operation; `None` in tasks without bands.
    pub(crate) kpis: Option<Kpis>,
    hours_per_step: f64,
    comfort_band: f64,
    last_action: Vec<f64>,
}

impl ZoneMetrics {
    /// Returns the root mean square deviation over `steps` steps, K.
    pub fn rms_deviation(&self, steps: usize) -> f64 {
        (self.squares / steps.max(1) as f64).sqrt()
    }

    /// Returns the root mean square of the penalized deviation over `steps` steps, K; in a zone without cooling, only
    /// below target.
    pub fn rms_penalized_deviation(&self, steps: usize) -> f64 {
        (self.penalized_squares / steps.max(1) as f64).sqrt()
    }

    /// Returns whether the penalized deviation was outside the task's comfort band in each of `steps` steps.
    pub fn is_never_near_target(&self, steps: usize) -> bool {
        steps > 0 && self.penalized_steps_outside == steps
    }

    /// Returns the mean absolute deviation over `steps` steps, K.
    pub fn mean_abs_deviation(&self, steps: usize) -> f64 {
        self.absolutes / steps.max(1) as f64
    }
}

impl Metrics {
    /// Returns the metrics of an episode that begins.
    pub fn new(zones: &[ControlledZone], actuators: usize, steps_per_hour: u32, comfort_band: f64) -> Self {
        let zones = zones.iter().map(|zone| ZoneMetrics {
            slot: zone.slot,
            fully_conditioned: zone.fully_conditioned,
            ..ZoneMetrics::default()
        });
        Self {
            zones: zones.collect(),
            travel: vec![0.0; actuators],
            last_action: vec![0.0; actuators],
            hours_per_step: 1.0 / f64::from(steps_per_hour),
            comfort_band,
            ..Self::default()
        }
    }

    /// Returns the total of a term over the steps, in the unit of its steps.
    pub fn total(&self, term: Term) -> f64 {
        self.terms.of(term)
    }

    /// Adds the outdoor air of a step (L/s) and the number of people it serves.
    pub(crate) fn add_outdoor_air(&mut self, [flow, people]: [f64; 2]) {
        self.outdoor_air[0] += flow;
        self.outdoor_air[1] += people;
    }

    /// Returns the mean outdoor air per person, L/s, while people are in the zones of systems with outdoor air; 0 if
    /// there are none.
    pub fn outdoor_air_per_person(&self) -> f64 {
        let [flow, people] = self.outdoor_air;
        if people > 0.0 { flow / people } else { 0.0 }
    }

    /// Adds a step that is already counted in `steps`. `low` and `high` are the bounds of the action.
    pub(crate) fn add(&mut self, reward: Reward, step: &StepView<'_>, low: &[f64], high: &[f64]) {
        self.episode_return += reward.total();
        self.temperature_penalty += reward.temperature_penalty;
        self.energy_penalty += reward.energy_penalty;
        self.terms.add(&step.terms);
        self.add_travel(step.action, low, high);
        for (zone, step) in self.zones.iter_mut().zip(step.zones) {
            let deviation = step.signed_deviation();
            let penalized = step.deviation();
            zone.penalized_squares += penalized * penalized;
            zone.penalized_steps_outside += usize::from(penalized.abs() > self.comfort_band);
            zone.occupied_steps += usize::from(step.occupied);
            let [cold, warm] = uncomfortable(step, self.comfort_band);
            zone.cold_steps += usize::from(step.occupied && cold);
            zone.warm_steps += usize::from(step.occupied && warm);
            zone.squares += deviation * deviation;
            zone.absolutes += deviation.abs();
            zone.steps_outside += usize::from(deviation.abs() > self.comfort_band);
            zone.discomfort += (penalized.abs() - self.comfort_band).max(0.0) * self.hours_per_step;
        }
    }

    /// The first action of an episode has no travel, because there is no previous action.
    fn add_travel(&mut self, action: &[f64], low: &[f64], high: &[f64]) {
        for (actuator, value) in action.iter().enumerate() {
            let range = high[actuator] - low[actuator];
            if self.steps > 1 && range > 0.0 {
                self.travel[actuator] += (value - self.last_action[actuator]).abs() / range;
            }
            self.last_action[actuator] = *value;
        }
    }

    /// Returns the root mean square deviation, K, above and below target alike, averaged over the zones with both
    /// heating and cooling.
    pub fn rms_deviation(&self) -> f64 {
        self.mean_over_zones(|zone| zone.rms_deviation(self.steps))
    }

    /// Returns the mean absolute deviation, K, averaged over the zones with both heating and cooling.
    pub fn mean_abs_deviation(&self) -> f64 {
        self.mean_over_zones(|zone| zone.mean_abs_deviation(self.steps))
    }

    /// Returns the hours outside the task's comfort band, averaged over the zones with both heating and cooling.
    pub fn hours_outside_band(&self) -> f64 {
        self.mean_over_zones(|zone| self.zone_hours_outside_band(zone))
    }

    /// Returns the hours in which a zone was outside the task's comfort band.
    pub fn zone_hours_outside_band(&self, zone: &ZoneMetrics) -> f64 {
        zone.steps_outside as f64 * self.hours_per_step
    }

    /// Returns the share of the occupied zone-hours that were too cold, by the predicted mean vote where it is known,
    /// otherwise by the task's comfort band; `None` if no controlled zone is ever occupied.
    pub fn occupied_too_cold(&self) -> Option<f64> {
        self.share_of_occupied(|zone| zone.cold_steps)
    }

    /// Returns the share of the occupied zone-hours that were too warm, as [`Metrics::occupied_too_cold`]; zones
    /// without cooling never are.
    pub fn occupied_too_warm(&self) -> Option<f64> {
        self.share_of_occupied(|zone| zone.warm_steps)
    }

    fn share_of_occupied(&self, steps: impl Fn(&ZoneMetrics) -> usize) -> Option<f64> {
        let sum = |steps: &dyn Fn(&ZoneMetrics) -> usize| self.zones.iter().map(steps).sum::<usize>();
        let occupied = sum(&|zone| zone.occupied_steps);
        (occupied > 0).then(|| sum(&steps) as f64 / occupied as f64)
    }

    /// Returns the thermal discomfort, K h, averaged over the controlled zones.
    pub fn discomfort(&self) -> f64 {
        self.zones.iter().map(|zone| zone.discomfort).sum::<f64>() / self.zones.len().max(1) as f64
    }

    /// Returns the actuator travel, full strokes/day, averaged over the actuators.
    pub fn daily_travel(&self) -> f64 {
        let days = self.steps as f64 * self.hours_per_step / 24.0;
        self.travel.iter().sum::<f64>()
            / self.travel.len().max(1) as f64
            / days.max(self.hours_per_step / 24.0)
    }

    /// Returns the share of the steps of controlled zones that were in sustained oscillation: ten or more swings of the
    /// air temperature in a row, each of at least 0.2 K and at most an hour, under the same target.
    pub fn oscillating_share(&self) -> f64 {
        let steps: usize = self.zones.iter().map(|zone| zone.oscillating_steps).sum();
        steps as f64 / (self.steps * self.zones.len()).max(1) as f64
    }

    /// Returns the root mean square of the penalized deviation, K, averaged over the zones without cooling; 0 if there
    /// are none.
    pub fn rms_heating_only(&self) -> f64 {
        let heated: Vec<_> = self.zones.iter().filter(|zone| !zone.fully_conditioned).collect();
        heated.iter().map(|zone| zone.rms_penalized_deviation(self.steps)).sum::<f64>()
            / heated.len().max(1) as f64
    }

    /// Returns the number of zones that were never near their target: see [`ZoneMetrics::is_never_near_target`].
    pub fn zones_never_near_target(&self) -> usize {
        self.zones.iter().filter(|zone| zone.is_never_near_target(self.steps)).count()
    }

    /// Returns the thermal discomfort of operation, K h, averaged over the zones, by the trapezoid rule; `None` in tasks
    /// without bands.
    pub fn zone_discomfort(&self) -> Option<f64> {
        Some(self.kpis.as_ref()?.discomfort(self.zones.len()))
    }

    /// Returns the CO₂ above the limit, ppm h, averaged over the zones, by the trapezoid rule; `None` in tasks without
    /// the CO₂ balance.
    pub fn zone_bad_air(&self) -> Option<f64> {
        self.kpis.as_ref()?.bad_air(self.zones.len())
    }

    /// Returns the total of a term in an operation task; `None` in tasks without bands.
    fn operation_total(&self, term: Term) -> Option<f64> {
        self.kpis.as_ref().map(|_| self.total(term))
    }

    /// Returns the HVAC energy of operation, kWh/m².
    pub fn operation_energy(&self) -> Option<f64> {
        Some(self.operation_total(Term::Energy)? / 1000.0)
    }

    /// Returns the cost of operation, currency/m².
    pub fn operation_cost(&self) -> Option<f64> {
        self.operation_total(Term::Cost)
    }

    /// Returns the emissions of operation, kg CO₂/m².
    pub fn operation_emissions(&self) -> Option<f64> {
        Some(self.operation_total(Term::Emissions)? / 1000.0)
    }

    /// Returns the largest quarter-hour demand of operation, kW/m²: electricity (0), gas and other fuels (1), district
    /// heat (2).
    pub fn operation_peak(&self, carrier: usize) -> Option<f64> {
        self.kpis.as_ref()?.peak(carrier)
    }

    fn mean_over_zones(&self, value: impl Fn(&ZoneMetrics) -> f64) -> f64 {
        let zones: Vec<_> = self.zones.iter().filter(|z| z.fully_conditioned).collect();
        zones.iter().map(|z| value(z)).sum::<f64>() / zones.len().max(1) as f64
    }
}

/// Returns whether a zone is too cold and whether it is too warm: by its predicted mean vote where that is known,
/// otherwise by the comfort band, K.
fn uncomfortable(step: &ZoneStep, comfort_band: f64) -> [bool; 2] {
    let (value, limit) = match step.vote {
        Some(vote) if step.penalize_above_target => (vote, NEUTRAL_VOTE),
        Some(vote) => (vote.min(0.0), NEUTRAL_VOTE),
        None => (step.deviation(), comfort_band),
    };
    [value < -limit, value > limit]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setpoints::calendar::Season;
    use crate::terms::Amounts;

    #[test]
    fn shares_of_occupied_hours_count_only_occupied_zones() {
        let zone = |slot| ControlledZone {
            slot,
            penalize_above_target: true,
            fully_conditioned: true,
            least_people: 0.0,
        };
        let mut metrics = Metrics::new(&[zone(0), zone(1)], 0, 12, 1.0);
        assert_eq!(metrics.occupied_too_cold(), None);
        let step = |temperature, occupied| ZoneStep::with_target(temperature, 21.0, occupied, true);
        for zones in [
            [step(19.0, true), step(15.0, false)],
            [step(23.0, true), step(30.0, false)],
            [step(20.5, true), step(22.5, true)],
        ] {
            let view = StepView {
                zones: &zones,
                observation: &[],
                action: &[],
                terms: Amounts::default(),
                day_of_year: 1,
                hour: 0.0,
                season: Season::Winter,
            };
            metrics.steps += 1;
            metrics.add(Reward::default(), &view, &[], &[]);
        }
        assert_eq!((metrics.occupied_too_cold(), metrics.occupied_too_warm()), (Some(0.25), Some(0.5)));
    }

    #[test]
    fn a_vote_replaces_the_comfort_band() {
        let zone = |vote, cooled| ZoneStep { vote, ..ZoneStep::with_target(30.0, 21.0, true, cooled) };
        assert_eq!(uncomfortable(&zone(None, true), 0.5), [false, true]);
        assert_eq!(uncomfortable(&zone(Some(0.4), true), 0.5), [false, false]);
        assert_eq!(uncomfortable(&zone(Some(-0.6), true), 0.5), [true, false]);
        assert_eq!(uncomfortable(&zone(Some(0.6), false), 0.5), [false, false], "nothing cools the zone");
    }
}
