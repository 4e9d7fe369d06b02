//! Outdoor air requirements of systems: their design minimum, and the damper of a unit that provides it.
//!
//! The design minimum of a system is the larger of the minimum flow of its `Controller:OutdoorAir` and, under a
//! `Controller:MechanicalVentilation`, the sum of its zones' requirements at design occupancy
//! (`DesignSpecification:OutdoorAir`; ASHRAE 62.1, equation 6-1, with a zone air distribution effectiveness of 1 and
//! without the correction for multiple zones). Specifications may be given by space.

use serde::{Deserialize, Serialize};
use serde_json::json;

use super::actuator::EngineVariable;
use super::schedules::constant_schedule;
use crate::Result;
use crate::model::{Fields, Model, items, number, text};
use crate::people::{self, PeopleGroup};
use crate::shape::Shape;
use crate::zone::{self, Zone, covers_zone};

const CONTROLLER: &str = "Controller:OutdoorAir";
const MECHANICAL: &str = "Controller:MechanicalVentilation";
const SPECIFICATION: &str = "DesignSpecification:OutdoorAir";
const SPECIFICATIONS_OF_SPACES: &str = "DesignSpecification:OutdoorAir:SpaceList";
const MINIMUM_SCHEDULE: &str = "minimum_outdoor_air_schedule_name";

/// Outdoor air per person where a specification has none, m³/s: the engine's default.
const PER_PERSON: f64 = 0.00944;

/// Outdoor air of a system.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ventilation {
    /// Design minimum of the outdoor air flow, kg/s.
    pub min_outdoor_air: f64,
    /// The damper that opens to the design minimum; `None` where outdoor air is an actuator or left to the model.
    pub damper: Option<MinimumDamper>,
    /// The engine's outdoor air mass flow, kg/s.
    pub outdoor_air: EngineVariable,
}

/// A damper of a unit that is open to the design minimum of outdoor air (1) or closed (0), apart from an economizer: a
/// schedule of the model, which an actuator of the engine may override.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MinimumDamper {
    /// Engine actuator: component type, for example `Schedule:Compact`.
    pub component: String,
    /// Engine actuator: control type.
    pub control: String,
    /// Engine actuator: object name.
    pub key: String,
}

impl Ventilation {
    /// Reads the design minimum of an outdoor air controller. The model must be hard-sized.
    pub(super) fn of(model: &Model, controller: &str, air_density: f64) -> Result<Self> {
        let fields = model.require(CONTROLLER, controller)?;
        let node = text(fields, "actuator_node_name").unwrap_or_default();
        let own = number(fields, "minimum_outdoor_air_flow_rate").unwrap_or(0.0);
        let mechanical = match text(fields, "mechanical_ventilation_controller_name") {
            Some(name) => zone_requirements(model, name)?,
            None => 0.0,
        };
        Ok(Self {
            min_outdoor_air: own.max(mechanical) * air_density,
            damper: None,
            outdoor_air: EngineVariable::new("System Node Mass Flow Rate", node),
        })
    }

    /// Gives the controller of a unit a schedule of its own for the minimum flow, with the values that it has in the
    /// model. The minimum becomes a flow rather than a fraction of the supply air.
    pub(super) fn with_damper(self, model: &mut Model, controller: &str) -> Result<Self> {
        let fields = model.require(CONTROLLER, controller)?;
        let shared = text(fields, MINIMUM_SCHEDULE).map(str::to_owned);
        let own = format!("{controller} Minimum Damper");
        let component = match shared.and_then(|name| find_schedule(model, &name)) {
            Some((class, fields)) => {
                model.insert(&class, &own, fields.into());
                class
            }
            None => {
                constant_schedule(model, &own, 1.0);
                "Schedule:Constant".to_owned()
            }
        };
        let fields = model.require_mut(CONTROLLER, controller)?;
        fields.insert(MINIMUM_SCHEDULE.into(), json!(own));
        fields.insert("minimum_limit_type".into(), json!("FixedMinimum"));
        let damper = MinimumDamper { component, control: "Schedule Value".to_owned(), key: own };
        Ok(Self { damper: Some(damper), ..self })
    }
}

