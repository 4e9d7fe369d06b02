//! SHA-256 digests in hexadecimal, for manifests, tasks, trajectories and results.

use sha2::{Digest, Sha256};

/// Returns bytes as lower-case hexadecimal.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Returns the SHA-256 of bytes in hexadecimal.
pub fn sha256(bytes: impl AsRef<[u8]>) -> String {
    hex(&Sha256::digest(bytes))
}

/// Returns the first 8 bytes of the SHA-256 of a name as a number, to seed its random draws.
pub fn seed_of(name: &str) -> u64 {
    let digest = Sha256::digest(name);
    digest[..8].iter().fold(0, |number, byte| number << 8 | u64::from(*byte))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// NIST's example of a one-block message for SHA-256.
    #[test]
    fn the_digest_of_abc_matches_the_standard() {
        assert_eq!(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
        assert_eq!(seed_of("abc"), 0xba78_16bf_8f01_cfea);
    }
}
