//! `picture.html`: the time series of an episode, in one file that needs no network.
//!
//! Every series is stored as the mean, minimum and maximum of each of at most [`MAX_POINTS`] spans of equal length,
//! quantized to 16 bits between the minimum and maximum of the whole series. That keeps a year of the largest building
//! below 5 MB. The page draws with its own script.

use std::io::Write;

use anyhow::Result;
use b2b_benchmark::report;
use b2b_building::hvac::Quantity;
use b2b_building::morphology::Owner;
use b2b_building::{Conditioning, PreparedBuilding};
use b2b_env::{Spaces, Target, Trajectory};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde::Serialize;
use serde_json::json;

use super::summary::Summary;

/// Name of the file.
pub const NAME: &str = "picture.html";

const PAGE: &str = include_str!("picture.html");
/// Maximum number of points of a series: the hours of a leap year.
const MAX_POINTS: usize = 8784;

/// Series of one unit over the time axis.
#[derive(Serialize)]
struct Panel {
    title: String,
    unit: &'static str,
    series: Vec<Series>,
    /// The comfort band around a constant target, to be shaded.
    #[serde(skip_serializing_if = "Option::is_none")]
    band: Option<[f64; 2]>,
}

/// One time series.
#[derive(Serialize)]
struct Series {
    name: String,
    /// Index of the color, the same for all series of a zone.
    color: usize,
    /// Whether the line is dashed, as for the reactive controllers beside an agent.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    dashed: bool,
    low: f64,
    high: f64,
    /// Means of the spans: base64 of little-endian 16-bit numbers, 0 for `low` and 65535 for `high`.
    mean: String,
    /// Minima and maxima of the spans, if a span has more than one step.
    #[serde(skip_serializing_if = "Option::is_none")]
    extremes: Option<[String; 2]>,
}

/// Writes the page. If the trajectory of the reactive controllers is given, their zone temperatures and power are drawn
/// beside those of the agent.
pub fn write(
    file: &mut impl Write,
    spaces: &Spaces,
    trajectory: &Trajectory,
    reactive: Option<&Trajectory>,
    summary: &Summary,
) -> Result<()> {
    let picture =
        Picture { spaces, trajectory, reactive, span: trajectory.len().div_ceil(MAX_POINTS).max(1) };
    let data = json!({
        "title": summary.title(),
        "summary": summary,
        "first_day": spaces.episode.period.first().day_of_year(),
        "steps_per_hour": spaces.episode.steps_per_hour,
        "span": picture.span,
        "points": trajectory.len().div_ceil(picture.span),
        "panels": picture.panels(),
    });
    Ok(file.write_all(report::fill(PAGE, &data).as_bytes())?)
}

