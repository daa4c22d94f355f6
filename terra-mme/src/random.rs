//! Uniform numbers from raw bits, the same on every platform.

use chacha20::rand_core::Rng;

/// Uniform in [0, 1), 53 bits.
pub(crate) fn uniform(rng: &mut impl Rng) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

/// Uniform in 0 .. n; 0 for n = 0. The bias of n in 2^53 is below 1e-9 for any n in use.
pub(crate) fn below(rng: &mut impl Rng, n: usize) -> usize {
    ((uniform(rng) * n as f64) as usize).min(n.saturating_sub(1))
}
