//! Windows and doors (`FenestrationSurface:Detailed`).

use crate::model::{Fields, Model, number, text};
use crate::zone::{Surface, polygon_area};

/// Class of windows and doors that are given by their corners.
pub const FENESTRATION: &str = "FenestrationSurface:Detailed";

/// Kind of a fenestration surface that is a door of glass.
const GLASS_DOOR: &str = "GlassDoor";

/// A window or a door in a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Opening {
    /// Name.
    pub name: String,
    /// Name of the surface it is in.
    pub surface: String,
    /// Whether it is glass: a window or a glass door.
    pub is_glass: bool,
    /// Name of its construction.
    pub construction: String,
    /// Corners, m, in the coordinates of its surface.
    pub corners: Vec<[f64; 3]>,
    /// Multiplier.
    pub multiplier: f64,
}

impl Opening {
    /// Area with multiplier, m², without frame.
    pub fn area(&self) -> f64 {
        polygon_area(&self.corners) * self.multiplier
    }
}

/// Returns the windows and doors of a model, in model order.
pub fn openings(model: &Model) -> Vec<Opening> {
    let opening = |(name, fields): (&str, &Fields)| {
        let part = |field: &str| text(fields, field).unwrap_or_default().to_owned();
        Opening {
            name: name.to_owned(),
            surface: part("building_surface_name"),
            is_glass: is_glass(fields),
            construction: part("construction_name"),
            corners: corners(fields),
            multiplier: number(fields, "multiplier").unwrap_or(1.0),
        }
    };
    model.objects(FENESTRATION).into_iter().map(opening).collect()
}

/// Returns whether a fenestration surface is glass.
pub fn is_glass(fenestration: &Fields) -> bool {
    ["Window", GLASS_DOOR].iter().any(|kind| is_of_kind(fenestration, kind))
}

/// Returns whether a fenestration surface is a glass door.
pub fn is_glass_door(fenestration: &Fields) -> bool {
    is_of_kind(fenestration, GLASS_DOOR)
}

/// The engine reads choices in any case.
fn is_of_kind(fenestration: &Fields, kind: &str) -> bool {
    text(fenestration, "surface_type").is_some_and(|own| own.eq_ignore_ascii_case(kind))
}

/// Returns the corners of a detailed fenestration surface.
pub fn corners(fields: &Fields) -> Vec<[f64; 3]> {
    let axis = |corner: usize, axis| number(fields, &format!("vertex_{corner}_{axis}_coordinate"));
    (1..=4).map_while(|i| Some([axis(i, "x")?, axis(i, "y")?, axis(i, "z")?])).collect()
}

/// Returns the surface that contains a fenestration surface.
pub fn parent<'a>(surfaces: &'a [Surface], fenestration: &Fields) -> Option<&'a Surface> {
    let name = text(fenestration, "building_surface_name")?;
    surfaces.iter().find(|surface| surface.name.eq_ignore_ascii_case(name))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn kinds_are_read_in_any_case() {
        let mut model = Model::default();
        for (number, kind) in ["window", "GLASSDOOR", "Door"].into_iter().enumerate() {
            model.insert(FENESTRATION, &number.to_string(), json!({"surface_type": kind}));
        }
        let kinds =
            model.objects(FENESTRATION).into_iter().map(|(_, own)| [is_glass(own), is_glass_door(own)]);
        assert_eq!(kinds.collect::<Vec<_>>(), [[true, false], [true, true], [false, false]]);
    }
}
