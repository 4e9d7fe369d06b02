//! The observation and the reward of a step.

use b2b_building::{Carrier, CarrierEnergy, EndUseEnergy};

use super::Env;
use super::engine::Engine;
use crate::metrics::kpis::Kpis;
use crate::preview::PREVIEW_HOURS;
use crate::reward::{Reward, StepView, ZoneStep};
use crate::setpoints::Asked;
use crate::setpoints::band::NextPair;
use crate::setpoints::calendar::{Moment, Season};
use crate::spaces::EpisodeConfig;
use crate::spaces::observation::Target;
use crate::spaces::slots::Shared;
use crate::terms::{Amounts, Measured};
use crate::zones::ControlledZone;
use crate::zones::carbon_dioxide::CarbonDioxide;
use crate::zones::comfort::Comfort;
use crate::zones::zone_air::ZoneAir;
use crate::{Error, Result};

/// Largest number of hours until the next change of setpoints, a week; also reported if there is none ahead.
const LONGEST_PREVIEW: f64 = 168.0;
/// The carriers of the demands of electricity, fuels and district heat.
const DEMANDS: [&[Carrier]; 3] = [
    &[Carrier::Electricity],
    &[Carrier::Gas, Carrier::Propane, Carrier::FuelOil, Carrier::OtherFuel],
    &[Carrier::DistrictHeating],
];

/// Returns a controlled zone in a step.
pub(super) fn zone_step(temperature: f64, asked: Asked, zone: &ControlledZone) -> ZoneStep {
    let Asked { occupied, target, pair } = asked;
    let step = ZoneStep::with_target(temperature, target, occupied, zone.penalize_above_target);
    ZoneStep { pair, ..step }
}

impl Env {
    /// The time of the observation, which is the beginning of the next step.
    pub(super) fn moment(&self) -> Moment {
        self.beginning_of(self.metrics.steps)
    }

    /// The time at which a step of the episode begins, counted from 0.
    pub(super) fn beginning_of(&self, step: usize) -> Moment {
        let episode = &self.spaces.episode;
        let steps_per_day = 24 * episode.steps_per_hour as usize;
        let day = (step / steps_per_day) as u32;
        Moment {
            day_of_year: episode.period.day_of_year(day),
            hour: (step % steps_per_day) as f64 / f64::from(episode.steps_per_hour),
        }
    }

    /// Stores occupancy and targets observed before the step, for its reward.
    pub(super) fn keep_targets(&mut self) {
        self.zone_steps.clear();
        let zones = self.zones.iter().zip(&self.asked);
        self.zone_steps.extend(zones.map(|(zone, asked)| zone_step(f64::NAN, *asked, zone)));
    }

    /// Returns the terms of a step that used energy (Wh/m²) and began at a moment.
    pub(super) fn measure(
        &mut self,
        end_uses: &EndUseEnergy,
        energy: &CarrierEnergy,
        began: Moment,
    ) -> Amounts {
        let Moment { day_of_year, hour } = began;
        let billed = self.billing.step(day_of_year, hour, energy);
        let EpisodeConfig { task, steps_per_hour, .. } = &self.spaces.episode;
        let hours = 1.0 / f64::from(*steps_per_hour);
        let cost = billed.cost.unwrap_or_else(|| task.cost(energy, hour));
        let emissions = billed.emissions.unwrap_or_else(|| task.emissions_of(energy, hour));
        Measured { energy, end_uses, cost, emissions, hours, so_far: &self.metrics.terms }.amounts()
    }

    /// The reward of the step just observed; adds the step to the metrics.
    pub(super) fn judge(&mut self, began: Moment, energy: &CarrierEnergy) -> Reward {
        let season = self.seasons.on(began.day_of_year);
        self.look_at_zones(season);
        let step = StepView {
            zones: &self.zone_steps,
            observation: &self.observation,
            action: &self.action,
            terms: self.terms,
            day_of_year: began.day_of_year,
            hour: began.hour,
            season,
        };
        let reward = self.reward.reward(&step);
        self.metrics.add(reward, &step, self.spaces.action.low(), self.spaces.action.high());
        let hours_per_step = 1.0 / f64::from(self.spaces.episode.steps_per_hour);
        if let Some(kpis) = &mut self.metrics.kpis {
            let of =
                |carriers: &[Carrier]| carriers.iter().map(|carrier| energy[*carrier as usize]).sum::<f64>();
            kpis.add(&self.zone_steps, DEMANDS.map(of), hours_per_step);
        }
        let zones = self.zone_steps.iter().zip(&mut self.oscillations).zip(&mut self.metrics.zones);
        for ((step, oscillation), metrics) in zones {
            metrics.oscillating_steps += oscillation.add(step.temperature, step.target, hours_per_step);
        }
        reward
    }

    /// Reads the zones at the end of the step from the observation.
    fn look_at_zones(&mut self, season: Season) {
        let (space, observation) = (&self.spaces.observation, &self.observation);
        for (number, (step, zone)) in self.zone_steps.iter_mut().zip(&self.zones).enumerate() {
            let seen = |quantity| space.zone_air(quantity, number).map(|slot| observation[slot]);
            step.temperature = observation[zone.slot];
            step.carbon_dioxide = seen(ZoneAir::CarbonDioxide);
            if let (Comfort::Pmv(pmv), Some(radiant), Some(humidity)) = (
                &self.spaces.episode.task.comfort,
                seen(ZoneAir::RadiantTemperature),
                seen(ZoneAir::Humidity),
            ) {
                step.vote = Some(pmv.vote_in(step.temperature, radiant, humidity, season));
            }
        }
    }

