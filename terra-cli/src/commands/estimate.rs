//! `terra estimate`: wheel forces, torques and slips with 1-sigma, one row a row of the log.

use std::fmt::Write;
use std::path::Path;

use terra_data::{DriveLog, LogKind, Rover, WHEELS};
use terra_ekf::spaces::longitudinal_robot::{F, R, V};
use terra_ekf::{FirstPass, ForceConfig, ForceRun, Step, wheel_estimates};

use crate::args::ReportArgs;
use crate::commands::estimate_view;
use crate::error::CliError;
use crate::input::{BLOCK, LogFile, rover};
use crate::output::{self, csv_number, csv_text};
use crate::progress::Spinner;
use crate::report;
use crate::robot::{config, forces, rows};

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
    let _spinner = Spinner::start(quiet, "estimating forces");
    let within = |e: CliError| e.in_files(log, rover_path);
    if !asked.smooth && !asked.report.asked() {
        let passes = Passes::new(&file, &rover, asked.filter).map_err(within)?;
        let run = passes.first().map_err(within)?;
        return output::pieces(asked.out, |put| passes.second(run, put)).map_err(within);
    }
    let known = Known {
        file: &file,
        name: log,
        rover: &rover,
        rover_name: rover_path,
        rover_sha256: &rover_sha,
    };
    let table = in_memory(&known, asked.filter, asked.smooth, asked.report)?;
    output::text(asked.out, &table)
}

/// A log with its rover file.
pub(crate) struct Known<'a> {
    pub(crate) file: &'a LogFile<'a>,
    pub(crate) name: &'a Path,
    pub(crate) rover: &'a Rover,
    pub(crate) rover_name: &'a Path,
    pub(crate) rover_sha256: &'a str,
}

/// The table of a log that is held in memory as a whole; writes the report, where one was asked for.
pub(crate) fn in_memory(
    known: &Known<'_>,
    filter: &str,
    smooth: bool,
    report: &ReportArgs,
) -> Result<String, CliError> {
    let drive = known.file.drive(known.rover)?;
    let forces = forces(&drive, known.rover, filter, smooth)
        .map_err(|e| e.in_files(known.name, known.rover_name))?;
    let table = csv(&drive, &forces.steps)?;
    output::report(report, || report::Page {
        title: "What forces does the ground give?".to_owned(),
        subtitle: known.name.display().to_string(),
        sections: vec![report::estimate_section(&estimate_view::view(
            &drive, &table,
        ))],
        provenance: vec![
            ("terra".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
            ("log SHA-256".to_owned(), known.file.sha256()),
            ("rover SHA-256".to_owned(), known.rover_sha256.to_owned()),
        ],
    })?;
    Ok(table)
}

/// A log that is run as it is read: twice, in memory that does not grow with it.
pub(crate) struct Passes<'a> {
    file: &'a LogFile<'a>,
    rover: &'a Rover,
    config: ForceConfig,
}

/// A run, and the rows it is to be over.
pub(crate) struct Run<'p> {
    run: ForceRun<'p>,
    rows: usize,
}

impl<'a> Passes<'a> {
    /// # Errors
    /// A log whose header or first row does not do, and as [`crate::robot::config`].
    pub(crate) fn new(
        file: &'a LogFile<'a>,
        rover: &'a Rover,
        filter: &str,
    ) -> Result<Self, CliError> {
        let head = file.drive_blocks(rover)?.next_block(1)?.unwrap_or_default();
        let config = config(&head.log, rover, filter, false)?;
        Ok(Passes {
            file,
            rover,
            config,
        })
    }

    /// Reads the whole log for what the filter must know of each segment before it begins.
    ///
    /// # Errors
    /// A row that cannot be read, and what the filter refuses.
    pub(crate) fn first(&self) -> Result<Run<'_>, CliError> {
        let mut pass = FirstPass::new(&self.config)?;
        let mut log = self.file.drive_blocks(self.rover)?;
        let mut count = 0;
        while let Some(block) = log.next_block(BLOCK)? {
            for (begins, row) in rows(&block) {
                if begins.is_some() {
                    pass.segment();
                }
                pass.row(&row);
            }
            count += block.log.len();
        }
        let run = pass.run()?;
        Ok(Run { run, rows: count })
    }

    /// Runs the filter and hands the table of the contract on, piece by piece.
    ///
    /// # Errors
    /// As `put`, as the filter, and a log that is no longer what it was.
    pub(crate) fn second(
        &self,
        Run {
            mut run,
            rows: count,
        }: Run<'_>,
        put: &mut dyn FnMut(&str) -> Result<(), CliError>,
    ) -> Result<(), CliError> {
        let mut log = self.file.drive_blocks(self.rover)?;
        let (mut names, mut steps, mut read) = (Vec::new(), Vec::new(), 0);
        let mut out = header();
        out.push('\n');
        let lines = |out: &mut String, steps: &mut Vec<Step>, names: &[String]| {
            steps.drain(..).try_for_each(|step| {
                let segment = names.get(step.segment).map_or("", String::as_str);
                line(out, segment, &step)
            })
        };
        while let Some(block) = log.next_block(BLOCK)? {
            for (begins, row) in rows(&block) {
                if let Some(name) = begins {
                    names.push(name.to_owned());
                    run.segment(&mut steps)?;
                }
                run.row(&row, &mut steps)?;
                lines(&mut out, &mut steps, &names)?;
            }
            read += block.log.len();
            put(&out)?;
            out.clear();
        }
        if read != count {
            return Err(CliError::data(
                format!("the log had {count} rows when it was first read, and now has {read}"),
                "estimate a copy of a log that is still being written",
            ));
        }
        run.finish(&mut steps)?;
        lines(&mut out, &mut steps, &names)?;
        put(&out)
    }
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

/// The columns of the contract: value and 1-sigma in pairs.
fn header() -> String {
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
    header
}

/// The line of a step.
fn line(out: &mut String, segment: &str, step: &Step) -> Result<(), CliError> {
    let _ = write!(
        out,
        "{},{},{},{},{}",
        step.time,
        csv_text(segment),
        step.flag,
        csv_number(step.nis),
        step.dof
    );
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
    Ok(())
}

/// The table of the contract, of a log in memory. Its segments cover all rows, so that each row has its step.
pub(crate) fn csv(log: &DriveLog, steps: &[Step]) -> Result<String, CliError> {
    let mut out = header();
    out.push('\n');
    for step in steps {
        let segment = log.segments.get(step.segment);
        line(&mut out, segment.map_or("", |s| s.name.as_str()), step)?;
    }
    Ok(out)
}
