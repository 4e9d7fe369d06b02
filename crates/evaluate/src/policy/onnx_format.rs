//! The wire format of ONNX models, [Protocol Buffers](https://protobuf.dev/programming-guides/encoding/). The library
//! that reads them trusts the lengths in a file, so a damaged file can make it allocate without bound or read in a
//! loop.

/// Maximum depth of nested messages, because reading is recursive.
const DEEPEST: usize = 100;

/// Maximum number of nodes, because the library recurses along chains of nodes. Policies have tens.
pub(super) const MOST_NODES: usize = 4000;

/// The messages of `onnx.proto3` that contain messages.
#[derive(Clone, Copy)]
enum Message {
    Model,
    Graph,
    Node,
    Attribute,
    Tensor,
    Value,
    Type,
    TensorType,
    SequenceType,
    Shape,
    /// A message that contains none.
    Leaf,
}

impl Message {
    /// Returns the kind of message in a field; `None` for other fields.
    fn field(self, number: u64) -> Option<Self> {
        Some(match (self, number) {
            (Self::Model, 7) | (Self::Attribute, 6) => Self::Graph,
            (Self::Graph, 1) => Self::Node,
            (Self::Graph, 5) | (Self::Attribute, 5) => Self::Tensor,
            (Self::Graph, 11..=13) => Self::Value,
            (Self::Node, 5) => Self::Attribute,
            (Self::Value, 2) | (Self::SequenceType, 1) => Self::Type,
            (Self::Type, 1) => Self::TensorType,
            (Self::Type, 4) => Self::SequenceType,
            (Self::TensorType, 2) => Self::Shape,
            (Self::Model, 8 | 14) | (Self::Tensor, 13) | (Self::Shape, 1) => Self::Leaf,
            _ => return None,
        })
    }
}

/// Checks that every field of a model ends inside its message, and limits its depth and its number of nodes.
///
/// # Errors
/// The problem and its byte offset.
pub(super) fn check(model: &[u8]) -> Result<(), String> {
    let mut reader = Reader { bytes: model, position: 0, nodes: 0 };
    reader.message(Message::Model, model.len(), 0)
}

struct Reader<'a> {
    bytes: &'a [u8],
    position: usize,
    /// Nodes read so far.
    nodes: usize,
}

impl Reader<'_> {
    /// Reads the fields of a message that ends at a position.
    fn message(&mut self, message: Message, end: usize, depth: usize) -> Result<(), String> {
        if depth > DEEPEST {
            return Err(format!("more than {DEEPEST} messages are inside each other"));
        }
        self.nodes += usize::from(matches!(message, Message::Node));
        if self.nodes > MOST_NODES {
            return Err(format!("it has more than {MOST_NODES} nodes"));
        }
        while self.position < end {
            let start = self.position;
            let damaged = || format!("the field at byte {start} is damaged");
            let tag = self.varint(end).ok_or_else(damaged)?;
            let length = match tag & 7 {
                0 => self.varint(end).map(|_| 0),
                1 => Some(8),
                2 => self.varint(end),
                5 => Some(4),
                _ => None,
            };
            let length = length.and_then(|length| usize::try_from(length).ok());
            let field_end = length.and_then(|length| self.position.checked_add(length));
            let field_end = field_end.filter(|&field_end| field_end <= end).ok_or_else(damaged)?;
            match message.field(tag >> 3).filter(|_| tag & 7 == 2) {
                Some(inner) => self.message(inner, field_end, depth + 1)?,
                None => self.position = field_end,
            }
        }
        Ok(())
    }

    /// Reads an integer of variable length.
    fn varint(&mut self, end: usize) -> Option<u64> {
        let mut value = 0_u64;
        for shift in (0..u64::BITS).step_by(7) {
            let byte = *self.bytes[..end].get(self.position)?;
            self.position += 1;
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Some(value);
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a field that holds some bytes.
    fn field(number: u8, content: &[u8]) -> Vec<u8> {
        let length = content.len();
        let length = [(length & 0x7f) as u8 | 0x80, (length >> 7) as u8];
        [&[number << 3 | 2][..], &length, content].concat()
    }

    #[test]
    fn lengths_beyond_the_end_of_their_message_are_errors() {
        let name = field(8, b"weights");
        let model = field(7, &field(5, &name));
        check(&model).unwrap();
        check(b"").unwrap();
        for position in [1, 4, 7] {
            let mut damaged = model.clone();
            damaged[position] += 1;
            let message = check(&damaged).unwrap_err();
            assert!(message.contains("is damaged"), "{message}");
        }
        // 2^64 - 16: skipping that many bytes goes back by 16.
        let backwards = [&[9 << 3 | 2, 0xf0][..], &[0xff; 8], &[1]].concat();
        assert_eq!(check(&backwards).unwrap_err(), "the field at byte 0 is damaged");
        assert!(check(&[&[8][..], &[0xff; 12]].concat()).is_err());
    }

    #[test]
    fn messages_inside_each_other_are_limited() {
        let sequence_of = |value_type: Vec<u8>| field(4, &field(1, &value_type));
        let model = |sequences| {
            let value_type = (0..sequences).fold(Vec::new(), |value_type, _| sequence_of(value_type));
            field(7, &field(11, &field(2, &value_type)))
        };
        // The graph, the value, its type, and two for each sequence.
        check(&model(48)).unwrap();
        assert_eq!(check(&model(49)).unwrap_err(), "more than 100 messages are inside each other");
    }
}
