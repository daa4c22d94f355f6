//! `terra estimate`: wheel forces, torques and slips with 1-sigma, one row a row of the log.

use std::fmt::Write;
use std::path::Path;

use terra_data::{DriveLog, LogKind, WHEELS};
use terra_ekf::spaces::longitudinal_robot::{F, R, V};
use terra_ekf::{Step, wheel_estimates};

use crate::args::ReportArgs;
use crate::commands::estimate_view;
use crate::error::CliError;
use crate::input::{LogFile, rover};
use crate::output::{self, csv_number, csv_text};
use crate::progress::Spinner;
use crate::report;
use crate::robot::forces;

/// What was asked for.
pub(crate) struct Asked<'a> {
    pub(crate) log: &'a Path,
    pub(crate) rover: &'a Path,
    pub(crate) filter: &'a str,
    pub(crate) smooth: bool,
    pub(crate) out: Option<&'a Path>,
    pub(crate) report: &'a ReportArgs,
}

pub(crate) fn run(asked: &Asked<'_>, quiet: bool) -> Result<(), CliError> {
    let (log, rover_path) = (asked.log, asked.rover);
    output::claim_with(asked.report, &[asked.out], &[log, rover_path])?;
    let (rover, rover_sha) = rover(rover_path)?;
    let file = LogFile::open(log)?;
    if file.kind(&rover)? == LogKind::Rig {
        return Err(no_rig(log));
    }
    let drive = file.drive(&rover)?;
    let _spinner = Spinner::start(quiet, "estimating forces");
    let forces = forces(&drive, &rover, asked.filter, asked.smooth)
        .map_err(|e| e.in_files(log, rover_path))?;
    let table = csv(&drive, &forces.steps)?;
    output::report(asked.report, || report::Page {
        title: "What forces does the ground give?".to_owned(),
        subtitle: log.display().to_string(),
        sections: vec![report::estimate_section(&estimate_view::view(
            &drive, &table,
        ))],
        provenance: vec![
            ("terra".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
            ("log SHA-256".to_owned(), file.sha256()),
            ("rover SHA-256".to_owned(), rover_sha),
        ],
    })?;
    output::text(asked.out, &table)
}

/// A rig log has nothing to estimate.
pub(crate) fn no_rig(log: &Path) -> CliError {
    CliError::usage(
        format!(
            "{}: a rig log measures the forces itself; there is nothing to estimate",
            log.display()
        ),
        "use `terra identify` or `terra gap`",
    )
}

/// The table of the contract: value and 1-sigma in pairs.
pub(crate) fn csv(log: &DriveLog, steps: &[Step]) -> Result<String, CliError> {
    let mut header = "time_s,segment,flag,nis,nis_dof".to_owned();
    let pair = |header: &mut String, stem: &str, unit: &str| {
        let _ = write!(header, ",{stem}{unit},{stem}_sd{unit}");
    };
    pair(&mut header, "ground_speed", "_m_s");
    pair(&mut header, "yaw_rate", "_rad_s");
    for w in WHEELS {
        pair(&mut header, &format!("wheel_speed_{w}"), "_rad_s");
        pair(&mut header, &format!("resistive_torque_{w}"), "_N_m");
        pair(&mut header, &format!("slip_{w}"), "");
        pair(&mut header, &format!("normal_load_{w}"), "_N");
        let _ = write!(header, ",drawbar_pull_{w}_share_N");
    }
    for side in ["left", "right"] {
        pair(&mut header, &format!("side_force_{side}"), "_N");
    }
    let columns = header.split(',').count();
    let mut out = header;
    out.push('\n');

    let mut steps = steps.iter().peekable();
    for row in 0..log.len() {
        let segment = log
            .segments
            .iter()
            .find(|s| s.rows.contains(&row))
            .map_or("", |s| s.name.as_str());
        let _ = write!(out, "{},{}", log.time[row], csv_text(segment));
        // Rows the filter could not run over stay in place, empty and flagged.
        let Some(step) = steps.next_if(|s| s.row == row) else {
            out.push_str(",not_observable");
            out.extend(std::iter::repeat_n(',', columns - 3));
            out.push('\n');
            continue;
        };
        let _ = write!(out, ",{},{},{}", step.flag, csv_number(step.nis), step.dof);
        let belief = &step.belief;
        let state = |k: usize| (belief.mean[k], belief.covariance[(k, k)].sqrt());
        for k in [V, R] {
            let (value, sd) = state(k);
            let _ = write!(out, ",{},{}", csv_number(value), csv_number(sd));
        }
        for w in wheel_estimates(belief, &step.vehicle)? {
            let slip = w.slip.map_or((f64::NAN, f64::NAN), |s| (s.value, s.sd));
            for (value, sd) in [
                (w.wheel_speed.value, w.wheel_speed.sd),
                (w.torque.value, w.torque.sd),
                slip,
                (w.normal_load.value, w.normal_load.sd),
            ] {
                let _ = write!(out, ",{},{}", csv_number(value), csv_number(sd));
            }
            let _ = write!(out, ",{}", csv_number(w.drawbar_share.unwrap_or(f64::NAN)));
        }
        for k in F {
            let (value, sd) = state(k);
            let _ = write!(out, ",{},{}", csv_number(value), csv_number(sd));
        }
        out.push('\n');
    }
    Ok(out)
}
