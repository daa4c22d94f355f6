//! The terrain of Chrono's soil contact model as JSON, in and out.
//!
//! Keys (SI, but the friction limit in degrees): `Bekker Kphi`, `Bekker Kc`, `Bekker n exponent`, `Mohr cohesive limit`,
//! `Mohr friction limit`, `Janosi shear coefficient`. They are found at any depth, because Chrono's scenes wrap them.
//! Beside them terra writes `Parameter source` and `Parameter confidence`, which Chrono passes over, and reads them again.

use std::borrow::Cow;
use std::io::{self, Write};
use std::path::Path;

use serde_json::{Value, json};
use terra_model::catalogue::{Confidence, Terrain};

use crate::atomic::atomic_write;
use crate::error::{DataError, Origin};
use crate::problem::Problem;
use crate::read_terrains::{self, MARKS};
use crate::source::read_text;
use crate::write::number;

const KEYS: [&str; 6] = [
    "Bekker Kphi",
    "Bekker Kc",
    "Bekker n exponent",
    "Mohr cohesive limit",
    "Mohr friction limit",
    "Janosi shear coefficient",
];
/// Where the values come from, and how far to trust them: of terra's own, for the way back.
const SOURCE: &str = "Parameter source";
const CONFIDENCE: &str = "Parameter confidence";

/// Reads one terrain from a Chrono JSON file; its id is the file's name.
///
/// # Errors
/// [`DataError::Configuration`]: no JSON, a key missing, or a value that is no number of that kind.
pub fn read_scm_json(path: impl AsRef<Path>) -> Result<Terrain, DataError> {
    let path = path.as_ref();
    let origin = Origin::configuration(&path.display().to_string());
    let text = read_text(path, &origin, "a terrain as JSON")?;
    let id = path
        .file_stem()
        .map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    parse_scm_json(&text, &origin.file, &id)
}

/// [`read_scm_json`] of a text; `name` stands for the file in errors.
///
/// # Errors
/// As there.
pub fn parse_scm_json(text: &str, name: &str, id: &str) -> Result<Terrain, DataError> {
    let origin = Origin::configuration(name);
    let root: Value = serde_json::from_str(text).map_err(|e| {
        origin.fail(
            e.line() as u64,
            e.column() as u64,
            Problem::WrongType {
                key: "the file".to_owned(),
                found: format!("no JSON ({e})"),
                expected: "a JSON object",
            },
        )
    })?;
    let mut values = [0.0; 6];
    for (key, value) in KEYS.iter().zip(&mut values) {
        let found = find(&root, key).ok_or_else(|| {
            origin.fail_file(Problem::MissingKey {
                key: (*key).to_owned(),
                table: "the terrain".to_owned(),
                expected: KEYS.join(", "),
            })
        })?;
        *value = found.as_f64().ok_or_else(|| {
            origin.fail_file(Problem::WrongType {
                key: (*key).to_owned(),
                found: found.to_string(),
                expected: "a number",
            })
        })?;
    }
    let [k_phi, k_c, n, cohesion, friction, shear] = values;
    let legal = [
        (n > 0.0, 2, "above 0"),
        (cohesion >= 0.0, 3, "at least 0 Pa"),
        ((0.0..90.0).contains(&friction), 4, "degrees in [0, 90)"),
        (shear > 0.0, 5, "above 0 m"),
    ];
    if let Some((_, k, expected)) = legal.iter().find(|(ok, _, _)| !ok) {
        return Err(origin.fail_file(Problem::OutOfRange {
            key: KEYS.get(*k).copied().unwrap_or_default().to_owned(),
            found: number(values.get(*k).copied()),
            expected: (*expected).to_owned(),
        }));
    }
    let label = find(&root, "Name").and_then(Value::as_str).unwrap_or(id);
    let confidence = match find(&root, CONFIDENCE) {
        None => Confidence::Own,
        Some(mark) => mark.as_str().and_then(Confidence::of_mark).ok_or_else(|| {
            origin.fail_file(Problem::WrongType {
                key: CONFIDENCE.to_owned(),
                found: mark.to_string(),
                expected: MARKS,
            })
        })?,
    };
    let source = match find(&root, SOURCE) {
        None => name,
        Some(source) => source.as_str().ok_or_else(|| {
            origin.fail_file(Problem::WrongType {
                key: SOURCE.to_owned(),
                found: source.to_string(),
                expected: "text",
            })
        })?,
    };
    Ok(Terrain {
        id: Cow::Owned(id.to_owned()),
        set: Cow::Borrowed("chrono"),
        name: Cow::Owned(label.to_owned()),
        moisture: None,
        sinkage_exponent: n,
        k_c,
        k_phi,
        cohesion,
        friction_angle: friction.to_radians(),
        shear_modulus: Some(shear),
        c1: None,
        c2: None,
        class: Cow::Borrowed(""),
        confidence,
        source: Cow::Owned(source.to_owned()),
    })
}

fn find<'v>(value: &'v Value, key: &str) -> Option<&'v Value> {
    match value {
        Value::Object(map) => map
            .get(key)
            .or_else(|| map.values().find_map(|inner| find(inner, key))),
        Value::Array(list) => list.iter().find_map(|inner| find(inner, key)),
        _ => None,
    }
}

/// A terrain with the keys of Chrono; a missing shear modulus is null, because Chrono has no default for it.
pub fn scm_json(terrain: &Terrain) -> Value {
    json!({
        "Name": terrain.id,
        "Bekker Kphi": terrain.k_phi,
        "Bekker Kc": terrain.k_c,
        "Bekker n exponent": terrain.sinkage_exponent,
        "Mohr cohesive limit": terrain.cohesion,
        "Mohr friction limit": terrain.friction_angle.to_degrees(),
        "Janosi shear coefficient": terrain.shear_modulus,
        SOURCE: terrain.source,
        CONFIDENCE: terrain.confidence.mark(),
    })
}

