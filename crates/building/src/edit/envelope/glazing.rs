//! Glazing: U-factor and solar heat gain.

use std::collections::BTreeSet;

use serde_json::json;

use crate::construction::SIMPLE_GLAZING as GLAZING;
use crate::edit::Amount;
use crate::edit::copies::{copy, other_class, spelled, unused_name};
use crate::edit::geometry::WALL_WITHOUT_CORNERS;
use crate::model::{Fields, items, number, text};
use crate::opening::{FENESTRATION, is_glass, parent};
use crate::zone::{self, Surface};
use crate::{Error, Model, Result};

/// Ratio of visible transmittance to solar heat gain coefficient: the minimum of the code (ASHRAE 90.1, 5.5.4.6), as in
/// the prototypes.
const LIGHT_TO_SOLAR_GAIN: f64 = 1.1;
/// Maximum visible transmittance.
const MAX_TRANSMITTANCE: f64 = 0.99;
/// Classes of windows and glass doors other than [`FENESTRATION`].
const SIMPLE_GLASS: [&str; 2] = ["Window", "GlazedDoor"];

/// A window or a glass door.
struct Glass {
    class: &'static str,
    name: String,
    /// Its construction, in lower case.
    construction: String,
    is_in_wall: bool,
}

/// Sets the U-factor (W/m²K) and the solar heat gain coefficient, if given, of every window and glass door in exterior
/// walls. Returns the number of windows and glass doors.
///
/// Skylights and interior windows are not changed: glazing that they share is copied. A construction that is given layer
/// by layer is replaced by one with a `WindowMaterial:SimpleGlazingSystem`, for which both properties must be given.
///
/// # Errors
/// [`Error::Edit`] naming the construction that cannot be changed; [`Error::MissingObject`] for a dangling reference.
pub fn glaze(model: &mut Model, u: Option<Amount>, shgc: Option<f64>) -> Result<usize> {
    let glass = glass(model)?;
    let (in_walls, elsewhere): (Vec<_>, Vec<_>) = glass.into_iter().partition(|glass| glass.is_in_wall);
    let names = |glass: &[Glass]| -> BTreeSet<String> {
        glass.iter().map(|each| each.construction.clone()).collect()
    };
    let others = names(&elsewhere);
    let mut glazings = BTreeSet::new();
    for construction in names(&in_walls) {
        let own = if others.contains(&construction) {
            let wanted = format!("{} of walls", spelled(model, "Construction", &construction));
            let own = copy(model, "Construction", &construction, &wanted)?;
            assign(model, &in_walls, &construction, &own)?;
            own
        } else {
            construction.clone()
        };
        match simple_glazing(model, &own)? {
            Some(glazing) if is_glazing_of(model, &glazing, &others) => {
                let wanted = format!("{} of walls", spelled(model, GLAZING, &glazing));
                let copied = copy(model, GLAZING, &glazing, &wanted)?;
                model
                    .require_mut("Construction", &own)?
                    .insert("outside_layer".into(), copied.clone().into());
                glazings.insert(copied.to_lowercase());
            }
            Some(glazing) => {
                glazings.insert(glazing);
            }
            None => {
                refuse_shading(model, &in_walls, &construction)?;
                let new = replace_layers(model, &own, u, shgc)?;
                assign(model, &in_walls, &construction, &new)?;
            }
        }
    }
    for name in &glazings {
        set(model.require_mut(GLAZING, name)?, u, shgc);
    }
    Ok(in_walls.len())
}

/// Returns the number of windows and glass doors in walls.
///
/// # Errors
/// Same as [`zone::surfaces`].
pub(in crate::edit) fn count(model: &Model) -> Result<usize> {
    Ok(glass(model)?.iter().filter(|glass| glass.is_in_wall).count())
}

fn set(glazing: &mut Fields, u: Option<Amount>, shgc: Option<f64>) {
    if let Some(u) = u.and_then(|u| u.of(number(glazing, "u_factor"))) {
        glazing.insert("u_factor".into(), json!(u));
    }
    if let Some(shgc) = shgc {
        glazing.insert("solar_heat_gain_coefficient".into(), json!(shgc));
        let transmittance = (LIGHT_TO_SOLAR_GAIN * shgc).min(MAX_TRANSMITTANCE);
        glazing.insert("visible_transmittance".into(), json!(transmittance));
    }
}

