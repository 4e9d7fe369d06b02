//! Design days of a weather file: the weather that equipment is sized for.

use b2b_climate::{DesignDay, Site};
use serde_json::{Value, json};

use crate::import::Notes;
use crate::model::{Fields, Model, number, text};
use crate::sizing::needs_sizing;

const CLASS: &str = "SizingPeriod:DesignDay";
/// Classes of periods that equipment can be sized for.
const PERIODS: [&str; 3] = [CLASS, "SizingPeriod:WeatherFileDays", "SizingPeriod:WeatherFileConditionType"];
/// Difference in design temperature above which a model's design days are for another climate, K.
const FAR: f64 = 5.0;

/// Replaces the periods that equipment is sized for with the design days of a weather file.
pub fn replace(model: &mut Model, site: &Site) {
    PERIODS.iter().for_each(|class| model.remove_class(class));
    model.insert(CLASS, "Heating 99.6 %", heating_day(site));
    model.insert(CLASS, "Cooling 0.4 %", cooling_day(site));
}

/// Replaces the design days of a user's model with a weather file's, unless it has some to `keep`, and notes which ones
/// it has.
pub fn of_imported(model: &mut Model, site: &Site, keep: bool, notes: &mut Notes) {
    if !needs_sizing(model) {
        notes.design_days = Some("none used: the model gives the sizes of its equipment".to_owned());
        if keep {
            notes.warnings.push(
                "--keep-design-days has no effect: the model gives the sizes of its equipment".to_owned(),
            );
        } else {
            replace(model, site);
        }
        return;
    }
    let of_site = format!("{:.1} and {:.1} °C", site.heating.dry_bulb, site.cooling.dry_bulb);
    let own = own_temperatures(model);
    let has_periods = PERIODS.iter().any(|class| !model.objects(class).is_empty());
    if keep && has_periods {
        notes.design_days = Some(match own {
            Some([cold, hot]) => {
                format!("the model's, {cold:.1} and {hot:.1} °C (the weather file has {of_site})")
            }
            None => "the sizing periods of the model".to_owned(),
        });
        let is_far = |[cold, hot]: [f64; 2]| {
            (cold - site.heating.dry_bulb).abs() > FAR || (hot - site.cooling.dry_bulb).abs() > FAR
        };
        if own.is_some_and(is_far) {
            notes.warnings.push(format!(
                "the model's design days are for another climate than the weather file's ({of_site}); \
                 leave out --keep-design-days to size its equipment for the weather"
            ));
        }
        return;
    }
    if keep {
        notes.warnings.push("the model has no design days to keep".to_owned());
    }
    replace(model, site);
    notes.design_days = Some(match own {
        Some([cold, hot]) => {
            format!("the weather file's, {of_site}, instead of the model's, {cold:.1} and {hot:.1} °C")
        }
        None => format!("the weather file's, {of_site}"),
    });
}

/// Returns the coldest and the hottest temperature of the design days of a model, °C; `None` unless it has both kinds.
fn own_temperatures(model: &Model) -> Option<[f64; 2]> {
    let days = model.objects(CLASS);
    let of = |kind: &str| {
        let is_kind =
            |fields: &Fields| text(fields, "day_type").is_some_and(|day| day.eq_ignore_ascii_case(kind));
        let days = days.iter().filter(|(_, fields)| is_kind(fields));
        days.filter_map(|(_, fields)| number(fields, "maximum_dry_bulb_temperature")).collect::<Vec<_>>()
    };
    let cold = of("WinterDesignDay").into_iter().reduce(f64::min)?;
    let hot = of("SummerDesignDay").into_iter().reduce(f64::max)?;
    Some([cold, hot])
}

/// The fields that both design days share.
fn design_day(site: &Site, day: &DesignDay, day_type: &str, wet_bulb: f64) -> Value {
    json!({
        "month": day.month,
        "day_of_month": 21,
        "day_type": day_type,
        "maximum_dry_bulb_temperature": day.dry_bulb,
        "daily_dry_bulb_temperature_range": day.daily_range,
        "dry_bulb_temperature_range_modifier_type": "DefaultMultipliers",
        "humidity_condition_type": "WetBulb",
        "wetbulb_or_dewpoint_at_maximum_dry_bulb": wet_bulb,
        "barometric_pressure": site.pressure(),
        "wind_speed": day.wind_speed.unwrap_or(0.0),
        "wind_direction": day.wind_direction.unwrap_or(0.0),
        "rain_indicator": "No",
        "snow_indicator": "No",
        "daylight_saving_time_indicator": "No",
    })
}

/// A saturated day without sun, as in the example models of the engine.
fn heating_day(site: &Site) -> Value {
    let mut day = design_day(site, &site.heating, "WinterDesignDay", site.heating.dry_bulb);
    day["solar_model_indicator"] = json!("ASHRAEClearSky");
    day["sky_clearness"] = json!(0.0);
    day
}

/// A clear day, with the optical depths of the sky if they are known.
fn cooling_day(site: &Site) -> Value {
    let cooling = &site.cooling;
    // Without a record: the dew point is near the night's lowest dry bulb, and the wet bulb about a third of the way
    // down to it.
    let wet_bulb = cooling.wet_bulb.unwrap_or(cooling.dry_bulb - cooling.daily_range / 3.0);
    let mut day = design_day(site, cooling, "SummerDesignDay", wet_bulb);
    match cooling.optical_depths {
        Some([beam, diffuse]) => {
            day["solar_model_indicator"] = json!("ASHRAETau");
            day["ashrae_clear_sky_optical_depth_for_beam_irradiance_taub_"] = json!(beam);
            day["ashrae_clear_sky_optical_depth_for_diffuse_irradiance_taud_"] = json!(diffuse);
        }
        None => {
            day["solar_model_indicator"] = json!("ASHRAEClearSky");
            day["sky_clearness"] = json!(1.0);
        }
    }
    day
}
