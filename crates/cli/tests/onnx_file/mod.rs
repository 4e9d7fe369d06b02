//! ONNX files to test with.

use prost::Message;
use tract_onnx::pb::tensor_shape_proto::{Dimension, dimension};
use tract_onnx::pb::{
    GraphProto, ModelProto, NodeProto, OperatorSetIdProto, TensorProto, TensorShapeProto, TypeProto,
    ValueInfoProto, type_proto,
};

const FLOAT: i32 = 1;

/// A policy of one layer without weights, as learning libraries export it: one observation in a batch of any size, and
/// the same number for every actuator.
pub fn linear_policy(observation: usize, action: usize, bias: f32) -> Vec<u8> {
    let node = NodeProto {
        op_type: "Gemm".into(),
        input: vec!["observation".into(), "weights".into(), "bias".into()],
        output: vec!["action".into()],
        ..NodeProto::default()
    };
    let graph = GraphProto {
        name: "policy".into(),
        node: vec![node],
        initializer: vec![
            tensor("weights", &[observation, action], vec![0.0; observation * action]),
            tensor("bias", &[action], vec![bias; action]),
        ],
        input: vec![value("observation", observation)],
        output: vec![value("action", action)],
        ..GraphProto::default()
    };
    let version = OperatorSetIdProto { domain: String::new(), version: 17 };
    let model = ModelProto {
        ir_version: 8,
        opset_import: vec![version],
        graph: Some(graph),
        ..ModelProto::default()
    };
    model.encode_to_vec()
}

fn tensor(name: &str, shape: &[usize], values: Vec<f32>) -> TensorProto {
    TensorProto {
        name: name.into(),
        dims: shape.iter().map(|each| *each as i64).collect(),
        data_type: FLOAT,
        float_data: values,
        ..TensorProto::default()
    }
}

fn value(name: &str, width: usize) -> ValueInfoProto {
    let of = |value| Dimension { value: Some(value), ..Dimension::default() };
    let shape = TensorShapeProto {
        dim: vec![
            of(dimension::Value::DimParam("batch".into())),
            of(dimension::Value::DimValue(width as i64)),
        ],
    };
    let tensor = type_proto::Tensor { elem_type: FLOAT, shape: Some(shape) };
    let of_type = TypeProto { value: Some(type_proto::Value::TensorType(tensor)), ..TypeProto::default() };
    ValueInfoProto { name: name.into(), r#type: Some(of_type), ..ValueInfoProto::default() }
}
