//! The energy bought for a building's HVAC, and the engine's meters for it.
//!
//! The meters `…:HVAC` count coils, fans and zone equipment. Boilers, chillers, towers, pumps and district energy count
//! in `…:Plant`, together with service hot water and refrigeration. In a model with such equipment, HVAC energy is
//! therefore the sum of the meters of [`EndUse`]. These include the pumps of service hot water, which have no separate
//! meter.

use b2b_base::carrier::Carrier;
use serde::{Deserialize, Serialize};

use crate::hvac::air_loop_graph::components;
use crate::hvac::references::Reference;
use crate::model::{Model, items, text};

/// A meter of the engine that counts toward HVAC energy.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct HvacMeter {
    /// The carrier it measures.
    pub carrier: Carrier,
    /// Name, for example `Electricity:HVAC`. The engine only has meters that something uses.
    pub name: String,
}

/// An end use of HVAC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EndUse {
    /// Heating coils, burners, boilers and district heating.
    Heating,
    /// Compressors, chillers and district cooling.
    Cooling,
    /// Fans.
    Fans,
    /// Pumps of the plant.
    Pumps,
    /// Cooling towers and fluid coolers.
    HeatRejection,
    /// Wheels and pumps of heat recovery.
    HeatRecovery,
    /// Humidifiers.
    Humidification,
}

/// An amount of energy for each end use, in the order of [`EndUse::ALL`].
pub type EndUseEnergy = [f64; EndUse::ALL.len()];

impl EndUse {
    /// All end uses.
    pub const ALL: [Self; 7] = [
        Self::Heating,
        Self::Cooling,
        Self::Fans,
        Self::Pumps,
        Self::HeatRejection,
        Self::HeatRecovery,
        Self::Humidification,
    ];

    /// Returns the beginning of the names of its meters.
    const fn meter(self) -> &'static str {
        match self {
            Self::Heating => "Heating",
            Self::Cooling => "Cooling",
            Self::Fans => "Fans",
            Self::Pumps => "Pumps",
            Self::HeatRejection => "HeatRejection",
            Self::HeatRecovery => "HeatRecovery",
            Self::Humidification => "Humidifier",
        }
    }

    /// Returns whether the meters `…:HVAC` of models without a plant include it.
    fn is_air_side(self) -> bool {
        !matches!(self, Self::Pumps | Self::HeatRejection)
    }
}

impl HvacMeter {
    /// Returns the names of the end-use meters that make up this meter; the engine may lack some. They need not add up
    /// to it: `Electricity:HVAC` includes the losses of a building's transformer.
    pub fn end_uses(&self) -> Vec<(EndUse, String)> {
        match self.name.strip_suffix(":HVAC") {
            Some(resource) => {
                let end_uses = EndUse::ALL.into_iter().filter(|end_use| end_use.is_air_side());
                end_uses.map(|end_use| (end_use, format!("{}:{resource}", end_use.meter()))).collect()
            }
            None => {
                let begin = self.name.split(':').next().unwrap_or_default();
                let found = EndUse::ALL.into_iter().find(|end_use| end_use.meter() == begin);
                found.map(|end_use| (end_use, self.name.clone())).into_iter().collect()
            }
        }
    }
}

/// Prefixes of the classes of ventilation outside systems, with the output of their fans' electricity, which is in the
/// meter of fans and not in `Electricity:HVAC`.
const OTHER_FANS: [(&str, &str); 2] = [
    ("ZoneVentilation:", "Zone Ventilation Fan Electricity Energy"),
    ("ZoneEarthtube", "Earth Tube Fan Electricity Energy"),
];

/// Returns the names of zone outputs, in J, that the end-use meters include and these meters do not.
pub(crate) fn fans_outside(model: &Model, meters: &[HvacMeter]) -> Vec<&'static str> {
    if meters.iter().all(|meter| meter.name != "Electricity:HVAC") {
        return Vec::new();
    }
    let has = |begin: &str| model.classes().any(|class| class.starts_with(begin));
    OTHER_FANS.into_iter().filter(|(begin, _)| has(begin)).map(|(_, output)| output).collect()
}

/// The engine's resources; a model need not use them.
const RESOURCES: [(&str, Carrier); 13] = [
    ("Electricity", Carrier::Electricity),
    ("NaturalGas", Carrier::Gas),
    ("Propane", Carrier::Propane),
    ("FuelOilNo1", Carrier::FuelOil),
    ("FuelOilNo2", Carrier::FuelOil),
    ("Diesel", Carrier::FuelOil),
    ("Gasoline", Carrier::FuelOil),
    ("Coal", Carrier::OtherFuel),
    ("OtherFuel1", Carrier::OtherFuel),
    ("OtherFuel2", Carrier::OtherFuel),
    ("DistrictHeatingWater", Carrier::DistrictHeating),
    ("DistrictHeatingSteam", Carrier::DistrictHeating),
    ("DistrictCooling", Carrier::DistrictCooling),
];

