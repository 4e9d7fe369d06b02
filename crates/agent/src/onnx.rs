//! Agents as ONNX files: those that are a plain network.

use std::sync::Arc;

use b2b_env::Spaces;
use b2b_env::vector::Arrangement;

use crate::acting::Acting;
use crate::agent::Agent;
use crate::network::{Activation, Distribution, Layer, Mlp, Shape};
use crate::observation::ObservationForm;
use crate::protobuf::{bytes, integer, text};
use crate::{Error, Result};

/// Version of the format, and of its operators.
const FORMAT: u64 = 8;
const OPERATORS: u64 = 17;
/// `TensorProto.FLOAT`.
const FLOAT: u64 = 1;

impl Agent {
    /// Returns the agent as an ONNX file that takes the environment's observation without scaling, or that by roles, and returns
    /// actions from -1 to 1.
    ///
    /// # Errors
    /// [`Error::NotPlain`] for an agent with features, which depend on earlier steps, or on a base controller;
    /// [`Error::OtherBuilding`] for a building that it was not made for.
    pub fn to_onnx(&self, spaces: &Arc<Spaces>) -> Result<Vec<u8>> {
        self.controller(spaces)?;
        let Shape::Mlp(mlp) = &self.actor().shape else {
            return Err(self.not_plain("it is a graph network"));
        };
        let interface = self.info().interface;
        if interface.observation != interface.observation.form.into() {
            return Err(self.not_plain("it observes attributes or a forecast"));
        }
        let arrangement = match interface.observation.form {
            ObservationForm::Raw => Arrangement::InOrder,
            ObservationForm::Roles => Arrangement::ByRole,
            ObservationForm::Features => return Err(self.not_plain("its features depend on earlier steps")),
        };
        if interface.acting != Acting::Direct {
            return Err(self.not_plain("it corrects the reactive controllers"));
        }
        let bounds: Vec<_> =
            arrangement.of(spaces).slots().into_iter().map(|slot| [slot.low, slot.high]).collect();
        Ok(model(&self.graph(mlp, &bounds)))
    }

    fn not_plain(&self, why: &'static str) -> Error {
        Error::NotPlain { agent: self.name().to_owned(), why }
    }

    /// Returns the graph: scaling, and the layers of the network.
    fn graph(&self, mlp: &Mlp, bounds: &[[f64; 2]]) -> Vec<u8> {
        let actor = self.actor();
        let scale: Vec<f32> = bounds.iter().map(|[low, high]| (2.0 / (high - low)) as f32).collect();
        let offset: Vec<f32> =
            bounds.iter().map(|[low, high]| ((low + high) / (low - high)) as f32).collect();
        let width = bounds.len();
        let mut parts = vec![
            node("Mul", &["observation", "scale"], "scaled by range"),
            node("Add", &["scaled by range", "offset"], "scaled"),
            tensor("scale", &[width], &scale),
            tensor("offset", &[width], &offset),
        ];
        let (actions, layers): (usize, Vec<Layer>) = (self.info().actuators.len(), mlp.layers().collect());
        let mut input = "scaled".to_owned();
        for (index, layer) in layers.iter().enumerate() {
            let is_last = index + 1 == layers.len();
            // Standard deviations behind the means of the last layer are for training.
            let outputs = if is_last { actions } else { layer.outputs };
            let [weights, biases, sums] = ["weights", "biases", "sums"].map(|part| format!("{part} {index}"));
            parts.push(node("Gemm", &[&input, &weights, &biases], &sums));
            parts.push(tensor(
                &weights,
                &[layer.inputs, outputs],
                &columns(&actor.parameters, layer, outputs),
            ));
            parts.push(tensor(&biases, &[outputs], &actor.parameters[layer.biases.clone()][..outputs]));
            let activation = match mlp.activation {
                _ if is_last && actor.distribution == Distribution::SquashedGaussian => "Tanh",
                _ if is_last => "Identity",
                Activation::Tanh => "Tanh",
                Activation::Relu => "Relu",
            };
            input = if is_last { "action".to_owned() } else { format!("layer {index}") };
            parts.push(node(activation, &[&sums], &input));
        }
        parts.push(text(2, "agent"));
        parts.push(bytes(11, &value("observation", width)));
        parts.push(bytes(12, &value("action", actions)));
        parts.concat()
    }
}

/// Returns the weights of the first columns of a layer.
fn columns(parameters: &[f32], layer: &Layer, outputs: usize) -> Vec<f32> {
    let rows = parameters[layer.weights.clone()].chunks_exact(layer.outputs);
    rows.flat_map(|row| &row[..outputs]).copied().collect()
}

fn model(graph: &[u8]) -> Vec<u8> {
    let operators = [text(1, ""), integer(2, OPERATORS)].concat();
    [integer(1, FORMAT), text(2, "building2building"), bytes(7, graph), bytes(8, &operators)].concat()
}

/// Returns a field with a `NodeProto` of one output.
fn node(operator: &str, inputs: &[&str], output: &str) -> Vec<u8> {
    let mut node: Vec<u8> = inputs.iter().flat_map(|input| text(1, input)).collect();
    node.extend(text(2, output));
    node.extend(text(4, operator));
    bytes(1, &node)
}

/// Returns a field with a `TensorProto` in single precision.
fn tensor(name: &str, shape: &[usize], values: &[f32]) -> Vec<u8> {
    let dims: Vec<u8> = shape.iter().flat_map(|size| integer(1, *size as u64)).collect();
    let data: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    bytes(5, &[dims, integer(2, FLOAT), text(8, name), bytes(9, &data)].concat())
}

/// Returns a `ValueInfoProto` of shape [batch, width].
fn value(name: &str, width: usize) -> Vec<u8> {
    let shape = [bytes(1, &text(2, "batch")), bytes(1, &integer(1, width as u64))].concat();
    let tensor_type = [integer(1, FLOAT), bytes(2, &shape)].concat();
    [text(1, name), bytes(2, &bytes(1, &tensor_type))].concat()
}
