//! Saved states with the SHA-256 of their file in the file's own metadata.

use std::collections::HashMap;

use b2b_base::seal;

use crate::error::{Error, Result};
use crate::state::State;

const KEY: &str = "sha256";
/// The text before the digest.
const BEFORE: &str = "\"sha256\":\"";

/// Returns the bytes of a state, in the safetensors format, with their digest.
pub(crate) fn seal(state: &State) -> Vec<u8> {
    let metadata = HashMap::from([(KEY.to_owned(), seal::open())]);
    let mut bytes = state.to_bytes_with(Some(metadata));
    assert!(seal::set(&mut bytes, BEFORE), "it was just written");
    bytes
}

/// Reads a sealed state.
///
/// # Errors
/// [`Error::State`] for bytes with a missing or wrong digest, and errors from [`State::from_bytes`].
pub(crate) fn unseal(bytes: &[u8]) -> Result<State> {
    match seal::is_intact(bytes, BEFORE) {
        None => Err(Error::State("it is damaged, or of an earlier version".to_owned())),
        Some(false) => Err(Error::State("it was changed: its SHA-256 does not match".to_owned())),
        Some(true) => State::from_bytes(bytes),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_flipped_bit_of_a_sealed_state_is_an_error() {
        let mut state = State::default();
        state.put_u64("steps", &[1 << 30]);
        state.put_f32("weights", &[1.0, -0.0]);
        let bytes = seal(&state);
        assert_eq!(unseal(&bytes).unwrap(), state);
        // Other programs read it, too.
        assert_eq!(State::from_bytes(&bytes).unwrap(), state);
        for bit in 0..8 * bytes.len() {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert!(unseal(&damaged).is_err(), "bit {bit}");
        }
        for length in 0..bytes.len() {
            assert!(unseal(&bytes[..length]).is_err(), "{length} bytes");
        }
        assert!(unseal(&state.to_bytes()).is_err());
    }
}