/// Prefixes of the classes of plant equipment for HVAC, without pumps and water heaters, which service hot water has
/// too.
const PLANT: [&str; 12] = [
    "Boiler:",
    "CentralHeatPumpSystem",
    "Chiller:",
    "ChillerHeater:",
    "CoolingTower:",
    "DistrictCooling",
    "DistrictHeating:",
    "EvaporativeFluidCooler:",
    "FluidCooler:",
    "GroundHeatExchanger:",
    "HeatPump:",
    "PlantComponent:",
];

/// Returns the meters of a model's HVAC energy, electricity and natural gas first.
pub(crate) fn hvac_meters(model: &Model) -> Vec<HvacMeter> {
    let has = |begin: &str| model.classes().any(|class| class.starts_with(begin));
    let has_plant = PLANT.iter().any(|begin| has(begin));
    let meters = |&(resource, carrier): &(&str, Carrier)| {
        let is_metered = |end_use: &EndUse| match end_use {
            EndUse::Heating | EndUse::Cooling => true,
            EndUse::Humidification => has("Humidifier:"),
            EndUse::HeatRecovery => carrier == Carrier::Electricity && has("HeatExchanger:AirToAir:"),
            EndUse::Fans | EndUse::Pumps | EndUse::HeatRejection => carrier == Carrier::Electricity,
        };
        let names: Vec<_> = match has_plant {
            true => {
                let end_uses = EndUse::ALL.into_iter().filter(is_metered);
                end_uses.map(|end_use| format!("{}:{resource}", end_use.meter())).collect()
            }
            false => vec![format!("{resource}:HVAC")],
        };
        names.into_iter().map(move |name| HvacMeter { carrier, name })
    };
    RESOURCES
        .iter()
        .filter(|(resource, carrier)| is_used(model, resource, *carrier))
        .flat_map(meters)
        .collect()
}

/// Beginnings of the classes that heat rooms or their air with hot water.
const HEATERS: [&str; 3] = ["Coil:", "ZoneHVAC:", "AirLoopHVAC:"];

/// Returns a warning that names the water heaters whose loops heat rooms: their fuel is service hot water for the engine's
/// meters, so that it is not in [`hvac_meters`].
pub(crate) fn heating_tanks(model: &Model) -> Option<String> {
    let mut tanks = Vec::new();
    for (_, plant) in model.objects("PlantLoop") {
        let of_side = |side: &str| of_branch_list(model, text(plant, side).unwrap_or_default());
        let heats = |of: &Reference| HEATERS.iter().any(|begin| begins_with(&of.class, begin));
        if of_side("demand_side_branch_list_name").iter().any(heats) {
            let supply = of_side("plant_side_branch_list_name");
            let own = supply.into_iter().filter(|of| begins_with(&of.class, "WaterHeater:"));
            tanks.extend(own.map(|of| format!("`{}`", of.name)));
        }
    }
    (!tanks.is_empty()).then(|| {
        format!(
            "the water heaters {} heat rooms, but their energy is service hot water, which HVAC energy and costs leave out; \
             replace them by boilers to count it",
            tanks.join(", ")
        )
    })
}

/// Returns whether a class, spelled in any case, begins with a text.
fn begins_with(class: &str, begin: &str) -> bool {
    class.get(..begin.len()).is_some_and(|start| start.eq_ignore_ascii_case(begin))
}

/// Returns the components of a branch list; none of what the model lacks.
fn of_branch_list(model: &Model, list: &str) -> Vec<Reference> {
    let branches = model.get("BranchList", list).into_iter().flat_map(|list| items(list, "branches"));
    let names = branches.filter_map(|item| text(item, "branch_name"));
    names.flat_map(|name| components(model, name).unwrap_or_default()).map(|found| found.object).collect()
}

/// Ideal loads take district heating by hot water and district cooling unless they name other fuels.
const IDEAL_LOADS: &str = "ZoneHVAC:IdealLoadsAirSystem";

/// Returns whether a model may use a resource. Every model may use electricity and natural gas.
fn is_used(model: &Model, resource: &str, carrier: Carrier) -> bool {
    match carrier {
        Carrier::Electricity | Carrier::Gas => true,
        Carrier::DistrictHeating | Carrier::DistrictCooling => {
            let class = resource.replacen("DistrictHeating", "DistrictHeating:", 1);
            let is_ideal = resource != "DistrictHeatingSteam";
            model.classes().any(|found| found == class || is_ideal && found == IDEAL_LOADS)
                || names_fuel(model, resource)
        }
        Carrier::Propane | Carrier::FuelOil | Carrier::OtherFuel => names_fuel(model, resource),
    }
}

