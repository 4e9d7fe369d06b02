//! From a model as its author left it to one that an agent can drive.

use std::path::Path;

use b2b_climate::Site;
use b2b_energyplus::Library;
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::hvac::energy_management;
use crate::hvac::{self, Actuator, Discovery, LeftAlone, System};
use crate::model::Model;
use crate::outputs;
use crate::run_period::RunPeriod;
use crate::sizing::{self, Sizes};
use crate::zone;
use crate::{Class, Error, Result};

/// A building ready for control: hard-sized, every actuator bites, nothing is written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PreparedBuilding {
    /// Name for people and for results, for example `OfficeSmall`.
    pub name: String,
    /// What it is of; `None` for a model of the user's own, and where it was not told.
    pub class: Option<Class>,
    /// Whether it is a prototype as it comes with the engine, and not one that the generator of the dataset made of it.
    pub prototype: bool,
    /// The model: [`PreparedBuilding::model_for`] gives it a run period.
    model: Model,
    /// Every zone, in model order.
    pub zones: Vec<Zone>,
    /// The systems whose actuators make the action, in the order of the action.
    pub systems: Vec<System>,
    /// Systems and equipment that keep their own controls, and why; empty but for imported buildings.
    pub left: Vec<LeftAlone>,
    /// Floor area of the conditioned zones, m²: what energy is divided by. Energy is that of all HVAC, so that zones
    /// under their own controls count too.
    pub conditioned_floor_area: f64,
}

/// A zone as an agent meets it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Zone {
    /// Name.
    pub name: String,
    /// Floor area with multiplier, m².
    pub floor_area: f64,
    /// What the equipment that an agent drives can do in it.
    pub conditioning: Conditioning,
    /// Whether equipment that nobody drives holds its temperature, by the thermostat and the schedules of the model's
    /// author. Such a zone is observed, and not judged.
    pub own_controls: bool,
}

/// What the equipment that an agent drives can do in a zone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Conditioning {
    /// Nothing: an attic, a plenum.
    None,
    /// Heat only.
    Heating,
    /// Heat and cool.
    HeatingAndCooling,
}

impl PreparedBuilding {
    /// Sizes a model as it is for a site and a weather file, then makes all of it controllable.
    ///
    /// # Errors
    /// [`Error::Unsupported`] naming the object that cannot be driven; [`Error::NothingToDrive`]; [`Error::Engine`] when
    /// the engine refuses the model.
    pub fn new(name: &str, mut model: Model, weather: &Path, library: &Library) -> Result<Self> {
        let air_density = size(&mut model, weather, library)?;
        energy_management::remove_ems_programs(&mut model, energy_management::sets_a_schedule);
        let systems = hvac::make_controllable(&mut model, air_density)?;
        Self::with(name, model, Discovery { systems, left: Vec::new() })
    }

    /// As [`PreparedBuilding::new`], but a system that cannot be driven is left as it is, and told in
    /// [`PreparedBuilding::left`]. For a user's own model: see [`crate::import`].
    ///
    /// # Errors
    /// As [`PreparedBuilding::new`], without [`Error::Unsupported`].
    pub fn as_far_as_possible(
        name: &str,
        mut model: Model,
        weather: &Path,
        library: &Library,
    ) -> Result<Self> {
        let air_density = size(&mut model, weather, library)?;
        let discovery = hvac::discover(&mut model, air_density)?;
        Self::with(name, model, discovery)
    }

    /// A sized model whose systems have been made controllable.
    fn with(name: &str, mut model: Model, Discovery { systems, left }: Discovery) -> Result<Self> {
        if systems.is_empty() {
            return Err(Error::NothingToDrive { name: name.to_owned(), left });
        }
        outputs::write_only(&mut model, &[]);
        keep_standard_time(&mut model);
        balance_exhaust(&mut model);
        one_system_step(&mut model);
        bound_warmup(&mut model);
        run_weather_alone(&mut model);
        let zones = zones(&model, &systems)?;
        let conditioned = |zone: &&Zone| zone.conditioning != Conditioning::None || zone.own_controls;
        Ok(Self {
            name: name.to_owned(),
            class: None,
            prototype: false,
            model,
            conditioned_floor_area: zones.iter().filter(conditioned).map(|z| z.floor_area).sum(),
            zones,
            systems,
            left,
        })
    }

    /// Lets go of the model, which takes ten times the memory of the rest, when environments have been made of it.
    pub fn forget_model(&mut self) {
        self.model = Model::default();
    }

    /// Tells what it is of.
    #[must_use]
    pub fn of_class(self, class: Option<Class>) -> Self {
        Self { class, ..self }
    }

    /// The model for one run period, with this many zone time steps an hour.
    pub fn model_for(&self, period: RunPeriod, steps_per_hour: u32) -> Model {
        let mut model = self.model.clone();
        model.remove_class("Timestep");
        model.insert("Timestep", "Timestep 1", json!({"number_of_timesteps_per_hour": steps_per_hour}));
        model.remove_class("RunPeriod");
        model.insert("RunPeriod", "Episode", period.to_epjson());
        model
    }

    /// The model as prepared, without a run period of its own.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The actuators, in the order of the action.
    pub fn actuators(&self) -> impl Iterator<Item = &Actuator> {
        self.systems.iter().flat_map(System::actuators)
    }

