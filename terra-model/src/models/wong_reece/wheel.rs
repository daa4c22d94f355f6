//! The geometry and the stresses of the Wong-Reece wheel.
//!
//! Each branch of the contact runs from its outer end (u = 0: entry in front, exit behind) to the angle of maximum
//! stress (u = 1). The integrals themselves are in [`super::kernel`], and in [`super::general`] for what is rare.

use crate::contact::{Contact, Hooks};
use crate::models::bekker::Ground;
use crate::models::displacement::displacement;
use crate::quadrature::sinc;
use crate::real::{Real, Root, is_plain};
use crate::root::{MAX_ENTRY_ANGLE, RISING_EXIT};
use crate::stress::StressPoint;

/// Everything but the entry angle, ready for integration.
#[derive(Clone, Copy)]
pub(super) struct Wheel<T> {
    pub(super) ground: Ground<T>,
    /// Radius that meets the soil.
    pub(super) radius: T,
    /// Radius at which soil is sheared: the tips of the lugs.
    pub(super) shear_radius: T,
    pub(super) width: T,
    pub(super) exit_ratio: T,
    pub(super) hump: T,
    /// Depth and extra stiffness of a layer below the surface.
    pub(super) layer: Option<(T, T)>,
    /// tan β of the sideways slip.
    pub(super) lateral: Option<T>,
    pub(super) braking: bool,
}

/// Load, thrust, compaction resistance, ∫τ dθ and the side force, all per R b.
#[derive(Clone, Copy)]
pub(super) struct Integrals<T> {
    pub(super) load: T,
    pub(super) thrust: T,
    pub(super) compaction: T,
    pub(super) shear: T,
    pub(super) lateral: T,
}

impl<T: Real> Integrals<T> {
    /// Each as another scalar.
    pub(super) fn map<S>(self, f: impl Fn(T) -> S) -> Integrals<S> {
        Integrals {
            load: f(self.load),
            thrust: f(self.thrust),
            compaction: f(self.compaction),
            shear: f(self.shear),
            lateral: f(self.lateral),
        }
    }

    /// A step further along their slopes.
    pub(super) fn moved(self, slopes: &Integrals<T>, step: T) -> Integrals<T> {
        Integrals {
            load: self.load + slopes.load * step,
            thrust: self.thrust + slopes.thrust * step,
            compaction: self.compaction + slopes.compaction * step,
            shear: self.shear + slopes.shear * step,
            lateral: self.lateral + slopes.lateral * step,
        }
    }
}

impl<T: Real> Wheel<T> {
    pub(super) fn new(ground: Ground<T>, at: &Contact<T>) -> Self {
        let hooks: &Hooks<T> = &at.hooks;
        let radius = at.radius * hooks.contact_radius;
        // A layer at depth zero is no layer; one of no extra stiffness still carries a derivative.
        let zero = T::Primal::zero();
        let has_layer = zero.any_lt(hooks.layer_depth.primal());
        Wheel {
            ground,
            radius,
            shear_radius: radius + hooks.lug_height,
            width: at.width,
            exit_ratio: hooks.exit_ratio,
            hump: hooks.shear_hump,
            layer: has_layer.then_some((hooks.layer_depth, hooks.layer_stiffness)),
            // No sideways slip and no derivative in it: the plain wheel, bit for bit.
            lateral: hooks
                .lateral_slip
                .filter(|tan| !is_plain::<T>() || zero.any_lt(tan.abs().primal())),
            braking: ground.slip.primal().any_lt(zero),
        }
    }

    /// A bare rim on virgin soil, driven.
    pub(super) fn plain(ground: Ground<T>, radius: T, width: T) -> Self {
        Wheel {
            ground,
            radius,
            shear_radius: radius,
            width,
            exit_ratio: T::zero(),
            hump: T::zero(),
            layer: None,
            lateral: None,
            braking: false,
        }
    }

    pub(super) fn map<S: Real>(&self, f: impl Fn(T) -> S + Copy) -> Wheel<S> {
        Wheel {
            ground: self.ground.map(f),
            radius: f(self.radius),
            shear_radius: f(self.shear_radius),
            width: f(self.width),
            exit_ratio: f(self.exit_ratio),
            hump: f(self.hump),
            layer: self
                .layer
                .map(|(depth, stiffness)| (f(depth), f(stiffness))),
            lateral: self.lateral.map(f),
            braking: self.braking,
        }
    }

    /// The angle up to which the load of the driven wheel rises with its sinkage.
    #[inline]
    pub(super) fn rises_to(&self) -> f64 {
        if self.exit_ratio.primal().max_lane() > RISING_EXIT {
            0.0
        } else {
            MAX_ENTRY_ANGLE
        }
    }

    pub(super) fn apex(&self, entry: T) -> T {
        self.ground.apex_ratio * entry
    }

    pub(super) fn exit(&self, entry: T) -> T {
        -(self.exit_ratio * entry)
    }

    /// E along the wheel and across it.
    pub(super) fn mobilised(&self, entry: T, angle: T) -> (T, T) {
        let per_modulus = self.shear_radius / self.ground.shear_modulus;
        let y = per_modulus * displacement(self.ground.slip, entry, angle);
        match self.lateral {
            None => {
                let e = self.mobilised_at(y.abs());
                (y.select_lt(T::zero(), -e, e), T::zero())
            }
            Some(tan) => {
                // j_y = R (1 - i) (θ1 - θ) tan β; the strength points along (j_x, j_y).
                let across = per_modulus * (T::one() - self.ground.slip) * (entry - angle) * tan;
                let both = (y.squared() + across.squared() + f64::MIN_POSITIVE).sqrt();
                let e = self.mobilised_at(both);
                (e * (y / both), e * (across / both))
            }
        }
    }

    /// (1 - e^-y)(1 + hump y e^(1 - y)) for y >= 0.
    fn mobilised_at(&self, y: T) -> T {
        let rise = -(-y).exp_m1();
        rise * (self.hump * y * (T::one() - rise) * std::f64::consts::E + 1.0)
    }

    /// (cos θF - cos θ1)/u at u = 2 half/d on the front branch: the depth over R without its factor u, the same on both.
    pub(super) fn depth_base(&self, entry: T, half: T) -> T {
        let d = T::one() - self.ground.apex_ratio;
        (T::one() - half)
            * sinc(entry * (T::one() - half))
            * sinc(entry * half)
            * d
            * entry.squared()
    }
}

impl Wheel<f64> {
    /// Stresses at one angle of the contact; the shear stress acts at an arm.
    pub(super) fn stress_at(&self, entry: f64, angle: f64, shear_arm: f64) -> StressPoint {
        let (exit, apex) = (self.exit(entry), self.apex(entry));
        let u = if angle >= apex {
            (entry - angle) / (entry - apex)
        } else {
            (angle - exit) / (apex - exit)
        };
        let u = u.clamp(0.0, 1.0);
        let depth =
            self.radius * u * self.depth_base(entry, 0.5 * (1.0 - self.ground.apex_ratio) * u);
        let mut normal_stress = self.ground.stiffness * depth.powf(self.ground.exponent);
        if let Some((top, stiffness)) = self.layer {
            normal_stress += stiffness * (depth - top).max(0.0);
        }
        let (along, _) = self.mobilised(entry, angle);
        let shear_stress =
            (self.ground.cohesion + normal_stress * self.ground.tan_friction) * along;
        StressPoint {
            angle,
            normal_stress,
            shear_stress,
            shear_arm,
        }
    }
}
