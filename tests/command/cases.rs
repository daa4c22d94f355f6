//! Everything that can be handed to the command by mistake: what is spoiled, the status, and what must be said
//! (fragments between bars). `file:line:column` is where the mistake was made.

use crate::bad_input::Spoil;

/// One mistake.
pub(crate) struct Case {
    pub(crate) what: &'static str,
    /// For cases that are a command line of their own.
    pub(crate) line: &'static str,
    pub(crate) spoil: fn(&Spoil),
    pub(crate) code: i32,
    pub(crate) says: &'static str,
}

const fn bad(what: &'static str, spoil: fn(&Spoil), code: i32, says: &'static str) -> Case {
    Case {
        what,
        line: "",
        spoil,
        code,
        says,
    }
}

const fn line(line: &'static str, code: i32, says: &'static str) -> Case {
    Case {
        what: "as it is",
        line,
        spoil: |_| {},
        code,
        says,
    }
}

const fn with(line: &'static str, spoil: fn(&Spoil), code: i32, says: &'static str) -> Case {
    Case {
        what: "spoiled",
        line,
        spoil,
        code,
        says,
    }
}

fn utf16(text: &str) -> Vec<u8> {
    [0xfeff]
        .into_iter()
        .chain(text.encode_utf16())
        .flat_map(u16::to_le_bytes)
        .collect()
}

fn latin1(text: &str) -> Vec<u8> {
    text.replacen("ramp", "r\u{1}mp", 1)
        .bytes()
        .map(|b| if b == 1 { 0xe4 } else { b })
        .collect()
}

fn gzip(text: &str) -> Vec<u8> {
    [b"\x1f\x8b\x08\0\0\0\0\0\0\x03", text.as_bytes()].concat()
}

fn nul(text: &str) -> Vec<u8> {
    text.replacen("ramp", "r\0mp", 3).into_bytes()
}

fn cut(text: &str) -> Vec<u8> {
    text.as_bytes()[..text.len() - 60].to_vec()
}

fn semicolons(text: &str) -> Vec<u8> {
    text.replace(',', ";").replace('.', ",").into_bytes()
}

/// A drive log that `estimate`, `identify` and `gap` must refuse in the same way. Columns: 1 time, 2 segment, 3 to 6 wheel
/// speeds, 7 to 10 torques, 11 ground speed, 12 yaw rate, 13 acceleration.
#[rustfmt::skip]
pub(crate) const DRIVE_LOGS: &[Case] = &[
    bad("missing", |f| f.remove("drive.csv"), 3, "drive.csv|no such file"),
    bad(
        "a folder",
        |f| {
            f.remove("drive.csv");
            f.folder("drive.csv")
        },
        3,
        "drive.csv|is a directory|expected a file",
    ),
    bad("empty", |f| f.put("drive.csv", ""), 3, "drive.csv|is empty|expected"),
    bad("blank lines", |f| f.put("drive.csv", "\n\n  \n"), 3, "drive.csv|is empty"),
    bad("header only", |f| f.keep("drive.csv", 1), 3, "drive.csv|no rows|expected at least one row"),
    bad("gzip", |f| f.encode("drive.csv", gzip), 3, "drive.csv|compressed (gzip)|decompress"),
    bad("UTF-16", |f| f.encode("drive.csv", utf16), 3, "drive.csv|UTF-16|UTF-8"),
    bad("Latin-1", |f| f.encode("drive.csv", latin1), 3, "drive.csv:2|not UTF-8|0xe4"),
    bad("NUL bytes", |f| f.encode("drive.csv", nul), 3, "drive.csv:2|NUL"),
    bad("binary", |f| f.put("drive.csv", [7u8; 500]), 3, "drive.csv|binary"),
    bad("Parquet", |f| f.put("drive.csv", b"PAR1 and so on"), 3, "drive.csv|Parquet"),
    bad("prose", |f| f.put("drive.csv", "Dear reader\nthis is no log\n"), 3, "drive.csv|wheel_speed_{fl,fr,rl,rr}_rad_s"),
    bad("semicolons", |f| f.encode("drive.csv", semicolons), 3, "drive.csv|';'|expected commas"),
    bad("cut short", |f| f.encode("drive.csv", cut), 3, "drive.csv:61|cut|13"),
    bad("a cell too many", |f| f.cell("drive.csv", 5, 13, "1,5"), 3, "drive.csv:5|14 cells|expected 13|decimal comma"),
    bad("a cell too few", |f| f.swap("drive.csv", "0.02,ramp,", "0.02,"), 3, "drive.csv:4|12 cells|expected 13"),
    bad("a decimal comma", |f| f.cell("drive.csv", 5, 3, "\"1,5\""), 3, "drive.csv:5:3|'1,5'|number|wheel_speed_fl_rad_s"),
    bad("a number with a tail", |f| f.cell("drive.csv", 9, 7, "12abc"), 3, "drive.csv:9:7|'12abc'|wheel_torque_fl_N_m"),
    bad("a word", |f| f.cell("drive.csv", 2, 11, "fast"), 3, "drive.csv:2:11|'fast'|ground_speed_m_s"),
    bad("two minus signs", |f| f.cell("drive.csv", 3, 13, "--1"), 3, "drive.csv:3:13|'--1'|accel_x_m_s2"),
    bad("time goes back", |f| f.cell("drive.csv", 6, 1, "0.001"), 3, "drive.csv:6:1|0.001 s after 0.03 s|increase"),
    bad("time stands still", |f| f.cell("drive.csv", 6, 1, "0.03"), 3, "drive.csv:6:1|increase inside 'ramp'"),
    bad("no time in a row", |f| f.cell("drive.csv", 6, 1, ""), 3, "drive.csv:6:1|no time"),
    bad("no time at all", |f| f.swap("drive.csv", "time_s", "tyme_s"), 3, "drive.csv:1|no column 'time_s'|did you mean 'tyme_s'"),
    bad("a wheel missing", |f| f.swap("drive.csv", "speed_rr_rad_s", "speed_r_rad_s"), 3, "drive.csv:1|wheel_speed_"),
    bad("a column twice", |f| f.swap("drive.csv", "yaw_rate_rad_s", "accel_x_m_s2"), 3, "drive.csv:1:13|accel_x_m_s2|column 12"),
    bad("an open quote", |f| f.cell("drive.csv", 7, 2, "\"ramp"), 3, "drive.csv:7|quote"),
];