    /// The zones that an agent can act on, in model order.
    pub fn controlled_zones(&self) -> impl Iterator<Item = &Zone> {
        self.zones.iter().filter(|z| z.conditioning != Conditioning::None)
    }
}

/// Writes the sizes into a model, and returns the air density that its design flows are meant at, kg/m³.
fn size(model: &mut Model, weather: &Path, library: &Library) -> Result<f64> {
    let site = Site::read(weather)?;
    if sizing::wants_sizing(model) {
        Sizes::of(model, weather, library)?.write_into(model)?;
    }
    Ok(standard_air_density(site.elevation))
}

/// Density the engine takes for design flows, kg/m³: dry air at 20 °C at the standard pressure of the site's
/// elevation (m), which it reads from the weather file.
pub fn standard_air_density(elevation: f64) -> f64 {
    // Standard atmosphere and ideal gas law with the engine's constants (Engineering Reference,
    // "Psychrometric Services").
    let pressure = 101_325.0 * libm::pow(1.0 - 2.25577e-05 * elevation, 5.2559);
    pressure / (287.0 * (20.0 + 273.15))
}

fn zones(model: &Model, systems: &[System]) -> Result<Vec<Zone>> {
    let conditioning = |zone: &str| {
        let serving = |s: &&System| s.zones().iter().any(|z| z.eq_ignore_ascii_case(zone));
        match systems.iter().find(serving) {
            None => Conditioning::None,
            Some(System::HeatingOnly(_)) => Conditioning::Heating,
            Some(_) => Conditioning::HeatingAndCooling,
        }
    };
    let prepared = |zone: zone::Zone| {
        let conditioning = conditioning(&zone.name);
        let own_controls = conditioning == Conditioning::None && hvac::has_own_controls(model, &zone.name)?;
        Ok(Zone {
            conditioning,
            own_controls,
            floor_area: zone.floor_area * zone.multiplier,
            name: zone.name,
        })
    };
    zone::zones(model)?.into_iter().map(prepared).collect()
}

/// Removes daylight saving: the clock that an agent sees and the occupants' schedules then agree all year,
/// and neither jumps.
fn keep_standard_time(model: &mut Model) {
    model.remove_class("RunPeriodControl:DaylightSavingTime");
}

/// Lets outdoor air leak in where an exhaust fan takes more than the supply brings; otherwise the engine
/// lets the missing air appear from nowhere, at room temperature.
fn balance_exhaust(model: &mut Model) {
    const CLASS: &str = "ZoneAirMassFlowConservation";
    if model.objects("Fan:ZoneExhaust").is_empty() {
        return;
    }
    model.remove_class(CLASS);
    model.insert(
        CLASS,
        "Mass balance",
        json!({
            "adjust_zone_mixing_and_return_for_air_mass_flow_balance": "None",
            "infiltration_balancing_method": "AddInfiltrationFlow",
            "infiltration_balancing_zones": "AllZones",
        }),
    );
}

/// One system step in each zone step: the engine may otherwise cut a zone step up to reach its tolerances, and
/// a meter reading would then cover several controls. Iterations are the engine's default: some prototypes
/// allow 5, which sudden actions exceed.
fn one_system_step(model: &mut Model) {
    model.remove_class("ConvergenceLimits");
    model.insert(
        "ConvergenceLimits",
        "One system step",
        json!({"minimum_system_timestep": 60, "maximum_hvac_iterations": 20}),
    );
}

/// Simulates the run period, which some models leave out, and not the design days.
fn run_weather_alone(model: &mut Model) {
    let control = sizing::simulation_control(model);
    control.insert("run_simulation_for_weather_file_run_periods".into(), json!("Yes"));
    control.insert("run_simulation_for_sizing_periods".into(), json!("No"));
}

/// Least and most warm-up days. The warm-up controller is the same for every agent, so that their number is
/// part of the environment's definition: 4 almost everywhere (measured on all types in Denver, Miami and
/// Fairbanks), up to 9 for a hall without cooling in summer and for cold zones in Fairbanks.
const WARMUP_DAYS: [u32; 2] = [4, 25];
/// How far two warm-up days may differ: K, and share of the loads. The engine's widest.
const WARMUP_TOLERANCES: [f64; 2] = [0.5, 0.5];

fn bound_warmup(model: &mut Model) {
    for name in model.names("Building") {
        if let Some(building) = model.get_mut("Building", &name) {
            building.insert("minimum_number_of_warmup_days".into(), json!(WARMUP_DAYS[0]));
            building.insert("maximum_number_of_warmup_days".into(), json!(WARMUP_DAYS[1]));
            building.insert("temperature_convergence_tolerance_value".into(), json!(WARMUP_TOLERANCES[0]));
            building.insert("loads_convergence_tolerance_value".into(), json!(WARMUP_TOLERANCES[1]));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn air_is_thinner_in_denver_than_at_the_sea() {
        // The engine's own figures for the weather files of Denver (1726 m) and Miami (11 m).
        assert!((standard_air_density(1726.0) - 0.977).abs() < 5e-4);
        assert!((standard_air_density(11.0) - 1.203).abs() < 5e-4);
    }
}
