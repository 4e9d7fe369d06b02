//! ONNX export of agents whose actions depend only on the current observation.

mod file;
mod graph;
mod plain;

use std::sync::Arc;

use b2b_env::Spaces;
use b2b_workers::Arrangement;

use crate::acting::Acting;
use crate::agent::Agent;
use crate::network::Shape;
use crate::observation::{ObservationForm, ObservationOptions};
use crate::{Error, Result};

impl Agent {
    /// Returns the agent as an ONNX file. The input is the environment's unscaled observation, or the observation by
    /// roles. The output is the action, where -1 and 1 are the bounds, to be clamped by the environment. A graph
    /// network's file is for this building only.
    ///
    /// # Errors
    /// [`Error::NotExportable`] for an agent with features, which depend on earlier steps, or on a base controller;
    /// [`Error::OtherBuilding`] and [`Error::UnknownNodeType`] for an unsuitable building.
    pub fn to_onnx(&self, spaces: &Arc<Spaces>) -> Result<Vec<u8>> {
        let pilot = self.pilot(spaces)?;
        let interface = self.info().interface;
        let ObservationOptions { form, attributes, forecast } = interface.observation;
        if form == ObservationForm::Features {
            return Err(self.not_exportable("its features depend on earlier steps"));
        }
        if attributes || forecast > 0 {
            return Err(self.not_exportable("it observes attributes or a forecast"));
        }
        if interface.acting != Acting::Direct {
            return Err(self.not_exportable("it corrects the reactive controllers"));
        }
        match &self.actor().shape {
            Shape::Mlp(mlp) => {
                let arrangement = match form {
                    ObservationForm::Roles => Arrangement::ByRole,
                    _ => Arrangement::InOrder,
                };
                let slots = arrangement.of(spaces).slots();
                let bounds: Vec<_> = slots.into_iter().map(|slot| [slot.low, slot.high]).collect();
                Ok(plain::file(self.actor(), mlp, &bounds, self.info().actuators.len()))
            }
            Shape::Graph(network) => {
                let graph = pilot.graph().expect("a pilot of a graph network has a graph");
                let features = pilot.observation().linear_features();
                let features = features.ok_or_else(|| self.not_exportable("its features are not linear"))?;
                Ok(graph::file(self.actor(), network, graph, &features, spaces.observation.len()))
            }
        }
    }

    fn not_exportable(&self, why: &'static str) -> Error {
        Error::NotExportable { agent: self.name().to_owned(), why }
    }
}
