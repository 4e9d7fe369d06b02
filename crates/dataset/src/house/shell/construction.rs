//! Layers, constructions and air films.
//!
//! Effective resistances include films, as in NBC 9.36. Layers with mass are written as they are; one massless layer
//! provides the rest.

use b2b_building::Model;
use serde_json::json;

/// Film of a wall's outside, m²K/W (ASHRAE Fundamentals, winter wind).
pub(crate) const FILM_OUTSIDE: f64 = 0.03;
/// Film of a wall's inside, m²K/W (ASHRAE Fundamentals, still air, horizontal flow).
pub(crate) const FILM_WALL: f64 = 0.12;
/// Film of each side of the attic floor, m²K/W (ASHRAE Fundamentals, still air, upward flow).
pub(crate) const FILM_CEILING: f64 = 0.11;
/// Minimum resistance of a massless layer in EnergyPlus, m²K/W.
const MIN_RESISTANCE: f64 = 0.01;

/// A layer with mass: name, thickness m, conductivity W/m·K, density kg/m³, specific heat J/kg·K, roughness, solar
/// absorptance. Properties: ASHRAE Fundamentals, chapter 26.
pub(crate) struct Layer(&'static str, f64, f64, f64, f64, &'static str, f64);

pub(crate) const SIDING: Layer = Layer("Siding", 0.0127, 0.094, 540.0, 1210.0, "MediumSmooth", 0.6);
pub(crate) const SHEATHING: Layer = Layer("Sheathing", 0.0127, 0.12, 540.0, 1210.0, "MediumSmooth", 0.7);
pub(crate) const SHINGLES: Layer = Layer("Shingles", 0.006, 0.081, 1120.0, 1260.0, "VeryRough", 0.9);
pub(crate) const GYPSUM: Layer = Layer("Gypsum", 0.0127, 0.16, 800.0, 1090.0, "Smooth", 0.5);
pub(crate) const CONCRETE: Layer = Layer("Concrete", 0.2, 1.73, 2240.0, 900.0, "Rough", 0.65);

impl Layer {
    pub(crate) fn resistance(&self) -> f64 {
        self.1 / self.2
    }

    pub(crate) fn add(&self, model: &mut Model) {
        let material = json!({
            "thickness": self.1,
            "conductivity": self.2,
            "density": self.3,
            "specific_heat": self.4,
            "roughness": self.5,
            "solar_absorptance": self.6,
        });
        model.insert("Material", self.0, material);
    }
}

pub(crate) fn insulation(model: &mut Model, name: &str, resistance: f64) {
    let material = json!({
        "roughness": "MediumRough",
        "thermal_resistance": resistance.max(MIN_RESISTANCE),
    });
    model.insert("Material:NoMass", name, material);
}

/// A construction, its layers from outside to inside.
pub(crate) fn construction(model: &mut Model, name: &str, layers: &[&str]) {
    let mut fields = json!({"outside_layer": layers[0]});
    for (index, layer) in layers.iter().enumerate().skip(1) {
        fields[format!("layer_{}", index + 1)] = json!(layer);
    }
    model.insert("Construction", name, fields);
}
