//! `terra-bench/counts.toml`: the committed counts, `[cpu]` tables of `kernel = instructions`.

use std::collections::BTreeMap;

/// Growth over the committed count that fails.
pub(crate) const ALLOWED: f64 = 0.02;

/// The counts of one target CPU.
pub(crate) fn read(text: &str, cpu: &str) -> Result<BTreeMap<String, f64>, String> {
    let mut counts = BTreeMap::new();
    let mut inside = false;
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.split('#').next().unwrap_or_default().trim();
        if let Some(table) = line.strip_prefix('[').and_then(|l| l.strip_suffix(']')) {
            inside = table.trim_matches('"') == cpu;
        } else if inside && !line.is_empty() {
            let wrong = || {
                format!("counts.toml:{number}: expected `kernel = instructions`, found `{line}`")
            };
            let (kernel, count) = line.split_once('=').ok_or_else(wrong)?;
            let count: f64 = count.trim().parse().map_err(|_| wrong())?;
            counts.insert(kernel.trim().trim_matches('"').to_owned(), count);
        }
    }
    Ok(counts)
}

/// How a measured count stands to the committed one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Standing {
    /// Nothing is committed.
    New,
    /// Within the allowance on both sides.
    Same,
    /// More than the allowance below: worth committing.
    Less,
    /// More than the allowance above: a failure.
    More,
}

/// Compares a count with the committed one.
pub(crate) fn compare(found: f64, committed: Option<f64>) -> Standing {
    match committed {
        None => Standing::New,
        Some(c) if found > c * (1.0 + ALLOWED) => Standing::More,
        Some(c) if found < c * (1.0 - ALLOWED) => Standing::Less,
        Some(_) => Standing::Same,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_of_the_cpu_is_read() {
        let text = "# why\n[\"x86-64\"]\nforward-solve = 30_1\n[\"x86-64-v3\"]\nforward-solve = 201.5 # faster\n\"hypothesis-update:21\" = 7\n";
        let v3 = read(text, "x86-64-v3");
        let expected = [("forward-solve", 201.5), ("hypothesis-update:21", 7.0)];
        assert_eq!(v3, Ok(expected.map(|(k, c)| (k.to_owned(), c)).into()));
        assert!(read(text, "x86-64").is_err_and(|e| e.starts_with("counts.toml:3")));
        assert_eq!(read(text, "other"), Ok(BTreeMap::new()));
    }

    #[test]
    fn two_percent_more_fails() {
        assert_eq!(compare(102.1, Some(100.0)), Standing::More);
        assert_eq!(compare(101.9, Some(100.0)), Standing::Same);
        assert_eq!(compare(97.0, Some(100.0)), Standing::Less);
        assert_eq!(compare(1.0, None), Standing::New);
    }
}
