//! Description of a building: quantities computed from its model.
//!
//! The [`Description`] of a prepared building has its geometry ([`crate::shape`]), its envelope, its leakage
//! ([`leakage`]) and its systems ([`equipment`]). An unsized model has no capacities; a construction that is not
//! defined by layers has no U-factor.

pub mod equipment;
pub mod leakage;

use std::path::Path;

use b2b_climate::EpwFile;
use serde::Serialize;

pub use crate::hvac::Equipment;
pub use equipment::SystemDescription;
use leakage::Measures;

use crate::construction::{ROOF_FILMS, WALL_FILMS, assembly_resistance, glazing};
use crate::hvac::System;
use crate::shape::{Bound, Face, OutsideBoundary, Point, Shape};
use crate::zone::{Space, SurfaceKind, is_in_space};
use crate::{Conditioning, Model, PreparedBuilding, Result};

/// Edition of ASHRAE 90.1 that the commercial types follow.
const CODE_YEAR: u32 = 2019;

/// The description of a building: geometry, envelope and equipment.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Description {
    /// Name of the building.
    pub name: String,
    /// Its location.
    pub location: Location,
    /// Properties that the model does not contain.
    pub origin: Origin,
    /// Floor area of the conditioned zones, m², as in [`PreparedBuilding`]: zones under their own controls count.
    pub conditioned_floor_area: f64,
    /// Volume of the same zones, m³.
    pub conditioned_volume: f64,
    /// Size of the bounding box along the building's axes, m.
    pub size: Point,
    /// Angle from true north to the building's y axis, clockwise, degrees.
    pub north_axis: f64,
    /// Number of levels with a conditioned floor, including a heated basement.
    pub levels: usize,
    /// The envelope.
    pub envelope: Envelope,
    /// The zones, in model order.
    pub zones: Vec<ZoneDescription>,
    /// Pairs of adjacent zones.
    pub adjacency: Vec<Adjacency>,
    /// The systems, in the order of the action.
    pub systems: Vec<SystemDescription>,
}

/// The location of a building, from its weather file.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Location {
    /// Name of the station.
    pub station: String,
    /// Degrees north.
    pub latitude: f64,
    /// Degrees east.
    pub longitude: f64,
    /// Elevation above sea level, m.
    pub elevation: f64,
    /// Heating degree-days of the weather file below 18 °C, K·d.
    pub heating_degree_days: f64,
    /// Cooling degree-days of the weather file above 10 °C, K·d.
    pub cooling_degree_days: f64,
}

/// Properties of a generated building that its model does not contain; empty for an imported building.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Origin {
    /// ASHRAE 169 climate zone, for example `5B`.
    pub climate_zone: Option<String>,
    /// Year of construction, or of the building code.
    pub year: Option<u32>,
    /// Name of the construction period.
    pub vintage: Option<String>,
}

/// The envelope of the conditioned zones.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Envelope {
    /// Mean U-factor of the opaque exterior walls with the code's air films, W/m²K.
    pub wall_u: Option<f64>,
    /// Mean U-factor of the roofs with the code's air films, W/m²K; for an attic or a plenum the lower U-factor of its
    /// roof and the ceiling below.
    pub roof_u: Option<f64>,
    /// Mean U-factor of the glazing in exterior walls of all zones, W/m²K.
    pub window_u: Option<f64>,
    /// Mean solar heat gain coefficient of the glazing in exterior walls of all zones.
    pub window_shgc: Option<f64>,
    /// Window-to-wall ratio of the whole building, including plenum walls.
    pub window_to_wall: f64,
    /// Skylight-to-roof ratio of the conditioned zones.
    pub skylight_to_roof: f64,
    /// Leakage of the conditioned zones at [`leakage::TEMPERATURE_DIFFERENCE`] and [`leakage::WIND`] with its schedule
    /// at 1, air changes per hour.
    pub infiltration: f64,
}

