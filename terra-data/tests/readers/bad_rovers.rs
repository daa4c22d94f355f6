//! Bad rover files, each with the kind, line and column (characters) of the error it must give.

use terra_data::{parse_rover, read_rover};

use crate::support::{Case, RIG, ROVER, check, kind};

/// Lines of `ROVER`: [vehicle] 1, mass 2 ... damping 8, [wheel] 10, radius 11 ... damping 14, [terrain] 16, model 17.
fn with(from: &str, to: &str) -> Vec<u8> {
    assert!(ROVER.contains(from), "{from}");
    ROVER.replacen(from, to, 1).into_bytes()
}

/// `ROVER` and a table after it: the table's name is in line 19, its first key in line 20.
fn and(table: &str) -> Vec<u8> {
    format!("{ROVER}\n{table}\n").into_bytes()
}

/// `ROVER` and a key of `[terrain]`, in line 18.
fn terrain(key: &str) -> Vec<u8> {
    format!("{ROVER}{key}\n").into_bytes()
}

fn rover(bytes: &[u8]) -> Result<terra_data::Rover, terra_data::DataError> {
    parse_rover(std::str::from_utf8(bytes).unwrap(), "rover.toml")
}

#[test]
fn tables_and_keys() {
    #[rustfmt::skip]
    let cases: Vec<Case<'_>> = vec![
        ("no TOML", with("mass_kg = 100.0", "mass_kg = = 100.0"), "Syntax", Some(2), Some(11)),
        ("a key twice", with("track_m = 0.6", "mass_kg = 1.0"), "Syntax", Some(4), Some(1)),
        ("unknown table", and("[noize]"), "UnknownKey", Some(19), Some(2)),
        ("unknown key", with("mass_kg", "mas_kg"), "UnknownKey", Some(2), Some(1)),
        ("unknown key, indented", with("track_m", "   trak_m"), "UnknownKey", Some(4), Some(4)),
        ("key without unit", with("radius_m", "radius"), "UnknownKey", Some(11), Some(1)),
        ("missing key", with("mass_kg = 100.0\n", ""), "MissingKey", Some(1), Some(2)),
        ("wheel inertia missing on a vehicle", with("inertia_kg_m2 = 0.25\n", ""), "MissingKey", Some(10), Some(2)),
        ("no wheel", b"[terrain]\nmodel = \"wong-reece\"\n".to_vec(), "MissingTable", None, None),
        ("no terrain", b"[wheel]\nradius_m = 1\nwidth_m = 1\n".to_vec(), "MissingTable", None, None),
        ("no model", with("model = \"wong-reece\"", ""), "MissingKey", Some(16), Some(2)),
        ("a table that is a number", b"wheel = 3\n".to_vec(), "WrongType", Some(1), Some(9)),
        ("text for a number", with("100.0", "\"100\""), "WrongType", Some(2), Some(11)),
        ("true for a number", with("100.0", "true"), "WrongType", Some(2), Some(11)),
        ("NaN", with("100.0", "nan"), "NotFinite", Some(2), Some(11)),
        ("infinity", with("0.22", "-inf"), "NotFinite", Some(7), Some(15)),
        ("overflow", with("0.22", "1e999"), "NotFinite", Some(7), Some(15)),
        ("mass 0", with("100.0", "0"), "OutOfRange", Some(2), Some(11)),
        ("negative track", with("track_m = 0.6", "track_m = -0.6"), "OutOfRange", Some(4), Some(11)),
        ("axle behind the car", with("axle_m = 0.3", "axle_m = 0.7"), "OutOfRange", Some(6), Some(22)),
        ("negative radius", with("0.254", "-0.254"), "OutOfRange", Some(11), Some(12)),
        ("half a grouser", with("width_m = 0.15", "width_m = 0.15\ngrouser_count = 24.5"), "WrongType", Some(13), Some(17)),
        ("minus one grouser", with("width_m = 0.15", "width_m = 0.15\ngrouser_count = -1"), "OutOfRange", Some(13), Some(17)),
        ("efficiency above 1", and("[drivetrain]\ntorque_constant_N_m_A = 0.065\ngear_ratio = 40\nefficiency = 1.2"), "OutOfRange", Some(22), Some(14)),
        ("half a drivetrain", and("[drivetrain]\ngear_ratio = 40"), "MissingKey", Some(19), Some(2)),
        ("filter source", and("[filter]\nground_speed = \"lidar\""), "UnknownName", Some(20), Some(16)),
        ("filter walk 0", and("[filter]\nforce_walk_N2_s3 = 0"), "OutOfRange", Some(20), Some(20)),
        ("window 0", and("[gap]\nwindow_s = 0.0"), "OutOfRange", Some(20), Some(12)),
        ("slip range of three", and("[gap]\nslip_range = [0, 0.5, 1]"), "OutOfRange", Some(20), Some(14)),
        ("slip range reversed", and("[gap]\nslip_range = [0.5, 0.1]"), "OutOfRange", Some(20), Some(14)),
        ("slip range beyond 1", and("[gap]\nslip_range = [0, 1.5]"), "OutOfRange", Some(20), Some(18)),
        ("prior of 1.1", and("[gap]\nprior = { none = 0.9, unknown = 0.2 }"), "OutOfRange", Some(20), Some(1)),
        ("noise of another name", and("[noise]\nwheel_speed_fl_rad_s = 0.1"), "UnknownKey", Some(20), Some(1)),
        ("noise 0", and("[noise]\nslip = 0"), "OutOfRange", Some(20), Some(8)),
        ("a condition's wheel", and("[condition.grousered]\nwheel = { radius = 0.1 }"), "UnknownKey", Some(20), Some(11)),
        ("a condition's soil", and("[condition.grousered]\nsoil = \"mine\""), "UnknownName", Some(20), Some(8)),
        ("a condition's key", and("[condition.grousered]\nwheels = {}"), "UnknownKey", Some(20), Some(1)),
    ];
    check(&cases, rover);
}

