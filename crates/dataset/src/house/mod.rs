//! The generator of detached Québec houses.
//!
//! 1. [`House`] holds the parameters; [`Geometry`] follows from them.
//! 2. [`Capacities`] follow from the heat loss and gain on the site's design days, unless the parameters give them.
//! 3. [`house`] writes the model: a heated zone [`LIVING`] over every storey and the basement, a vented [`ATTIC`],
//!    optionally a vented [`CRAWLSPACE`] and an unheated [`GARAGE`], and one ducted unit, heat pump or furnace with
//!    cooling, whose air flow and supply temperature follow two schedules.
//! 4. [`HouseSample`] draws parameters distributed like Québec's detached houses.
//!
//! # Control
//! | `Schedule:Constant` | meaning | range |
//! |---|---|---|
//! | `Living Supply Air Flow Fraction` | share of the design flow (`AirTerminal:SingleDuct:VAV:NoReheat`, `maximum_air_flow_rate`) | 0, or 0.2 to 1 |
//! | `Living Supply Air Temperature` | supply air, °C | 10 to 45 |
//! | `Living Heating Setpoint`, `Living Cooling Setpoint` | thermostat, °C; fixed so that it never moves the damper | do not set |
//!
//! The flow is exact; the supply temperature is exact within the capacity of the coils (measured).
//!
//! # Engine messages
//! Below half of the design flow, the engine warns that the heating coil's air flow per capacity is out of range: its
//! range for heat pumps is narrower than that of a variable flow. The supply temperature stays exact. At or below 0.1
//! of the design flow, the engine's psychrometric functions leave their range, so flows must be 0, or 0.2 and more.
//!
//! # Scope
//! Québec's detached houses with ducts, about a quarter of all. Half of all detached houses heat with baseboards and
//! have no air system to control.

mod gains;
mod geometry;
mod household;
mod parameters;
mod sample;
mod simulation;
mod zones;

pub use geometry::Geometry;
pub use household::Household;
pub use hvac::capacities::Capacities;
pub use hvac::thermostat::{add_thermostat, lacks_thermostat};
pub(crate) use parameters::bounds::{HEAT_PUMP_COP, HEAT_PUMP_CUTOFF, HEATER_EFFICIENCY};
pub use parameters::bounds::{NUMBERS, Number};
pub use parameters::{Foundation, Heater, Heating, House};
pub(crate) use sample::{CUTOFF, FUEL};
pub use sample::{DIMENSIONS, FixedProperties, HouseSample, Vintage};
pub use zones::{ATTIC, CRAWLSPACE, GARAGE, LIVING};

use b2b_building::Model;
use b2b_climate::Site;

use crate::Result;

/// Generates the hard-sized model of a house at a place, ready to run.
///
/// The same parameters give the same bytes, on every machine.
///
/// # Errors
/// The errors of [`House::check`].
pub fn house(parameters: &House, site: &Site) -> Result<Model> {
    parameters.check()?;
    let geometry = Geometry::new(parameters);
    let capacities = parameters.capacities.unwrap_or_else(|| Capacities::for_design_days(parameters, site));
    let mut model = Model::default();
    simulation::add(&mut model, parameters, site);
    hvac::schedules::add(&mut model);
    zones::add(&mut model, &geometry);
    shell::envelope::add(&mut model, parameters, &geometry);
    shell::buffers::add(&mut model, parameters, &geometry);
    shell::ground::add(&mut model, parameters, &geometry, site);
    shell::infiltration::add(&mut model, parameters, &geometry);
    gains::add(&mut model, parameters);
    hvac::air_loop::add(&mut model, parameters, &capacities);
    hvac::coils::add(&mut model, parameters, &capacities);
    Ok(model)
}

mod hvac;
mod shell;
#[cfg(test)]
mod tests;
