//! User catalogues of terrains: bad ones, and a good one against the built-in values.

use terra_data::{read_terrains_from, write_terrains_to};
use terra_model::catalogue::{self, Confidence, Terrain};

use crate::support::{Case, check};

const HEADER: &str = "id,set,name,n,kc_kN_m_n1,kphi_kN_m_n2,c_kPa,phi_deg,K_m,c1,c2";

#[test]
fn bad_ones() {
    let csv = |rows: &str| format!("{HEADER}\n{rows}\n").into_bytes();
    #[rustfmt::skip]
    let cases: Vec<Case<'_>> = vec![
        ("no bytes", vec![], "Empty", None, None),
        ("comments only", b"# soils\n".to_vec(), "Empty", None, None),
        ("no rows", csv("# none yet"), "NoRows", Some(1), None),
        ("phi renamed", HEADER.replace("phi_deg", "phi_dg").into_bytes(), "MissingColumn", Some(1), Some(8)),
        ("a column twice", HEADER.replace("c2", "c1").into_bytes(), "DuplicateColumn", Some(1), Some(11)),
        ("no id", csv(",s,S,1,1,1,1,30,.01,,"), "MissingValue", Some(2), Some(1)),
        ("no exponent", csv("a,s,S,NA,1,1,1,30,.01,,"), "MissingValue", Some(2), Some(4)),
        ("exponent 0", csv("a,s,S,0,1,1,1,30,.01,,"), "BadValue", Some(2), Some(4)),
        ("friction of a wall", csv("a,s,S,1,1,1,1,90,.01,,"), "BadValue", Some(2), Some(8)),
        ("negative cohesion", csv("a,s,S,1,1,1,-1,30,.01,,"), "BadValue", Some(2), Some(7)),
        ("K of 0", csv("a,s,S,1,1,1,1,30,0,,"), "BadValue", Some(2), Some(9)),
        ("words", csv("a,s,S,1,hard,1,1,30,.01,,"), "BadNumber", Some(2), Some(5)),
        ("after a comment", csv("# soft\n\n# softer\na,s,S,1,1,1,1,x,.01,,"), "BadNumber", Some(5), Some(8)),
        ("an unknown mark", format!("{HEADER},conf,source_note\na,s,S,1,1,1,1,30,.01,,,D,a book\n").into_bytes(), "UnknownMark", Some(2), Some(12)),
        ("a mark in small letters", format!("# mine\nconf,{HEADER}\nA,a,s,S,1,1,1,1,30,.01,,\na,b,s,S,1,1,1,1,30,.01,,\n").into_bytes(), "UnknownMark", Some(4), Some(1)),
        ("two columns of marks", format!("{HEADER},conf,conf\na,s,S,1,1,1,1,30,.01,,,A,A\n").into_bytes(), "DuplicateColumn", Some(1), Some(13)),
        ("a name of backspaces", csv("a,s,S\x08\x08,1,1,1,1,30,.01,,"), "UnknownMark", Some(2), Some(3)),
        ("an id twice", csv("a,s,S,1,1,1,1,30,.01,,\nb,s,S,1,1,1,1,30,.01,,\na,s,S,1,1,1,1,30,.01,,"), "DuplicateTerrain", Some(4), Some(1)),
    ];
    check(&cases, |bytes| read_terrains_from(bytes, "soils.csv"));
    assert!(
        read_terrains_from(&b""[..], "soils.csv")
            .unwrap_err()
            .is_configuration()
    );
}

#[test]
fn a_row_comes_out_as_in_the_built_in_catalogue() {
    let rows = "# Wong T2.3\nnote,c2,c1,K_m,phi_deg,c_kPa,kphi_kN_m_n2,kc_kN_m_n1,n,name,set,id\n\
                dense,0.41,0.38,0.025,28,1.04,1528.43,0.99,1.1,Dry sand (LLL),wong21,dry_sand\n\
                ,NA,,NA,30,1,1523.4,0.9,1.1,no K,own,mine\n";
    let own = read_terrains_from(rows.as_bytes(), "soils.csv").unwrap();
    let known = catalogue::find("dry_sand").unwrap();
    let [sand, mine] = own.as_slice() else {
        panic!("two rows")
    };
    assert_eq!(
        (sand.k_c, sand.k_phi, sand.cohesion),
        (known.k_c, known.k_phi, known.cohesion)
    );
    assert_eq!(
        (sand.friction_angle, sand.sinkage_exponent),
        (known.friction_angle, known.sinkage_exponent)
    );
    assert_eq!(
        (sand.shear_modulus, sand.c1, sand.c2),
        (known.shear_modulus, known.c1, known.c2)
    );
    assert_eq!((mine.shear_modulus, mine.c1, mine.c2), (None, None, None));
}

/// A mark that is none says where it stands and which there are.
#[test]
fn an_unknown_mark_is_named_with_its_place_and_the_known_ones() {
    let csv = format!("{HEADER},source_note,conf\na,s,S,1,1,1,1,30,.01,,,a book,D\n");
    let said = read_terrains_from(csv.as_bytes(), "soils.csv")
        .unwrap_err()
        .to_string();
    for part in ["soils.csv:2:13:", "'conf'", "'D'", "A, B, C or user"] {
        assert!(said.contains(part), "{part}: {said}");
    }
}

/// Without the columns, and where a cell says nothing, a row is the user's own and comes from the file.
#[test]
fn a_row_that_says_nothing_of_itself_is_the_users_own() {
    let plain = format!("{HEADER}\na,s,S,1,1,1,1,30,.01,,\n");
    let blank = format!(
        "{HEADER},conf,source_note\na,s,S,1,1,1,1,30,.01,,,,\nb,s,S,1,1,1,1,30,.01,,,NA,na\n"
    );
    for csv in [plain, blank] {
        for soil in read_terrains_from(csv.as_bytes(), "soils.csv").unwrap() {
            assert_eq!(soil.confidence, Confidence::Own, "{}", soil.id);
            assert_eq!(soil.source, "soils.csv", "{}", soil.id);
        }
    }
}

/// Source and trust are read, written and read again as they were: of every built-in row, and of texts that a table must quote.
#[test]
fn source_and_trust_survive_being_written() {
    let mut soils: Vec<Terrain> = catalogue::terrains().to_vec();
    let mut odd = soils[0].clone();
    odd.id = "odd".into();
    odd.confidence = Confidence::Own;
    odd.source = "a \"book\", page 3; Größe,\nsecond line".into();
    soils.push(odd);
    let mut csv = vec![];
    write_terrains_to(&mut csv, &soils).unwrap();
    let again = read_terrains_from(csv.as_slice(), "again.csv").unwrap();
    assert_eq!(again.len(), soils.len());
    for (found, written) in again.iter().zip(&soils) {
        assert_eq!(
            (&found.id, found.confidence, &found.source),
            (&written.id, written.confidence, &written.source)
        );
    }
    let marks = |of: Confidence| again.iter().filter(|t| t.confidence == of).count();
    let all = [
        Confidence::Agreed,
        Confidence::Single,
        Confidence::Recalled,
        Confidence::Own,
    ];
    assert!(all.into_iter().all(|c| marks(c) > 0));
}
