//! Thermal properties of constructions: resistance of opaque layers, U-factor and solar heat gain of glazing.

use crate::Model;
use crate::Result;
use crate::model::{Fields, number, text};

/// Air films on both sides of a wall, m²K/W: 0.03 outside, 0.12 inside (ASHRAE 90.1, A9.4.1).
pub const WALL_FILMS: f64 = 0.15;
/// Air films on both sides of a roof, m²K/W: 0.03 outside, 0.11 inside (heat flowing up).
pub const ROOF_FILMS: f64 = 0.14;
/// Class of the insulation in the prototypes: a resistance without mass.
pub const INSULATION: &str = "Material:NoMass";
/// Class of glazing that is given by U-factor and solar heat gain coefficient only.
pub const SIMPLE_GLAZING: &str = "WindowMaterial:SimpleGlazingSystem";
/// Layers of a construction, outermost first.
pub(crate) const LAYERS: [&str; 10] = [
    "outside_layer",
    "layer_2",
    "layer_3",
    "layer_4",
    "layer_5",
    "layer_6",
    "layer_7",
    "layer_8",
    "layer_9",
    "layer_10",
];

/// Properties of a glazing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glazing {
    /// U-factor with air films, W/m²K.
    pub u: f64,
    /// Solar heat gain coefficient.
    pub shgc: f64,
}

/// Returns the layers of a construction, outermost first.
pub fn layers(construction: &Fields) -> impl Iterator<Item = &str> {
    LAYERS.iter().map_while(|layer| text(construction, layer))
}

/// Returns the insulation layer of a construction, in lower case.
///
/// # Errors
/// [`crate::Error::MissingObject`] when the model has no such construction.
pub fn insulation_of(model: &Model, construction: &str) -> Result<Option<String>> {
    let fields = model.require("Construction", construction)?;
    let insulation = layers(fields).find(|layer| model.contains(INSULATION, layer));
    Ok(insulation.map(str::to_lowercase))
}

/// Returns the resistance of a material, m²K/W; `None` if its class has none.
pub fn resistance(model: &Model, material: &str) -> Option<f64> {
    for class in [INSULATION, "Material:AirGap"] {
        if let Some(fields) = model.get(class, material) {
            return number(fields, "thermal_resistance");
        }
    }
    let fields = model.get("Material", material)?;
    Some(number(fields, "thickness")? / number(fields, "conductivity")?)
}

/// Returns the resistance of all layers of a construction without air films, m²K/W; `None` for a construction that is
/// not made of opaque layers, such as a window or a slab given by its F-factor.
pub fn assembly_resistance(model: &Model, construction: &str) -> Option<f64> {
    let mut layers = layers(model.get("Construction", construction)?).peekable();
    layers.peek()?;
    layers.map(|layer| resistance(model, layer)).sum()
}

/// Returns the glazing of a window construction; `None` if it is given layer by layer.
pub fn glazing(model: &Model, construction: &str) -> Option<Glazing> {
    let glass = text(model.get("Construction", construction)?, "outside_layer")?;
    let fields = model.get(SIMPLE_GLAZING, glass)?;
    Some(Glazing { u: number(fields, "u_factor")?, shgc: number(fields, "solar_heat_gain_coefficient")? })
}
