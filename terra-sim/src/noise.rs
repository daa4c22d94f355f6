//! Random numbers: one stream a channel, so that no channel's draws depend on what else is simulated.

use chacha20::ChaCha8Rng;
use chacha20::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

/// Streams within one run; the index is part of the format of a seed, so append only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stream {
    WheelSpeed(usize),
    WheelTorque(usize),
    GroundSpeed,
    YawRate,
    AccelX,
    Sinkage(usize),
    ForceRoughness(usize),
    TorqueRoughness(usize),
    RigDrawbarPull,
    RigTorque,
    RigSinkage,
    RigSlip,
    RigLoad,
    RigTravelSpeed,
    RigRimSpeed,
    RigForceRoughness,
    RigTorqueRoughness,
    AccelY,
    LateralSpeed,
    Distance,
    NormalLoad(usize),
    /// How a rig's load is held.
    RigLoadHold,
}

/// Streams of a channel's faults (dropouts, outliers) lie this far behind its noise.
const FAULTS: u64 = 128;

impl Stream {
    fn index(self) -> u64 {
        match self {
            Stream::WheelSpeed(w) => w as u64,
            Stream::WheelTorque(w) => 4 + w as u64,
            Stream::GroundSpeed => 8,
            Stream::YawRate => 9,
            Stream::AccelX => 10,
            Stream::Sinkage(w) => 12 + w as u64,
            Stream::ForceRoughness(w) => 16 + w as u64,
            Stream::TorqueRoughness(w) => 20 + w as u64,
            Stream::RigDrawbarPull => 32,
            Stream::RigTorque => 33,
            Stream::RigSinkage => 34,
            Stream::RigSlip => 35,
            Stream::RigLoad => 36,
            Stream::RigTravelSpeed => 37,
            Stream::RigRimSpeed => 38,
            Stream::RigForceRoughness => 39,
            Stream::RigTorqueRoughness => 40,
            Stream::AccelY => 41,
            Stream::LateralSpeed => 42,
            Stream::Distance => 43,
            Stream::NormalLoad(w) => 44 + w as u64,
            Stream::RigLoadHold => 48,
        }
    }
}

/// Streams reserved a run.
const STREAMS_A_RUN: u64 = 256;

fn generator(seed: u64, run: u64, index: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(run.wrapping_mul(STREAMS_A_RUN).wrapping_add(index));
    rng
}

/// Uniform numbers that decide on a channel's faults.
#[derive(Debug)]
pub(crate) struct Faults(ChaCha8Rng);

impl Faults {
    pub(crate) fn new(seed: u64, run: u64, stream: Stream) -> Self {
        Faults(generator(seed, run, FAULTS + stream.index()))
    }

    /// Three numbers in [0, 1) a row, asked for or not.
    pub(crate) fn draw(&mut self) -> [f64; 3] {
        std::array::from_fn(|_| rand_distr::StandardUniform.sample(&mut self.0))
    }
}

/// White Gaussian noise of one channel.
#[derive(Debug)]
pub(crate) struct White {
    rng: ChaCha8Rng,
    sd: f64,
}

impl White {
    pub(crate) fn new(seed: u64, run: u64, stream: Stream, sd: f64) -> Self {
        White {
            rng: generator(seed, run, stream.index()),
            sd,
        }
    }

    /// The next draw; advances the stream even when the standard deviation is 0.
    pub(crate) fn draw(&mut self) -> f64 {
        let z: f64 = StandardNormal.sample(&mut self.rng);
        self.sd * z
    }
}

/// Upper edge of the band of ground roughness \[Hz\]: its correlation first vanishes after 1/(2 f) = 50 ms.
const ROUGHNESS_BAND: f64 = 10.0;
const ROUGHNESS_WAVES: usize = 48;

