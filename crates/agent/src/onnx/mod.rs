//! ONNX export of agents whose actions depend only on the current observation, and on the state of a memory.

mod file;
mod graph;
mod plain;

use std::sync::Arc;

use b2b_env::Spaces;
use b2b_workers::Arrangement;

use crate::agent::Agent;
use crate::network::{MemorySpan, Shape};
use crate::observation::{ObservationForm, ObservationOptions};
use crate::{Error, Result};

impl Agent {
    /// Returns the agent as an ONNX file. The input is the environment's unscaled observation, or the observation by
    /// roles. The output is the action, where -1 and 1 are the bounds, to be clamped by the environment. With a memory,
    /// the state is the second input and the next state the second output. A graph network's file is for this building
    /// only.
    ///
    /// # Errors
    /// [`Error::NotExportable`] for an agent that observes features, attributes, a forecast or feedback, or has a base
    /// controller; [`Error::OtherBuilding`] and [`Error::UnknownNodeType`] for an unsuitable building.
    pub fn to_onnx(&self, spaces: &Arc<Spaces>) -> Result<Vec<u8>> {
        let pilot = self.pilot(spaces)?;
        let interface = self.info().interface;
        let ObservationOptions { form, attributes, forecast, feedback } = interface.observation;
        if form == ObservationForm::Features {
            return Err(self.not_exportable("its features depend on earlier steps"));
        }
        if attributes || forecast > 0 {
            return Err(self.not_exportable("it observes attributes or a forecast"));
        }
        if feedback {
            return Err(self.not_exportable(
                "it observes its previous action and reward, which the file has no input for",
            ));
        }
        if interface.acting.has_base() {
            return Err(self.not_exportable("it acts through another controller"));
        }
        let actions = self.info().actuators.len();
        let mut file = match &self.actor().shape {
            Shape::Mlp(mlp) => plain::file(self.actor(), mlp, &bounds(form, spaces), actions),
            Shape::Recurrent(network) => {
                plain::recurrent(self.actor(), network, &bounds(form, spaces), actions)
            }
            Shape::Graph(network) => {
                let graph = pilot.graph().expect("a pilot of a graph network has a graph");
                let features = pilot.observation().linear_features();
                let features = features.ok_or_else(|| self.not_exportable("its features are not linear"))?;
                graph::file(self.actor(), network, graph, &features, spaces.observation.len())
            }
        };
        if let Some(episodes) = self.info().memory_episodes {
            file.extend(file::metadata(MemorySpan::KEY, &episodes.to_string()));
        }
        Ok(file)
    }

    fn not_exportable(&self, why: &'static str) -> Error {
        Error::NotExportable { agent: self.name().to_owned(), why }
    }
}

/// Returns the bounds of the slots of the observation in a form.
fn bounds(form: ObservationForm, spaces: &Arc<Spaces>) -> Vec<[f64; 2]> {
    let arrangement = match form {
        ObservationForm::Roles => Arrangement::ByRole,
        _ => Arrangement::InOrder,
    };
    arrangement.of(spaces).slots().into_iter().map(|slot| [slot.low, slot.high]).collect()
}
