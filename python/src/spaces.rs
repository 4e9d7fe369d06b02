//! What is seen and driven, and the building behind it.

use std::path::PathBuf;
use std::sync::Arc;

use b2b_building::description::Description;
use b2b_building::morphology::{NodeType, Universe};
use b2b_building::zone::SurfaceKind;
use b2b_building::{Conditioning, Morphology as Graph};
use b2b_env::{Decomposition, Target};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use serde_json::{Value, json};

use crate::arrays;
use crate::catalog::Inner;
use crate::error::{of_building, of_env, raise};

/// A face: number of its zone, whether it is a floor, corners (x, y, z), m.
type Face = (usize, bool, Vec<[f64; 3]>);

/// What an environment sees and drives, as data.
#[pyclass(frozen, module = "building2building._core")]
pub struct Spaces {
    spaces: Arc<b2b_env::Spaces>,
    building: Arc<Inner>,
}

impl Spaces {
    /// Of an environment of a building.
    pub fn new(spaces: Arc<b2b_env::Spaces>, building: Arc<Inner>) -> Self {
        building.keep(&spaces);
        Self { spaces, building }
    }

    /// For the crates.
    pub fn inner(&self) -> &b2b_env::Spaces {
        &self.spaces
    }

    fn weather(&self) -> &PathBuf {
        &self.spaces.episode.weather
    }

    fn describe(&self) -> PyResult<Description> {
        Description::of(&self.spaces.building, self.weather(), self.building.origin.clone())
            .map_err(of_building)
    }
}

#[pymethods]
impl Spaces {
    /// Names, units and bounds, the zones, and where what is in the observation; JSON.
    fn to_json(&self) -> String {
        let b2b_env::Spaces { building, episode, observation, .. } = &*self.spaces;
        let slots = observation.slots().iter().map(|slot| {
            json!({"name": slot.name, "unit": slot.unit, "low": slot.low, "high": slot.high,
                   "source": slot.source, "quantity": slot.quantity, "owner": slot.owner})
        });
        let actuators = building.owned_actuators().map(|(owner, actuator)| {
            json!({"name": actuator.name, "unit": actuator.quantity.unit(), "low": actuator.low,
                   "high": actuator.high, "quantity": actuator.quantity, "owner": owner})
        });
        let mut controlled = 0;
        let zones = building.zones.iter().enumerate().map(|(slot, zone)| {
            let judged = zone.conditioning != Conditioning::None;
            let (target, occupancy) = match (judged, observation.target(controlled)) {
                (false, _) => (Value::Null, Value::Null),
                (true, Target::Always(_)) => (Value::Null, Value::Null),
                (true, Target::Slot(slot)) => (json!(slot), json!(observation.occupancy(controlled))),
            };
            controlled += usize::from(judged);
            json!({"name": zone.name, "temperature_slot": slot, "controlled": judged,
                   "heating": judged, "cooling": zone.conditioning == Conditioning::HeatingAndCooling,
                   "own_controls": zone.own_controls, "floor_area": zone.floor_area,
                   "target_slot": target, "occupancy_slot": occupancy})
        });
        json!({
            "name": building.name,
            "conditioned_floor_area": building.conditioned_floor_area,
            "observation": slots.collect::<Vec<_>>(),
            "action": actuators.collect::<Vec<_>>(),
            "zones": zones.collect::<Vec<_>>(),
            "constant_target": observation.constant_target(),
            "energy_scale": episode.task.scale_for(building.class, episode.steps_per_hour),
            "outdoor_temperature": observation.outdoor_temperature(),
            "electricity": observation.electricity(),
            "gas": observation.gas(),
            "first_day": episode.period.first().day_of_year(),
            "steps_per_hour": episode.steps_per_hour,
            "episode_steps": self.spaces.episode_steps(),
        })
        .to_string()
    }

