//! Draws for a challenge: one generator a case, so that no case depends on another or on threads.

use chacha20::ChaCha8Rng;
use chacha20::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};

/// One stream of random numbers.
pub(crate) struct Draws(ChaCha8Rng);

impl Draws {
    /// Stream of a seed.
    pub(crate) fn new(seed: u64, stream: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(stream);
        Draws(rng)
    }

    /// Uniform in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        StandardUniform.sample(&mut self.0)
    }

    /// Uniform in [from, to).
    pub(crate) fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.unit()
    }

    /// Uniform below n (n from 1).
    pub(crate) fn below(&mut self, n: usize) -> usize {
        ((self.unit() * n as f64) as usize).min(n.saturating_sub(1))
    }

    /// True or false.
    pub(crate) fn coin(&mut self) -> bool {
        self.unit() < 0.5
    }

    /// A standard normal within ± `limit`.
    pub(crate) fn normal_within(&mut self, limit: f64) -> f64 {
        loop {
            let z: f64 = StandardNormal.sample(&mut self.0);
            if z.abs() <= limit {
                return z;
            }
        }
    }

    /// A whole number that every reader of JSON keeps exactly (32 bits).
    pub(crate) fn seed(&mut self) -> u64 {
        let x: u32 = StandardUniform.sample(&mut self.0);
        u64::from(x)
    }

    /// 32 bytes in hexadecimal.
    pub(crate) fn nonce(&mut self) -> String {
        (0..4)
            .map(|_| {
                let x: u64 = StandardUniform.sample(&mut self.0);
                format!("{x:016x}")
            })
            .collect()
    }

    /// Any order, each as likely (Fisher and Yates).
    pub(crate) fn shuffle<T>(&mut self, items: &mut [T]) {
        for k in (1..items.len()).rev() {
            let other = self.below(k + 1);
            items.swap(k, other);
        }
    }

    /// `n` items of a list, as evenly as possible: the list in random order, again and again.
    pub(crate) fn deal<T: Clone>(&mut self, list: &[T], n: usize) -> Vec<T> {
        let mut out = Vec::with_capacity(n);
        while out.len() < n && !list.is_empty() {
            let mut round = list.to_vec();
            self.shuffle(&mut round);
            round.truncate(n - out.len());
            out.append(&mut round);
        }
        out
    }
}

/// The number of six significant digits next to x. Its shortest decimal is then the same in every language, which a
/// digest over text needs.
pub(crate) fn six_digits(x: f64) -> f64 {
    format!("{x:.5e}").parse().unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dealing_is_even() {
        let dealt = Draws::new(1, 0).deal(&[0, 1, 2, 3], 10);
        for k in 0..4 {
            let n = dealt.iter().filter(|x| **x == k).count();
            assert!(n == 2 || n == 3, "{k}: {n}");
        }
    }

    #[test]
    fn six_digits_are_kept() {
        assert_eq!(six_digits(1_528_434.9), 1_528_430.0);
        assert_eq!(six_digits(-0.012_345_678), -0.012_345_7);
        assert_eq!(six_digits(0.0), 0.0);
    }
}
