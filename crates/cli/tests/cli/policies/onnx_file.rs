//! ONNX files to test with, written field by field after `onnx.proto`.

use b2b_agent::protobuf::{bytes, integer, text};

const FLOAT: u64 = 1;

/// Returns a policy of one layer without weights, as learning libraries export it: one observation in a batch of any
/// size, and the same value for every actuator.
pub fn linear_policy(observation: usize, action: usize, bias: f32) -> Vec<u8> {
    let node =
        [text(1, "observation"), text(1, "weights"), text(1, "bias"), text(2, "action"), text(4, "Gemm")]
            .concat();
    let graph = [
        bytes(1, &node),
        text(2, "policy"),
        bytes(5, &tensor("weights", &[observation, action], &vec![0.0; observation * action])),
        bytes(5, &tensor("bias", &[action], &vec![bias; action])),
        bytes(11, &value("observation", observation)),
        bytes(12, &value("action", action)),
    ]
    .concat();
    model(&graph)
}

/// Returns a policy with memory: its state adds up a small part of every observation, and its actions, in [-1, 1],
/// follow the state.
pub fn summing_policy(observation: usize, action: usize) -> Vec<u8> {
    let node = |inputs: &[&str], output: &str, operator: &str| {
        let inputs = inputs.iter().flat_map(|name| text(1, name)).collect();
        bytes(1, &[inputs, text(2, output), text(4, operator)].concat())
    };
    let graph = [
        node(&["observation", "part"], "small", "Mul"),
        node(&["state", "small"], "next state", "Add"),
        node(&["next state", "weights", "bias"], "drive", "Gemm"),
        node(&["drive"], "action", "Tanh"),
        text(2, "policy"),
        bytes(5, &tensor("part", &[1], &[1e-5])),
        bytes(5, &tensor("weights", &[observation, action], &vec![0.2; observation * action])),
        bytes(5, &tensor("bias", &[action], &vec![-0.5; action])),
        bytes(11, &value("observation", observation)),
        bytes(11, &value("state", observation)),
        bytes(12, &value("action", action)),
        bytes(12, &value("next state", observation)),
    ]
    .concat();
    model(&graph)
}

/// A `ModelProto` of a graph.
fn model(graph: &[u8]) -> Vec<u8> {
    let opset = [text(1, ""), integer(2, 17)].concat();
    [integer(1, 8), bytes(7, graph), bytes(8, &opset)].concat()
}

/// A `TensorProto` of single-precision numbers.
fn tensor(name: &str, shape: &[usize], values: &[f32]) -> Vec<u8> {
    let dims: Vec<u8> = shape.iter().flat_map(|size| integer(1, *size as u64)).collect();
    let data: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    [dims, integer(2, FLOAT), text(8, name), bytes(9, &data)].concat()
}

/// A `ValueInfoProto` of shape [batch, width].
fn value(name: &str, width: usize) -> Vec<u8> {
    let shape = [bytes(1, &text(2, "batch")), bytes(1, &integer(1, width as u64))].concat();
    let tensor_type = [integer(1, FLOAT), bytes(2, &shape)].concat();
    [text(1, name), bytes(2, &bytes(1, &tensor_type))].concat()
}

/// Returns a policy that never ends: a product of thousands of large matrices, which depend on the observation.
pub fn endless_policy() -> Vec<u8> {
    const SIZE: u64 = 4096;
    let name = |place: usize| format!("product {place}");
    let sum = [text(1, "observation"), text(2, "sum"), text(4, "ReduceSum")].concat();
    let expand = [text(1, "sum"), text(1, "sizes"), text(2, &name(0)), text(4, "Expand")].concat();
    let product = |place: usize| {
        let node = [text(1, &name(place)), text(1, &name(0)), text(2, &name(place + 1)), text(4, "MatMul")];
        bytes(1, &node.concat())
    };
    let sizes: Vec<u8> = [SIZE; 2].iter().flat_map(|size| size.to_le_bytes()).collect();
    const INT64: u64 = 7;
    let sizes = [integer(1, 2), integer(2, INT64), text(8, "sizes"), bytes(9, &sizes)].concat();
    let graph = [
        bytes(1, &sum),
        bytes(1, &expand),
        (0..2000).flat_map(product).collect(),
        text(2, "endless"),
        bytes(5, &sizes),
        bytes(11, &[text(1, "observation"), bytes(2, &bytes(1, &integer(1, FLOAT)))].concat()),
        bytes(12, &[text(1, &name(2000)), bytes(2, &bytes(1, &integer(1, FLOAT)))].concat()),
    ]
    .concat();
    model(&graph)
}
