//! Relocation: site, design days, ground temperatures and mains water.

use b2b_building::{Model, design_days};
use b2b_climate::Site;
use serde_json::{Value, json};

use crate::ground_temperatures;

/// Moves the model to the site of a weather file. The engine reads latitude, longitude and elevation from the weather
/// file; the model has the same values for its readers.
pub(super) fn relocate(model: &mut Model, site: &Site) {
    replace(
        model,
        "Site:Location",
        &[(
            &site.name,
            json!({
                "latitude": site.latitude,
                "longitude": site.longitude,
                "time_zone": site.time_zone,
                "elevation": site.elevation,
            }),
        )],
    );
    design_days::replace(model, site);
    ground(model, site);
    replace(model, "Site:WaterMainsTemperature", &[("Mains Water", mains_water(site))]);
}

/// Replaces the objects of a class.
fn replace(model: &mut Model, class: &str, objects: &[(&str, Value)]) {
    model.remove_class(class);
    for (name, fields) in objects {
        model.insert(class, name, fields.clone());
    }
}

/// Ground temperatures at 2 m, for slabs on grade and other surfaces in ground contact.
fn ground(model: &mut Model, site: &Site) {
    for kind in ["FCfactorMethod", "BuildingSurface"] {
        let class = format!("Site:GroundTemperature:{kind}");
        if model.objects(&class).is_empty() {
            continue;
        }
        replace(model, &class, &[("Ground", ground_temperatures::monthly_fields(site))]);
    }
}

/// Mains water follows the annual mean and amplitude of the air (the engine's correlation of Christensen and Burch), or
/// of the ground if the file has no hours.
fn mains_water(site: &Site) -> Value {
    let months = site.monthly_dry_bulbs.unwrap_or(site.ground_temperatures);
    let (low, high) =
        months.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), t| (l.min(*t), h.max(*t)));
    json!({
        "calculation_method": "Correlation",
        "annual_average_outdoor_air_temperature": months.iter().sum::<f64>() / 12.0,
        "maximum_difference_in_monthly_average_outdoor_air_temperatures": high - low,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use b2b_building::model::{number, text};
    use b2b_climate::DesignDay;

    fn site() -> Site {
        let day = DesignDay {
            month: 7,
            dry_bulb: 33.2,
            daily_range: 6.6,
            wind_speed: Some(4.5),
            wind_direction: Some(140.0),
            wet_bulb: Some(25.3),
            optical_depths: Some([0.528, 1.905]),
        };
        let heating = DesignDay { month: 1, dry_bulb: 8.7, daily_range: 0.0, ..day };
        Site {
            name: "Miami Intl Ap".into(),
            latitude: 25.82,
            longitude: -80.3,
            time_zone: -5.0,
            elevation: 11.0,
            ground_temperatures: [24.0; 12],
            monthly_dry_bulbs: None,
            year: None,
            has_leap_day: false,
            skips_leap_day: false,
            has_daylight_saving: false,
            holidays: 0,
            heating,
            cooling: day,
            sized_by_hours: false,
        }
    }

    fn relocated(site: &Site) -> Model {
        let mut model = Model::default();
        model.insert("Site:Location", "Denver", json!({}));
        model.insert("SizingPeriod:DesignDay", "Denver Clg", json!({}));
        model.insert("Site:GroundTemperature:FCfactorMethod", "G", json!({}));
        relocate(&mut model, site);
        model
    }

    #[test]
    fn objects_of_the_old_site_are_removed() {
        let model = relocated(&site());
        assert_eq!(model.names("Site:Location"), ["Miami Intl Ap"]);
        assert_eq!(model.names("SizingPeriod:DesignDay"), ["Cooling 0.4 %", "Heating 99.6 %"]);
        let ground = model.get("Site:GroundTemperature:FCfactorMethod", "Ground").unwrap();
        assert_eq!(number(ground, "july_ground_temperature"), Some(24.0));
        assert!(model.names("Site:GroundTemperature:BuildingSurface").is_empty());
    }

    #[test]
    fn design_days_have_the_humidity_and_the_sky_of_the_station() {
        let model = relocated(&site());
        let day = model.get("SizingPeriod:DesignDay", "Cooling 0.4 %").unwrap();
        assert_eq!(number(day, "wetbulb_or_dewpoint_at_maximum_dry_bulb"), Some(25.3));
        assert_eq!(text(day, "solar_model_indicator"), Some("ASHRAETau"));
        assert!((number(day, "barometric_pressure").unwrap() - 101_193.0).abs() < 2.0);
        let night = model.get("SizingPeriod:DesignDay", "Heating 99.6 %").unwrap();
        assert_eq!(number(night, "sky_clearness"), Some(0.0));
    }

    #[test]
    fn a_station_without_records_has_a_clear_sky_and_a_likely_humidity() {
        let mut site = site();
        site.cooling = DesignDay { wet_bulb: None, optical_depths: None, ..site.cooling };
        let model = relocated(&site);
        let day = model.get("SizingPeriod:DesignDay", "Cooling 0.4 %").unwrap();
        assert_eq!(number(day, "sky_clearness"), Some(1.0));
        assert!((number(day, "wetbulb_or_dewpoint_at_maximum_dry_bulb").unwrap() - 31.0).abs() < 1e-9);
    }
}
