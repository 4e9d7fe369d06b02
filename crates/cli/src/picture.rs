//! `picture.html`: an episode to look at, in one file that needs no network.
//!
//! Every series goes into the page as the mean, the least and the greatest value of each of at most
//! [`MAXIMUM_POINTS`] spans of equal length, in 16 bits between the least and the greatest of the whole series;
//! that keeps a year of the largest building below 5 MB. The page draws with its own script.

use std::io::Write;

use anyhow::Result;
use b2b_building::hvac::Quantity;
use b2b_building::morphology::Owner;
use b2b_building::{Conditioning, PreparedBuilding};
use b2b_env::{Env, Target, Trajectory};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde::Serialize;
use serde_json::json;

use crate::summary::Summary;

/// Name of the file.
pub const NAME: &str = "picture.html";

const PAGE: &str = include_str!("picture.html");
/// Points of a series: a year of hours, the last day's rounding included.
const MAXIMUM_POINTS: usize = 8784;

/// Graphs of one unit over the time axis.
#[derive(Serialize)]
struct Panel {
    title: String,
    unit: &'static str,
    series: Vec<Series>,
    /// A band to be shaded: the target and the comfort band to both sides, where it does not move.
    #[serde(skip_serializing_if = "Option::is_none")]
    band: Option<[f64; 2]>,
}

/// One graph.
#[derive(Serialize)]
struct Series {
    name: String,
    /// Series of the same colour belong to the same zone.
    color: usize,
    low: f64,
    high: f64,
    /// Means, minima and maxima of the spans, base64 of little-endian 16-bit numbers from `low` to `high`.
    mean: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    extremes: Option<[String; 2]>,
}

/// Writes the page.
pub fn write(file: &mut impl Write, env: &Env, trajectory: &Trajectory, summary: &Summary) -> Result<()> {
    let picture = Picture { env, trajectory, span: trajectory.len().div_ceil(MAXIMUM_POINTS).max(1) };
    let data = json!({
        "title": summary.title(),
        "summary": summary,
        "first_day": env.episode().period.first().day_of_year(),
        "steps_per_hour": env.episode().steps_per_hour,
        "span": picture.span,
        "points": trajectory.len().div_ceil(picture.span),
        "panels": picture.panels(),
    });
    // `<` would let a name end the script element.
    let data = data.to_string().replace('<', "\\u003c");
    Ok(file.write_all(PAGE.replace("{{DATA}}", &data).as_bytes())?)
}

struct Picture<'a> {
    env: &'a Env,
    trajectory: &'a Trajectory,
    /// Steps to a point.
    span: usize,
}