/// A zone. Areas and volumes include the zone multiplier.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ZoneDescription {
    /// Name.
    pub name: String,
    /// Heating and cooling capability of its equipment.
    pub conditioning: Conditioning,
    /// Floor area, m².
    pub floor_area: f64,
    /// Volume, m³.
    pub volume: f64,
    /// Zone multiplier.
    pub multiplier: f64,
    /// Center of its bounding box relative to the building's: 0 at west, south and bottom before rotation, 1 at the
    /// other end.
    pub center: Point,
    /// Size of its bounding box relative to the building's.
    pub extent: Point,
    /// Area of exterior walls, including windows, m².
    pub exterior_wall_area: f64,
    /// Exterior walls as a fraction of all its walls.
    pub exterior_wall_fraction: f64,
    /// Area of roofs exposed to the outdoors, m².
    pub roof_area: f64,
    /// Area in ground contact as a fraction of all enclosing surfaces.
    pub ground_contact_fraction: f64,
    /// Glazing in exterior walls, m².
    pub window_area: f64,
    /// Glazing in roofs, m².
    pub skylight_area: f64,
    /// Window-to-wall ratio; 0 without exterior walls.
    pub window_to_wall: f64,
    /// Leakage as in [`Envelope::infiltration`], air changes per hour.
    pub infiltration: f64,
    /// Its equipment.
    pub equipment: Option<Equipment>,
}

/// Two adjacent zones.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Adjacency {
    /// Numbers of the zones, the lower first.
    pub zones: [usize; 2],
    /// Shared area, m².
    pub area: f64,
}

impl PreparedBuilding {
    /// Returns its geometry.
    ///
    /// # Errors
    /// The errors of [`Shape::of`].
    pub fn shape(&self) -> Result<Shape> {
        Shape::of(self.model())
    }

    /// Returns the U-factor of an opaque construction with the code's air films of a wall, or of the glazing of a
    /// window, W/m²K; `None` if neither layers nor a U-factor give it.
    pub fn construction_u(&self, construction: &str) -> Option<f64> {
        let model = self.model();
        glazing(model, construction).map(|glazing| glazing.u).or_else(|| u(model, construction, WALL_FILMS))
    }
}

impl Origin {
    /// Returns the origin of a commercial building, in a climate zone that may be unknown.
    pub fn commercial(climate_zone: Option<&str>) -> Self {
        Self { climate_zone: climate_zone.map(str::to_owned), year: Some(CODE_YEAR), vintage: None }
    }
}

impl Location {
    /// Reads the location of a weather file (EPW).
    ///
    /// # Errors
    /// The errors of [`b2b_climate::Site::read`].
    pub fn read(weather: &Path) -> Result<Self> {
        let file = EpwFile::open(weather)?;
        let (site, days) = (file.site()?, file.degree_days()?);
        Ok(Self {
            station: site.name,
            latitude: site.latitude,
            longitude: site.longitude,
            elevation: site.elevation,
            heating_degree_days: days.heating,
            cooling_degree_days: days.cooling,
        })
    }
}

impl Description {
    /// Describes a prepared building with its weather file (EPW).
    ///
    /// # Errors
    /// The errors of [`b2b_climate::Site::read`]; [`crate::Error::Unsupported`] for a surface that cannot be read;
    /// [`crate::Error::MissingObject`] for a dangling reference.
    pub fn of(building: &PreparedBuilding, weather: &Path, origin: Origin) -> Result<Self> {
        let conditioning: Vec<_> = building.zones.iter().map(|zone| zone.conditioning).collect();
        let location = Location::read(weather)?;
        let own: Vec<_> = building.zones.iter().map(|zone| zone.own_controls).collect();
        let (name, model) = (&building.name, building.model());
        Self::of_model(name, model, &conditioning, &own, &building.systems, location, origin)
    }

