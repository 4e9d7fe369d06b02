//! The machine's arithmetic, on which the bits of a simulation depend besides its inputs.
//!
//! glibc chooses its mathematical functions by the instructions of the CPU, and they round differently with and without
//! fused multiply-add. Networks choose their kernels in the same way.

#![allow(unsafe_code, reason = "the C library")]

use std::hint::black_box;
use std::sync::OnceLock;

use crate::digest::sha256;

/// Returns the fingerprint of this machine's arithmetic, such as `x86_64, glibc 2.36, fma avx2, libm 1b2c3d4e5f60`:
/// architecture, C library, vector instructions, and a digest of the values of the mathematical functions.
///
/// Machines with the same fingerprint give the same bits.
pub fn fingerprint() -> String {
    static FINGERPRINT: OnceLock<String> = OnceLock::new();
    FINGERPRINT
        .get_or_init(|| {
            format!("{}, {}{}, libm {}", std::env::consts::ARCH, c_library(), instructions(), libm())
        })
        .clone()
}

#[cfg(target_env = "gnu")]
fn c_library() -> String {
    // SAFETY: returns a static string that ends with a zero byte.
    let version = unsafe { std::ffi::CStr::from_ptr(libc::gnu_get_libc_version()) };
    format!("glibc {}", version.to_string_lossy())
}

#[cfg(not(target_env = "gnu"))]
fn c_library() -> String {
    std::env::consts::OS.to_owned()
}

#[cfg(target_arch = "x86_64")]
fn instructions() -> String {
    let known = [
        ("fma", std::arch::is_x86_feature_detected!("fma")),
        ("avx2", std::arch::is_x86_feature_detected!("avx2")),
        ("avx512f", std::arch::is_x86_feature_detected!("avx512f")),
    ];
    let here: Vec<&str> = known.into_iter().filter(|(_, here)| *here).map(|(name, _)| name).collect();
    if here.is_empty() { String::new() } else { format!(", {}", here.join(" ")) }
}

#[cfg(not(target_arch = "x86_64"))]
fn instructions() -> String {
    String::new()
}

/// Returns a digest of the values of the C library's functions at two thousand arguments each.
fn libm() -> String {
    let functions: [fn(f64) -> f64; 12] = [
        f64::exp,
        f64::ln,
        f64::log10,
        f64::sin,
        f64::cos,
        f64::tan,
        f64::asin,
        f64::acos,
        f64::atan,
        f64::sinh,
        f64::tanh,
        |x| black_box(x).powf(black_box(1.7)),
    ];
    let mut bits = Vec::new();
    for function in functions {
        for argument in (1..=1000).flat_map(|n| [f64::from(n) / 1001.0, f64::from(n) * 0.37]) {
            bits.extend(function(black_box(argument)).to_bits().to_le_bytes());
        }
    }
    sha256(bits)[..12].to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fingerprint_has_architecture_and_libm_and_is_stable() {
        let here = fingerprint();
        assert!(here.starts_with(std::env::consts::ARCH) && here.contains("libm "), "{here}");
        assert_eq!(libm(), libm());
    }
}
