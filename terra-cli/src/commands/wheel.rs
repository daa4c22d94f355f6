//! `terra wheel`: the force-slip curve of one wheel, and its stresses.

use std::path::{Path, PathBuf};

use terra_model::{
    AnyEffect, Contact, ForceLaw, Law, LugPhase, ModelError, Registry, StressProfile, Touch,
};

use crate::args::{ReportArgs, WheelArgs};
use crate::commands::pages::acts_on;
use crate::error::CliError;
use crate::output;
use crate::report::{self, WheelRow};
use crate::soils::{Soils, parameters, values};

const HEADER: &str = "slip,normal_load_N,drawbar_pull_N,torque_N_m,thrust_N,motion_resistance_N,sinkage_m,entry_angle_rad,max_stress_angle_rad,max_normal_stress_Pa,max_shear_stress_Pa,status";
/// What `--contributions` adds: drawbar pull = rim and lug thrust - compaction and bulldozing resistance + the other.
const CONTRIBUTIONS: &str =
    "rim_thrust_N,lug_thrust_N,compaction_resistance_N,bulldozing_resistance_N,other_force_N";
const STRESS_HEADER: &str = "slip,angle_rad,normal_stress_Pa,shear_stress_Pa\n";
const LUGS_HEADER: &str = "slip,phase_rad,lug_pull_N,lug_torque_N_m,lug_load_N\n";
/// Moments of a lug's passage.
const MOMENTS: usize = 100;
/// Points of a stress profile.
const POINTS: usize = 101;

pub(crate) fn run(args: &WheelArgs) -> Result<(), CliError> {
    let beside = |asked: bool, what| {
        let csv = args.csv.as_deref().filter(|_| asked);
        csv.map(|path| path_beside(path, what))
    };
    let stress_file = beside(args.stress, "stress");
    let lugs_file = beside(args.lugs, "lugs");
    let tables = [
        args.csv.as_deref(),
        stress_file.as_deref(),
        lugs_file.as_deref(),
    ];
    let inputs: Vec<&Path> = args.soil.catalogue.as_deref().into_iter().collect();
    output::claim_with(&args.report, &tables, &inputs)?;
    let found = tables_of(&Asked {
        terrain: &args.soil.terrain,
        catalogue: args.soil.catalogue.as_deref(),
        model: &args.model,
        values: &values(&args.value)?,
        radius: args.radius,
        width: args.width,
        load: args.load,
        slips: &slips(&args.slip)?,
        contributions: args.contributions,
        stress: args.stress,
        lugs: args.lugs,
        report: &args.report,
    })?;
    let beside = [(stress_file, found.stress), (lugs_file, found.lugs)];
    if let Some(path) = &args.csv {
        output::text(Some(path), &found.forces)?;
        for (file, table) in beside {
            if let Some(table) = table {
                output::text(file.as_deref(), &table)?;
            }
        }
        return Ok(());
    }
    let mut csv = found.forces;
    for table in beside.into_iter().filter_map(|(_, table)| table) {
        csv.push('\n');
        csv.push_str(&table);
    }
    output::stdout(&csv)
}

/// What is asked of a wheel.
pub(crate) struct Asked<'a> {
    pub(crate) terrain: &'a str,
    /// Soils of one's own.
    pub(crate) catalogue: Option<&'a Path>,
    pub(crate) model: &'a str,
    /// Values in place of the soil's.
    pub(crate) values: &'a [(&'a str, f64)],
    pub(crate) radius: f64,
    pub(crate) width: f64,
    pub(crate) load: f64,
    pub(crate) slips: &'a [f64],
    pub(crate) contributions: bool,
    pub(crate) stress: bool,
    pub(crate) lugs: bool,
    pub(crate) report: &'a ReportArgs,
}

/// The tables of a wheel, as CSV.
pub(crate) struct Tables {
    pub(crate) forces: String,
    pub(crate) stress: Option<String>,
    pub(crate) lugs: Option<String>,
}

/// A law with the parameters of a soil by its id, then the magnitudes of its effects.
pub(crate) fn law_on(
    registry: &Registry,
    model: &str,
    terrain: &str,
    catalogue: Option<&Path>,
    values: &[(&str, f64)],
) -> Result<(Law, Vec<f64>), CliError> {
    let (law, magnitudes) = law(registry, model)?;
    let soils = Soils::open(catalogue)?;
    let mut p = parameters(soils.find(terrain)?, law.model(), values)?;
    p.extend(magnitudes);
    Ok((law, p))
}

