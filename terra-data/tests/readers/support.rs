//! What several test files share.

use terra_data::{DataError, Rover, parse_rover};

/// A rover with the example values of the contract and no optional table.
pub(crate) const ROVER: &str = r#"[vehicle]
mass_kg = 100.0
yaw_inertia_kg_m2 = 10.0
track_m = 0.6
wheelbase_m = 0.6
cg_to_front_axle_m = 0.3
cg_height_m = 0.22
yaw_damping_N_m_s = 8.0

[wheel]
radius_m = 0.254
width_m = 0.15
inertia_kg_m2 = 0.25
damping_N_m_s = 0.1

[terrain]
model = "wong-reece"
"#;

/// A rig without optional table; `[terrain]` is last, so that a test may go on in it.
pub(crate) const RIG: &str = r#"[wheel]
radius_m = 0.254
width_m = 0.15

[terrain]
model = "wong-reece"
"#;

/// The smallest drive log's header.
pub(crate) const DRIVE: &str = "time_s,wheel_speed_fl_rad_s,wheel_speed_fr_rad_s,wheel_speed_rl_rad_s,wheel_speed_rr_rad_s,ground_speed_m_s";

pub(crate) fn rover(extra: &str) -> Rover {
    parse_rover(&format!("{ROVER}{extra}"), "rover.toml").unwrap()
}

pub(crate) fn rig(extra: &str) -> Rover {
    parse_rover(&format!("{RIG}{extra}"), "rig.toml").unwrap()
}

/// The kind of an error: the name of its variant.
pub(crate) fn kind(error: &DataError) -> String {
    let text = format!("{:?}", error.problem());
    text.split([' ', '(', '{']).next().unwrap().to_owned()
}

/// A bad input with the error it must give: kind, line, column.
pub(crate) type Case<'a> = (&'a str, Vec<u8>, &'a str, Option<u64>, Option<u64>);

/// Checks every case and reports all that differ.
pub(crate) fn check<T>(cases: &[Case<'_>], read: impl Fn(&[u8]) -> Result<T, DataError>) {
    let mut wrong = Vec::new();
    for (name, bytes, expected, line, column) in cases {
        match read(bytes) {
            Ok(_) => wrong.push(format!("{name}: no error, expected {expected}")),
            Err(e) => {
                let found = (kind(&e), e.line(), e.column());
                if found != ((*expected).to_owned(), *line, *column) {
                    wrong.push(format!(
                        "{name}: expected {expected} {line:?} {column:?}, found {found:?}: {e}"
                    ));
                }
                // The text begins with the place, as editors and people expect it.
                let mut place = e.file().to_owned();
                for n in [line, column].into_iter().flatten() {
                    place.push_str(&format!(":{n}"));
                }
                assert!(
                    e.to_string().starts_with(&format!("{place}: ")),
                    "{name}: {e}"
                );
            }
        }
    }
    assert!(
        wrong.is_empty(),
        "{} of {}:\n{}",
        wrong.len(),
        cases.len(),
        wrong.join("\n")
    );
}