struct Picture<'a> {
    spaces: &'a Spaces,
    trajectory: &'a Trajectory,
    reactive: Option<&'a Trajectory>,
    /// Steps per point.
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
        let band = self.spaces.episode.task.comfort_band;
        let zones = |picture: &Self| {
            picture.zones(|conditioning| conditioning != Conditioning::None).collect::<Vec<_>>()
        };
        let series = self.with_reactive(zones);
        let target = self.spaces.observation.constant_target();
        let band = target.map(|target| [target - band, target + band]);
        Panel { title: "Zone air temperature".into(), unit: "°C", series, band }
    }

    /// Returns the targets that vary over time.
    fn targets(&self) -> Panel {
        let zones = self.spaces.building.zones.iter().enumerate();
        let controlled = zones.filter(|(_, zone)| zone.conditioning != Conditioning::None);
        let series = controlled.enumerate().filter_map(|(index, (number, zone))| {
            match self.spaces.observation.target(index) {
                Target::Slot(slot) => Some(self.slot(zone.name.clone(), number, slot, 1.0)),
                Target::Always(_) => None,
            }
        });
        Panel { title: "Target temperature".into(), unit: "°C", series: series.collect(), band: None }
    }

    /// Returns the temperatures of the outdoor air and of unconditioned zones, such as attics and plenums.
    fn outdoor(&self) -> Panel {
        let outdoor = self.spaces.observation.outdoor_temperature();
        let mut series =
            vec![self.slot("outdoor air".into(), self.spaces.building.zones.len(), outdoor, 1.0)];
        series.extend(self.zones(|conditioning| conditioning == Conditioning::None));
        Panel { title: "Outdoor air and unconditioned zones".into(), unit: "°C", series, band: None }
    }

    /// Returns the temperatures of the zones whose conditioning matches.
    fn zones(&self, matches: impl Fn(Conditioning) -> bool) -> impl Iterator<Item = Series> {
        let zones = self.spaces.building.zones.iter().enumerate();
        let slots = self.spaces.observation.zone_temperatures();
        zones
            .zip(slots)
            .filter(move |((_, zone), _)| matches(zone.conditioning))
            .map(|((number, zone), slot)| self.slot(zone.name.clone(), number, slot, 1.0))
    }

    fn power(&self) -> Panel {
        let space = &self.spaces.observation;
        let per_hour = f64::from(self.spaces.episode.steps_per_hour);
        let series = self.with_reactive(|picture| {
            vec![
                picture.slot("electricity".into(), 0, space.electricity(), per_hour),
                picture.slot("gas".into(), 1, space.gas(), per_hour),
            ]
        });
        Panel { title: "HVAC power".into(), unit: "W/m²", series, band: None }
    }

    fn actions(&self, quantity: Quantity, what: &str) -> Panel {
        let building = &self.spaces.building;
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

    /// Returns series, followed by the same series of the reactive controllers, dashed, if their trajectory is given.
    fn with_reactive(&self, series: impl Fn(&Self) -> Vec<Series>) -> Vec<Series> {
        let mut all = series(self);
        if let Some(trajectory) = self.reactive {
            let reactive = Self { trajectory, reactive: None, ..*self };
            let dashed =
                |each: Series| Series { name: format!("{}, reactive", each.name), dashed: true, ..each };
            all.extend(series(&reactive).into_iter().map(dashed));
        }
        all
    }

    /// Returns a slot of the observation, multiplied by a scale.
    fn slot(&self, name: String, color: usize, slot: usize, scale: f64) -> Series {
        self.series(name, color, self.trajectory.observed(slot).map(|value| value * scale).collect())
    }

    fn series(&self, name: String, color: usize, values: Vec<f64>) -> Series {
        let (low, high) = (minimum(&values), maximum(&values));
        let points = |of: fn(&[f64]) -> f64| encode(values.chunks(self.span).map(of), low, high);
        Series {
            name,
            color,
            dashed: false,
            low,
            high,
            mean: points(|span| span.iter().sum::<f64>() / span.len() as f64),
            extremes: (self.span > 1).then(|| [points(minimum), points(maximum)]),
        }
    }
}

fn minimum(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

fn maximum(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// Returns the index of the zone that an actuator belongs to; for an air loop, its first zone.
fn zone_of(building: &PreparedBuilding, owner: Owner) -> usize {
    match owner {
        Owner::Zone(zone) => zone,
        Owner::AirLoop(system) => building.layouts()[system].zones[0].index,
        Owner::Weather | Owner::Calendar | Owner::Energy => 0,
    }
}

/// Returns base64 of 16-bit numbers, 0 for `low` and 65535 for `high`.
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
    fn values_are_quantized_between_minimum_and_maximum() {
        let bytes = BASE64_STANDARD.decode(encode([1.0, 2.0, 3.0].into_iter(), 1.0, 3.0)).unwrap();
        assert_eq!(bytes, [0, 0, 0, 128, 255, 255]);
    }

    #[test]
    fn the_page_needs_no_network() {
        assert_eq!(PAGE.matches("{{DATA}}").count(), 1);
        for word in ["http://", "https://", "src=", "@import", "<link"] {
            assert!(!PAGE.contains(word), "{word}");
        }
    }
}
