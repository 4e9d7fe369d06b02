//! Comfort penalties: squared deviation as in the paper or outside a deadband, predicted mean vote, or deviation from a
//! band.

use serde::{Deserialize, Serialize};

use crate::Result;
use crate::limits::within;
use crate::metrics::NEUTRAL_VOTE;
use crate::reward::ZoneStep;
use crate::setpoints::calendar::Season;
use crate::task::OPERATION_WEIGHT;

/// The comfort penalty of a reward, averaged over the controlled zones.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Comfort {
    /// (T − target)², K² (paper, eq. 1).
    #[default]
    Squared,
    /// Squared deviation outside a deadband, K².
    Deadband {
        /// Half width of the deadband, K.
        half_width: f64,
    },
    /// PMV² while the zone is occupied; the target is not used. In operation tasks, the vote beyond ±0.5 times
    /// [`PMV_WEIGHT`].
    Pmv(Pmv),
    /// Deviation from the band, K, times a weight: the operation tasks.
    Band {
        /// Penalty per kelvin outside the band, averaged over the zones, in units of the mean cost of a step.
        weight: f64,
    },
}

/// Penalty of a vote beyond ±0.5 in operation tasks, in units of the mean cost of a step: a vote is about 3 K of air and
/// radiant temperature.
pub const PMV_WEIGHT: f64 = 3.0 * OPERATION_WEIGHT;

/// Assumptions of the predicted mean vote (ISO 7730). In operation tasks, mean radiant temperature and humidity are
/// the zone's own; otherwise, the radiant temperature is the air temperature and the humidity an assumption.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Pmv {
    /// Metabolic rate, met; 1.2 for office work.
    pub metabolic_rate: f64,
    /// Air speed, m/s.
    pub air_speed: f64,
    /// Indoor relative humidity, %; not used in operation tasks.
    pub humidity: f64,
    /// Clothing insulation in winter, December to February (June to August in the south), clo.
    pub winter_clothing: f64,
    /// Clothing insulation in summer, June to August (December to February in the south), clo; in other months the mean
    /// of both.
    pub summer_clothing: f64,
}

impl Default for Pmv {
    fn default() -> Self {
        Self {
            metabolic_rate: 1.2,
            air_speed: 0.1,
            humidity: 50.0,
            winter_clothing: 1.0,
            summer_clothing: 0.5,
        }
    }
}

impl Comfort {
    pub(crate) fn check(&self) -> Result<()> {
        match self {
            Self::Squared => Ok(()),
            Self::Deadband { half_width } => within("half_width", *half_width, 0.0, 50.0),
            Self::Band { weight } => within("weight", *weight, 0.0, 1e6),
            // Ranges in which ISO 7730 recommends the index.
            Self::Pmv(pmv) => {
                within("metabolic_rate", pmv.metabolic_rate, 0.8, 4.0)?;
                within("air_speed", pmv.air_speed, 0.0, 1.0)?;
                within("humidity", pmv.humidity, 0.0, 100.0)?;
                within("winter_clothing", pmv.winter_clothing, 0.0, 2.0)?;
                within("summer_clothing", pmv.summer_clothing, 0.0, 2.0)
            }
        }
    }

    /// Returns the penalty of a zone.
    pub(crate) fn penalty(&self, zone: &ZoneStep, season: Season) -> f64 {
        match self {
            Self::Squared => zone.deviation().powi(2),
            Self::Deadband { half_width } => (zone.deviation().abs() - half_width).max(0.0).powi(2),
            Self::Band { weight } => weight * zone.deviation().abs(),
            Self::Pmv(_) if !zone.occupied => 0.0,
            Self::Pmv(pmv) => {
                let felt = |vote: f64| if zone.penalize_above_target { vote.abs() } else { (-vote).max(0.0) };
                match zone.vote {
                    Some(vote) => PMV_WEIGHT * (felt(vote) - NEUTRAL_VOTE).max(0.0),
                    None => felt(pmv.vote(zone.temperature, season)).powi(2),
                }
            }
        }
    }
}

impl Pmv {
    fn vote(&self, temperature: f64, season: Season) -> f64 {
        self.vote_in(temperature, temperature, self.humidity, season)
    }

    /// Returns the vote at an air temperature and a mean radiant temperature, °C, and a relative humidity, %.
    pub(crate) fn vote_in(&self, temperature: f64, radiant: f64, humidity: f64, season: Season) -> f64 {
        let clothing = match season {
            Season::Winter => self.winter_clothing,
            Season::Summer => self.summer_clothing,
            Season::Between => 0.5 * (self.winter_clothing + self.summer_clothing),
        };
        let air = Air { temperature, radiant, speed: self.air_speed, humidity };
        vote(&air, self.metabolic_rate, clothing)
    }
}

/// Thermal environment of a person.
struct Air {
    /// Air temperature, °C.
    temperature: f64,
    /// Mean radiant temperature, °C.
    radiant: f64,
    /// Air speed, m/s.
    speed: f64,
    /// Relative humidity, %.
    humidity: f64,
}

/// One met, W/m²; one clo, m²K/W; 0 °C in K as the standard rounds it.
const MET: f64 = 58.15;
const CLO: f64 = 0.155;
const KELVIN: f64 = 273.0;