/// The windows and glass doors of a model whose surface is known.
fn glass(model: &Model) -> Result<Vec<Glass>> {
    let surfaces = zone::surfaces(model)?;
    let mut found = Vec::new();
    for class in [FENESTRATION, SIMPLE_GLASS[0], SIMPLE_GLASS[1]] {
        for (name, fields) in model.objects(class) {
            if class == FENESTRATION && !is_glass(fields) {
                continue;
            }
            let Some(is_in_wall) = is_in_wall(model, &surfaces, fields) else { continue };
            let construction = text(fields, "construction_name").unwrap_or_default().to_lowercase();
            found.push(Glass { class, name: name.to_owned(), construction, is_in_wall });
        }
    }
    Ok(found)
}

fn is_in_wall(model: &Model, surfaces: &[Surface], fields: &Fields) -> Option<bool> {
    if let Some(surface) = parent(surfaces, fields) {
        return Some(surface.is_exterior_wall());
    }
    let name = text(fields, "building_surface_name")?;
    model.contains(WALL_WITHOUT_CORNERS, name).then_some(true)
}

/// Returns the glazing of a construction, in lower case; `None` if it is given layer by layer.
fn simple_glazing(model: &Model, construction: &str) -> Result<Option<String>> {
    // A window from a data file, or with complex fenestration.
    if other_class(model, construction).is_some() {
        return Ok(None);
    }
    let fields = model.require("Construction", construction)?;
    let glass = text(fields, "outside_layer").unwrap_or_default();
    Ok(model.contains(GLAZING, glass).then(|| glass.to_lowercase()))
}

/// Returns whether one of these constructions uses this glazing.
fn is_glazing_of(model: &Model, glazing: &str, constructions: &BTreeSet<String>) -> bool {
    let outside = |name: &String| text(model.get("Construction", name)?, "outside_layer").map(str::to_owned);
    constructions.iter().filter_map(outside).any(|layer| layer.eq_ignore_ascii_case(glazing))
}

/// Refuses windows in walls that have this construction and are shaded: shading is defined for its layers.
fn refuse_shading(model: &Model, glass: &[Glass], construction: &str) -> Result<()> {
    let Some(shaded) = glass.iter().find(|each| each.construction == construction && is_shaded(model, each))
    else {
        return Ok(());
    };
    let class = other_class(model, construction).unwrap_or("Construction");
    let why = format!("a WindowShadingControl shades its window `{}`; remove the shading first", shaded.name);
    Err(Error::edit(class, construction, &why))
}

/// Creates a construction with simple glazing instead of one that is given layer by layer, and returns its name.
fn replace_layers(
    model: &mut Model,
    construction: &str,
    u: Option<Amount>,
    shgc: Option<f64>,
) -> Result<String> {
    let class = other_class(model, construction).unwrap_or("Construction").to_owned();
    let (Some(Amount::Value(_)), Some(_)) = (u, shgc) else {
        let remedy = match u {
            Some(Amount::Times(_)) => {
                "give it a WindowMaterial:SimpleGlazingSystem first (`b2b edit --window-u … --window-shgc …`), or calibrate \
                 other parameters"
            }
            _ => "set window_u and window_shgc",
        };
        let why = "its glazing is given layer by layer, so its U-factor and solar heat gain are unknown";
        return Err(Error::edit(&class, construction, &format!("{why}; {remedy}")));
    };
    let name = spelled(model, &class, construction);
    let glazing = unused_name(model, "WindowMaterial", &format!("{name} Glazing"));
    let mut fields = Fields::new();
    set(&mut fields, u, shgc);
    model.insert(GLAZING, &glazing, fields.into());
    let new = unused_name(model, "Construction", &format!("{name} Simple"));
    model.insert("Construction", &new, json!({"outside_layer": glazing}));
    Ok(new)
}

fn is_shaded(model: &Model, glass: &Glass) -> bool {
    let controls = model.objects("WindowShadingControl");
    let mut shaded = controls.iter().flat_map(|(_, fields)| items(fields, "fenestration_surfaces"));
    shaded.any(|item| {
        text(item, "fenestration_surface_name").is_some_and(|name| name.eq_ignore_ascii_case(&glass.name))
    })
}

