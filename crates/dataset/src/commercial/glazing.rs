//! Glazing: U-factor and solar heat gain.

use std::collections::BTreeSet;

use b2b_building::construction::SIMPLE_GLAZING as GLAZING;
use b2b_building::model::text;
use b2b_building::opening::{FENESTRATION, is_glass, parent};
use b2b_building::zone::{self, Surface, SurfaceKind};
use b2b_building::{Error, Model, Result};
use serde_json::json;

/// Ratio of visible transmittance to solar heat gain coefficient: the minimum of the code (ASHRAE 90.1, 5.5.4.6), as in the
/// prototypes.
const LIGHT_TO_SOLAR_GAIN: f64 = 1.1;

/// Sets the U-factor (W/m²K) and the solar heat gain coefficient of every window and glass door in walls. Skylights have
/// separate requirements and are not changed.
pub(super) fn glaze(model: &mut Model, u: f64, shgc: f64) -> Result<()> {
    let surfaces = zone::surfaces(model)?;
    let in_walls = glazings(model, &surfaces, |kind| kind == SurfaceKind::Wall)?;
    let elsewhere = glazings(model, &surfaces, |kind| kind != SurfaceKind::Wall)?;
    if let Some(shared) = in_walls.intersection(&elsewhere).next() {
        return Err(Error::Unsupported {
            class: GLAZING.into(),
            name: shared.clone(),
            why: "windows and skylights share it; use separate glazings".into(),
        });
    }
    for name in &in_walls {
        let glazing = model.require_mut(GLAZING, name)?;
        glazing.insert("u_factor".into(), json!(u));
        glazing.insert("solar_heat_gain_coefficient".into(), json!(shgc));
        glazing.insert("visible_transmittance".into(), json!(LIGHT_TO_SOLAR_GAIN * shgc));
    }
    Ok(())
}

/// The glazing materials of the glass in surfaces of some kinds, in lower case.
fn glazings(
    model: &Model,
    surfaces: &[Surface],
    wanted: impl Fn(SurfaceKind) -> bool,
) -> Result<BTreeSet<String>> {
    let mut found = BTreeSet::new();
    for (_, fields) in model.objects(FENESTRATION).into_iter().filter(|(_, fields)| is_glass(fields)) {
        if parent(surfaces, fields).is_some_and(|surface| wanted(surface.kind)) {
            let construction = text(fields, "construction_name").unwrap_or_default();
            let glass = text(model.require("Construction", construction)?, "outside_layer");
            found.insert(glass.unwrap_or_default().to_lowercase());
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn model(skylight_glass: &str) -> Model {
        let corner =
            |x, y, z| json!({"vertex_x_coordinate": x, "vertex_y_coordinate": y, "vertex_z_coordinate": z});
        let surface = |kind| {
            json!({"surface_type": kind,
            "vertices": [corner(0, 0, 0), corner(1, 0, 0), corner(1, 0, 1)]})
        };
        let glass = |wall, construction| json!({"surface_type": "Window", "building_surface_name": wall, "construction_name": construction});
        let text = json!({
            "BuildingSurface:Detailed": {"Wall": surface("Wall"), "Roof": surface("Roof")},
            FENESTRATION: {"W": glass("WALL", "Window"), "S": glass("Roof", "Skylight")},
            "Construction": {"Window": {"outside_layer": "GLASS"}, "Skylight": {"outside_layer": skylight_glass}},
            GLAZING: {"Glass": {"u_factor": 2.0}, "Dome": {"u_factor": 3.0}},
        });
        Model::from_epjson(&text.to_string(), Path::new("test.epJSON")).unwrap()
    }

    #[test]
    fn windows_change_and_skylights_stay() {
        let mut model = model("Dome");
        glaze(&mut model, 1.5, 0.4).unwrap();
        let glass = model.get(GLAZING, "Glass").unwrap();
        assert_eq!((&glass["u_factor"], &glass["solar_heat_gain_coefficient"]), (&json!(1.5), &json!(0.4)));
        assert_eq!(model.get(GLAZING, "Dome").unwrap()["u_factor"], 3.0);
    }

    #[test]
    fn a_glazing_of_windows_and_skylights_is_rejected() {
        let error = glaze(&mut model("Glass"), 1.5, 0.4).unwrap_err();
        assert!(error.to_string().contains("`glass`"), "{error}");
    }
}