/// The tables that were asked for; writes the report, where one was.
pub(crate) fn tables_of(args: &Asked<'_>) -> Result<Tables, CliError> {
    let registry = Registry::builtin().with_forms();
    let (law, p) = law_on(
        &registry,
        args.model,
        args.terrain,
        args.catalogue,
        args.values,
    )?;
    let mut csv = HEADER.to_owned();
    if args.contributions {
        csv.push(',');
        csv.push_str(CONTRIBUTIONS);
    }
    csv.push('\n');
    let mut stress = STRESS_HEADER.to_owned();
    let mut lugs = LUGS_HEADER.to_owned();
    let mut rows = vec![];
    for &slip in args.slips {
        let at = Contact::new(slip, args.load, args.radius, args.width);
        match law.forces(&p, &at) {
            Ok(f) => {
                let profile = law.stresses(&p, &at, POINTS)?;
                if args.stress && profile.is_none() {
                    return Err(CliError::usage(
                        format!(
                            "--stress: {} knows forces alone, no stresses",
                            law.model().name()
                        ),
                        "leave --stress out, or take a model of stresses such as wong-reece",
                    ));
                }
                if args.lugs {
                    lugs.push_str(&passage(&law, &p, &at)?);
                }
                let cell = |x: Option<f64>| x.map(|x| x.to_string()).unwrap_or_default();
                csv.push_str(&format!(
                    "{slip},{},{},{},{},{},{},{},{},{},{},ok",
                    args.load,
                    f.drawbar_pull,
                    f.resistive_torque,
                    f.parts.total_thrust(),
                    f.parts.motion_resistance(),
                    cell(f.sinkage),
                    cell(f.angles.map(|a| a.entry)),
                    cell(f.angles.map(|a| a.max_stress)),
                    cell(profile.as_ref().map(|s| s.max_normal.normal_stress)),
                    cell(profile.as_ref().map(|s| s.max_shear.shear_stress)),
                ));
                if args.contributions {
                    let p = &f.parts;
                    csv.push_str(&format!(
                        ",{},{},{},{},{}",
                        p.thrust,
                        p.lug_thrust,
                        p.compaction_resistance,
                        p.bulldozing_resistance,
                        p.other
                    ));
                }
                csv.push('\n');
                rows.push(WheelRow {
                    slip,
                    drawbar: f.drawbar_pull,
                    torque: f.resistive_torque,
                    sinkage: f.sinkage.unwrap_or(f64::NAN),
                    stresses: profile.iter().flat_map(stresses).collect(),
                });
                for point in profile.iter().flat_map(|s| &s.points) {
                    stress.push_str(&format!(
                        "{slip},{},{},{}\n",
                        point.angle, point.normal_stress, point.shear_stress
                    ));
                }
            }
            Err(ModelError::NoEquilibrium { .. }) => {
                let none = if args.contributions { ",,,,," } else { "" };
                csv.push_str(&format!(
                    "{slip},{},,,,,,,,,,no-equilibrium{none}\n",
                    args.load
                ));
                rows.push(WheelRow {
                    slip,
                    ..WheelRow::NONE
                });
            }
            Err(e) => return Err(e.into()),
        }
    }
    output::report(args.report, || page(args, rows))?;
    Ok(Tables {
        forces: csv,
        stress: args.stress.then_some(stress),
        lugs: args.lugs.then_some(lugs),
    })
}

/// What the lugs push during the passage of one, line by line.
fn passage(law: &Law, p: &[f64], at: &Contact<f64>) -> Result<String, CliError> {
    let Some(cycle) = law.lug_cycle(p, at, MOMENTS)? else {
        return Err(CliError::usage(
            format!("--lugs: {} has no lugs that push", law.model().name()),
            "leave --lugs out, or take grouser-passive with lug_height and lug_count above 0",
        ));
    };
    let line = |c: &LugPhase| {
        format!(
            "{},{},{},{},{}\n",
            at.slip, c.phase, c.pull, c.torque, c.load
        )
    };
    Ok(cycle.iter().map(line).collect())
}

fn stresses(profile: &StressProfile) -> impl Iterator<Item = [f64; 3]> + '_ {
    let points = profile.points.iter();
    points.map(|p| [p.angle, p.normal_stress, p.shear_stress])
}

fn page(args: &Asked<'_>, rows: Vec<WheelRow>) -> report::Page {
    let view = report::WheelView {
        title: "Forces and stresses".to_owned(),
        load: args.load,
        radius: args.radius,
        rows,
    };
    report::Page {
        title: "What does the ground give this wheel?".to_owned(),
        subtitle: format!(
            "{} on {}: radius {} m, width {} m, load {} N{}",
            args.model,
            args.terrain,
            args.radius,
            args.width,
            args.load,
            with(args.values)
        ),
        sections: vec![report::wheel_section(&view)],
        provenance: vec![("terra".to_owned(), env!("CARGO_PKG_VERSION").to_owned())],
    }
}

/// Values in place of the soil's, for a line of text.
pub(super) fn with<N: std::fmt::Display>(values: &[(N, f64)]) -> String {
    let all = values
        .iter()
        .map(|(name, value)| format!(", {name}={value}"));
    all.collect()
}