/// A rig log. Columns: 1 trial, 2 condition, 3 pass, 4 slip, 5 load, 6 pull, 7 torque, 8 sinkage, 9 and 10 speeds.
#[rustfmt::skip]
pub(crate) const RIG_LOGS: &[Case] = &[
    bad("missing", |f| f.remove("rig.csv"), 3, "rig.csv|no such file"),
    bad("header only", |f| f.keep("rig.csv", 1), 3, "rig.csv|no rows"),
    bad("a bad number", |f| f.cell("rig.csv", 8, 6, "12abc"), 3, "rig.csv:8:6|drawbar_pull_N|'12abc'"),
    bad("half a pass", |f| f.cell("rig.csv", 8, 3, "1.5"), 3, "rig.csv:8:3|pass|1.5"),
    bad("no load", |f| f.swap("rig.csv", "normal_load_N", "load"), 3, "rig.csv|normal_load_N"),
    bad("ragged", |f| f.cell("rig.csv", 3, 6, "1,5"), 3, "rig.csv:3|11 cells|expected 10"),
    bad("a column twice", |f| f.swap("rig.csv", "torque_N_m", "drawbar_pull_N"), 3, "rig.csv:1:7|drawbar_pull_N|column 6"),
    bad("gzip", |f| f.encode("rig.csv", gzip), 3, "rig.csv|gzip"),
];

