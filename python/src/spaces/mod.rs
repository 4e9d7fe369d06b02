//! The observation and action spaces of an environment, and its building.

pub(crate) mod morphology;

use std::sync::Arc;

use b2b_building::description::Description;
use b2b_building::morphology::Owner as Part;
use b2b_building::shape::Face;
use b2b_building::zone::SurfaceKind;
use b2b_building::{Conditioning, Morphology as Graph};
use b2b_env::{Decomposition, RoleObservation, RoleValue, Target};
use numpy::PyArray1;
use pyo3::prelude::*;

use self::morphology::Morphology;
use crate::buildings::catalog::Inner;
use crate::env::owner::{Owner, name_of};
use crate::interpreter::arrays;
use crate::interpreter::error::{of_building, of_env};

/// The spaces of an environment of a building.
#[pyclass(frozen, module = "building2building._core")]
pub struct Spaces {
    spaces: Arc<b2b_env::Spaces>,
    /// `None` for a building that was drawn by a batch of environments.
    building: Option<Arc<Inner>>,
}

/// A slot of the observation.
#[pyclass(frozen, get_all, module = "building2building._core")]
pub struct Slot {
    /// Name, for example `Core_ZN air temperature`.
    name: String,
    /// SI unit.
    unit: &'static str,
    /// Lower bound.
    low: f64,
    /// Upper bound.
    high: f64,
    /// Quantity, for example `air_temperature`.
    quantity: String,
    /// The part of the building that it belongs to.
    owner: Py<Owner>,
    /// Source of the value.
    source: &'static str,
}

/// A slot of the fixed-width observation of houses.
#[pyclass(frozen, get_all, module = "building2building._core")]
pub struct RoleSlot {
    /// Name, for example `garage air temperature`.
    name: String,
    /// SI unit.
    unit: &'static str,
    /// Lower bound.
    low: f64,
    /// Upper bound.
    high: f64,
    /// Slot of the building's own observation that it copies; `None` if it is constant.
    slot: Option<usize>,
    /// Its value if it is constant, else 0.
    constant: f64,
}

/// A slot of the action.
#[pyclass(frozen, get_all, module = "building2building._core")]
pub struct Actuator {
    /// Name, for example `Core_ZN supply air flow`.
    name: String,
    /// SI unit.
    unit: &'static str,
    /// Lower bound.
    low: f64,
    /// Upper bound.
    high: f64,
    /// Quantity, for example `supply_air_flow`.
    quantity: String,
    /// The part of the building that it belongs to.
    owner: Py<Owner>,
}

/// A thermal zone.
#[pyclass(frozen, get_all, module = "building2building._core")]
pub struct Zone {
    /// Name in the model.
    name: String,
    /// Slot of its air temperature.
    temperature_slot: usize,
    /// Whether it has a target and counts in the reward.
    controlled: bool,
    /// Whether its equipment can cool it.
    cooling: bool,
    /// Whether it keeps the model's own controls: thermostat and schedules.
    own_controls: bool,
    /// Floor area, m².
    floor_area: f64,
    /// Slot of its target, or of its heating setpoint in a task with bands; `None` if it has none or it is constant.
    target_slot: Option<usize>,
    /// Slot of its cooling setpoint; `None` in a task without bands and in a zone without cooling.
    cooling_setpoint_slot: Option<usize>,
    /// Slot of its occupancy; `None` if it has no target slot.
    occupancy_slot: Option<usize>,
}

impl Spaces {
    /// Creates the spaces of an environment of a building.
    pub fn new(spaces: Arc<b2b_env::Spaces>, building: Arc<Inner>) -> Self {
        building.keep(&spaces);
        Self { spaces, building: Some(building) }
    }

    /// Creates the spaces of a building that was drawn.
    pub fn drawn(spaces: Arc<b2b_env::Spaces>) -> Self {
        Self { spaces, building: None }
    }

    /// Returns the underlying spaces.
    pub fn inner(&self) -> &b2b_env::Spaces {
        &self.spaces
    }

    /// Returns the underlying spaces, to be shared.
    pub fn shared(&self) -> &Arc<b2b_env::Spaces> {
        &self.spaces
    }

    fn describe(&self) -> PyResult<Description> {
        let origin = match &self.building {
            Some(building) => building.origin.clone(),
            None => Inner::of_spaces(&self.spaces).origin,
        };
        Description::of(&self.spaces.building, &self.spaces.episode.weather, origin).map_err(of_building)
    }
}

#[pymethods]
impl Spaces {
    /// Name of the building.
    #[getter]
    fn name(&self) -> &str {
        &self.spaces.building.name
    }

    /// Conditioned floor area, m².
    #[getter]
    fn conditioned_floor_area(&self) -> f64 {
        self.spaces.building.conditioned_floor_area
    }

    /// Slots of the observation, in order.
    #[getter]
    fn observation(&self, py: Python<'_>) -> PyResult<Vec<Slot>> {
        let slot = |slot: &b2b_env::Slot| {
            Ok(Slot {
                name: slot.name.clone(),
                unit: slot.unit,
                low: slot.low,
                high: slot.high,
                quantity: name_of(slot.quantity),
                owner: Py::new(py, Owner::from(slot.owner))?,
                source: slot.source,
            })
        };
        self.spaces.observation.slots().iter().map(slot).collect()
    }