/// The file of another table: its name before the extension.
fn path_beside(path: &Path, what: &str) -> PathBuf {
    match path.extension() {
        Some(e) => path.with_extension(format!("{what}.{}", e.to_string_lossy())),
        None => path.with_extension(what),
    }
}

/// `model+effect=magnitude+effect/form=magnitude+...` to a law and its magnitudes.
pub(crate) fn law(registry: &Registry, text: &str) -> Result<(Law, Vec<f64>), CliError> {
    let mut names = vec![];
    let mut magnitudes = vec![];
    for (k, part) in text.split('+').enumerate() {
        let (name, magnitude) = part
            .split_once('=')
            .map_or((part, None), |(n, m)| (n, Some(m)));
        names.push(name);
        if k == 0 {
            continue;
        }
        let value = match magnitude {
            Some(m) => m
                .parse::<f64>()
                .ok()
                .filter(|m| m.is_finite())
                .ok_or_else(|| {
                    CliError::usage(
                        format!("'{m}' is no magnitude for {name}"),
                        "write for example slip-sinkage=0.3",
                    )
                })?,
            None => {
                return Err(CliError::usage(
                    format!("effect {name} without a magnitude"),
                    format!("write {name}=0.3; `terra effects` gives the unit"),
                ));
            }
        };
        magnitudes.push(value);
    }
    let law = registry.law(&names.join("+"))?;
    on_a_wheel(&law)?;
    Ok((law, magnitudes))
}

/// Refuses effects that leave the forces of a wheel on its own as they are: those of sensors, vehicles and drivetrains, and
/// those that act by what such a wheel does not have.
pub(super) fn on_a_wheel(law: &Law) -> Result<(), CliError> {
    for effect in law.effects() {
        if let Some(place) = elsewhere(&**effect) {
            return Err(CliError::usage(
                format!(
                    "effect {} acts on {place}: it changes no force of one wheel",
                    effect.name()
                ),
                "leave it out here; `terra simulate` makes logs with it",
            ));
        }
        if !effect.reads().is_empty() {
            let by: Vec<&str> = effect.reads().iter().map(|r| r.name()).collect();
            return Err(CliError::usage(
                format!(
                    "effect {} acts by the {}, which one wheel at a slip and a load does not have: it changes nothing",
                    effect.name(),
                    by.join(", ")
                ),
                "leave it out here; `terra simulate` makes logs with it",
            ));
        }
    }
    Ok(())
}

/// Where an effect acts that does not act on a wheel.
fn elsewhere(effect: &dyn AnyEffect) -> Option<String> {
    let touches = effect.touches();
    let on_it = |t: &Touch| matches!(t, Touch::Contact | Touch::Forces);
    let places: Vec<&str> = touches.iter().map(|t| acts_on(*t)).collect();
    (!touches.iter().any(on_it)).then(|| places.join(", "))
}

/// `A:B:STEP`, B included to rounding, or one number.
pub(super) fn slips(text: &str) -> Result<Vec<f64>, CliError> {
    const MOST: f64 = 1e6;
    let bad = |why: &str| {
        CliError::usage(
            format!("--slip {text}: {why}"),
            "write A:B:STEP with A <= B in [-1, 1], for example 0.05:0.95:0.05",
        )
    };
    let parts: Vec<f64> = text
        .split(':')
        .map(|p| p.trim().parse::<f64>().ok().filter(|x| x.is_finite()))
        .collect::<Option<_>>()
        .ok_or_else(|| bad("not numbers"))?;
    let out = match parts[..] {
        [one] => vec![one],
        [a, b, step] if step > 0.0 && a <= b => {
            let n = ((b - a) / step + 1e-9).floor();
            if n > MOST {
                return Err(bad("more than a million slips"));
            }
            // a + k step carries the rounding of step; ten decimals are what a person can have meant.
            (0..=n as usize)
                .map(|k| ((a + k as f64 * step) * 1e10).round() / 1e10)
                .collect()
        }
        _ => return Err(bad("expected one slip, or A:B:STEP with STEP > 0")),
    };
    if out.iter().any(|s| s.abs() > 1.0) {
        return Err(bad("library slip lies in [-1, 1]"));
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_include_both_ends() {
        assert_eq!(
            slips("0.05:0.2:0.05").unwrap_or_default(),
            vec![0.05, 0.1, 0.15, 0.2]
        );
        assert_eq!(slips("-0.2").unwrap_or_default(), vec![-0.2]);
        for bad in [
            "", "a", "0:1", "0:1:0", "1:0:0.1", "0:2:0.5", "nan", "0:1:-0.1",
        ] {
            assert!(slips(bad).is_err(), "{bad}");
        }
    }
}
