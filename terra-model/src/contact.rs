//! One wheel's contact with the ground: all that a terrain model may look at.

use crate::real::Real;

/// A place inside a stress integral where an effect may act; a model lists the ones it honours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Hook {
    /// Factor on the pressure-sinkage stiffness k.
    Stiffness,
    /// Factor on the cohesion in the shear law.
    Cohesion,
    /// Factor on tan φ in the shear law.
    Friction,
    /// Factor on the shear modulus K.
    ShearModulus,
    /// Addend to the sinkage exponent n.
    SinkageExponent,
    /// Factor on the radius that meets the ground (the torque arm keeps the rim's radius).
    ContactRadius,
    /// Exit angle as a share of the entry angle.
    ExitRatio,
    /// Hump of the shear curve before it settles.
    ShearHump,
    /// Height of grousers or lugs.
    LugHeight,
    /// A stiffer layer below a depth.
    Layer,
    /// Sideways slip of the contact, which turns the shear stress.
    LateralSlip,
}

impl Hook {
    /// True where there is room for one effect only: a second would take the first one's place instead of adding to it.
    pub fn holds_one(self) -> bool {
        matches!(self, Hook::Layer | Hook::LateralSlip)
    }

    /// Name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Hook::Stiffness => "stiffness",
            Hook::Cohesion => "cohesion",
            Hook::Friction => "friction",
            Hook::ShearModulus => "shear modulus",
            Hook::SinkageExponent => "sinkage exponent",
            Hook::ContactRadius => "contact radius",
            Hook::ExitRatio => "exit angle",
            Hook::ShearHump => "shear hump",
            Hook::LugHeight => "lug height",
            Hook::Layer => "layer",
            Hook::LateralSlip => "lateral slip",
        }
    }
}

/// The only way into a stress integral, neutral by default. Each field is one [`Hook`].
#[derive(Clone, Copy, Debug)]
pub struct Hooks<T> {
    /// Factor on k \[1\].
    pub stiffness: T,
    /// Factor on c in the shear law \[1\].
    pub cohesion: T,
    /// Factor on tan φ in the shear law \[1\].
    pub friction: T,
    /// Factor on K \[1\].
    pub shear_modulus: T,
    /// Addend to n \[1\].
    pub sinkage_exponent: T,
    /// Factor on the contact radius \[1\].
    pub contact_radius: T,
    /// κ in θ2 = -κ θ1 \[1\].
    pub exit_ratio: T,
    /// Height of the hump of the shear curve, as a share of the plateau \[1\].
    pub shear_hump: T,
    /// Lug height \[m\].
    pub lug_height: T,
    /// Depth of a stiffer layer below the surface \[m\]; 0 means that there is none.
    pub layer_depth: T,
    /// Extra stiffness of that layer \[Pa/m\].
    pub layer_stiffness: T,
    /// tan β of the sideways slip that the shear stress follows \[1\], left positive; none: it points along the wheel.
    pub lateral_slip: Option<T>,
    /// Whether that slip only takes from the pull: no side force of the model is handed on.
    pub pull_only: bool,
}

impl<T: Real> Hooks<T> {
    /// Nothing changed.
    pub fn neutral() -> Self {
        let (zero, one) = (T::zero(), T::one());
        Hooks {
            stiffness: one,
            cohesion: one,
            friction: one,
            shear_modulus: one,
            sinkage_exponent: zero,
            contact_radius: one,
            exit_ratio: zero,
            shear_hump: zero,
            lug_height: zero,
            layer_depth: zero,
            layer_stiffness: zero,
            lateral_slip: None,
            pull_only: false,
        }
    }

