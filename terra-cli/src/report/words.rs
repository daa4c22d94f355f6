//! Names of channels, factors and units as a person says them.

/// A channel in words, with the unit it is shown in.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Quantity {
    /// `drawbar pull`.
    pub(super) label: String,
    /// Unit it is shown in; empty for a pure number.
    pub(super) unit: String,
    /// Shown value of one SI unit.
    pub(super) factor: f64,
}

impl Quantity {
    /// `drawbar pull, N`, with a capital.
    pub(super) fn axis(&self) -> String {
        let label = capital(&self.label);
        if self.unit.is_empty() {
            label
        } else {
            format!("{label}, {}", self.unit)
        }
    }
}

/// Unit suffixes of the log columns, longest first.
const SUFFIXES: [&str; 12] = [
    "_rad_s2", "_rad_s", "_m_s2", "_m_s", "_N_m", "_kg", "_rad", "_Pa", "_N", "_A", "_s", "_m",
];

/// A column name before its unit, and the unit with its dash: (`drawbar_pull`, `_N`).
pub(super) fn unit_suffix(name: &str) -> (&str, &str) {
    SUFFIXES
        .iter()
        .find_map(|s| Some((name.strip_suffix(s)?, *s)))
        .unwrap_or((name, ""))
}
const WHEELS: [(&str, &str); 4] = [
    ("_fl", " (front left)"),
    ("_fr", " (front right)"),
    ("_rl", " (rear left)"),
    ("_rr", " (rear right)"),
];

/// The channel `name` of the data (`wheel_torque_fl_N_m`) with its SI unit; sinkage is shown in millimetres.
pub(super) fn quantity(name: &str, si: &str) -> Quantity {
    let (mut stem, _) = unit_suffix(name);
    let mut wheel = "";
    for (token, words) in WHEELS {
        if let Some(rest) = stem.strip_suffix(token) {
            (stem, wheel) = (rest, words);
        }
    }
    let label = format!("{}{wheel}", stem.replace('_', " "));
    if stem == "sinkage" && si == "m" {
        return Quantity {
            label,
            unit: "mm".to_owned(),
            factor: 1e3,
        };
    }
    Quantity {
        label,
        unit: unit(si),
        factor: 1.0,
    }
}

/// A regime factor in words, and its unit.
pub(super) fn factor(name: &str) -> (String, &'static str) {
    let unit = match name {
        "load" => "N",
        "speed" => "m/s",
        "path" => "m",
        "yaw_rate" => "rad/s",
        "time" => "s",
        _ => "",
    };
    (name.replace('_', " "), unit)
}

/// `N m`, `m/s²`, `N/mⁿ⁺²`; nothing for `1`.
pub(super) fn unit(si: &str) -> String {
    match si {
        "1" => String::new(),
        _ => si
            .replace("^(n+2)", "ⁿ⁺²")
            .replace("^(n+1)", "ⁿ⁺¹")
            .replace("^2", "²")
            .replace("^3", "³")
            .replace("s2", "s²")
            .replace(' ', "\u{a0}"),
    }
}

/// A soil parameter in words; symbols (`k_phi`, `c1`) stay as they are.
pub(super) fn parameter(name: &str) -> String {
    if name.starts_with("k_") || name.len() <= 3 {
        name.to_owned()
    } else {
        capital(&name.replace('_', " "))
    }
}

/// The unit in which a soil parameter's numbers stay short on an axis, and its shown value of one SI unit.
pub(super) fn parameter_unit(si: &str, values: impl IntoIterator<Item = f64>) -> (String, f64) {
    let finite = values.into_iter().filter(|v| v.is_finite());
    let most = finite.fold(0.0f64, |a, v| a.max(v.abs()));
    match si {
        "Pa" => ("kPa".to_owned(), 1e-3),
        "rad" => ("deg".to_owned(), 180.0 / std::f64::consts::PI),
        "m" if most < 0.5 => ("mm".to_owned(), 1e3),
        si if si.starts_with("N/m") && most >= 1e7 => (format!("M{}", unit(si)), 1e-6),
        si if si.starts_with("N/m") && most >= 1e4 => (format!("k{}", unit(si)), 1e-3),
        si => (unit(si), 1.0),
    }
}

/// A value with its unit, if any.
pub(super) fn unit_after(value: &str, unit: &str) -> String {
    if unit.is_empty() {
        value.to_owned()
    } else {
        format!("{value}\u{a0}{unit}")
    }
}

/// The first letter large.
pub(super) fn capital(text: &str) -> String {
    let mut chars = text.chars();
    match chars.next() {
        Some(first) => first.to_uppercase().chain(chars).collect(),
        None => String::new(),
    }
}

/// `a`, `a and b`, `a, b and c`.
pub(super) fn join<S: AsRef<str>>(names: &[S], last: &str) -> String {
    match names {
        [] => String::new(),
        [one] => one.as_ref().to_owned(),
        [first @ .., end] => {
            let first: Vec<&str> = first.iter().map(AsRef::as_ref).collect();
            format!("{} {last} {}", first.join(", "), end.as_ref())
        }
    }
}

/// At most `most` names, and how many are not shown.
pub(super) fn join_some<S: AsRef<str>>(names: &[S], most: usize) -> String {
    let shown: Vec<&str> = names.iter().take(most).map(AsRef::as_ref).collect();
    match names.len().saturating_sub(most) {
        0 => shown.join(", "),
        n => format!("{} and {n} more", shown.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_in_words() {
        assert_eq!(quantity("drawbar_pull_N", "N").axis(), "Drawbar pull, N");
        assert_eq!(quantity("sinkage_m", "m").axis(), "Sinkage, mm");
        assert_eq!(
            quantity("wheel_torque_fl_N_m", "N m").axis(),
            "Wheel torque (front left), N\u{a0}m"
        );
        assert_eq!(quantity("accel_x_m_s2", "m/s2").axis(), "Accel x, m/s²");
    }

    #[test]
    fn lists_in_words() {
        assert_eq!(join(&["a", "b", "c"], "or"), "a, b or c");
        assert_eq!(join_some(&["a", "b", "c"], 1), "a and 2 more");
    }
}