impl Picture<'_> {
    fn panels(&self) -> Vec<Panel> {
        let mut panels = vec![self.temperatures(), self.targets(), self.outdoor(), self.power()];
        const GROUPS: [(Quantity, &str); 5] = [
            (Quantity::SupplyAirFlow, "supply air flow"),
            (Quantity::SupplyAirTemperature, "supply air temperature"),
            (Quantity::OutdoorAirFlow, "outdoor air flow"),
            (Quantity::DamperOpening, "damper opening"),
            (Quantity::HeatingSetpoint, "heating setpoint"),
        ];
        panels.extend(GROUPS.map(|(quantity, what)| self.actions(quantity, what)));
        panels.retain(|panel| !panel.series.is_empty());
        panels
    }

    fn temperatures(&self) -> Panel {
        let band = self.env.episode().task.comfort_band;
        let series = self.zones(|conditioning| conditioning != Conditioning::None).collect();
        let target = self.env.observation_space().constant_target();
        let band = target.map(|target| [target - band, target + band]);
        Panel { title: "Zone air temperature".into(), unit: "°C", series, band }
    }

    /// Where they move.
    fn targets(&self) -> Panel {
        let zones = self.env.building().zones.iter().enumerate();
        let controlled = zones.filter(|(_, zone)| zone.conditioning != Conditioning::None);
        let series = controlled.enumerate().filter_map(|(index, (number, zone))| {
            match self.env.observation_space().target(index) {
                Target::Slot(slot) => Some(self.slot(zone.name.clone(), number, slot, 1.0)),
                Target::Always(_) => None,
            }
        });
        Panel { title: "Target temperature".into(), unit: "°C", series: series.collect(), band: None }
    }

    /// Attics and plenums with the outdoors, which they follow more than they follow any target.
    fn outdoor(&self) -> Panel {
        let outdoor = self.env.observation_space().outdoor_temperature();
        let mut series = vec![self.slot("outdoor air".into(), self.env.building().zones.len(), outdoor, 1.0)];
        series.extend(self.zones(|conditioning| conditioning == Conditioning::None));
        Panel { title: "Outdoors and unconditioned zones".into(), unit: "°C", series, band: None }
    }

    /// Temperatures of the zones with such equipment.
    fn zones(&self, with: impl Fn(Conditioning) -> bool) -> impl Iterator<Item = Series> {
        let zones = self.env.building().zones.iter().enumerate();
        let slots = self.env.observation_space().zone_temperatures();
        zones
            .zip(slots)
            .filter(move |((_, zone), _)| with(zone.conditioning))
            .map(|((number, zone), slot)| self.slot(zone.name.clone(), number, slot, 1.0))
    }

    fn power(&self) -> Panel {
        let space = self.env.observation_space();
        let per_hour = f64::from(self.env.episode().steps_per_hour);
        let series = vec![
            self.slot("electricity".into(), 0, space.electricity(), per_hour),
            self.slot("gas".into(), 1, space.gas(), per_hour),
        ];
        Panel { title: "HVAC power".into(), unit: "W/m²", series, band: None }
    }

    fn actions(&self, quantity: Quantity, what: &str) -> Panel {
        let building = self.env.building();
        let actuators = building.owned_actuators().enumerate();
        let series = actuators.filter(|(_, (_, actuator))| actuator.quantity == quantity).map(
            |(k, (owner, actuator))| {
                let name = actuator.name.trim_end_matches(what).trim_end().to_owned();
                self.series(name, zone_of(building, owner), self.trajectory.acted(k).collect())
            },
        );
        Panel {
            title: format!("Action: {what}"),
            unit: quantity.unit(),
            series: series.collect(),
            band: None,
        }
    }

    /// What a slot of the observation was, times a scale.
    fn slot(&self, name: String, color: usize, slot: usize, scale: f64) -> Series {
        self.series(name, color, self.trajectory.observed(slot).map(|value| value * scale).collect())
    }

    fn series(&self, name: String, color: usize, values: Vec<f64>) -> Series {
        let (low, high) = (least(&values), greatest(&values));
        let points = |of: fn(&[f64]) -> f64| encode(values.chunks(self.span).map(of), low, high);
        Series {
            name,
            color,
            low,
            high,
            mean: points(|span| span.iter().sum::<f64>() / span.len() as f64),
            extremes: (self.span > 1).then(|| [points(least), points(greatest)]),
        }
    }
}

fn least(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

fn greatest(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// The zone of an actuator, by index; for those of an air handler the first zone of the air loop.
fn zone_of(building: &PreparedBuilding, owner: Owner) -> usize {
    match owner {
        Owner::Zone(zone) => zone,
        Owner::AirLoop(system) => building.layouts()[system].zones[0].index,
        Owner::Weather | Owner::Calendar | Owner::Energy => 0,
    }
}

/// Base64 of 16-bit numbers, 0 for `low` and 65535 for `high`.
fn encode(values: impl Iterator<Item = f64>, low: f64, high: f64) -> String {
    let range = if high > low { high - low } else { 1.0 };
    let bytes: Vec<u8> = values
        .flat_map(|value| (((value - low) / range * f64::from(u16::MAX)).round() as u16).to_le_bytes())
        .collect();
    BASE64_STANDARD.encode(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_encoded_between_the_least_and_the_greatest() {
        let bytes = BASE64_STANDARD.decode(encode([1.0, 2.0, 3.0].into_iter(), 1.0, 3.0)).unwrap();
        assert_eq!(bytes, [0, 0, 0, 128, 255, 255]);
    }

    #[test]
    fn the_page_loads_nothing_from_elsewhere() {
        assert_eq!(PAGE.matches("{{DATA}}").count(), 1);
        for word in ["http://", "https://", "src=", "@import", "<link"] {
            assert!(!PAGE.contains(word), "{word}");
        }
    }
}