/// Returns whether an object of a model names a fuel.
fn names_fuel(model: &Model, resource: &str) -> bool {
    let burns = |class| {
        model.objects(class).iter().any(|(_, fields)| {
            let fuels = fields.keys().filter(|field| field.ends_with("fuel_type"));
            fuels.filter_map(|field| text(fields, field)).any(|fuel| fuel.eq_ignore_ascii_case(resource))
        })
    };
    model.classes().any(burns)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn names(model: &Model) -> Vec<String> {
        hvac_meters(model).into_iter().map(|meter| meter.name).collect()
    }

    #[test]
    fn ideal_loads_take_district_heating_and_cooling() {
        let mut model = Model::default();
        model.insert(IDEAL_LOADS, "Ideal", json!({}));
        let district = ["DistrictHeatingWater:HVAC", "DistrictCooling:HVAC"];
        assert_eq!(names(&model)[2..], district);
    }

    #[test]
    fn without_a_plant_the_air_side_is_metered() {
        let mut model = Model::default();
        model.insert("WaterHeater:Mixed", "Heater", json!({"heater_fuel_type": "NaturalGas"}));
        model.insert("Pump:ConstantSpeed", "Circulator", json!({}));
        model.insert("Coil:Heating:Fuel", "Furnace", json!({"fuel_type": "fueloilno2"}));
        assert_eq!(names(&model), ["Electricity:HVAC", "NaturalGas:HVAC", "FuelOilNo2:HVAC"]);
        assert!(fans_outside(&model, &hvac_meters(&model)).is_empty());
        model.insert("ZoneVentilation:DesignFlowRate", "Exhaust", json!({}));
        let fans = fans_outside(&model, &hvac_meters(&model));
        assert_eq!(fans, ["Zone Ventilation Fan Electricity Energy"]);
        let end_uses = hvac_meters(&model)[1].end_uses();
        assert_eq!(end_uses[0], (EndUse::Heating, "Heating:NaturalGas".to_owned()));
        assert!(end_uses.iter().all(|(end_use, _)| *end_use != EndUse::Pumps), "the circulator is not HVAC");
    }

    #[test]
    fn water_heaters_that_heat_rooms_are_named() {
        let mut model = Model::default();
        let plant =
            json!({"plant_side_branch_list_name": "Supply", "demand_side_branch_list_name": "Demand"});
        model.insert("PlantLoop", "Hot Water", plant);
        model.insert("BranchList", "Supply", json!({"branches": [{"branch_name": "Tank Branch"}]}));
        model.insert("BranchList", "Demand", json!({"branches": [{"branch_name": "Use Branch"}]}));
        let branch = |class: &str, name: &str| json!({"components": [{"component_object_type": class, "component_name": name}]});
        model.insert("Branch", "Tank Branch", branch("WaterHeater:Mixed", "Tank"));
        model.insert("Branch", "Use Branch", branch("WaterUse:Connections", "Sinks"));
        assert_eq!(heating_tanks(&model), None);
        model.insert("Branch", "Use Branch", branch("Coil:Heating:Water", "Coil"));
        assert!(heating_tanks(&model).unwrap().contains("water heaters `Tank` heat rooms"));
    }

    #[test]
    fn with_a_plant_end_uses_are_metered() {
        let mut model = Model::default();
        model.insert("DistrictHeating:Water", "Purchased", json!({}));
        let meters = hvac_meters(&model);
        let of = |carrier| {
            let metered = meters.iter().filter(move |meter| meter.carrier == carrier);
            metered.map(|meter| meter.name.as_str()).collect::<Vec<_>>()
        };
        let electricity = ["Heating", "Cooling", "Fans", "Pumps", "HeatRejection"];
        assert_eq!(of(Carrier::Electricity), electricity.map(|end_use| format!("{end_use}:Electricity")));
        assert_eq!(of(Carrier::Gas), ["Heating:NaturalGas", "Cooling:NaturalGas"]);
        let district = ["Heating:DistrictHeatingWater", "Cooling:DistrictHeatingWater"];
        assert_eq!(of(Carrier::DistrictHeating), district);
        assert_eq!(meters.len(), 9);
        model.insert("ZoneVentilation:DesignFlowRate", "Exhaust", json!({}));
        assert!(fans_outside(&model, &meters).is_empty(), "the meter of fans counts");
        assert!(
            meters.iter().all(|meter| matches!(&meter.end_uses()[..], [(_, name)] if *name == meter.name))
        );
    }
}
