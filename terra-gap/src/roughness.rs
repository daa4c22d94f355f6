//! The ground's roughness: fast force fluctuation that no sensor's noise covers.
//!
//! A wrong model varies slowly with slip and load, so roughness shows in the scatter between successive windows, robust
//! variance of (r_k - r_{k-1})/sqrt 2 less the known noise, and in the scatter inside a window beyond the sensor's noise;
//! the smaller of the two is taken.

use nalgebra::DVector;
use terra_data::Rover;

use crate::dataset::DataSet;
use crate::noise::NoiseModel;
use crate::rig::median;

/// Adds the roughness the rover file states, or else the one the log shows, channel by channel.
pub(crate) fn add(
    noise: &mut NoiseModel,
    data: &mut DataSet,
    rover: &Rover,
    residual: &DVector<f64>,
) {
    data.notes.retain(|n| !n.starts_with("roughness"));
    let vehicle = rover.nominal_vehicle();
    let stacked: Vec<(usize, usize)> = data.stacked().collect();
    let diagonal: Vec<f64> = noise
        .blocks
        .iter()
        .flat_map(|b| b.diagonal().iter().copied().collect::<Vec<_>>())
        .collect();
    let mut extra = vec![];
    for (c, channel) in data.channels.iter().enumerate() {
        let torque = channel.name.starts_with("wheel_torque");
        let key = if torque {
            "roughness_N_m"
        } else {
            "roughness_N"
        };
        let stated = rover.noise.get(key).zip(vehicle).map(|(sd, v)| {
            // Tens of ms of correlation leave about four independent samples in a window of .2 s.
            let mean = sd / (rover.gap.window / 0.05).max(1.0).sqrt();
            match channel.name.as_str() {
                _ if torque => mean,
                "yaw_acceleration_rad_s2" => mean * v.track / v.yaw_inertia,
                _ => 2.0 * mean / v.mass,
            }
        });
        let variance = match stated {
            Some(sd) => sd * sd,
            None => {
                let rows: Vec<usize> = (0..stacked.len()).filter(|&k| stacked[k].1 == c).collect();
                let steps: Vec<f64> = rows
                    .windows(2)
                    .filter(|w| {
                        data.observations[stacked[w[0]].0].group
                            == data.observations[stacked[w[1]].0].group
                    })
                    .map(|w| (residual[w[1]] - residual[w[0]]) / std::f64::consts::SQRT_2)
                    .collect();
                if steps.len() < 8 {
                    continue;
                }
                let middle = median(steps.iter().copied());
                let sd = 1.4826 * median(steps.iter().map(|s| (s - middle).abs()));
                let known = median(rows.iter().map(|&k| diagonal[k]));
                // A wrong model changes from window to window too, a controller works inside them: each alone says too much.
                let inside = data.short_scatter.get(c).copied().flatten();
                (sd * sd - known)
                    .max(0.0)
                    .min(inside.unwrap_or(f64::INFINITY))
            }
        };
        if variance > 0.0 {
            extra.push((c, variance));
            data.notes.push(format!(
                "roughness of {}: {:.3} {} per window, {}",
                channel.name,
                variance.sqrt(),
                channel.unit,
                if stated.is_some() {
                    "as stated"
                } else {
                    "from the log's short-time scatter"
                }
            ));
        }
    }
    for (c, variance) in extra {
        noise.add_channel_variance(data, c, variance);
    }
}