    /// Writes the preview, if the task has one.
    fn look_ahead(&mut self, Moment { day_of_year, hour }: Moment) {
        let (Some(first), Some(forecast)) = (self.spaces.observation.preview(), &self.forecast) else {
            return;
        };
        let mut slot = first;
        let mut put = |value: f64| {
            self.observation[slot] = value;
            slot += 1;
        };
        for (zone, asked) in self.asked.iter().enumerate() {
            let next = self.targets.next(zone, day_of_year, hour);
            let NextPair { hours, pair } =
                next.unwrap_or(NextPair { hours: LONGEST_PREVIEW, pair: asked.pair });
            put(pair.heating);
            if pair.cooling.is_finite() {
                put(pair.cooling);
            }
            put(hours.min(LONGEST_PREVIEW));
        }
        let mut values = [[0.0; PREVIEW_HOURS]; 3];
        let [prices, temperatures, solar] = &mut values;
        if !self.billing.preview(day_of_year, hour, prices) {
            let constant = &self.spaces.episode.task.prices.electricity;
            for (ahead, price) in prices.iter_mut().enumerate() {
                *price = constant.at(hour + ahead as f64);
            }
        }
        forecast.write(day_of_year, hour, temperatures, solar);
        values.iter().flatten().for_each(|value| put(*value));
    }

    /// Starts the indicators of operation in the state just observed.
    pub(super) fn begin_kpis(&mut self) {
        if self.spaces.episode.task.is_operation() {
            let (space, task) = (&self.spaces.observation, &self.spaces.episode.task);
            let temperatures = self.zones.iter().map(|zone| self.observation[zone.slot]);
            let air = (0..self.zones.len()).filter_map(|zone| space.zone_air(ZoneAir::CarbonDioxide, zone));
            let kpis = Kpis::begin(temperatures.collect());
            self.metrics.kpis = Some(match task.carbon_dioxide {
                Some(CarbonDioxide { limit, .. }) => {
                    kpis.with_carbon_dioxide(limit, air.map(|slot| self.observation[slot]).collect())
                }
                None => kpis,
            });
        }
    }

    /// Adds the errors of faulty sensors to the observation, after the reward was computed from true temperatures.
    pub(super) fn disturb(&mut self) {
        if let Some(impairment) = &self.impairment {
            let zones = self.spaces.building.zones.len();
            impairment.disturb(self.metrics.steps, &mut self.observation[..zones]);
        }
    }

    /// Writes the observation. `energy` in Wh/m², electricity and all other carriers.
    pub(super) fn observe(&mut self, engine: &Engine, energy: [f64; 2]) -> Result<()> {
        for (slot, variable) in self.observation.iter_mut().zip(&engine.temperatures) {
            *slot = engine.simulation.read(*variable);
        }
        let space = &self.spaces.observation;
        let of_air = space.first_air();
        for (slot, variable) in self.observation[of_air..].iter_mut().zip(&engine.air) {
            *slot = engine.simulation.read(*variable);
        }
        let [temperature, humidity] = engine.outdoor.map(|v| engine.simulation.read(v));
        let moment = self.moment();
        let mut put = |slot: Shared, value: f64| self.observation[space.shared(slot)] = value;
        put(Shared::OutdoorTemperature, temperature);
        put(Shared::OutdoorHumidity, humidity);
        let calendar = self.spaces.episode.period.calendar();
        put(Shared::TimeOfDay, moment.hour);
        put(Shared::DayOfWeek, f64::from(calendar.weekday(moment.day_of_year)));
        put(Shared::DayOfYear, f64::from(moment.day_of_year));
        put(Shared::Electricity, energy[0]);
        put(Shared::Gas, energy[1]);
        if let Some(slot) = space.holiday() {
            let is_holiday = self.spaces.building.holidays.contains(&calendar.count(moment.day_of_year));
            self.observation[slot] = f64::from(u8::from(is_holiday));
        }
        for zone in 0..self.zones.len() {
            let asked = self.targets.at(zone, moment, engine.occupied(zone));
            self.asked[zone] = asked;
            if let Some(occupancy) = space.occupancy(zone) {
                self.observation[occupancy] = f64::from(u8::from(asked.occupied));
            }
            match space.target(zone) {
                Target::Always(_) => {}
                Target::Slot(slot) => self.observation[slot] = asked.pair.heating,
                Target::Between([heating, cooling]) => {
                    self.observation[heating] = asked.pair.heating;
                    self.observation[cooling] = asked.pair.cooling;
                }
            }
        }
        self.look_ahead(moment);
        let space = &self.spaces.observation;
        match self.observation.iter().position(|v| !v.is_finite()) {
            None => Ok(()),
            Some(slot) => Err(Error::ObservationNotFinite {
                slot: space.slots()[slot].name.clone(),
                value: self.observation[slot],
                step: self.metrics.steps,
            }),
        }
    }
}