    /// Describes a model, sized or not, with the conditioning of its zones and whether they have controls of their own,
    /// in model order, and with its systems.
    ///
    /// # Errors
    /// The errors of [`Description::of`], apart from errors in the weather file.
    pub fn of_model(
        name: &str,
        model: &Model,
        conditioning: &[Conditioning],
        own_controls: &[bool],
        systems: &[Box<dyn System>],
        location: Location,
        origin: Origin,
    ) -> Result<Self> {
        let shape = Shape::of(model)?;
        let (systems, equipment) = equipment::describe(model, systems, &shape.zones)?;
        let [low, high] = shape.extent();
        let size = std::array::from_fn(|axis| high[axis] - low[axis]);
        let zones = crate::zone::zones(model)?;
        let zones = zones.into_iter().zip(conditioning).zip(equipment).enumerate();
        let zones = zones.map(|(number, ((zone, conditioning), equipment))| ZoneDescription {
            equipment,
            ..describe_zone(model, &shape, number, &zone, *conditioning)
        });
        let zones: Vec<_> = zones.collect();
        let is_conditioned = |zone: usize| {
            let is_served = zones.get(zone).is_some_and(|zone| zone.conditioning != Conditioning::None);
            is_served || own_controls.get(zone).is_some_and(|own| *own)
        };
        let total = |of: fn(&ZoneDescription) -> f64| -> f64 {
            let conditioned = zones.iter().enumerate().filter(|(zone, _)| is_conditioned(*zone));
            conditioned.map(|(_, zone)| of(zone)).sum()
        };
        let volume = total(|zone| zone.volume);
        let adjacency = shape.shared_areas().into_iter().map(|(zones, area)| Adjacency { zones, area });
        Ok(Self {
            name: name.to_owned(),
            location,
            origin,
            conditioned_floor_area: total(|zone| zone.floor_area),
            conditioned_volume: volume,
            size,
            north_axis: shape.north_axis,
            levels: shape.levels(is_conditioned),
            envelope: Envelope {
                infiltration: ratio(total(|zone| zone.infiltration * zone.volume), volume),
                ..envelope(model, &shape, is_conditioned, |zone| {
                    zones.get(zone).map_or(1.0, |zone| zone.multiplier)
                })
            },
            adjacency: adjacency.collect(),
            zones,
            systems,
        })
    }
}

/// A zone without its equipment.
fn describe_zone(
    model: &Model,
    shape: &Shape,
    number: usize,
    zone: &crate::zone::Zone,
    conditioning: Conditioning,
) -> ZoneDescription {
    let faces = shape.bounds(number);
    let area = |wanted: &dyn Fn(&Bound) -> bool| -> f64 {
        faces.iter().filter(|face| wanted(face)).map(Bound::area).fold(0.0, |sum, area| sum + area)
    };
    let is_outer = |face: &Bound| face.outside_boundary == OutsideBoundary::Outdoors;
    let is_wall = |face: &Bound| face.kind == SurfaceKind::Wall;
    let exterior_walls = area(&|face| is_outer(face) && is_wall(face));
    let glass = |kind: SurfaceKind| -> f64 {
        let outer = faces.iter().filter(|face| is_outer(face) && face.kind == kind);
        outer.map(|face| face.face.glass_area()).fold(0.0, |sum, area| sum + area)
    };
    let windows = glass(SurfaceKind::Wall);
    let volume = shape.volume(number);
    let measures = |space: Option<&Space>| {
        let is_own =
            |face: &Bound| space.is_none_or(|space| is_in_space(model, &face.face.name, &space.name));
        let (floor, volume) = match space {
            None => (zone.floor_area, volume),
            // As high as the zone unless it has a volume.
            Some(Space { floor_area, volume: own, .. }) => {
                (*floor_area, own.unwrap_or_else(|| volume * ratio(*floor_area, zone.floor_area)))
            }
        };
        Measures {
            floor,
            exterior: area(&|face| is_outer(face) && is_own(face)),
            exterior_walls: area(&|face| is_outer(face) && is_wall(face) && is_own(face)),
            volume,
        }
    };
    let [low, high] = shape.extent();
    let [zone_low, zone_high] = shape.zone_extent(number);
    let share = |axis: usize, length: f64| ratio(length, high[axis] - low[axis]);
    ZoneDescription {
        name: zone.name.clone(),
        conditioning,
        // The sum over no floors is -0.
        floor_area: zone.floor_area.max(0.0) * zone.multiplier,
        volume: volume * zone.multiplier,
        multiplier: zone.multiplier,
        center: std::array::from_fn(|a| share(a, (zone_low[a] + zone_high[a]) / 2.0 - low[a])),
        extent: std::array::from_fn(|a| share(a, zone_high[a] - zone_low[a])),
        exterior_wall_area: exterior_walls * zone.multiplier,
        exterior_wall_fraction: ratio(exterior_walls, area(&is_wall)),
        roof_area: area(&|face| is_outer(face) && face.kind == SurfaceKind::Roof) * zone.multiplier,
        ground_contact_fraction: ratio(
            area(&|face| face.outside_boundary == OutsideBoundary::Ground),
            area(&|_| true),
        ),
        window_area: windows * zone.multiplier,
        skylight_area: glass(SurfaceKind::Roof) * zone.multiplier,
        window_to_wall: ratio(windows, exterior_walls),
        infiltration: ratio(3600.0 * leakage::flow(model, zone, measures), volume),
        equipment: None,
    }
}

