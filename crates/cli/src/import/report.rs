//! The zones and systems of an imported model.

use b2b_building::hvac::{self, Kind, Uncontrolled};
use b2b_building::import::Notes;
use b2b_building::{Carrier, Conditioning};
use b2b_dataset::BuildingName;
use serde::Serialize;

use super::trial::Trial;
use crate::program::prepare::Prepared;

/// The zones and systems of a model, and whether the agent controls them.
#[derive(Serialize)]
pub struct Report {
    pub model: String,
    pub place: String,
    pub conditioned_floor_area_m2: f64,
    /// Energy carriers used by its HVAC.
    pub energy_carriers: Vec<Carrier>,
    pub zones: Vec<Zone>,
    /// The systems that the agent controls.
    pub systems: Vec<System>,
    /// The components that follow the setpoints of their zones, with the reason why they have no actuators of their
    /// own.
    pub follows_setpoints: Vec<Uncontrolled>,
    /// The components that it does not control, with the reason.
    pub not_controlled: Vec<Uncontrolled>,
    /// How the model was read and sized.
    pub notes: Notes,
    pub trial: Option<Trial>,
}

#[derive(Serialize)]
pub struct Zone {
    pub name: String,
    pub floor_area_m2: f64,
    /// Whether the agent controls it.
    pub controlled: bool,
    /// Whether it keeps the thermostat and schedules of the model.
    pub own_controls: bool,
    pub equipment: String,
}

#[derive(Serialize)]
pub struct System {
    /// Identifier of its kind.
    pub kind: String,
    pub name: String,
    pub zones: Vec<String>,
    pub actuators: Vec<String>,
    /// Design minimum of outdoor air, which the ventilation interlock keeps while a zone is occupied; `None` without
    /// outdoor air.
    pub min_outdoor_air_kg_s: Option<f64>,
}

impl Report {
    /// Collects the systems found in a prepared model.
    pub fn new(name: &BuildingName, prepared: &Prepared, trial: Option<Trial>) -> Self {
        let building = &prepared.building;
        let (follows_setpoints, not_controlled) =
            building.uncontrolled.iter().cloned().partition(|item| item.follows_setpoints);
        Self {
            model: name.to_string(),
            place: prepared.place.clone(),
            conditioned_floor_area_m2: building.conditioned_floor_area,
            energy_carriers: building.carriers().collect(),
            zones: building.zones.iter().map(Zone::of).collect(),
            systems: building.systems.iter().map(|system| System::of(&**system)).collect(),
            follows_setpoints,
            not_controlled,
            notes: building.notes.clone(),
            trial,
        }
    }

    /// Returns the number of zones that the agent controls.
    pub fn controlled_zones(&self) -> usize {
        self.zones.iter().filter(|zone| zone.controlled).count()
    }

    /// Returns the number of actuators.
    pub fn actuators(&self) -> usize {
        self.systems.iter().map(|system| system.actuators.len()).sum()
    }

    /// Returns the number of controlled systems of a kind.
    pub fn count(&self, kind: Kind) -> usize {
        self.systems.iter().filter(|system| system.kind == kind.id()).count()
    }
}

impl Zone {
    fn of(zone: &b2b_building::Zone) -> Self {
        let equipment = match zone.conditioning {
            Conditioning::HeatingAndCooling => "heating and cooling, controlled",
            Conditioning::Heating => "heating, controlled",
            Conditioning::None if zone.own_controls => "not controlled",
            Conditioning::None => "none",
        };
        Self {
            name: zone.name.clone(),
            floor_area_m2: zone.floor_area,
            controlled: zone.conditioning != Conditioning::None,
            own_controls: zone.own_controls,
            equipment: equipment.to_owned(),
        }
    }
}

impl System {
    fn of(system: &dyn hvac::System) -> Self {
        Self {
            kind: system.kind().id.to_owned(),
            name: system.name().to_owned(),
            zones: system.zones().into_iter().map(str::to_owned).collect(),
            actuators: system.actuators().into_iter().map(|actuator| actuator.name.clone()).collect(),
            min_outdoor_air_kg_s: system.ventilation().map(|air| air.min_outdoor_air),
        }
    }

    /// Returns the name of its kind.
    pub fn kind_name(&self) -> &str {
        match Kind::find(&self.kind) {
            Some(kind) => kind.name(),
            None => &self.kind,
        }
    }
}

/// Components of one class with the same reason.
pub struct Group<'a> {
    pub class: &'a str,
    pub reason: &'a str,
    pub members: Vec<&'a Uncontrolled>,
}

/// Returns components grouped by class and reason.
pub fn groups(components: &[Uncontrolled]) -> Vec<Group<'_>> {
    let mut groups: Vec<Group> = Vec::new();
    for item in components {
        match groups.iter_mut().find(|g| g.class == item.object.class && g.reason == item.reason) {
            Some(group) => group.members.push(item),
            None => {
                groups.push(Group { class: &item.object.class, reason: &item.reason, members: vec![item] })
            }
        }
    }
    groups
}
