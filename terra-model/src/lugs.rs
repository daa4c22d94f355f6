//! The passage of lugs: what they push at one moment, where the forces of a model are the mean over their places.

/// What all lugs in contact push together at one moment, the wheel held at its mean sinkage.
///
/// A wheel of N lugs that turns with ω goes through such a cycle N ω/2π times a second. The mean over a cycle is what the
/// model's forces hold: that of the pull is [`Contributions::lug_thrust`](crate::Contributions::lug_thrust).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LugPhase {
    /// How far the lug that left the soil last is past the exit, 0 to 2π/N \[rad\].
    pub phase: f64,
    /// Forward push \[N\].
    pub pull: f64,
    /// Torque against the drive \[N m\].
    pub torque: f64,
    /// Share of the load \[N\].
    pub load: f64,
}