#[test]
fn terrain_tables() {
    #[rustfmt::skip]
    let cases: Vec<Case<'_>> = vec![
        ("unknown model", with("wong-reece", "wong-rece"), "UnknownName", Some(17), Some(9)),
        ("unknown effect", with("wong-reece", "wong-reece+slip-sinkge"), "UnknownName", Some(17), Some(9)),
        ("an effect the model cannot carry", with("wong-reece", "linear-stress+grousers"), "Model", Some(17), Some(9)),
        ("unknown start", terrain("start = \"dry_snad\""), "UnknownName", Some(18), Some(9)),
        ("start without K", terrain("start = \"dlr_a\""), "IncompleteTerrain", Some(18), Some(9)),
        ("start that is a number", terrain("start = 3"), "WrongType", Some(18), Some(9)),
        ("unknown set", terrain("hypotheses = \"wong12\""), "UnknownName", Some(18), Some(14)),
        ("start without parameters", terrain("start = {}"), "MissingKey", Some(18), Some(1)),
        ("start with a parameter of nobody", terrain("start = { density = 1 }"), "UnknownKey", Some(18), Some(11)),
        ("both moduli", terrain("start = { k_eq = 1e6, k_phi = 1e6 }"), "Conflict", Some(18), Some(11)),
        ("friction in degrees", terrain("start = { k_eq = 1e6, sinkage_exponent = 1, cohesion = 1e3, friction_angle = 28 }"), "OutOfRange", Some(18), Some(78)),
        ("sd of nobody", terrain("prior_sd = { phi = 0.1 }"), "UnknownKey", Some(18), Some(14)),
        ("sd 0", terrain("prior_sd = { cohesion = 0 }"), "OutOfRange", Some(18), Some(25)),
    ];
    check(&cases, rover);
}

