//! Every function, with what C may hand in by mistake.
#![allow(clippy::unwrap_used, clippy::panic)]
#![allow(
    unsafe_code,
    reason = "the tests call the interface as C does, with pointers"
)]

use std::ffi::{CStr, CString};
use std::ptr::{null, null_mut};

use terra_capi::*;

fn said() -> String {
    unsafe { CStr::from_ptr(terra_last_error()) }
        .to_str()
        .unwrap()
        .to_owned()
}

fn law(name: &str) -> *mut TerraLaw {
    let mut law = null_mut();
    let name = CString::new(name).unwrap();
    let status = unsafe { terra_law_new(name.as_ptr(), &mut law) };
    assert_eq!(status, TerraStatus::Ok, "{}", said());
    assert_eq!(said(), "");
    law
}

fn set(law: *mut TerraLaw, name: &CStr, value: f64) -> TerraStatus {
    unsafe { terra_law_set_parameter(law, name.as_ptr(), value) }
}

const CONTACT: TerraContact = TerraContact {
    slip: 0.2,
    normal_load: 245.25,
    radius: 0.254,
    width: 0.15,
    speed: 0.0,
    slip_angle: 0.0,
    earlier_passes: 0.0,
};

fn none() -> TerraForces {
    TerraForces {
        drawbar_pull: 1.0,
        resistive_torque: 1.0,
        lateral_force: 1.0,
        sinkage: 1.0,
        entry_angle: 1.0,
    }
}

#[test]
fn null_is_refused_everywhere() {
    let (made, mut value, mut out) = (law("wong-reece"), 0.0, none());
    let (name, c) = (c"cohesion".as_ptr(), &CONTACT);
    let mut slopes = [0.0; 6];
    let mut handle = null_mut();
    let bad = unsafe {
        [
            terra_law_new(null(), &mut handle),
            terra_law_new(name, null_mut()),
            terra_law_set_terrain(null_mut(), name),
            terra_law_set_terrain(made, null()),
            terra_law_set_parameter(null_mut(), name, 1.0),
            terra_law_set_parameter(made, null(), 1.0),
            terra_law_get_parameter(null(), name, &mut value),
            terra_law_get_parameter(made, null(), &mut value),
            terra_law_get_parameter(made, name, null_mut()),
            terra_law_forces(null(), c, &mut out),
            terra_law_forces(made, null(), &mut out),
            terra_law_forces(made, c, null_mut()),
            terra_law_forces_many(null(), c, 1, &mut out, null_mut()),
            terra_law_forces_many(made, null(), 1, &mut out, null_mut()),
            terra_law_forces_many(made, c, 1, null_mut(), null_mut()),
            terra_law_forces_and_slopes(made, c, &mut out, null_mut()),
            terra_law_forces_and_slopes(made, c, null_mut(), slopes.as_mut_ptr()),
            terra_law_new(c"\xff".as_ptr(), &mut handle),
        ]
    };
    assert!(bad.iter().all(|s| *s == TerraStatus::BadPointer), "{bad:?}");
    assert!(said().contains("UTF-8"));
    unsafe {
        assert_eq!(terra_law_parameter_count(null()), 0);
        assert!(terra_law_parameter_name(null(), 0).is_null());
        terra_law_free(null_mut());
        terra_law_free(made);
    }
}