/// Returns the predicted mean vote (ISO 7730:2005, equations 1 to 4) without external work: −3 cold, 0 neutral, 3 hot.
fn vote(air: &Air, met: f64, clo: f64) -> f64 {
    let metabolism = met * MET;
    let vapor_pressure = air.humidity * 10.0 * libm::exp(16.6536 - 4030.183 / (air.temperature + 235.0));
    let clothing = Clothing::in_balance(air, metabolism, clo * CLO);
    let dry = clothing.radiation(air.radiant) + clothing.convection(air.temperature);
    let diffusion = 3.05e-3 * (5733.0 - 6.99 * metabolism - vapor_pressure);
    let sweat = 0.42 * (metabolism - MET).max(0.0);
    let respiration =
        1.7e-5 * metabolism * (5867.0 - vapor_pressure) + 0.0014 * metabolism * (34.0 - air.temperature);
    (0.303 * libm::exp(-0.036 * metabolism) + 0.028) * (metabolism - diffusion - sweat - respiration - dry)
}

/// Outer surface of a clothed person.
struct Clothing {
    /// Surface temperature, °C.
    temperature: f64,
    /// Clothing area factor: clothed over nude surface area.
    area: f64,
    /// Convective heat transfer coefficient, W/m²K.
    convective: f64,
}

impl Clothing {
    /// Solves by bisection for the surface temperature at which conduction through the clothing equals surface losses.
    fn in_balance(air: &Air, metabolism: f64, insulation: f64) -> Self {
        const STEPS: usize = 60;
        let area = if insulation <= 0.078 { 1.0 + 1.29 * insulation } else { 1.05 + 0.645 * insulation };
        let forced = 12.1 * air.speed.sqrt();
        let skin = 35.7 - 0.028 * metabolism;
        let (mut low, mut high) = (air.temperature.min(air.radiant).min(skin) - 1.0, 100.0);
        let mut clothing = Self { temperature: 0.0, area, convective: forced };
        for _ in 0..STEPS {
            clothing.temperature = 0.5 * (low + high);
            let free = 2.38 * (clothing.temperature - air.temperature).abs().sqrt().sqrt();
            clothing.convective = free.max(forced);
            let loss = clothing.radiation(air.radiant) + clothing.convection(air.temperature);
            if clothing.temperature > skin - insulation * loss {
                high = clothing.temperature;
            } else {
                low = clothing.temperature;
            }
        }
        clothing
    }

    fn radiation(&self, radiant: f64) -> f64 {
        3.96e-8 * self.area * ((self.temperature + KELVIN).powi(4) - (radiant + KELVIN).powi(4))
    }

    fn convection(&self, air: f64) -> f64 {
        self.area * self.convective * (self.temperature - air)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of table D.1 of ISO 7730:2005.
    #[test]
    fn votes_match_the_examples_of_the_standard() {
        for (temperature, radiant, speed, humidity, met, clo, expected) in [
            (22.0, 22.0, 0.10, 60.0, 1.2, 0.5, -0.75),
            (27.0, 27.0, 0.10, 60.0, 1.2, 0.5, 0.77),
            (27.0, 27.0, 0.30, 60.0, 1.2, 0.5, 0.44),
            (23.5, 25.5, 0.10, 60.0, 1.2, 0.5, -0.01),
            (23.5, 25.5, 0.30, 60.0, 1.2, 0.5, -0.55),
            (19.0, 19.0, 0.10, 40.0, 1.2, 1.0, -0.60),
            (27.0, 27.0, 0.10, 40.0, 1.2, 1.0, 1.13),
        ] {
            let air = Air { temperature, radiant, speed, humidity };
            let found = vote(&air, met, clo);
            assert!(
                (found - expected).abs() < 0.02,
                "{temperature} °C, {clo} clo: {found:.3}, expected {expected}"
            );
        }
    }

    #[test]
    fn the_vote_rises_with_the_temperature_and_the_clothing() {
        let pmv = Pmv::default();
        let votes: Vec<f64> = (10..35).map(|t| pmv.vote(f64::from(t), Season::Winter)).collect();
        assert!(votes.windows(2).all(|pair| pair[0] < pair[1]));
        assert!(pmv.vote(21.0, Season::Winter) > pmv.vote(21.0, Season::Between));
        assert!(pmv.vote(21.0, Season::Between) > pmv.vote(21.0, Season::Summer));
    }

    #[test]
    fn each_comfort_model_penalizes_as_documented() {
        let zone = ZoneStep::with_target(24.0, 21.0, false, true);
        let heated = ZoneStep { penalize_above_target: false, ..zone };
        let penalty = |comfort: &Comfort, zone: &ZoneStep| comfort.penalty(zone, Season::Summer);
        assert_eq!(penalty(&Comfort::Squared, &zone), 9.0);
        assert_eq!(penalty(&Comfort::Squared, &heated), 0.0);
        assert_eq!(penalty(&Comfort::Deadband { half_width: 1.0 }, &zone), 4.0);
        let pmv = Comfort::Pmv(Pmv::default());
        assert_eq!(penalty(&pmv, &zone), 0.0);
        let there = ZoneStep { occupied: true, ..zone };
        assert!(penalty(&pmv, &there) > 0.0);
        let hot = ZoneStep { temperature: 35.0, occupied: true, ..heated };
        assert_eq!(penalty(&pmv, &hot), 0.0);
        let felt = |vote| penalty(&pmv, &ZoneStep { vote: Some(vote), ..there });
        assert_eq!([felt(-1.5), felt(0.4), felt(1.0)], [PMV_WEIGHT, 0.0, 0.5 * PMV_WEIGHT]);
    }
}