    /// The same values as another scalar.
    pub fn map<S>(self, f: impl Fn(T) -> S) -> Hooks<S> {
        Hooks {
            stiffness: f(self.stiffness),
            cohesion: f(self.cohesion),
            friction: f(self.friction),
            shear_modulus: f(self.shear_modulus),
            sinkage_exponent: f(self.sinkage_exponent),
            contact_radius: f(self.contact_radius),
            exit_ratio: f(self.exit_ratio),
            shear_hump: f(self.shear_hump),
            lug_height: f(self.lug_height),
            layer_depth: f(self.layer_depth),
            layer_stiffness: f(self.layer_stiffness),
            lateral_slip: self.lateral_slip.map(f),
            pull_only: self.pull_only,
        }
    }
}

/// One wheel's contact. `slip` follows the library convention: driving 1 - v/(R ω), braking R ω/v - 1, in \[-1, 1\].
#[derive(Clone, Copy, Debug)]
pub struct Contact<T> {
    /// Library slip \[1\].
    pub slip: T,
    /// Normal load W \[N\].
    pub normal_load: T,
    /// Wheel radius R \[m\].
    pub radius: T,
    /// Wheel width b \[m\].
    pub width: T,
    /// Speed of the wheel centre v \[m/s\]; 0 when unknown.
    pub speed: T,
    /// Wheel speed ω \[rad/s\]; 0 when unknown.
    pub wheel_speed: T,
    /// Slip angle β \[rad\]: the wheel centre moves to the left of where the wheel points. In a turn of a vehicle
    /// whose wheels do not steer it is atan(x r/|v|) for a wheel x ahead of the centre.
    pub slip_angle: T,
    /// Yaw rate of the vehicle \[rad/s\].
    pub yaw_rate: T,
    /// Path that the vehicle travelled since the log began \[m\].
    pub path: T,
    /// Earlier passes over this track: 0 on virgin soil, 1 for a rear wheel in its front wheel's rut.
    pub earlier_passes: T,
    /// +1 on the right, -1 on the left, 0 for a rig.
    pub side: T,
    /// How far the wheel is ahead of the vehicle's centre of mass \[m\], 0 for a rig.
    pub ahead: T,
    /// Distance between the vehicle's axles \[m\], 0 for a rig.
    pub wheelbase: T,
    /// Time \[s\].
    pub time: T,
    /// What effects changed inside the stress integral.
    pub hooks: Hooks<T>,
    /// Entry angle \[rad\] of the same contact a little elsewhere, where a search for it may begin. Forces do not depend on it but
    /// for less than the model's tolerance.
    pub near: Option<T>,
    /// Whether that was found for these very numbers.
    pub near_is_here: bool,
}

impl<T: Real> Contact<T> {
    /// A contact on virgin soil with everything but these four at rest.
    pub fn new(slip: T, normal_load: T, radius: T, width: T) -> Self {
        let zero = T::zero();
        Contact {
            slip,
            normal_load,
            radius,
            width,
            speed: zero,
            wheel_speed: zero,
            slip_angle: zero,
            yaw_rate: zero,
            path: zero,
            earlier_passes: zero,
            side: zero,
            ahead: zero,
            wheelbase: zero,
            time: zero,
            hooks: Hooks::neutral(),
            near: None,
            near_is_here: false,
        }
    }
}

impl Contact<f64> {
    /// The same contact, hooks included, as constants of another scalar.
    pub fn lift<T: Real>(&self) -> Contact<T> {
        self.map(T::from)
    }
}

impl<T: Real> Contact<T> {
    /// The same values as another scalar.
    pub fn map<S>(self, f: impl Fn(T) -> S + Copy) -> Contact<S> {
        Contact {
            slip: f(self.slip),
            normal_load: f(self.normal_load),
            radius: f(self.radius),
            width: f(self.width),
            speed: f(self.speed),
            wheel_speed: f(self.wheel_speed),
            slip_angle: f(self.slip_angle),
            yaw_rate: f(self.yaw_rate),
            path: f(self.path),
            earlier_passes: f(self.earlier_passes),
            side: f(self.side),
            ahead: f(self.ahead),
            wheelbase: f(self.wheelbase),
            time: f(self.time),
            hooks: self.hooks.map(f),
            near: self.near.map(f),
            near_is_here: self.near_is_here,
        }
    }
}