/// A rover file of a drive.
#[rustfmt::skip]
pub(crate) const ROVERS: &[Case] = &[
    bad("missing", |f| f.remove("rover.toml"), 2, "rover.toml|no such file"),
    bad(
        "a folder",
        |f| {
            f.remove("rover.toml");
            f.folder("rover.toml")
        },
        2,
        "rover.toml|is a directory",
    ),
    bad("empty", |f| f.put("rover.toml", ""), 2, "rover.toml|is empty"),
    bad("no TOML", |f| f.put("rover.toml", "mass = = 3\n"), 2, "rover.toml:1:|TOML"),
    bad("UTF-16", |f| f.encode("rover.toml", utf16), 2, "rover.toml|UTF-16"),
    bad("an unknown key", |f| f.swap("rover.toml", "mass_kg", "mas_kg"), 2, "rover.toml:5:1|'mas_kg'|did you mean 'mass_kg'"),
    bad("an unknown table", |f| f.swap("rover.toml", "[wheel]", "[weel]"), 2, "rover.toml:|'weel'|did you mean 'wheel'"),
    bad("a missing key", |f| f.swap("rover.toml", "radius_m = 0.254\n", ""), 2, "rover.toml:|radius_m"),
    bad("a missing table", |f| f.swap("rover.toml", "[terrain]\nmodel = \"wong-reece\"\nhypotheses = \"wong21\"\n", ""), 2, "rover.toml|[terrain]"),
    bad("a wrong type", |f| f.swap("rover.toml", "mass_kg = 100.0", "mass_kg = \"heavy\""), 2, "rover.toml:5:11|mass_kg|number"),
    bad("not a number", |f| f.swap("rover.toml", "mass_kg = 100.0", "mass_kg = nan"), 2, "rover.toml:5:11|mass_kg|nan|finite"),
    bad("infinite", |f| f.swap("rover.toml", "width_m = 0.15", "width_m = inf"), 2, "rover.toml:|width_m|inf|finite"),
    bad("below zero", |f| f.swap("rover.toml", "mass_kg = 100.0", "mass_kg = -100.0"), 2, "rover.toml:5:11|mass_kg|-100"),
    bad("unknown model", |f| f.swap("rover.toml", "\"wong-reece\"", "\"wong-reese\""), 2, "rover.toml:|'wong-reese'|did you mean 'wong-reece'"),
    bad("unknown effect", |f| f.swap("rover.toml", "\"wong-reece\"", "\"wong-reece+slipsinkage\""), 2, "rover.toml:|'slipsinkage'|did you mean 'slip-sinkage'"),
    bad("unknown set", |f| f.swap("rover.toml", "\"wong21\"", "\"wong12\""), 2, "rover.toml:|wong12"),
    bad("unknown start", |f| f.swap("rover.toml", "hypotheses", "start = \"dri_sand\"\nhypotheses"), 2, "rover.toml:|'dri_sand'|did you mean 'dry_sand'"),
    bad("no noise level", |f| f.swap("rover.toml", "wheel_speed_rad_s = 0.05\n", ""), 2, "rover.toml|[noise]|wheel_speed_rad_s"),
    bad("a noise of zero", |f| f.swap("rover.toml", "yaw_rate_rad_s = 0.005", "yaw_rate_rad_s = 0"), 2, "rover.toml:|yaw_rate_rad_s|above 0"),
    bad("a rig's file", |f| f.encode("rover.toml", |_| include_bytes!("../../examples/rig/rig.toml").to_vec()), 2, "rover.toml|[vehicle]"),
];

/// A rig file.
#[rustfmt::skip]
pub(crate) const RIGS: &[Case] = &[
    bad("missing", |f| f.remove("rig.toml"), 2, "rig.toml|no such file"),
    bad("no noise level", |f| f.swap("rig.toml", "slip = 0.005\n", ""), 2, "rig.toml|slip"),
    bad("a rover's file", |f| f.encode("rig.toml", |_| include_bytes!("../../examples/paper/rover.toml").to_vec()), 2, "rig.toml|drawbar_pull_N"),
    bad("unknown soil key", |f| f.swap("rig.toml", "start = \"dry_sand\"", "start = { cohesio = 1.0 }"), 2, "rig.toml:|cohesio"),
    bad("NaN in a soil", |f| f.swap("rig.toml", "start = \"dry_sand\"", "start = \"dry_sand\"\nprior_sd = { cohesion = nan }"), 2, "rig.toml:12:|cohesion|nan"),
    bad("unknown hypotheses", |f| f.swap("rig.toml", "[terrain]\n", "[terrain]\nhypotheses = \"nope.csv\"\n"), 2, "nope.csv"),
];

