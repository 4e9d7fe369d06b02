//! The subset of Protocol Buffers that event files and ONNX need.

/// Returns a field with a message, text or bytes.
pub fn bytes(field: u64, content: &[u8]) -> Vec<u8> {
    [varint(field << 3 | 2), varint(content.len() as u64), content.to_vec()].concat()
}

/// Returns a field with a string.
pub fn text(field: u64, content: &str) -> Vec<u8> {
    bytes(field, content.as_bytes())
}

/// Returns a field with a whole number.
pub fn integer(field: u64, value: u64) -> Vec<u8> {
    [varint(field << 3), varint(value)].concat()
}

/// Returns a field with a number in single precision.
pub fn single(field: u64, value: f32) -> Vec<u8> {
    [&varint(field << 3 | 5)[..], &value.to_le_bytes()].concat()
}

/// Returns a field with a number in double precision.
pub fn double(field: u64, value: f64) -> Vec<u8> {
    [&varint(field << 3 | 1)[..], &value.to_le_bytes()].concat()
}

fn varint(mut value: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_match_the_specification() {
        assert_eq!(integer(1, 150), [0x08, 0x96, 0x01]);
        assert_eq!(text(2, "testing"), [&[0x12, 0x07][..], b"testing"].concat());
        assert_eq!(single(2, 0.5), [0x15, 0, 0, 0, 0x3f]);
        assert_eq!(double(1, 1.0)[..], [0x09, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f]);
    }
}
