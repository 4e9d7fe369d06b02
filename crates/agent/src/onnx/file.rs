//! ONNX files: one graph of operators.

use crate::protobuf::{bytes, integer, single, text};

/// Version of the format, and of its operators.
const FORMAT: u64 = 8;
const OPERATORS: u64 = 17;
/// `TensorProto.FLOAT` and `TensorProto.INT64`.
const FLOAT: u64 = 1;
const INT64: u64 = 7;

/// A graph under construction, with single-precision inputs and outputs. Unnamed values get a name.
#[derive(Default)]
pub(super) struct File {
    parts: Vec<u8>,
    values: usize,
}

impl File {
    /// Adds an operator with one output and returns the name of the output.
    pub(super) fn operator(&mut self, operator: &str, inputs: &[&str], attributes: &[Vec<u8>]) -> String {
        let output = self.name();
        self.named(operator, inputs, attributes, &output);
        output
    }

    /// Adds an operator with one output of this name.
    pub(super) fn named(&mut self, operator: &str, inputs: &[&str], attributes: &[Vec<u8>], output: &str) {
        let mut node: Vec<u8> = inputs.iter().flat_map(|input| text(1, input)).collect();
        node.extend(text(2, output));
        node.extend(text(4, operator));
        node.extend(attributes.concat());
        self.parts.extend(bytes(1, &node));
    }

    /// Adds a constant of single precision, and returns its name.
    pub(super) fn tensor(&mut self, shape: &[usize], values: &[f32]) -> String {
        let data: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.constant(shape, FLOAT, &data)
    }

    /// Adds a constant of whole numbers, and returns its name.
    pub(super) fn integers(&mut self, shape: &[usize], values: &[usize]) -> String {
        let data: Vec<u8> = values.iter().flat_map(|value| (*value as u64).to_le_bytes()).collect();
        self.constant(shape, INT64, &data)
    }

    fn constant(&mut self, shape: &[usize], kind: u64, data: &[u8]) -> String {
        let name = self.name();
        let dims: Vec<u8> = shape.iter().flat_map(|size| integer(1, *size as u64)).collect();
        self.parts.extend(bytes(5, &[dims, integer(2, kind), text(8, &name), bytes(9, data)].concat()));
        name
    }

    fn name(&mut self) -> String {
        self.values += 1;
        format!("value {}", self.values)
    }

    /// Returns the bytes of the file, for inputs and outputs of shape [batch, width].
    pub(super) fn finish(mut self, inputs: &[(&str, usize)], outputs: &[(&str, usize)]) -> Vec<u8> {
        self.parts.extend(text(2, "agent"));
        for (field, values) in [(11, inputs), (12, outputs)] {
            values.iter().for_each(|each| self.parts.extend(bytes(field, &value(*each))));
        }
        let operators = [text(1, ""), integer(2, OPERATORS)].concat();
        [integer(1, FORMAT), text(2, "building2building"), bytes(7, &self.parts), bytes(8, &operators)]
            .concat()
    }
}

/// Returns a `ValueInfoProto` of shape [batch, width].
fn value((name, width): (&str, usize)) -> Vec<u8> {
    let shape = [bytes(1, &text(2, "batch")), bytes(1, &integer(1, width as u64))].concat();
    let tensor_type = [integer(1, FLOAT), bytes(2, &shape)].concat();
    [text(1, name), bytes(2, &bytes(1, &tensor_type))].concat()
}

/// Returns an entry of metadata, which may follow the other fields of a file.
pub(super) fn metadata(key: &str, value: &str) -> Vec<u8> {
    bytes(14, &[text(1, key), text(2, value)].concat())
}

/// Returns an attribute with a whole number.
pub(super) fn whole(name: &str, value: usize) -> Vec<u8> {
    bytes(5, &[text(1, name), integer(3, value as u64), integer(20, 2)].concat())
}

/// Returns an attribute with whole numbers.
pub(super) fn list(name: &str, values: &[usize]) -> Vec<u8> {
    let values: Vec<u8> = values.iter().flat_map(|value| integer(8, *value as u64)).collect();
    bytes(5, &[text(1, name), values, integer(20, 7)].concat())
}

/// Returns an attribute with a number in single precision.
pub(super) fn number(name: &str, value: f32) -> Vec<u8> {
    bytes(5, &[text(1, name), single(2, value), integer(20, 1)].concat())
}