#[test]
fn column_maps() {
    #[rustfmt::skip]
    let cases: Vec<Case<'_>> = vec![
        ("a column of nobody", and("[columns]\nwheel_speed_lf_rad_s = { from = \"wfl\" }"), "UnknownName", Some(20), Some(1)),
        ("a text", and("[columns]\ntime_s = \"t\""), "WrongType", Some(20), Some(10)),
        ("no from", and("[columns]\ntime_s = { unit = \"ms\" }"), "MissingKey", Some(20), Some(1)),
        ("another key", and("[columns]\ntime_s = { form = \"t\" }"), "UnknownKey", Some(20), Some(12)),
        ("an unknown unit", and("[columns]\ntime_s = { from = \"t\", unit = \"seconds\" }"), "UnknownName", Some(20), Some(31)),
        ("another quantity's unit", and("[columns]\npitch_rad = { from = \"p\", unit = \"mm\" }"), "WrongDimension", Some(20), Some(34)),
        ("rpm for a speed", and("[columns]\nground_speed_m_s = { from = \"v\", unit = \"rpm\" }"), "WrongDimension", Some(20), Some(41)),
        ("a unit of text", and("[columns]\nsegment = { from = \"s\", unit = \"m\" }"), "UnknownName", Some(20), Some(32)),
        ("a convention of time", and("[columns]\ntime_s = { from = \"t\", convention = \"percent\" }"), "UnknownName", Some(20), Some(37)),
        ("an unknown convention", and("[columns]\nslip = { from = \"s\", convention = \"per cent\" }"), "UnknownName", Some(20), Some(35)),
        ("percent twice", and("[columns]\nslip = { from = \"s\", unit = \"percent\", convention = \"percent\" }"), "Conflict", Some(20), Some(1)),
    ];
    check(&cases, rover);
}

#[test]
fn files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rover.toml");
    let read = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        read_rover(&path)
    };
    #[rustfmt::skip]
    let cases: Vec<Case<'_>> = vec![
        ("no bytes", vec![], "Empty", None, None),
        ("a comment only", b"# later\n".to_vec(), "MissingTable", None, None),
        ("two megabytes", vec![b'#'; 2 << 20], "TooLarge", None, None),
        ("gzip", b"\x1f\x8b\x08".to_vec(), "Compressed", None, None),
        ("utf-16", b"\xff\xfe[\0w\0".to_vec(), "Utf16", None, None),
        ("latin-1", [RIG.as_bytes(), b"# \xe9t\xe9\n"].concat(), "NotUtf8", Some(7), Some(3)),
        ("a start id of neither catalogue", format!("{RIG}hypotheses = \"own.csv\"\nstart = \"mars_1\"\n").into_bytes(), "UnknownName", Some(8), Some(9)),
    ];
    let own = "id,set,name,n,kc_kN_m_n1,kphi_kN_m_n2,c_kPa,phi_deg,K_m,c1,c2\nmars_2,own,Mars,1,1,1000,1,30,0.01,NA,NA\n";
    std::fs::write(folder.path().join("own.csv"), own).unwrap();
    check(&cases, read);
    let good = format!("{RIG}hypotheses = \"own.csv\"\nstart = \"mars_2\"\n");
    read(good.as_bytes()).unwrap();
    assert_eq!(kind(&read_rover(folder.path()).unwrap_err()), "IsDirectory");
    let error = read_rover(folder.path().join("none.toml")).unwrap_err();
    assert_eq!(kind(&error), "NotFound");
    assert!(error.is_configuration());
}

#[test]
fn an_error_names_the_key_the_nearest_one_and_the_unit_that_would_do() {
    let text = ROVER.replace("mass_kg", "mas_kg");
    let e = parse_rover(&text, "rover.toml").unwrap_err().to_string();
    assert!(
        e.starts_with("rover.toml:2:1: unknown key 'mas_kg' in [vehicle]"),
        "{e}"
    );
    assert!(e.ends_with("did you mean 'mass_kg'?"), "{e}");
    let text = format!("{ROVER}[columns]\npitch_rad = {{ from = \"p\", unit = \"mm\" }}\n");
    let e = parse_rover(&text, "rover.toml").unwrap_err().to_string();
    assert!(
        e.contains("'mm', a unit of length; expected one of rad, deg"),
        "{e}"
    );
    let e = parse_rover(&ROVER.replace("wong-reece", "wong-rece"), "rover.toml").unwrap_err();
    assert!(e.to_string().contains("did you mean 'wong-reece'?"), "{e}");
}