#[test]
fn parameters_by_name() {
    let made = law("wong-reece+slip-sinkage+grousers");
    let count = unsafe { terra_law_parameter_count(made) };
    let names: Vec<String> = (0..count)
        .map(|k| {
            unsafe { CStr::from_ptr(terra_law_parameter_name(made, k)) }
                .to_str()
                .unwrap()
                .to_owned()
        })
        .collect();
    assert!(unsafe { terra_law_parameter_name(made, count) }.is_null());
    assert!(names.contains(&"friction_angle".to_owned()), "{names:?}");
    assert!(
        names.contains(&"slip-sinkage.magnitude".to_owned()),
        "{names:?}"
    );

    let mut value = 0.0;
    let get = |name: &CStr, value: &mut f64| unsafe {
        terra_law_get_parameter(made, name.as_ptr(), value)
    };
    assert_eq!(get(c"cohesion", &mut value), TerraStatus::Ok);
    assert!(value.is_nan(), "not set");
    assert_eq!(get(c"slip-sinkage.magnitude", &mut value), TerraStatus::Ok);
    assert_eq!(value, 0.0);
    // Without a soil there are no forces.
    let mut out = none();
    assert_eq!(
        unsafe { terra_law_forces(made, &CONTACT, &mut out) },
        TerraStatus::OutOfRange
    );
    assert!(out.drawbar_pull.is_nan() && out.sinkage.is_nan());

    assert_eq!(
        unsafe { terra_law_set_terrain(made, c"dry_sand".as_ptr()) },
        TerraStatus::Ok
    );
    // 1.04 kPa, as Wong 2001 gives it.
    assert_eq!(get(c"cohesion", &mut value), TerraStatus::Ok);
    assert_eq!(value, 1040.0);
    assert_eq!(set(made, c"cohesion", 2e3), TerraStatus::Ok);
    assert_eq!(get(c"cohesion", &mut value), TerraStatus::Ok);
    assert_eq!(value, 2e3);
    assert_eq!(set(made, c"cohesoin", 2e3), TerraStatus::UnknownName);
    assert!(said().contains("'cohesion'"), "{}", said());
    assert_eq!(set(made, c"cohesion", f64::NAN), TerraStatus::OutOfRange);
    assert_eq!(
        unsafe { terra_law_set_terrain(made, c"dry_snad".as_ptr()) },
        TerraStatus::UnknownName
    );
    unsafe { terra_law_free(made) };
}

#[test]
fn each_wheel_has_its_own_status() {
    let made = law("wong-reece");
    assert_eq!(
        unsafe { terra_law_set_terrain(made, c"dry_sand".as_ptr()) },
        TerraStatus::Ok
    );
    let contacts = [
        CONTACT,
        TerraContact {
            normal_load: 1e9,
            ..CONTACT
        },
        TerraContact {
            slip: 3.0,
            ..CONTACT
        },
        TerraContact {
            slip: 0.5,
            ..CONTACT
        },
    ];
    let (mut out, mut statuses) = ([none(); 4], [TerraStatus::Internal; 4]);
    let first = unsafe {
        terra_law_forces_many(
            made,
            contacts.as_ptr(),
            4,
            out.as_mut_ptr(),
            statuses.as_mut_ptr(),
        )
    };
    assert_eq!(first, TerraStatus::NoEquilibrium);
    use TerraStatus::*;
    assert_eq!(statuses, [Ok, NoEquilibrium, OutOfRange, Ok]);
    assert!(out[1].drawbar_pull.is_nan() && out[2].drawbar_pull.is_nan());
    for k in [0, 3] {
        let mut alone = none();
        assert_eq!(
            unsafe { terra_law_forces(made, &contacts[k], &mut alone) },
            Ok
        );
        assert_eq!(alone, out[k]);
    }
    unsafe { terra_law_free(made) };
}

/// Central differences of the forces, a second way to the slopes.
#[test]
fn slopes_are_those_of_the_forces() {
    let made = law("wong-reece");
    assert_eq!(
        unsafe { terra_law_set_terrain(made, c"dry_sand".as_ptr()) },
        TerraStatus::Ok
    );
    let (mut out, mut slopes) = (none(), [0.0; 6]);
    let status =
        unsafe { terra_law_forces_and_slopes(made, &CONTACT, &mut out, slopes.as_mut_ptr()) };
    assert_eq!(status, TerraStatus::Ok);
    let at = |slip: f64, load: f64| {
        let contact = TerraContact {
            slip: CONTACT.slip + slip,
            normal_load: CONTACT.normal_load + load,
            ..CONTACT
        };
        let mut f = none();
        assert_eq!(
            unsafe { terra_law_forces(made, &contact, &mut f) },
            TerraStatus::Ok
        );
        [f.drawbar_pull, f.resistive_torque, f.sinkage]
    };
    for (column, (slip, load)) in [(1e-6, 0.0), (0.0, 1e-3)].into_iter().enumerate() {
        let (above, below) = (at(slip, load), at(-slip, -load));
        for row in 0..3 {
            let expected = (above[row] - below[row]) / (2.0 * (slip + load));
            let found = slopes[2 * row + column];
            assert!(
                (found - expected).abs() < 1e-6 * (1.0 + expected.abs()),
                "{row} {column}: {found} {expected}"
            );
        }
    }
    unsafe { terra_law_free(made) };
}

#[test]
fn the_header_knows_its_version() {
    let header =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/include/terra.h")).unwrap();
    assert!(header.contains(&format!(
        "#define TERRA_ABI_VERSION {}\n",
        terra_abi_version()
    )));
}