/// Force fluctuation of rough ground: band-limited, smooth in time (so any integrator sees the same function), of the
/// given standard deviation.
///
/// # Equation
/// F(t) = sd sqrt(2/M) Σ_k cos(2π f_k t + φ_k), f_k uniform below 10 Hz, φ_k uniform; autocorrelation
/// sd² sin(2π f τ)/(2π f τ) with f = 10 Hz.
///
/// # Reference
/// M. Shinozuka, G. Deodatis, Applied Mechanics Reviews 44 (1991) 191-204 (spectral representation).
#[derive(Clone, Debug)]
pub(crate) struct Roughness {
    /// Angular frequency \[rad/s\] and phase \[rad\].
    waves: Vec<(f64, f64)>,
    amplitude: f64,
}

impl Roughness {
    pub(crate) fn new(seed: u64, run: u64, stream: Stream, sd: f64) -> Self {
        if sd == 0.0 {
            return Roughness {
                waves: Vec::new(),
                amplitude: 0.0,
            };
        }
        let mut rng = generator(seed, run, stream.index());
        let uniform = rand_distr::StandardUniform;
        let waves = (0..ROUGHNESS_WAVES)
            .map(|_| {
                let (f, p): (f64, f64) = (uniform.sample(&mut rng), uniform.sample(&mut rng));
                (TAU * ROUGHNESS_BAND * f, TAU * p)
            })
            .collect();
        Roughness {
            waves,
            amplitude: sd * (2.0 / ROUGHNESS_WAVES as f64).sqrt(),
        }
    }

    pub(crate) fn at(&self, time: f64) -> f64 {
        self.amplitude
            * self
                .waves
                .iter()
                .map(|(w, p)| (w * time + p).cos())
                .sum::<f64>()
    }
}

/// Forces and torques of rough ground on the four wheels, summed once an instant.
#[derive(Clone, Debug)]
pub(crate) struct RoughGround {
    force: [Roughness; 4],
    torque: [Roughness; 4],
    last: Option<(f64, [f64; 4], [f64; 4])>,
}

impl RoughGround {
    pub(crate) fn new(force: [Roughness; 4], torque: [Roughness; 4]) -> Self {
        RoughGround {
            force,
            torque,
            last: None,
        }
    }

    /// Forces \[N\] and torques \[N m\] at a time.
    pub(crate) fn at(&mut self, time: f64) -> ([f64; 4], [f64; 4]) {
        match self.last {
            Some((t, force, torque)) if t == time => (force, torque),
            _ => {
                let force = self.force.each_ref().map(|r| r.at(time));
                let torque = self.torque.each_ref().map(|r| r.at(time));
                self.last = Some((time, force, torque));
                (force, torque)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Over many draws of the field: variance as declared, correlation .50 at 30 ms and 0 at 50 ms.
    #[test]
    fn roughness_has_its_variance_and_correlation() {
        let (mut c0, mut c30, mut c50) = (0.0, 0.0, 0.0);
        let n = 4000;
        for seed in 0..n {
            let field = Roughness::new(seed, 0, Stream::ForceRoughness(0), 3.0);
            let at = field.at(0.7);
            c0 += at * at;
            c30 += at * field.at(0.73);
            c50 += at * field.at(0.75);
        }
        let n = n as f64;
        // sd of a mean of squares of a Gaussian: 9 sqrt(2/n) = .2; five of them.
        assert!((c0 / n - 9.0).abs() < 1.0, "{}", c0 / n);
        let expected = 9.0 * (TAU * 0.3f64).sin() / (TAU * 0.3);
        assert!((c30 / n - expected).abs() < 1.0, "{} {expected}", c30 / n);
        assert!((c50 / n).abs() < 1.0);
    }

    #[test]
    fn streams_are_independent_of_each_other() {
        let draw = |seed, run, stream| White::new(seed, run, stream, 1.0).draw();
        let one = draw(1, 0, Stream::YawRate);
        assert_eq!(one, draw(1, 0, Stream::YawRate));
        assert_ne!(one, draw(2, 0, Stream::YawRate));
        assert_ne!(one, draw(1, 1, Stream::YawRate));
        assert_ne!(one, draw(1, 0, Stream::AccelX));
    }
}
