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
    /// v \[m/s\].
    pub ground_speed: Vec<f64>,
    /// r \[rad/s\].
    pub yaw_rate: Vec<f64>,
    /// Specific force along x \[m/s²\].
    pub accel_x: Vec<f64>,
    /// Inclination of the ground, effects included \[rad\].
    pub pitch: Vec<f64>,
    /// ∫ v dt since the run or the last reset began \[m\].
    pub distance: Vec<f64>,
    /// F_x of each wheel on the vehicle, roughness included \[N\].
    pub drawbar_pull: [Vec<f64>; 4],
    /// T_r \[N m\].
    pub resistive_torque: [Vec<f64>; 4],
    /// z \[m\]; none for a model without one.
    pub sinkage: Option<[Vec<f64>; 4]>,
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
