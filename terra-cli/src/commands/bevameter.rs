//! `terra bevameter`: soil from plates pressed into it and from shear tests.

use std::path::Path;

use crate::args::{BevameterArgs, BevameterKind, ReportArgs};
use crate::bevameter::{Columns, Kind, Soil, Tests, fit, read, to_json};
use crate::error::CliError;
use crate::input;
use crate::output::{self, short, table};
use crate::report;

pub(crate) fn run(args: &BevameterArgs) -> Result<(), CliError> {
    let inputs: Vec<_> = [Some(args.log.as_path()), args.columns.as_deref()]
        .into_iter()
        .flatten()
        .collect();
    output::claim_with(&args.report, &[args.json.as_deref()], &inputs)?;
    let kind = match args.kind {
        BevameterKind::Plate => Kind::Plate,
        BevameterKind::Shear => Kind::Shear,
    };
    let columns = match &args.columns {
        Some(path) => Columns::read(path)?,
        None => Columns::default(),
    };
    let bytes = input::bytes(&args.log)?;
    let (tests, soils) = fitted(&args.log, &bytes, kind, &columns, &args.report)?;
    if let Some(path) = &args.json {
        output::json(Some(path), &to_json(kind, &tests, &soils))?;
    }
    output::stdout(&summary(&tests, &soils))
}

/// The tests of a log and the soils they tell; writes the report, where one was asked for.
pub(crate) fn fitted(
    log: &Path,
    bytes: &[u8],
    kind: Kind,
    columns: &Columns,
    report: &ReportArgs,
) -> Result<(Tests, Vec<Soil>), CliError> {
    let tests = read(log, bytes, kind, columns)?;
    let soils = fit(kind, &tests, columns)?;
    output::report(report, || report::Page {
        title: match kind {
            Kind::Plate => "What do the plates say?".to_owned(),
            Kind::Shear => "What do the shear tests say?".to_owned(),
        },
        subtitle: log.display().to_string(),
        sections: soils
            .iter()
            .map(|s| {
                report::bevameter_section(&report::BevameterView {
                    title: title(s),
                    shear: kind == Kind::Shear,
                    fits: s.fits.clone(),
                })
            })
            .collect(),
        provenance: vec![
            ("terra".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
            ("log SHA-256".to_owned(), tests.sha256.clone()),
        ],
    })?;
    Ok((tests, soils))
}

fn title(soil: &Soil) -> String {
    if soil.name.is_empty() {
        "Soil".to_owned()
    } else {
        format!("Soil {}", soil.name)
    }
}

fn summary(tests: &Tests, soils: &[Soil]) -> String {
    let mut out = format!(
        "{}: {} rows, {} with a missing cell, {} left out\n",
        tests.file, tests.rows, tests.missing, tests.left_out
    );
    for soil in soils {
        out.push_str(&format!(
            "\n{}, {} tests\n",
            title(soil),
            soil.fits.tests.len()
        ));
        let best = soil.fits.best().map(|l| l.law);
        let rows: Vec<Vec<String>> = soil
            .fits
            .laws
            .iter()
            .map(|l| {
                let values: Vec<String> = l
                    .parameters
                    .iter()
                    .map(|p| {
                        let interval = if p.low.is_finite() && p.high.is_finite() {
                            format!("[{}, {}]", short(p.low), short(p.high))
                        } else {
                            "[not known]".to_owned()
                        };
                        let unit = if p.unit == "1" { "" } else { p.unit };
                        let text = format!("{} {} {interval} {unit}", p.name, short(p.value));
                        text.trim_end().to_owned()
                    })
                    .collect();
                let mark = if best == Some(l.law) { "*" } else { "" };
                vec![
                    format!("{}{mark}", l.law),
                    format!("{:.1}", 100.0 * l.rms_share),
                    format!("{:.1}", l.delta_bic),
                    values.join("; "),
                ]
            })
            .collect();
        out.push_str(&table(
            &["law", "misfit %", "BIC +", "parameters [95 %]"],
            &rows,
        ));
        for u in &soil.fits.undetermined {
            out.push_str(&format!("  cannot be known: {u}\n"));
        }
    }
    out
}
