//! What a drive's world has beside soils, manoeuvres and effects.

use std::collections::BTreeMap;

use terra_data::Start;

/// Everything optional about a drive or a rig; the default is the nominal vehicle with perfect motors on soils that do not
/// change.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct World {
    /// What holds the vehicle sideways.
    pub side_slip: SideSlip,
    /// The vehicle stays upright, as in a planar simulator: no load goes to the outer wheels in turns, nor to the lower ones on a
    /// slope aside.
    pub upright: bool,
    /// Soil under fl, fr, rl, rr where the two wheels of a side differ.
    pub wheels: Option<[Start; 4]>,
    /// Changes of soil along the path, in order.
    pub patches: Vec<Patch>,
    /// Remember in the plane where wheels have been: a rear wheel runs in a rut only where its front wheel made one,
    /// and ruts of this run count for every later crossing.
    pub ruts: bool,
    /// The motors.
    pub motor: Motor,
    /// Sensors that are not what `[noise]` alone says, by column name with or without the wheel.
    pub sensors: BTreeMap<String, SensorSettings>,
    /// How badly a rig holds its load: sd of the true load as a share of the wanted one \[1\].
    pub load_hold: f64,
}

/// What holds the vehicle sideways.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SideSlip {
    /// The ground holds its centre of mass on the line it points along: the nominal vehicle.
    #[default]
    Held,
    /// The soil's own shear under each wheel.
    Free,
}

/// A change of soil along the path.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    /// Where it begins \[m\] of signed path.
    pub from: f64,
    /// Length over which the old soil gives way to the new one \[m\].
    pub blend: f64,
    /// Soil under fl, fr, rl, rr from there on.
    pub terrain: [Start; 4],
}

/// The motors and their controllers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor {
    /// Largest torque at the wheel \[N m\].
    pub torque_limit: f64,
    /// Wheel speed at which no driving torque is left \[rad/s\].
    pub no_load_speed: f64,
    /// Torque lost a unit of wheel speed \[N m s\].
    pub droop: f64,
    /// Pure delay of commands \[s\].
    pub delay: f64,
    /// Time constant of the torque \[s\].
    pub lag: f64,
    /// η of the gears \[1\].
    pub efficiency: f64,
    /// Coulomb friction of the gears \[N m\] at the wheel.
    pub coulomb: f64,
    /// Viscous friction of the gears \[N m s\] at the wheel.
    pub viscous: f64,
    /// k_t: torque at the wheel an ampere \[N m/A\], before friction and efficiency; 0 where no current is asked for.
    pub torque_constant: f64,
    /// ω_n of the speed controller \[rad/s\].
    pub control_frequency: f64,
}

impl Default for Motor {
    fn default() -> Self {
        Motor {
            torque_limit: f64::INFINITY,
            no_load_speed: f64::INFINITY,
            droop: 0.0,
            delay: 0.0,
            lag: 0.0,
            efficiency: 1.0,
            coulomb: 0.0,
            viscous: 0.0,
            torque_constant: 0.0,
            control_frequency: 10.0,
        }
    }
}

/// One sensor: reading = quantised(saturated(scale x truth(t - delay) + bias + noise + outlier)), or missing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorSettings {
    /// Factor \[1\].
    pub scale: f64,
    /// Addend, in the channel's unit.
    pub bias: f64,
    /// 1-sigma in place of `[noise]`, in the channel's unit (still times `noise_scale`).
    pub noise: Option<f64>,
    /// Delay \[s\]; before a run or a reset the sensor shows its beginning.
    pub delay: f64,
    /// Rows a second that have a reading; the others are missing.
    pub rate: Option<f64>,
    /// Share of readings that are missing \[1\].
    pub dropout: f64,
    /// Share of readings that are off \[1\].
    pub outliers: f64,
    /// By how much, up or down, in the channel's unit.
    pub outlier_size: f64,
    /// Smallest reading.
    pub min: f64,
    /// Largest reading.
    pub max: f64,
    /// Step between readings, in the channel's unit; 0 for none.
    pub step: f64,
}

impl Default for SensorSettings {
    fn default() -> Self {
        SensorSettings {
            scale: 1.0,
            bias: 0.0,
            noise: None,
            delay: 0.0,
            rate: None,
            dropout: 0.0,
            outliers: 0.0,
            outlier_size: 0.0,
            min: f64::NEG_INFINITY,
            max: f64::INFINITY,
            step: 0.0,
        }
    }
}
