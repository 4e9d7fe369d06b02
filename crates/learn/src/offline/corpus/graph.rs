//! The graph of a building, with the node of every value of an observation and an action.

use std::path::Path;

use b2b_base::aside::write_whole;
use b2b_base::digest::sha256;
use b2b_building::Description;
use b2b_building::description::Origin;
use b2b_building::hvac::Quantity;
use b2b_building::morphology::{Morphology, Observed, Owner};
use b2b_env::Spaces;
use serde::Serialize;

use crate::error::at;
use crate::{Error, Result};

/// The graph of a building under a task, as `graphs/NAME.json`.
#[derive(Serialize)]
pub(super) struct Graph {
    #[serde(flatten)]
    morphology: Morphology,
    /// Values of an observation, in order.
    observation: Vec<Place<Observed>>,
    /// Values of an action, in order.
    action: Vec<Place<Quantity>>,
}

/// A value of a vector and its node.
#[derive(Serialize)]
struct Place<Q> {
    name: String,
    /// Number of the node; `None` for a part of the building that is not a node.
    node: Option<usize>,
    quantity: Q,
    low: f64,
    high: f64,
}

impl Graph {
    /// Returns the graph of a building that still has its model.
    pub(super) fn of(spaces: &Spaces) -> Result<Self> {
        let failed = |error: b2b_building::Error| Error::Invalid(error.to_string());
        let description = Description::of(&spaces.building, &spaces.episode.weather, Origin::default());
        let morphology = Morphology::of(&spaces.building, &description.map_err(failed)?);
        let node = |owner: Owner| morphology.node_of(owner);
        let slots = spaces.observation.slots().iter();
        let observation = slots.map(|slot| Place {
            name: slot.name.clone(),
            node: node(slot.owner),
            quantity: slot.quantity,
            low: slot.low,
            high: slot.high,
        });
        let observation = observation.collect();
        let space = &spaces.action;
        let actuator = |index: usize| Place {
            name: space.names()[index].clone(),
            node: node(space.owners()[index]),
            quantity: space.quantities()[index],
            low: space.low()[index],
            high: space.high()[index],
        };
        let action = (0..space.len()).map(actuator).collect();
        Ok(Self { morphology, observation, action })
    }

    /// Writes the graph to a folder under a name that its content decides, unless it is there. Returns the name.
    pub(super) fn write(&self, folder: &Path) -> Result<String> {
        let text = serde_json::to_string(self).expect("it is plain data");
        let name = format!("{}-{}.json", self.morphology.name, &sha256(&text)[..12]);
        let path = folder.join(&name);
        if !path.exists() {
            write_whole(&path, text.as_bytes()).map_err(at(&path))?;
        }
        Ok(name)
    }
}