/// A scenario of a drive.
#[rustfmt::skip]
pub(crate) const SCENARIOS: &[Case] = &[
    bad("missing", |f| f.remove("ramp.toml"), 2, "ramp.toml|No such file"),
    bad(
        "a folder",
        |f| {
            f.remove("ramp.toml");
            f.folder("ramp.toml")
        },
        2,
        "ramp.toml|directory",
    ),
    bad("empty", |f| f.put("ramp.toml", ""), 2, "ramp.toml|seed"),
    bad("no TOML", |f| f.put("ramp.toml", "seed = \n"), 2, "ramp.toml:1"),
    bad("binary", |f| f.put("ramp.toml", [0xffu8; 40]), 2, "ramp.toml|UTF-8"),
    bad("an unknown key", |f| f.swap("ramp.toml", "rate_hz", "rate_Hz"), 2, "ramp.toml:4:1|rate_Hz|rate_hz"),
    bad("a wrong type", |f| f.swap("ramp.toml", "rate_hz = 100.0", "rate_hz = true"), 2, "ramp.toml:4:11|number"),
    bad("a rate of NaN", |f| f.swap("ramp.toml", "rate_hz = 100.0", "rate_hz = nan"), 2, "ramp.toml:4:11|finite"),
    bad("a rate below zero", |f| f.swap("ramp.toml", "rate_hz = 100.0", "rate_hz = -1.0"), 2, "ramp.toml:4:11|above 0"),
    bad("no end", |f| f.swap("ramp.toml", "duration_s = 2.0", "duration_s = 1e12"), 2, "ramp.toml|duration"),
    bad("a name that two segments have", |f| f.swap("ramp.toml", "[[segment]]", "[[segment]]\nname = \"ramp\"\nduration_s = 1.0\ntorque_N_m = 1.0\n[[segment]]\nreset = true"), 2, "ramp.toml:|'ramp' too|a name of its own"),
    bad("no rover", |f| f.swap("ramp.toml", "\"rover.toml\"", "\"rovr.toml\""), 2, "rovr.toml|no such file"),
    bad("a rig's file", |f| f.swap("ramp.toml", "\"rover.toml\"", "\"rig.toml\""), 2, "ramp.toml|[vehicle]"),
    bad("unknown soil", |f| f.swap("ramp.toml", "\"lean_clay_22\"", "\"lean_clay22\""), 2, "ramp.toml|'lean_clay22'|did you mean 'lean_clay_22'"),
    bad("unknown model", |f| f.swap("ramp.toml", "seed = 1", "model = \"bekkr\"\nseed = 1"), 2, "ramp.toml|'bekkr'"),
    bad("unknown effect", |f| f.swap("ramp.toml", "[[segment]]", "[[effect]]\nname = \"grouser\"\nmagnitude = 1.0\n[[segment]]"), 2, "ramp.toml|'grouser'|did you mean 'grousers'"),
    bad("a magnitude out of range", |f| f.swap("ramp.toml", "[[segment]]", "[[effect]]\nname = \"slip-sinkage\"\nmagnitude = 99.0\n[[segment]]"), 2, "ramp.toml|slip-sinkage|99|0 to 5"),
    bad("a rig's effect", |f| f.swap("ramp.toml", "[[segment]]", "[[effect]]\nname = \"load-error\"\nmagnitude = 0.1\n[[segment]]"), 2, "ramp.toml|load-error|drive"),
    bad("an unknown form", |f| f.swap("ramp.toml", "[[segment]]", "[[effect]]\nname = \"slip-sinkage\"\nform = \"defalt\"\nmagnitude = 0.1\n[[segment]]"), 2, "ramp.toml|'defalt'|did you mean 'default'"),
    bad("no noise level", |f| f.swap("rover.toml", "wheel_torque_N_m = 0.1\n", ""), 2, "ramp.toml|[noise]|wheel_torque_N_m"),
    bad(
        "soil that gives way",
        |f| f.swap("ramp.toml", "terrain = \"lean_clay_22\"", "terrain = { k_c = 0.0, k_phi = 1e3, sinkage_exponent = 1.0, cohesion = 10.0, friction_angle = 0.1, shear_modulus = 0.02, c1 = 0.4, c2 = 0.2 }"),
        3,
        "ramp.toml: at 0.0|wheel|soil carries at most",
    ),
];