/// Assigns another construction to the glass that has this one.
fn assign(model: &mut Model, glass: &[Glass], from: &str, to: &str) -> Result<()> {
    for each in glass.iter().filter(|each| each.construction.eq_ignore_ascii_case(from)) {
        model.require_mut(each.class, &each.name)?.insert("construction_name".into(), to.into());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn model(skylight_glass: &str) -> Model {
        let corner =
            |x, y, z| json!({"vertex_x_coordinate": x, "vertex_y_coordinate": y, "vertex_z_coordinate": z});
        let surface = |kind| {
            json!({"surface_type": kind, "outside_boundary_condition": "Outdoors",
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

    fn glaze_to(model: &mut Model, u: f64, shgc: f64) -> Result<usize> {
        glaze(model, Some(Amount::Value(u)), Some(shgc))
    }

    /// The glazing of a window.
    fn glazing_of(model: &Model, window: &str) -> Fields {
        let construction = text(model.get(FENESTRATION, window).unwrap(), "construction_name").unwrap();
        let glass = text(model.get("Construction", construction).unwrap(), "outside_layer").unwrap();
        model.get(GLAZING, glass).unwrap().clone()
    }

    #[test]
    fn windows_change_and_skylights_stay() {
        let mut model = model("Dome");
        assert_eq!(glaze_to(&mut model, 1.5, 0.4).unwrap(), 1);
        let glass = model.get(GLAZING, "Glass").unwrap();
        assert_eq!((&glass["u_factor"], &glass["solar_heat_gain_coefficient"]), (&json!(1.5), &json!(0.4)));
        assert_eq!(model.get(GLAZING, "Dome").unwrap()["u_factor"], 3.0);
    }

    #[test]
    fn glazing_that_skylights_share_is_copied() {
        let mut of_material = model("Glass");
        let mut of_construction = model("Glass");
        let skylight = of_construction.require_mut(FENESTRATION, "S").unwrap();
        skylight.insert("construction_name".into(), json!("WINDOW"));
        for model in [&mut of_material, &mut of_construction] {
            glaze_to(model, 1.5, 0.4).unwrap();
            assert_eq!(glazing_of(model, "W")["u_factor"], 1.5);
            assert_eq!(glazing_of(model, "S")["u_factor"], 2.0);
        }
    }

    #[test]
    fn windows_between_rooms_keep_their_glazing() {
        let mut model = model("Dome");
        let mut between = model.get("BuildingSurface:Detailed", "Wall").unwrap().clone();
        between.insert("outside_boundary_condition".into(), json!("Surface"));
        model.insert("BuildingSurface:Detailed", "Partition", between.into());
        let inner = json!({"surface_type": "Window", "building_surface_name": "Partition", "construction_name": "Window"});
        model.insert(FENESTRATION, "I", inner);
        assert_eq!(glaze_to(&mut model, 1.5, 0.4).unwrap(), 1);
        assert_eq!(glazing_of(&model, "W")["u_factor"], 1.5);
        assert_eq!(glazing_of(&model, "I")["u_factor"], 2.0);
    }

    #[test]
    fn one_property_changes_alone_and_a_multiple_is_taken_once() {
        let mut model = model("Dome");
        let door = json!({"surface_type": "GlassDoor", "building_surface_name": "Wall", "construction_name": "Window"});
        model.insert(FENESTRATION, "D", door);
        assert_eq!(glaze(&mut model, Some(Amount::Times(1.5)), None).unwrap(), 2);
        let glass = model.get(GLAZING, "Glass").unwrap();
        assert_eq!((&glass["u_factor"], glass.get("visible_transmittance")), (&json!(3.0), None));
    }

    #[test]
    fn layered_glazing_is_replaced_if_both_properties_are_given() {
        let mut model = model("Dome");
        model.remove(GLAZING, "Glass");
        model.insert("WindowMaterial:Glazing", "Glass", json!({"thickness": 0.003}));
        let error = glaze(&mut model, Some(Amount::Value(1.5)), None).unwrap_err().to_string();
        assert!(error.contains("Construction `window`") && error.contains("window_shgc"), "{error}");
        let error = glaze(&mut model, Some(Amount::Times(1.5)), None).unwrap_err().to_string();
        assert!(error.contains("`b2b edit --window-u") && error.contains("other parameters"), "{error}");
        glaze_to(&mut model, 1.5, 0.4).unwrap();
        assert_eq!(glazing_of(&model, "W")["u_factor"], 1.5);
        assert_eq!(glazing_of(&model, "S")["u_factor"], 3.0);
    }

    #[test]
    fn a_shaded_layered_window_is_named() {
        let mut model = model("Dome");
        model.remove(GLAZING, "Glass");
        let control = json!({"fenestration_surfaces": [{"fenestration_surface_name": "w"}]});
        model.insert("WindowShadingControl", "Blind", control);
        let error = glaze_to(&mut model, 1.5, 0.4).unwrap_err().to_string();
        assert!(error.contains("`W`") && error.contains("remove the shading"), "{error}");
        // Also where a skylight has the same construction.
        model.require_mut(FENESTRATION, "S").unwrap().insert("construction_name".into(), json!("Window"));
        let error = glaze_to(&mut model, 1.5, 0.4).unwrap_err().to_string();
        assert!(error.contains("`W`") && error.contains("remove the shading"), "{error}");
    }
}