/// Writes terrains as a catalogue that [`read_terrains`](crate::read_terrains) reads, atomically.
///
/// # Errors
/// [`DataError::Write`].
pub fn write_terrains(path: impl AsRef<Path>, terrains: &[Terrain]) -> Result<(), DataError> {
    atomic_write(path, |w| write_terrains_to(w, terrains))
}

/// [`write_terrains`] to a stream.
///
/// # Errors
/// Those of the stream.
pub fn write_terrains_to(out: impl Write, terrains: &[Terrain]) -> io::Result<()> {
    let mut csv = csv::Writer::from_writer(out);
    csv.write_record([
        "id",
        "set",
        "name",
        "n",
        "kc_kN_m_n1",
        "kphi_kN_m_n2",
        "c_kPa",
        "phi_deg",
        "K_m",
        "c1",
        "c2",
        read_terrains::CONFIDENCE,
        read_terrains::SOURCE,
    ])?;
    for t in terrains {
        let optional = |v: Option<f64>| v.map_or_else(|| "NA".to_owned(), |v| number(Some(v)));
        csv.write_record([
            t.id.to_string(),
            t.set.to_string(),
            t.name.to_string(),
            number(Some(t.sinkage_exponent)),
            number(Some(t.k_c / 1e3)),
            number(Some(t.k_phi / 1e3)),
            number(Some(t.cohesion / 1e3)),
            number(Some(t.friction_angle.to_degrees())),
            optional(t.shear_modulus),
            optional(t.c1),
            optional(t.c2),
            t.confidence.mark().to_owned(),
            t.source.to_string(),
        ])?;
    }
    csv.flush()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read_terrains_from;

    /// The units of Chrono's own soft soil: pascals and metres as they are, 20 degrees as radians.
    const SOFT: &str = r#"{"Name": "soft", "Type": "Terrain", "Parameters": {
        "Bekker Kphi": 0.2e6, "Bekker Kc": 0, "Bekker n exponent": 1.1,
        "Mohr cohesive limit": 250.0, "Mohr friction limit": 20, "Janosi shear coefficient": 0.01}}"#;

    #[test]
    fn units_of_chrono() {
        let t = parse_scm_json(SOFT, "soft.json", "soft").unwrap();
        assert_eq!(
            (t.k_phi, t.k_c, t.sinkage_exponent, t.cohesion),
            (2e5, 0.0, 1.1, 250.0)
        );
        assert!((t.friction_angle - 0.349_065_850_4).abs() < 1e-10);
        assert_eq!(t.shear_modulus, Some(0.01));
    }

    #[test]
    fn out_and_in_again_and_through_a_catalogue() {
        let t = parse_scm_json(SOFT, "soft.json", "soft").unwrap();
        let again = parse_scm_json(&scm_json(&t).to_string(), "again.json", "soft").unwrap();
        assert_eq!(
            (again.k_phi, again.cohesion, again.shear_modulus),
            (t.k_phi, t.cohesion, t.shear_modulus)
        );
        assert!((again.friction_angle - t.friction_angle).abs() < 1e-15);
        let mut csv = vec![];
        write_terrains_to(&mut csv, std::slice::from_ref(&t)).unwrap();
        let read = read_terrains_from(csv.as_slice(), "soil.csv").unwrap();
        assert_eq!(read[0].id, "soft");
        assert!((read[0].k_phi - 2e5).abs() < 1e-9 && (read[0].cohesion - 250.0).abs() < 1e-12);
    }

    /// To Chrono, from there to a catalogue, and in again: the soil still says where it comes from. Chrono's own files do not.
    #[test]
    fn source_and_trust_go_to_chrono_and_back() {
        let known = terra_model::catalogue::find("rubicon_sandy_loam").unwrap();
        let json = scm_json(known).to_string();
        let again = parse_scm_json(&json, "soil.json", "soil").unwrap();
        let mut csv = vec![];
        write_terrains_to(&mut csv, std::slice::from_ref(&again)).unwrap();
        let read = read_terrains_from(csv.as_slice(), "soil.csv").unwrap();
        assert_eq!(read[0].source, known.source);
        assert_eq!(read[0].confidence, Confidence::Single);
        let plain = parse_scm_json(SOFT, "soft.json", "soft").unwrap();
        assert_eq!(
            (plain.source.as_ref(), plain.confidence),
            ("soft.json", Confidence::Own)
        );
        let e = parse_scm_json(&json.replace("\"B\"", "\"D\""), "soil.json", "soil")
            .unwrap_err()
            .to_string();
        assert!(e.contains("\"D\"") && e.contains("A, B, C or user"), "{e}");
    }

    #[test]
    fn what_is_wrong_is_named() {
        let without = SOFT.replace("Mohr friction limit", "friction");
        let e = parse_scm_json(&without, "s.json", "s")
            .unwrap_err()
            .to_string();
        assert!(e.contains("Mohr friction limit"), "{e}");
        let steep = SOFT.replace(
            "\"Mohr friction limit\": 20",
            "\"Mohr friction limit\": 120",
        );
        let e = parse_scm_json(&steep, "s.json", "s")
            .unwrap_err()
            .to_string();
        assert!(e.contains("120") && e.contains("[0, 90)"), "{e}");
        let e = parse_scm_json("{\"a\": ", "s.json", "s").unwrap_err();
        assert_eq!(e.line(), Some(1));
    }
}
