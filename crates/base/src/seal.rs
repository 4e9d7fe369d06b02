//! A file that states its own SHA-256, computed with zeros in its place.

use crate::digest::sha256;

/// Number of hexadecimal digits.
const DIGITS: usize = 64;

/// Returns the digits of a seal that is not yet set.
pub fn open() -> String {
    "0".repeat(DIGITS)
}

/// Replaces an open seal, which follows the text `before`, with the digest of the content. Returns whether there was
/// one.
pub fn set(content: &mut [u8], before: &str) -> bool {
    let Some(place) = place(content, before) else { return false };
    let digest = sha256(&*content);
    content[place..place + DIGITS].copy_from_slice(digest.as_bytes());
    true
}

/// Returns whether content matches the digest stated after the text `before`; `None` if none is stated.
pub fn is_intact(content: &[u8], before: &str) -> Option<bool> {
    let place = place(content, before)?;
    let mut opened = content.to_vec();
    opened[place..place + DIGITS].fill(b'0');
    Some(sha256(opened).as_bytes() == &content[place..place + DIGITS])
}

/// Returns where the digest begins.
fn place(content: &[u8], before: &str) -> Option<usize> {
    let place = content.windows(before.len()).position(|window| window == before.as_bytes())? + before.len();
    (place + DIGITS <= content.len()).then_some(place)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_flipped_bit_of_a_sealed_content_breaks_its_seal() {
        let mut content = format!("{{\"steps\":3,\"sha256\":\"{}\"}}", open()).into_bytes();
        let before = "\"sha256\":\"";
        assert!(set(&mut content, before));
        assert_eq!(is_intact(&content, before), Some(true));
        for bit in 0..8 * content.len() {
            let mut damaged = content.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert_ne!(is_intact(&damaged, before), Some(true), "bit {bit}");
        }
        assert_eq!(is_intact(b"{}", before), None);
        assert!(!set(&mut content[..30], before));
    }
}
