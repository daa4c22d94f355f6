//! The key of a challenge: what is withheld, and the commitment to it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::error::CliError;
use crate::input::sha256;

/// Schema of a key file.
pub(crate) const SCHEMA: &str = "terra-challenge-key/1";

/// A key file.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct KeyFile {
    /// `terra-challenge-key/1`.
    pub schema: String,
    /// What every case was made from; a key without it cannot be simulated again.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub design: Option<SealedDesign>,
    /// Which draws were kept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub draws: Option<Gate>,
    /// One entry a case.
    pub cases: Vec<KeyCase>,
}

/// What a draw must show to become a case, whatever its kind.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct Gate {
    /// Windows that must move, without effects and in the log itself.
    pub moving_windows: usize,
    /// Length of a window \[s\].
    pub window_s: f64,
    /// Speed of vehicle and rims above which a window moves \[m/s\].
    pub speed_m_s: f64,
    /// Draws that moved too little or did not get through, of all cases.
    pub rejected: usize,
}

/// Design and nominal simulator, as text.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct SealedDesign {
    /// Its name.
    pub name: String,
    /// The rover file.
    pub rover: String,
    /// The scenario file, without what a case draws.
    pub scenario: String,
}

/// One case's secret.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct KeyCase {
    /// Name of the case.
    pub case: String,
    /// 64 hexadecimal digits.
    pub nonce: String,
    /// What the digest is over, as it stands in the file; [`CaseKey`] is its meaning.
    pub key: Value,
}

/// What is withheld in a case.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct CaseKey {
    /// none, single, pair, off-library, form-variant.
    pub kind: String,
    /// What the truth has and the nominal simulator lacks.
    pub effects: Vec<SealedEffect>,
    /// Seed of the noise.
    pub seed: u64,
    /// Draws before this one that moved too little or did not get through.
    #[serde(default)]
    pub rejected: usize,
    /// True soil of the left and the right wheels by parameter name; a rig uses `left`.
    #[serde(default)]
    pub soil: BTreeMap<String, BTreeMap<String, f64>>,
    /// The catalogue soil that the true soil was drawn around.
    pub terrain: Value,
}

/// An effect of the truth.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct SealedEffect {
    /// Formula.
    #[serde(default = "default_form")]
    pub form: String,
    /// One number, or a list when the effect has several.
    pub magnitude: Value,
    /// Name.
    pub name: String,
}

fn default_form() -> String {
    "default".to_owned()
}

/// JSON with sorted keys and without spaces.
pub fn canonical(value: &Value) -> String {
    fn write(value: &Value, out: &mut String) {
        match value {
            Value::Object(map) => {
                let sorted: BTreeMap<&String, &Value> = map.iter().collect();
                out.push('{');
                for (k, (name, item)) in sorted.into_iter().enumerate() {
                    if k > 0 {
                        out.push(',');
                    }
                    out.push_str(&Value::from(name.as_str()).to_string());
                    out.push(':');
                    write(item, out);
                }
                out.push('}');
            }
            Value::Array(items) => {
                out.push('[');
                for (k, item) in items.iter().enumerate() {
                    if k > 0 {
                        out.push(',');
                    }
                    write(item, out);
                }
                out.push(']');
            }
            other => out.push_str(&other.to_string()),
        }
    }
    let mut out = String::new();
    write(value, &mut out);
    out
}

/// SHA-256 of nonce, `|`, canonical key.
pub fn digest(case: &KeyCase) -> String {
    sha256(format!("{}|{}", case.nonce, canonical(&case.key)).as_bytes())
}

impl KeyCase {
    /// The meaning of the key.
    ///
    /// # Errors
    /// A key that is not one, naming the case.
    pub fn read(&self) -> Result<CaseKey, CliError> {
        CaseKey::deserialize(&self.key).map_err(|e| CliError::BadData {
            message: format!("{}: the key is not one: {e}", self.case),
            help: None,
        })
    }
}

impl CaseKey {
    /// The names that a right answer holds, joined in alphabetical order; `none` without effects.
    pub fn truth(&self) -> String {
        match self.kind.as_str() {
            "off-library" => "unknown".to_owned(),
            _ if self.effects.is_empty() => "none".to_owned(),
            _ => {
                let mut names: Vec<&str> = self.effects.iter().map(|e| e.name.as_str()).collect();
                names.sort_unstable();
                names.join("+")
            }
        }
    }
}

/// Reads a JSON file of a known shape.
///
/// # Errors
/// Bad data with file, line and column.
pub(crate) fn read_json<T: for<'de> Deserialize<'de>>(path: &Path) -> Result<T, CliError> {
    let text = std::fs::read_to_string(path).map_err(|e| CliError::BadData {
        message: format!("{}: cannot be read: {e}", path.display()),
        help: None,
    })?;
    serde_json::from_str(&text).map_err(|e| {
        let (line, column) = (e.line().max(1), e.column().max(1));
        let what = e.to_string();
        // The place is said once, in front.
        let what = what.split(" at line ").next().unwrap_or(&what).to_owned();
        CliError::BadData {
            message: format!("{}:{line}:{column}: {what}", path.display()),
            help: None,
        }
    })
}

impl KeyFile {
    /// Reads a key file.
    ///
    /// # Errors
    /// Bad data with file, line and column; a case named twice; a schema that is not known.
    pub fn open(path: &Path) -> Result<Self, CliError> {
        let file: KeyFile = read_json(path)?;
        let bad = |message: String| CliError::BadData {
            message: format!("{}:1:1: {message}", path.display()),
            help: None,
        };
        if file.schema != SCHEMA {
            return Err(bad(format!(
                "schema '{}', expected '{SCHEMA}'",
                file.schema
            )));
        }
        let mut seen = BTreeSet::new();
        for case in &file.cases {
            if !seen.insert(case.case.as_str()) {
                return Err(bad(format!("{} is there twice", case.case)));
            }
            case.read().map_err(|e| bad(e.to_string()))?;
        }
        Ok(file)
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn canonical_text_has_sorted_keys_and_no_spaces() {
        let v = json!({"b": [1, 2.5, {"z": null, "a": true}], "a": "x \"y\""});
        assert_eq!(
            canonical(&v),
            r#"{"a":"x \"y\"","b":[1,2.5,{"a":true,"z":null}]}"#
        );
    }

    /// By another program: printf '%s' 'ab|{"kind":"none"}' | sha256sum.
    #[test]
    fn digest_is_of_nonce_bar_key() {
        let case = KeyCase {
            case: "case_001".into(),
            nonce: "ab".into(),
            key: json!({"kind": "none"}),
        };
        assert_eq!(digest(&case), DIGEST_BY_SHA256SUM);
    }

    const DIGEST_BY_SHA256SUM: &str =
        "2452c5e72b4fcca2dbb59c1f009b153116ee83c90e233d34eb46283341b11bcb";

    #[test]
    fn a_pair_is_joined_in_alphabetical_order() {
        let effect = |name: &str| SealedEffect {
            form: "default".into(),
            magnitude: json!(1.0),
            name: name.into(),
        };
        let mut key = CaseKey {
            kind: "pair".into(),
            effects: vec![effect("torque-bias"), effect("slope")],
            seed: 1,
            rejected: 0,
            soil: BTreeMap::new(),
            terrain: json!("dry_sand"),
        };
        assert_eq!(key.truth(), "slope+torque-bias");
        key.kind = "off-library".into();
        assert_eq!(key.truth(), "unknown");
        key.kind = "none".into();
        key.effects.clear();
        assert_eq!(key.truth(), "none");
    }
}