/// Returns the class and the fields of a schedule that an actuator can override.
fn find_schedule(model: &Model, name: &str) -> Option<(String, Fields)> {
    const CLASSES: [&str; 4] = ["Schedule:Compact", "Schedule:Constant", "Schedule:Year", "Schedule:File"];
    CLASSES.iter().find_map(|class| Some(((*class).to_owned(), model.get(class, name)?.clone())))
}

/// Returns the sum of the design requirements of the zones under a mechanical ventilation controller, m³/s.
fn zone_requirements(model: &Model, controller: &str) -> Result<f64> {
    let zones = zone::zones(model)?;
    let shape = Shape::of(model)?;
    let people = people::groups(model)?;
    let mut sum = 0.0;
    for item in items(model.require(MECHANICAL, controller)?, "zone_specifications") {
        let listed = text(item, "zone_or_zonelist_name").unwrap_or_default();
        let covered = zones.iter().enumerate().filter(|(_, zone)| covers_zone(model, listed, &zone.name));
        for (number, zone) in covered {
            let specified = text(item, "design_specification_outdoor_air_object_name");
            if let Some(name) = specified.or_else(|| sizing_specification(model, &zone.name)) {
                sum += zone_requirement(model, name, zone, shape.volume(number), &people)? * zone.multiplier;
            }
        }
    }
    Ok(sum)
}

/// Returns the outdoor air that a specification, or one for each space, requires for a zone at design occupancy, m³/s.
fn zone_requirement(
    model: &Model,
    specification: &str,
    zone: &Zone,
    volume: f64,
    people: &[PeopleGroup],
) -> Result<f64> {
    let people = |space: Option<&str>| -> f64 {
        let of_space = |group: &&PeopleGroup| space.is_none() || group.space.as_deref() == space;
        let groups = people.iter().filter(|group| group.zone == zone.name).filter(of_space);
        groups.map(|group| group.people).sum()
    };
    let Some(by_space) = model.get(SPECIFICATIONS_OF_SPACES, specification) else {
        let whole = Room { floor_area: zone.floor_area, volume, people: people(None) };
        return Ok(requirement(model.require(SPECIFICATION, specification)?, whole));
    };
    let spaces = zone::spaces(model, &zone.name);
    let mut sum = 0.0;
    for item in items(by_space, "space_specs") {
        let named = text(item, "space_name").unwrap_or_default();
        let Some(space) = spaces.iter().find(|space| space.name.eq_ignore_ascii_case(named)) else {
            continue;
        };
        let name = text(item, "space_design_specification_outdoor_air_object_name").unwrap_or_default();
        let room = Room {
            floor_area: space.floor_area,
            volume: volume * space.floor_area / zone.floor_area,
            people: people(Some(&space.name)),
        };
        sum += requirement(model.require(SPECIFICATION, name)?, room);
    }
    Ok(sum)
}

/// Returns the specification that the sizing of a zone names.
fn sizing_specification<'a>(model: &'a Model, zone: &str) -> Option<&'a str> {
    let sizing = model.objects("Sizing:Zone").into_iter();
    let of_zone = |fields: &&Fields| {
        covers_zone(model, text(fields, "zone_or_zonelist_name").unwrap_or_default(), zone)
    };
    let mut of_zone = sizing.map(|(_, fields)| fields).filter(of_zone);
    text(of_zone.next()?, "design_specification_outdoor_air_object_name")
}

/// A zone or a space.
struct Room {
    /// Floor area, m².
    floor_area: f64,
    /// Volume, m³; a space's is its share of the zone by floor area, as in the engine.
    volume: f64,
    /// People at design occupancy.
    people: f64,
}

