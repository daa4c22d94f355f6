//! What really happened: columns without noise and without sensor effects.

use terra_data::{Segment, WHEELS};

/// A named column of a truth table.
#[derive(Clone, Debug, PartialEq)]
pub struct TruthColumn<'a> {
    /// Name with unit, as in a file.
    pub name: String,
    /// One value a row.
    pub values: &'a [f64],
}

/// Truth of a drive, one row a row of its log. Arrays of four are fl, fr, rl, rr.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DriveTruth {
    /// t \[s\].
    pub time: Vec<f64>,
    /// Manoeuvres.
    pub segments: Vec<Segment>,
    /// ω \[rad/s\].
    pub wheel_speed: [Vec<f64>; 4],
    /// Torque the motors deliver at the wheels \[N m\].
    pub wheel_torque: [Vec<f64>; 4],
    /// Currents of the motors \[A\]; none without a torque constant.
    pub motor_current: Option<[Vec<f64>; 4]>,
    /// v \[m/s\].
    pub ground_speed: Vec<f64>,
    /// v_y at the centre of mass, left positive \[m/s\]; 0 on a vehicle that is held.
    pub lateral_speed: Vec<f64>,
    /// r \[rad/s\].
    pub yaw_rate: Vec<f64>,
    /// Specific force along x \[m/s²\].
    pub accel_x: Vec<f64>,
    /// Specific force along y \[m/s²\].
    pub accel_y: Vec<f64>,
    /// Inclination of the ground, effects included \[rad\].
    pub pitch: Vec<f64>,
    /// Side slope, left side up positive \[rad\].
    pub roll: Vec<f64>,
    /// ∫ v dt since the run or the last reset began \[m\].
    pub distance: Vec<f64>,
    /// ψ since the run or the last reset began \[rad\].
    pub heading: Vec<f64>,
    /// x and y of the centre of mass in the ground's plane \[m\].
    pub position: [Vec<f64>; 2],
    /// F_x of each wheel on the vehicle, roughness included \[N\].
    pub drawbar_pull: [Vec<f64>; 4],
    /// F_y of each wheel on the vehicle \[N\].
    pub lateral_force: [Vec<f64>; 4],
    /// T_r \[N m\].
    pub resistive_torque: [Vec<f64>; 4],
    /// z \[m\]; none for a model without one.
    pub sinkage: Option<[Vec<f64>; 4]>,
    /// β of each wheel, left positive \[rad\].
    pub slip_angle: [Vec<f64>; 4],
    /// Torque as the drive's electronics know it, before sensor effects and noise \[N m\].
    pub torque_reading: [Vec<f64>; 4],
    /// Wheel speed as the encoder turns, before sensor effects and noise \[rad/s\].
    pub speed_reading: [Vec<f64>; 4],
    /// Library slip that the soil sees, effects on the contact included \[1\].
    pub slip: [Vec<f64>; 4],
    /// W that the soil carries \[N\].
    pub normal_load: [Vec<f64>; 4],
    /// True where a rule for standstill took part at some wheel: slip and forces are regularised there.
    pub standstill: Vec<bool>,
}

impl DriveTruth {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// True without rows.
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// All numeric columns with their names, in the order of a file.
    pub fn columns(&self) -> Vec<TruthColumn<'_>> {
        let mut columns = vec![TruthColumn {
            name: "time_s".into(),
            values: &self.time,
        }];
        four(&mut columns, "wheel_speed", "_rad_s", &self.wheel_speed);
        four(&mut columns, "wheel_torque", "_N_m", &self.wheel_torque);
        for (name, values) in [
            ("ground_speed_m_s", &self.ground_speed),
            ("yaw_rate_rad_s", &self.yaw_rate),
            ("accel_x_m_s2", &self.accel_x),
            ("pitch_rad", &self.pitch),
            ("distance_m", &self.distance),
            ("lateral_speed_m_s", &self.lateral_speed),
            ("accel_y_m_s2", &self.accel_y),
            ("roll_rad", &self.roll),
            ("heading_rad", &self.heading),
            ("position_x_m", &self.position[0]),
            ("position_y_m", &self.position[1]),
        ] {
            columns.push(TruthColumn {
                name: name.into(),
                values,
            });
        }
        four(&mut columns, "drawbar_pull", "_N", &self.drawbar_pull);
        four(
            &mut columns,
            "resistive_torque",
            "_N_m",
            &self.resistive_torque,
        );
        if let Some(sinkage) = &self.sinkage {
            four(&mut columns, "sinkage", "_m", sinkage);
        }
        four(&mut columns, "slip", "", &self.slip);
        four(&mut columns, "normal_load", "_N", &self.normal_load);
        four(&mut columns, "lateral_force", "_N", &self.lateral_force);
        four(&mut columns, "slip_angle", "_rad", &self.slip_angle);
        if let Some(current) = &self.motor_current {
            four(&mut columns, "motor_current", "_A", current);
        }
        columns
    }
}

fn four<'a>(columns: &mut Vec<TruthColumn<'a>>, stem: &str, unit: &str, four: &'a [Vec<f64>; 4]) {
    for (wheel, values) in WHEELS.iter().zip(four) {
        columns.push(TruthColumn {
            name: format!("{stem}_{wheel}{unit}"),
            values,
        });
    }
}

/// Truth of a rig's trials, one row a row of its log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RigTruth {
    /// Library slip that the soil sees \[1\].
    pub slip: Vec<f64>,
    /// W that the soil carries \[N\].
    pub normal_load: Vec<f64>,
    /// D \[N\].
    pub drawbar_pull: Vec<f64>,
    /// T at the axle, bearing damping and losses included \[N m\].
    pub torque: Vec<f64>,
    /// T_r of the soil alone \[N m\].
    pub resistive_torque: Vec<f64>,
    /// z \[m\]; none for a model without one.
    pub sinkage: Option<Vec<f64>>,
    /// v \[m/s\].
    pub travel_speed: Vec<f64>,
}

impl RigTruth {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.slip.len()
    }

    /// True without rows.
    pub fn is_empty(&self) -> bool {
        self.slip.is_empty()
    }

    /// All columns with their names, in the order of a file.
    pub fn columns(&self) -> Vec<TruthColumn<'_>> {
        let mut columns: Vec<TruthColumn<'_>> = [
            ("slip", &self.slip),
            ("normal_load_N", &self.normal_load),
            ("drawbar_pull_N", &self.drawbar_pull),
            ("torque_N_m", &self.torque),
            ("resistive_torque_N_m", &self.resistive_torque),
            ("travel_speed_m_s", &self.travel_speed),
        ]
        .into_iter()
        .map(|(name, values)| TruthColumn {
            name: name.into(),
            values,
        })
        .collect();
        if let Some(sinkage) = &self.sinkage {
            columns.push(TruthColumn {
                name: "sinkage_m".into(),
                values: sinkage,
            });
        }
        columns
    }
}
