//! Buffers that grow to the largest batch.

/// Returns the first `length` values of a buffer, which grows if it is shorter.
pub fn sized(buffer: &mut Vec<f32>, length: usize) -> &mut [f32] {
    if buffer.len() < length {
        buffer.resize(length, 0.0);
    }
    &mut buffer[..length]
}