/// The envelope without its leakage. `times` is the multiplier of a zone.
fn envelope(
    model: &Model,
    shape: &Shape,
    is_conditioned: impl Fn(usize) -> bool,
    times: impl Fn(usize) -> f64,
) -> Envelope {
    let (mut walls, mut roofs) = (Mean::default(), Mean::default());
    let (mut window_u, mut window_shgc) = (Mean::default(), Mean::default());
    let (mut gross_walls, mut glass_in_walls, mut gross_roofs, mut skylights) = (0.0, 0.0, 0.0, 0.0);
    for face in shape.faces.iter().filter(|face| face.outside_boundary == OutsideBoundary::Outdoors) {
        let times = times(face.zone);
        let [area, glass, openings] = [face.area(), face.glass_area(), openings(face)].map(|own| times * own);
        match face.kind {
            SurfaceKind::Wall => {
                gross_walls += area;
                glass_in_walls += glass;
                if is_conditioned(face.zone) {
                    walls.add(u(model, &face.construction, WALL_FILMS), area - openings);
                }
                for window in face.openings.iter().filter(|opening| opening.is_glass) {
                    let glazing = glazing(model, &window.construction);
                    window_u.add(glazing.map(|g| g.u), times * window.area());
                    window_shgc.add(glazing.map(|g| g.shgc), times * window.area());
                }
            }
            SurfaceKind::Roof if is_conditioned(face.zone) => {
                gross_roofs += area;
                skylights += glass;
                roofs.add(u(model, &face.construction, ROOF_FILMS), area - openings);
            }
            SurfaceKind::Roof => {
                let (u, area) = better_of_roof_and_ceilings(model, shape, face, &is_conditioned);
                roofs.add(u, times * area);
            }
            SurfaceKind::Floor | SurfaceKind::Ceiling => {}
        }
    }
    Envelope {
        wall_u: walls.value(),
        roof_u: roofs.value(),
        window_u: window_u.value(),
        window_shgc: window_shgc.value(),
        window_to_wall: ratio(glass_in_walls, gross_walls),
        skylight_to_roof: ratio(skylights, gross_roofs),
        infiltration: 0.0,
    }
}

/// U-factor and area of the insulation above conditioned zones under an unconditioned one: its roof, or the ceilings
/// below. No area if there are no conditioned zones below.
fn better_of_roof_and_ceilings(
    model: &Model,
    shape: &Shape,
    roof: &Face,
    is_conditioned: impl Fn(usize) -> bool,
) -> (Option<f64>, f64) {
    let below = shape.bounds(roof.zone).into_iter().filter(|bound| {
        bound.kind == SurfaceKind::Floor
            && matches!(bound.outside_boundary, OutsideBoundary::Zone(zone) if is_conditioned(zone))
    });
    let mut ceilings = Mean::default();
    below.for_each(|bound| ceilings.add(u(model, &bound.face.construction, ROOF_FILMS), bound.area()));
    let roof_u = u(model, &roof.construction, ROOF_FILMS);
    match (roof_u, ceilings.value()) {
        _ if ceilings.area == 0.0 => (None, 0.0),
        (Some(roof_u), Some(ceiling_u)) => (Some(roof_u.min(ceiling_u)), roof.area()),
        (roof_u, ceiling_u) => (roof_u.or(ceiling_u), roof.area()),
    }
}

fn u(model: &Model, construction: &str, films: f64) -> Option<f64> {
    Some(1.0 / (assembly_resistance(model, construction)? + films))
}

fn openings(face: &Face) -> f64 {
    face.openings.iter().map(crate::opening::Opening::area).sum()
}

/// A ratio; 0 if `whole` is 0.
fn ratio(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part.max(0.0) / whole } else { 0.0 }
}

/// An area-weighted mean; unknown if any value is.
#[derive(Default)]
struct Mean {
    sum: f64,
    area: f64,
    is_unknown: bool,
}

impl Mean {
    fn add(&mut self, value: Option<f64>, area: f64) {
        let area = area.max(0.0);
        self.area += area;
        match value {
            Some(value) => self.sum += value * area,
            None => self.is_unknown |= area > 0.0,
        }
    }

    fn value(&self) -> Option<f64> {
        (self.area > 0.0 && !self.is_unknown).then(|| self.sum / self.area)
    }
}