    /// Slots of the fixed-width observation, with a slot for every zone role; `None` if the building is not a generated
    /// house.
    #[getter]
    fn roles(&self) -> Option<Vec<RoleSlot>> {
        let slot = |slot: &b2b_env::RoleSlot| {
            let (own, constant) = match slot.value {
                RoleValue::Slot(own) => (Some(own), 0.0),
                RoleValue::Constant(constant) => (None, constant),
            };
            let (unit, low, high) = (slot.unit, slot.low, slot.high);
            RoleSlot { name: slot.name.clone(), unit, low, high, slot: own, constant }
        };
        Some(RoleObservation::of(&self.spaces)?.slots().iter().map(slot).collect())
    }

    /// Lower bounds of the observation.
    #[getter]
    fn observation_low<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let low: Vec<f64> = self.spaces.observation.slots().iter().map(|slot| slot.low).collect();
        arrays::row(py, &low)
    }

    /// Upper bounds of the observation.
    #[getter]
    fn observation_high<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let high: Vec<f64> = self.spaces.observation.slots().iter().map(|slot| slot.high).collect();
        arrays::row(py, &high)
    }

    /// Slots of the action, in order.
    #[getter]
    fn action(&self, py: Python<'_>) -> PyResult<Vec<Actuator>> {
        let actuator = |(owner, actuator): (Part, &b2b_building::hvac::Actuator)| {
            Ok(Actuator {
                name: actuator.name.clone(),
                unit: actuator.quantity.unit(),
                low: actuator.low,
                high: actuator.high,
                quantity: name_of(actuator.quantity),
                owner: Py::new(py, Owner::from(owner))?,
            })
        };
        self.spaces.building.owned_actuators().map(actuator).collect()
    }

    /// Lower bounds of the action, in physical units.
    #[getter]
    fn action_low<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        arrays::row(py, self.spaces.action.low())
    }

    /// Upper bounds of the action, in physical units.
    #[getter]
    fn action_high<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        arrays::row(py, self.spaces.action.high())
    }

    /// All zones, in model order.
    #[getter]
    fn zones(&self) -> Vec<Zone> {
        let observation = &self.spaces.observation;
        let mut controlled_zones = 0..;
        let zone = |(temperature_slot, zone): (usize, &b2b_building::Zone)| {
            let controlled = zone.conditioning != Conditioning::None;
            let number = if controlled { controlled_zones.next() } else { None };
            let (target_slot, cooling_setpoint_slot) =
                number.map_or((None, None), |number| match observation.target(number) {
                    Target::Slot(slot) => (Some(slot), None),
                    Target::Between([heating, cooling]) => (Some(heating), Some(cooling)),
                    Target::Always(_) => (None, None),
                });
            Zone {
                name: zone.name.clone(),
                temperature_slot,
                controlled,
                cooling: zone.conditioning == Conditioning::HeatingAndCooling,
                own_controls: zone.own_controls,
                floor_area: zone.floor_area,
                target_slot,
                cooling_setpoint_slot,
                occupancy_slot: number.and_then(|number| observation.occupancy(number)),
            }
        };
        self.spaces.building.zones.iter().enumerate().map(zone).collect()
    }

    /// Target of every controlled zone, °C; `None` if targets change over time.
    #[getter]
    fn constant_target(&self) -> Option<f64> {
        self.spaces.observation.constant_target()
    }

    /// Scale of the energy penalty, the paper's τ_E.
    #[getter]
    fn energy_scale(&self) -> f64 {
        let b2b_env::Spaces { building, episode, .. } = &*self.spaces;
        episode.task.scale_for(building.class, episode.steps_per_hour)
    }

    /// Slot of the outdoor air temperature; the next slot is the outdoor relative humidity.
    #[getter]
    fn outdoor_temperature_slot(&self) -> usize {
        self.spaces.observation.outdoor_temperature()
    }

    /// Slot of the HVAC electricity of the step.
    #[getter]
    fn electricity_slot(&self) -> usize {
        self.spaces.observation.electricity()
    }

    /// Slot of the non-electric HVAC energy of the step: gas, other fuels and district energy.
    #[getter]
    fn gas_slot(&self) -> usize {
        self.spaces.observation.gas()
    }

    /// Zone time steps per hour.
    #[getter]
    fn steps_per_hour(&self) -> u32 {
        self.spaces.episode.steps_per_hour
    }

    /// Number of steps of the whole run period.
    #[getter]
    fn episode_steps(&self) -> usize {
        self.spaces.episode_steps()
    }

    /// Returns the description that `b2b show --json` prints, as JSON text.
    fn description_json(&self) -> PyResult<String> {
        Ok(serde_json::to_string(&self.describe()?).expect("a description is plain data"))
    }

    /// Returns the floors of the zones: index of the zone, and corners (x, y, z) in m.
    fn floors(&self) -> PyResult<Vec<(usize, Vec<[f64; 3]>)>> {
        let shape = self.spaces.building.shape().map_err(of_building)?;
        let floors = shape.faces.into_iter().filter(|face| face.kind == SurfaceKind::Floor);
        Ok(floors.map(|Face { zone, corners, .. }| (zone, corners)).collect())
    }

    /// Returns the building as a graph, with the maps between its vectors and the arrays of its nodes.
    fn morphology(&self) -> PyResult<Morphology> {
        let graph = Graph::of(&self.spaces.building, &self.describe()?);
        let decomposition =
            Decomposition::new(&graph, &self.spaces.observation, &self.spaces.action).map_err(of_env)?;
        Ok(Morphology::new(graph, decomposition))
    }
}