    /// What the building is, in numbers; JSON as in `b2b show --json`.
    fn description(&self) -> PyResult<String> {
        Ok(serde_json::to_string(&self.describe()?).expect("a description is plain data"))
    }

    /// Every face: number of its zone, whether it is a floor, corners (x, y, z), m.
    fn faces(&self) -> PyResult<Vec<Face>> {
        let shape = self.spaces.building.shape().map_err(of_building)?;
        let face = |face: b2b_building::description::shape::Face| {
            (face.zone, face.kind == SurfaceKind::Floor, face.corners)
        };
        Ok(shape.faces.into_iter().map(face).collect())
    }

    /// The building as a graph, with the translations of its spaces.
    fn morphology(&self) -> PyResult<Morphology> {
        let graph = Graph::of(&self.spaces.building, &self.describe()?);
        let decomposition =
            Decomposition::new(&graph, &self.spaces.observation, &self.spaces.action).map_err(of_env)?;
        Ok(Morphology { graph, decomposition })
    }
}

/// A building as a graph, with the translations between its vectors and the arrays of its nodes.
#[pyclass(frozen, module = "building2building._core")]
pub struct Morphology {
    graph: Graph,
    decomposition: Decomposition,
}

#[pymethods]
impl Morphology {
    /// Nodes, edges, the universe, and where the array of each node type is in the buffers; JSON.
    fn to_json(&self) -> String {
        let layout = |layout: &b2b_building::morphology::Layout| {
            let block = |node_type: NodeType| {
                let block = layout.block(node_type);
                json!([block.offset, block.nodes, block.slots])
            };
            NodeType::ALL.map(block)
        };
        json!({
            "graph": self.graph,
            "universe": Universe::new(),
            "observation": layout(self.decomposition.observation_layout()),
            "action": layout(self.decomposition.action_layout()),
            "observation_cells": self.decomposition.observation_cells(),
            "action_cells": self.decomposition.action_cells(),
        })
        .to_string()
    }

    /// Observations, one a row, as rows of the nodes' buffer.
    fn split<'py>(
        &self,
        py: Python<'py>,
        observations: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let (values, [count, width]) = arrays::rows(observations)?;
        let expected = self.decomposition.observation_cells().len();
        check_width("observation", width, expected)?;
        let nodes = self.decomposition.observation_layout().len();
        let (mut buffer, mut all) = (vec![0.0; nodes], Vec::with_capacity(count * nodes));
        for row in values.chunks_exact(width) {
            self.decomposition.split(row, &mut buffer);
            all.extend(buffer.iter().map(|value| *value as f32));
        }
        arrays::table(py, all, [count, nodes])
    }

    /// Rows of the nodes' buffer of actions as actions, one a row.
    fn join<'py>(&self, py: Python<'py>, nodes: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let (values, [count, width]) = arrays::rows(nodes)?;
        check_width("array of node actions", width, self.decomposition.action_layout().len())?;
        let actuators = self.decomposition.action_cells().len();
        let (mut action, mut all) = (vec![0.0; actuators], Vec::with_capacity(count * actuators));
        for row in values.chunks_exact(width) {
            self.decomposition.join(row, &mut action);
            all.extend(action.iter().map(|value| *value as f32));
        }
        arrays::table(py, all, [count, actuators])
    }

    /// An action, or its bounds, as the nodes' buffer of actions; what is not driven is 0.
    fn split_action<'py>(
        &self,
        py: Python<'py>,
        action: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let action = arrays::numbers(action)?;
        check_width("action", action.len(), self.decomposition.action_cells().len())?;
        let mut buffer = vec![0.0; self.decomposition.action_layout().len()];
        self.decomposition.split_action(&action, &mut buffer);
        Ok(arrays::single(py, &buffer))
    }
}

fn check_width(what: &str, given: usize, expected: usize) -> PyResult<()> {
    if given == expected {
        return Ok(());
    }
    Err(raise("ActionError", format!("the {what} has {given} numbers, and this building's has {expected}")))
}
