//! User catalogues of terrains: bad ones, and a good one against the built-in values.

use terra_data::read_terrains_from;
use terra_model::catalogue;

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
