//! Saved states with the SHA-256 of their file in the file's own metadata, computed with zeros in its place.

use std::collections::HashMap;

use b2b_base::digest::sha256;

use crate::error::{Error, Result};
use crate::state::State;

const KEY: &str = "sha256";
/// Number of hexadecimal digits.
const DIGITS: usize = 64;

/// Returns the bytes of a state, in the safetensors format, with their digest.
pub(crate) fn seal(state: &State) -> Vec<u8> {
    let metadata = HashMap::from([(KEY.to_owned(), "0".repeat(DIGITS))]);
    let mut bytes = state.to_bytes_with(Some(metadata));
    let digest = sha256(&bytes);
    let place = place(&bytes).expect("it was just written");
    bytes[place..place + DIGITS].copy_from_slice(digest.as_bytes());
    bytes
}

/// Reads a sealed state.
///
/// # Errors
/// [`Error::State`] for bytes without a digest or with another one, and those of [`State::from_bytes`].
pub(crate) fn unseal(mut bytes: Vec<u8>) -> Result<State> {
    let place =
        place(&bytes).ok_or_else(|| Error::State("it is damaged, or of an earlier version".to_owned()))?;
    let digest = bytes[place..place + DIGITS].to_owned();
    bytes[place..place + DIGITS].fill(b'0');
    if sha256(&bytes).as_bytes() != digest {
        return Err(Error::State("it was changed: its SHA-256 is another one".to_owned()));
    }
    State::from_bytes(&bytes)
}

/// Returns where the digest begins.
fn place(bytes: &[u8]) -> Option<usize> {
    let before = format!("\"{KEY}\":\"");
    let place = bytes.windows(before.len()).position(|window| window == before.as_bytes())? + before.len();
    (place + DIGITS <= bytes.len()).then_some(place)
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
        assert_eq!(unseal(bytes.clone()).unwrap(), state);
        // Other programs read it, too.
        assert_eq!(State::from_bytes(&bytes).unwrap(), state);
        for bit in 0..8 * bytes.len() {
            let mut damaged = bytes.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert!(unseal(damaged).is_err(), "bit {bit}");
        }
        for length in 0..bytes.len() {
            assert!(unseal(bytes[..length].to_owned()).is_err(), "{length} bytes");
        }
        assert!(unseal(state.to_bytes()).is_err());
    }
}