/// Command lines.
#[rustfmt::skip]
pub(crate) const LINES: &[Case] = &[
    line("", 2, "Usage"),
    line("frobnicate", 2, "frobnicate"),
    line("identfy drive.csv", 2, "identify"),
    line("--frobnicate", 2, "--frobnicate"),
    line("estimate drive.csv", 2, "--rover"),
    line("estimate --rover rover.toml", 2, "LOG"),
    line("estimate drive.csv --rover rover.toml --fliter ekf", 2, "--filter"),
    line("estimate drive.csv drive.csv --rover rover.toml", 2, "drive.csv"),
    line("terrains --threads 0", 2, "--threads"),
    line("terrains --threads many", 2, "--threads"),
    line("simulate ramp.toml", 2, "--out"),
    line("simulate ramp.toml --out out.csv --seed -1", 2, "seed"),
    line("completions tcsh", 2, "tcsh"),
    // Names.
    line("estimate drive.csv --rover rover.toml --filter ufk", 2, "'ufk'|did you mean 'ukf'|terra filters"),
    line("identify drive.csv --rover rover.toml --filter ufk", 2, "'ufk'|did you mean 'ukf'"),
    line("identify drive.csv --rover rover.toml --estimator sidesum", 2, "'sidesum'|did you mean 'side-sum'|terra estimators"),
    line("gap rig.csv --rover rig.toml --effects slip-sinkage,slip-sinkag", 2, "'slip-sinkag'|did you mean 'slip-sinkage'|terra effects"),
    line("gap rig.csv --rover rig.toml --effects all,slip-sinkage", 2, "'all'"),
    line("wheel --terrain dry_snad --radius_m 0.2 --width_m 0.1 --load_N 100 --slip 0.2", 2, "'dry_snad'|did you mean 'dry_sand'|terra terrains"),
    line("wheel --terrain dry_sand --radius_m 0.2 --width_m 0.1 --load_N 100 --slip 0.2 --model wong", 2, "'wong'|terra models"),
    line("wheel --terrain dry_sand --radius_m 0.2 --width_m 0.1 --load_N 100 --slip 0.2 --model wong-reece+grouser=1", 2, "'grouser'|did you mean 'grousers'|terra effects"),
    line("wheel --terrain mer_b_sandy_loam --radius_m 0.2 --width_m 0.1 --load_N 100 --slip 0.2", 2, "mer_b_sandy_loam|shear_modulus"),
    // Numbers.
    line("wheel --terrain dry_sand --radius_m 0,2 --width_m 0.1 --load_N 100 --slip 0.2", 2, "0,2"),
    line("wheel --terrain dry_sand --radius_m -0.2 --width_m 0.1 --load_N 100 --slip 0.2", 2, "radius"),
    line("wheel --terrain dry_sand --radius_m 0.2 --width_m 0 --load_N 100 --slip 0.2", 2, "width"),
    line("wheel --terrain dry_sand --radius_m 0.2 --width_m 0.1 --load_N nan --slip 0.2", 2, "normal_load"),
    line("wheel --terrain dry_sand --radius_m 0.2 --width_m 0.1 --load_N inf --slip 0.2", 2, "normal_load"),
    line("wheel --terrain dry_sand --radius_m 0.2 --width_m 0.1 --load_N -5 --slip 0.2", 2, "normal_load"),
    line("wheel --terrain dry_sand --radius_m 0.2 --width_m 0.1 --load_N 100 --slip 0.1:2:0.1", 2, "[-1, 1]"),
    line("wheel --terrain dry_sand --radius_m 0.2 --width_m 0.1 --load_N 100 --slip 0:1:0", 2, "STEP"),
    line("wheel --terrain dry_sand --radius_m 0.2 --width_m 0.1 --load_N 100 --slip 0:1:1e-9", 2, "million"),
    line("wheel --terrain dry_sand --radius_m 0.2 --width_m 0.1 --load_N 100 --slip 0.2 --model wong-reece+grousers", 2, "without a magnitude"),
    line("wheel --terrain dry_sand --radius_m 0.2 --width_m 0.1 --load_N 100 --slip 0.2 --model wong-reece+grousers=big", 2, "'big'"),
    line("identify drive.csv --rover rover.toml --choice floor:2", 2, "floor"),
    line("identify drive.csv --rover rover.toml --choice sometimes", 2, "sometimes|forgetting:L"),
    line("identify drive.csv --rover rover.toml --choice transition:none.txt", 2, "none.txt"),
    with("identify drive.csv --rover rover.toml --choice transition:m.txt", |f| f.put("m.txt", "1 0\n0 x\n"), 2, "m.txt|line 2|'x'"),
    with("identify drive.csv --rover rover.toml --choice transition:m.txt", |f| f.put("m.txt", "1 0\n0 0.5\n"), 2, "1"),
    with("identify drive.csv --rover rover.toml --choice transition:m.txt", |f| f.put("m.txt", "1 0\n0 1\n"), 2, "21"),
    line("gap rig.csv --rover rig.toml --combine 3", 2, "combine"),
    line("gap drive.csv --rover rover.toml --windows 3", 2, "windows|16"),
    line("identify drive.csv --rover rover.toml --rows 20", 2, "FIRST-LAST"),
    line("identify drive.csv --rover rover.toml --rows 20-10", 2, "FIRST-LAST"),
    line("identify drive.csv --rover rover.toml --rows 0-10", 2, "FIRST-LAST"),
    line("identify drive.csv --rover rover.toml --rows 201-300", 3, "no row 201|terra inspect"),
    line("identify rig.csv --rover rig.toml --rows 1-5", 2, "rig log|leave --rows out"),
    // What does not go together.
    line("gap drive.csv --rover rover.toml --watch --same-bed", 2, "--same-bed"),
    line("simulate rover.toml --out out.csv", 2, "rover.toml|is a rover file|scenario"),
    line("gap drive.csv --rover mine.toml", 2, "mine.toml|no such file|terra init"),
    line("gap drive.csv --rover rover.toml --json nowhere/out.json", 4, "nowhere|make it first"),
    line("merge drive.csv --out out.jsonl", 3, "drive.csv:1:|terra sweep"),
    with("inspect log.csv", |f| f.put("log.csv", "PAR1\0\0"), 3, "Parquet|terra import parquet log.csv --out"),
    line("gap rig.csv --rover rig.toml --hold-out segment", 2, "rig log|trial"),
    line("gap drive.csv --rover rover.toml --hold-out trial", 2, "drive log|segment"),
    line("estimate rig.csv --rover rig.toml", 2, "rig.csv|rig log"),
    line("estimate drive.csv --rover rig.toml", 2, "rig.toml|[vehicle]"),
    line("identify drive.csv --rover rig.toml", 2, "rig.toml|[vehicle]"),
    line("gap drive.csv --rover rig.toml", 2, "rig.toml|[vehicle]"),
    line("identify rig.csv --rover rover.toml", 2, "rover.toml|drawbar_pull_N"),
    line("gap rig.csv --rover rover.toml", 2, "rover.toml|drawbar_pull_N"),
    with(
        "gap drive.csv --rover rover.toml --json out.json",
        |f| {
            f.swap("rover.toml", "hypotheses", "start = \"dry_sand\"\nhypotheses");
            f.swap("rover.toml", "accel_x_m_s2 = 0.05\n", "")
        },
        2,
        "rover.toml|accel_x_m_s2",
    ),
    line("estimate drive_truth.csv --rover rig.toml", 2, "rig.toml|[vehicle]"),
    with("identify drive.csv --rover rover.toml --json out.json", |f| f.keep("drive.csv", 13), 3, "drive.csv|no sample could be weighed"),
    with(
        "estimate drive.csv --rover rover.toml",
        |f| {
            for c in 7..11 {
                f.swap("drive.csv", ["_fl_N_m", "_fr_N_m", "_rl_N_m", "_rr_N_m"][c - 7], "")
            }
        },
        3,
        "drive.csv|neither wheel torques nor motor currents|wheel_torque_fl_N_m",
    ),
    // Where results may go.
    line("estimate drive.csv --rover rover.toml --out no/such/out.csv", 4, "no/such/out.csv"),
    line("simulate ramp.toml --out no/out.csv", 4, "no/out.csv"),
    line("simulate ramp.toml --out out.csv --truth no/truth.csv", 4, "no/truth.csv"),
    line("identify drive.csv --rover rover.toml --json out.json --html no/out.html", 4, "no/out.html"),
    line("gap rig.csv --rover rig.toml --json out.json --html no/out.html", 4, "no/out.html"),
    line("wheel --terrain dry_sand --radius_m 0.2 --width_m 0.1 --load_N 100 --slip 0.2 --csv no/out.csv", 4, "no/out.csv"),
    with("estimate drive.csv --rover rover.toml --out full", |f| f.folder("full"), 4, "full|directory"),
    with("wheel --terrain dry_sand --radius_m 0.2 --width_m 0.1 --load_N 100 --slip 0.2 --stress --csv out.csv", |f| f.folder("out.stress.csv"), 4, "out.stress.csv|directory"),
    line("estimate drive.csv --rover rover.toml --out drive.csv/out.csv", 4, "drive.csv/out.csv"),
    line("demo --out drive.csv", 4, "drive.csv"),
    line("demo --out drive.csv/demo", 4, "drive.csv/demo"),
    line("estimate drive.csv --rover rover.toml --out ./drive.csv", 2, "./drive.csv|input"),
    line("estimate drive.csv --rover rover.toml --out rover.toml", 2, "rover.toml|input"),
    line("simulate ramp.toml --out ramp.toml", 2, "ramp.toml|input"),
    line("simulate ramp.toml --out out.csv --truth rover.toml", 2, "rover.toml|input"),
    line("simulate ramp.toml --out new.csv --truth ./new.csv", 2, "new.csv|two results"),
    line("gap rig.csv --rover rig.toml --json out.json --html out.json", 2, "out.json|two results"),
];
