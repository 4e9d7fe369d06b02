//! The hours of a morphed year.

use super::header::Location;
use super::months::{DAYS, HOURS, Target, held_under, months, range, scaled, spread, trend};
use super::sky::{at_elevation, clearness, humidity, sky_radiation, split, suns, with_total};
use crate::epw::column;
use crate::station::{MonthNormals, Station};
use crate::sun;

/// The morphed columns of a year, and the original lines for the others.
pub(super) struct Year<'a> {
    lines: Vec<&'a str>,
    pub(super) dry_bulb: Vec<f64>,
    dew_point: Vec<f64>,
    pressure: Vec<f64>,
    global: Vec<f64>,
    wind: Vec<f64>,
    /// Opaque sky cover, tenths.
    cover: Vec<f64>,
    /// The sun over each hour.
    sun: Vec<sun::Sun>,
}

impl<'a> Year<'a> {
    pub(super) fn read(lines: impl Iterator<Item = &'a str>) -> Self {
        let lines: Vec<&str> = lines.collect();
        let values = |column: usize| {
            // `Record::of` has checked these columns.
            let value = |line: &&str| line.split(',').nth(column).and_then(|v| v.trim().parse().ok());
            lines.iter().map(|line| value(line).unwrap_or_default()).collect()
        };
        Self {
            dry_bulb: values(column::DRY_BULB),
            dew_point: values(column::DEW_POINT),
            pressure: values(column::PRESSURE),
            global: values(column::GLOBAL),
            wind: values(column::WIND),
            cover: values(column::COVER),
            sun: Vec::new(),
            lines,
        }
    }

    pub(super) fn moved_to(&self, station: &Station, from: Location) -> Self {
        let mut dry_bulb = Vec::with_capacity(HOURS);
        let mut dew_point = Vec::with_capacity(HOURS);
        let mut wind = Vec::with_capacity(HOURS);
        let (dry_bulb_trend, dew_point_trend) = (trend(&self.dry_bulb), trend(&self.dew_point));
        for (month, hours) in months().enumerate() {
            let normals = &station.months[month];
            let own = &self.dry_bulb[hours.clone()];
            let target =
                Target { mean: normals.dry_bulb, spread: normals.daily_spread, range: normals.daily_range };
            let stretch = target.spread / spread(own);
            dry_bulb.extend(target.reached_by(own, &dry_bulb_trend[hours.clone()]));
            let own = &self.dew_point[hours.clone()];
            let target = Target { mean: normals.dew_point, spread: stretch * spread(own), range: range(own) };
            let dew = target.reached_by(own, &dew_point_trend[hours.clone()]);
            dew_point.extend(held_under(dew, &dry_bulb[hours.clone()], normals.dew_point));
            wind.extend(scaled(&self.wind[hours], normals.wind_speed));
        }
        let to = sun::Position { latitude: station.latitude, longitude: station.longitude, ..from.sun };
        let sun = suns(to);
        Self {
            global: self.sun_under(&suns(from.sun), &sun, &station.months),
            pressure: at_elevation(&self.pressure, from.elevation, station.elevation),
            cover: self.cover.clone(),
            lines: self.lines.clone(),
            dry_bulb,
            dew_point,
            wind,
            sun,
        }
    }

    /// Global horizontal irradiation of each hour: its clearness under another sun path, scaled to the monthly totals.
    fn sun_under(&self, from: &[sun::Sun], to: &[sun::Sun], normals: &[MonthNormals; 12]) -> Vec<f64> {
        let mut global = Vec::with_capacity(HOURS);
        for (month, hours) in months().enumerate() {
            let clearness = clearness(&self.global[hours.clone()], &from[hours.clone()]);
            let target = normals[month].global_horizontal * DAYS[month] as f64;
            global.extend(with_total(&clearness, &to[hours], target));
        }
        global
    }

    pub(super) fn write(&self, text: &mut String) {
        for (hour, line) in self.lines.iter().enumerate() {
            let mut values: Vec<String> = line.split(',').map(str::to_owned).collect();
            self.overwrite(hour, &mut values);
            text.push_str(&values.join(","));
            text.push('\n');
        }
    }

    fn overwrite(&self, hour: usize, values: &mut [String]) {
        let (dry_bulb, dew_point) = (self.dry_bulb[hour], self.dew_point[hour]);
        let sun = self.sun[hour];
        let global = self.global[hour];
        let (beam, diffuse) = split(global, sun);
        for (column, value) in [
            (column::DRY_BULB, dry_bulb),
            (column::DEW_POINT, dew_point),
            (column::EXTRATERRESTRIAL_HORIZONTAL, sun.horizontal()),
            (column::EXTRATERRESTRIAL_NORMAL, if sun.cosine > 0.0 { sun.extraterrestrial } else { 0.0 }),
            (column::INFRARED, sky_radiation(dry_bulb, dew_point, self.cover[hour])),
            (column::GLOBAL, global),
            (column::BEAM, beam),
            (column::DIFFUSE, diffuse),
            (column::WIND, self.wind[hour]),
        ] {
            values[column] = format!("{value:.1}");
        }
        values[column::HUMIDITY] = format!("{:.0}", humidity(dry_bulb, dew_point));
        values[column::PRESSURE] = format!("{:.0}", self.pressure[hour]);
        // Marked as missing: EnergyPlus does not use them.
        for column in column::ILLUMINANCE {
            values[column] = "999999".into();
        }
        values[column::ZENITH_LUMINANCE] = "9999".into();
    }
}