/// Returns the outdoor air that a specification requires for a room, m³/s.
fn requirement(specification: &Fields, room: Room) -> f64 {
    let value = |field: &str, default: f64| number(specification, field).unwrap_or(default);
    let per_person = || value("outdoor_air_flow_per_person", PER_PERSON) * room.people;
    let per_area = || value("outdoor_air_flow_per_zone_floor_area", 0.0) * room.floor_area;
    let per_zone = || value("outdoor_air_flow_per_zone", 0.0);
    let air_changes = || value("outdoor_air_flow_air_changes_per_hour", 0.0) * room.volume / 3600.0;
    match text(specification, "outdoor_air_method").unwrap_or("Flow/Person").to_lowercase().as_str() {
        "flow/area" => per_area(),
        "flow/zone" => per_zone(),
        "airchanges/hour" => air_changes(),
        "sum" => per_person() + per_area() + per_zone() + air_changes(),
        "maximum" => per_person().max(per_area()).max(per_zone()).max(air_changes()),
        // Other methods depend on contaminants or schedules; per person is the engine's default.
        _ => per_person(),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use serde_json::{Value, json};

    use super::*;

    fn model(specification: Value) -> Model {
        let text = json!({
            "Zone": {"Hall": {"floor_area": 100.0}, "Shop": {"floor_area": 50.0, "multiplier": 2}},
            "ZoneList": {"All": {"zones": [{"zone_name": "Hall"}, {"zone_name": "Shop"}]}},
            "People": {
                "Crowd": {"zone_or_zonelist_or_space_or_spacelist_name": "hall",
                    "number_of_people_calculation_method": "People/Area", "people_per_floor_area": 0.1},
                "Staff": {"zone_or_zonelist_or_space_or_spacelist_name": "Shop", "number_of_people": 4},
            },
            "DesignSpecification:OutdoorAir": {"Fresh": specification},
            "Controller:MechanicalVentilation": {"DCV": {"zone_specifications": [
                {"zone_or_zonelist_name": "All", "design_specification_outdoor_air_object_name": "Fresh"},
            ]}},
            "Controller:OutdoorAir": {"OA": {
                "minimum_outdoor_air_flow_rate": 0.05, "actuator_node_name": "Inlet",
                "mechanical_ventilation_controller_name": "DCV",
            }},
        });
        Model::from_epjson(&text.to_string(), Path::new("test.epJSON")).unwrap()
    }

    #[test]
    fn the_design_minimum_is_the_sum_over_the_zones_at_design_occupancy() {
        let minimum = |specification: Value| {
            Ventilation::of(&model(specification), "OA", 1.2).unwrap().min_outdoor_air / 1.2
        };
        let area = json!({"outdoor_air_method": "Flow/Area", "outdoor_air_flow_per_zone_floor_area": 0.001});
        assert!((minimum(area) - (0.1 + 2.0 * 0.05)).abs() < 1e-12);
        let person = json!({"outdoor_air_method": "Flow/Person", "outdoor_air_flow_per_person": 0.01});
        assert!((minimum(person) - (10.0 + 2.0 * 4.0) * 0.01).abs() < 1e-12);
        let little = json!({"outdoor_air_method": "Flow/Zone", "outdoor_air_flow_per_zone": 0.001});
        assert_eq!(minimum(little), 0.05, "the controller's own minimum is larger");
    }

    #[test]
    fn air_changes_count_the_zone_s_volume() {
        let minimum = |method: &str| {
            let specification = json!({"outdoor_air_method": method, "outdoor_air_flow_per_person": 0.01,
                "outdoor_air_flow_air_changes_per_hour": 3.0});
            let mut model = model(specification);
            for (zone, volume) in [("Hall", 300.0), ("Shop", 120.0)] {
                model.require_mut("Zone", zone).unwrap().insert("volume".into(), json!(volume));
            }
            Ventilation::of(&model, "OA", 1.2).unwrap().min_outdoor_air / 1.2
        };
        let people = [10.0 * 0.01, 2.0 * 4.0 * 0.01];
        let changes = [3.0 * 300.0 / 3600.0, 2.0 * 3.0 * 120.0 / 3600.0];
        assert!((minimum("AirChanges/Hour") - (changes[0] + changes[1])).abs() < 1e-12);
        assert!((minimum("Sum") - (changes[0] + changes[1] + people[0] + people[1])).abs() < 1e-12);
        assert!((minimum("Maximum") - (changes[0] + changes[1])).abs() < 1e-12);
    }

    #[test]
    fn people_and_specifications_of_spaces_count() {
        let mut model = model(json!({"outdoor_air_method": "Sum", "outdoor_air_flow_per_person": 0.01}));
        model.insert("Space", "Aisles", json!({"zone_name": "Shop", "floor_area": 30.0}));
        model.insert("Space", "Store", json!({"zone_name": "Shop", "floor_area": 20.0}));
        model.insert("SpaceList", "Sales", json!({"spaces": [{"space_name": "aisles"}]}));
        let place = "zone_or_zonelist_or_space_or_spacelist_name";
        let customers = json!({place: "Sales", "number_of_people_calculation_method": "People/Area",
            "people_per_floor_area": 0.2});
        model.insert("People", "Customers", customers);
        let minimum = |model: &Model| Ventilation::of(model, "OA", 1.2).unwrap().min_outdoor_air / 1.2;
        // 10 in the hall; 4 of the staff and 6 customers in each of two shops.
        assert!((minimum(&model) - (10.0 + 2.0 * (4.0 + 6.0)) * 0.01).abs() < 1e-12);
        let per_area =
            json!({"outdoor_air_method": "Flow/Area", "outdoor_air_flow_per_zone_floor_area": 0.002});
        model.insert(SPECIFICATION, "By Area", per_area);
        let spec = |space: &str, name: &str| json!({"space_name": space, "space_design_specification_outdoor_air_object_name": name});
        let specs = json!({"space_specs": [spec("Aisles", "Fresh"), spec("Store", "By Area")]});
        model.insert(SPECIFICATIONS_OF_SPACES, "Shop Specs", specs);
        let list = json!([
            {"zone_or_zonelist_name": "Hall", "design_specification_outdoor_air_object_name": "Fresh"},
            {"zone_or_zonelist_name": "Shop", "design_specification_outdoor_air_object_name": "Shop Specs"},
        ]);
        model.require_mut(MECHANICAL, "DCV").unwrap().insert("zone_specifications".into(), list);
        // In the aisles, 6 customers and 30 / 50 of the staff; in the store, 20 m² x 0.002.
        let shop = (6.0 + 2.4) * 0.01 + 20.0 * 0.002;
        assert!((minimum(&model) - (10.0 * 0.01 + 2.0 * shop)).abs() < 1e-12);
    }

    #[test]
    fn a_unit_gets_a_damper_schedule_of_its_own_with_the_values_of_the_model() {
        let mut model = model(json!({}));
        let shared = json!({"hourly_value": 0.5});
        model.insert("Schedule:Constant", "Shared", shared.clone());
        let controller = model.require_mut(CONTROLLER, "OA").unwrap();
        controller.insert(MINIMUM_SCHEDULE.into(), json!("shared"));
        controller.insert("minimum_limit_type".into(), json!("ProportionalMinimum"));
        let ventilation = Ventilation::of(&model, "OA", 1.2).unwrap().with_damper(&mut model, "OA").unwrap();
        let damper = ventilation.damper.unwrap();
        assert_eq!(damper.component, "Schedule:Constant");
        assert_eq!(
            model.require(&damper.component, &damper.key).unwrap()["hourly_value"],
            shared["hourly_value"]
        );
        let controller = model.require(CONTROLLER, "OA").unwrap();
        assert_eq!(controller[MINIMUM_SCHEDULE], damper.key);
        assert_eq!(controller["minimum_limit_type"], "FixedMinimum");
    }
}
