//! Makes the cases of a challenge, the same bytes on any number of threads.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde_json::{Value, json};
use terra_data::Start;
use terra_sim::{EffectSetting, Scenario};

use super::carry::{carried, quiet};
use super::design::{AnyLog, Design, simulate};
use super::draw::{Carried, Draft, Soils, drafts, magnitude, possible};
use super::key::{CaseKey, Gate, KeyCase, KeyFile, SCHEMA, SealedEffect, digest};
use super::library::{Known, Library};
use super::moving::{self, moves, needed};
use super::random::Draws;
use super::shares::{Kind, Shares};
use crate::error::CliError;

/// Cases made at once: what a challenge needs of memory does not grow with its length.
const BATCH: usize = 32;
/// Soils and magnitudes that are tried until the vehicle gets through.
const ATTEMPTS: usize = 60;

/// One case: its name, its log, its secret.
#[derive(Clone, Debug)]
pub struct MadeCase {
    /// `case_001`.
    pub name: String,
    /// The log file.
    pub log: Vec<u8>,
    /// What is withheld.
    pub key: KeyCase,
}

/// What a challenge was made of.
#[derive(Clone, Debug)]
pub struct Challenge {
    /// All secrets.
    pub key: KeyFile,
    /// The rover file.
    pub rover: String,
    /// The commitments, a line a case.
    pub commitment: String,
    /// Number of cases a kind.
    pub counts: Vec<(Kind, usize)>,
    /// Known effects that the design cannot carry.
    pub not_carried: Vec<String>,
}

/// Makes `n` cases; each is handed to `keep` in the order of names, and `step` is told of each.
///
/// # Errors
/// A kind that was asked for and cannot be drawn, a design no soil gets through, what `keep` says.
pub fn make(
    design: &Design,
    library: &Library,
    shares: Shares,
    n: usize,
    seed: u64,
    step: &(dyn Fn() + Sync),
    keep: &mut dyn FnMut(&MadeCase) -> Result<(), CliError>,
) -> Result<Challenge, CliError> {
    let known = library.known();
    let without = simulate(&quiet(&design.scenario), &design.rover, library.registry())?;
    // Only what may be drawn is tried.
    let tried = |kinds: &[Kind], list: &[Known]| {
        if kinds.iter().any(|k| shares.holds(*k)) {
            carried(design, library, &without, list)
        } else {
            vec![]
        }
    };
    let named = [Kind::Single, Kind::Pair];
    let can = Carried {
        known: tried(&named, &known),
        off_library: tried(&[Kind::OffLibrary], library.off_library()),
        form_variants: tried(&[Kind::FormVariant], library.form_variants()),
    };
    let draws_known = named.iter().any(|k| shares.holds(*k));
    let shares = possible(shares, &can)?;
    let all = drafts(n, seed, &shares, &can);
    let soils = Soils::new(
        &design.rover,
        library.registry(),
        &design.scenario.model,
        &design.scenario.left,
        &design.scenario.right,
    )?;
    let digits = n.to_string().len().max(3);
    let mut cases = Vec::with_capacity(n);
    let mut commitment = String::new();
    let mut rejected = 0;
    for (batch, drafts) in all.chunks(BATCH).enumerate() {
        let made: Vec<Result<(MadeCase, usize), CliError>> = drafts
            .par_iter()
            .enumerate()
            .map(|(k, draft)| {
                let number = batch * BATCH + k + 1;
                let name = format!("case_{number:0digits$}");
                let draws = Draws::new(seed, number as u64);
                let made = one(name, draft, design, library, &soils, draws);
                step();
                made
            })
            .collect();
        for case in made {
            let (case, before) = case?;
            rejected += before;
            keep(&case)?;
            commitment.push_str(&format!("{} {}\n", case.name, digest(&case.key)));
            cases.push(case.key);
        }
    }
    let counts = Kind::ALL
        .into_iter()
        .map(|kind| (kind, all.iter().filter(|d| d.kind == kind).count()))
        .collect();
    let not_carried = known
        .into_iter()
        .filter(|k| draws_known && !can.known.contains(k))
        .map(|k| k.name)
        .collect();
    Ok(Challenge {
        key: KeyFile {
            schema: SCHEMA.to_owned(),
            design: Some(design.sealed.clone()),
            draws: (needed(design) > 0).then_some(Gate {
                moving_windows: needed(design),
                window_s: moving::WINDOW,
                speed_m_s: moving::SPEED,
                rejected,
            }),
            cases,
        },
        rover: design.sealed.rover.clone(),
        commitment,
        counts,
        not_carried,
    })
}

fn one(
    name: String,
    draft: &Draft,
    design: &Design,
    library: &Library,
    soils: &Soils,
    mut draws: Draws,
) -> Result<(MadeCase, usize), CliError> {
    let nonce = draws.nonce();
    let mut last = None;
    let (radius, windows) = (design.rover.wheel.radius, needed(design));
    let through = |scenario: &Scenario| -> Result<AnyLog, CliError> {
        let log = simulate(scenario, &design.rover, library.registry())?;
        if moves(&log, radius, windows) {
            Ok(log)
        } else {
            Err(CliError::data(
                format!("fewer than {windows} windows of {} s move", moving::WINDOW),
                "stronger manoeuvres",
            ))
        }
    };
    for rejected in 0..ATTEMPTS {
        let mut scenario = design.scenario.clone();
        scenario.seed = draws.seed();
        let [left, right] = soils.draw(&mut draws);
        for known in &draft.effects {
            scenario.effects.push(EffectSetting {
                name: known.name.clone(),
                magnitude: library
                    .sizes(known)
                    .iter()
                    .map(|size| magnitude(size, &mut draws))
                    .collect(),
                form: Some(known.form.clone()),
            });
        }
        scenario.left = Start::Values(left.clone());
        scenario.right = Start::Values(right.clone());
        // The soil must let the vehicle move by itself, whatever the case holds.
        let mut bare = quiet(&scenario);
        bare.effects.clear();
        match through(&bare).and_then(|_| through(&scenario)) {
            Ok(log) => {
                let key = CaseKey {
                    kind: draft.kind.name().to_owned(),
                    effects: scenario.effects.iter().map(sealed).collect(),
                    seed: scenario.seed,
                    rejected,
                    soil: BTreeMap::from([("left".to_owned(), left), ("right".to_owned(), right)]),
                    terrain: around(&design.scenario.left),
                };
                let key = KeyCase {
                    case: name.clone(),
                    nonce,
                    key: json!(key),
                };
                let made = MadeCase {
                    log: log.bytes()?,
                    name,
                    key,
                };
                return Ok((made, rejected));
            }
            // The design itself is known to work: this soil does not carry the vehicle, or is none for this model.
            Err(e) => last = Some(e),
        }
    }
    let why = last.map(|e| e.to_string()).unwrap_or_default();
    Err(CliError::data(
        format!("no soil gets through this design in {ATTEMPTS} draws; the last: {why}"),
        "gentler manoeuvres, or smaller prior_sd in [terrain] of the rover file",
    ))
}

/// The scenario that a key's case was simulated with.
///
/// # Errors
/// A key whose numbers are none.
pub(crate) fn scenario_of(key: &CaseKey, design: &Design) -> Result<Scenario, CliError> {
    let mut scenario = design.scenario.clone();
    scenario.seed = key.seed;
    for (side, start) in [("left", &mut scenario.left), ("right", &mut scenario.right)] {
        if let Some(values) = key.soil.get(side) {
            *start = Start::Values(values.clone());
        }
    }
    for effect in &key.effects {
        let numbers: Option<Vec<f64>> = match &effect.magnitude {
            Value::Array(items) => items.iter().map(Value::as_f64).collect(),
            other => other.as_f64().map(|e| vec![e]),
        };
        let magnitude = numbers.ok_or_else(|| CliError::BadData {
            message: format!(
                "the magnitude of {} is {}, expected a number",
                effect.name, effect.magnitude
            ),
            help: None,
        })?;
        scenario.effects.push(EffectSetting {
            name: effect.name.clone(),
            magnitude,
            form: Some(effect.form.clone()),
        });
    }
    Ok(scenario)
}

fn sealed(effect: &EffectSetting) -> SealedEffect {
    SealedEffect {
        form: effect.form.clone().unwrap_or_else(|| "default".to_owned()),
        magnitude: match effect.magnitude.as_slice() {
            [one] => json!(one),
            several => json!(several),
        },
        name: effect.name.clone(),
    }
}

fn around(start: &Start) -> Value {
    match start {
        Start::Id(id) => json!(id),
        Start::Own(soil) => json!(soil.id),
        Start::Values(values) => json!(values),
    }
}

#[cfg(test)]
mod tests {
    use terra_model::{Channel, Effect, Param, Real, Registry, Scale, Scope, Touch};

    use super::*;

    const SHARE: &[Param] = &[Param {
        name: "magnitude",
        symbol: "e",
        unit: "1",
        min: 0.0,
        max: 5.0,
        scale: Scale::Linear,
        prior_sd: 0.2,
        doc: "share",
    }];

    /// A load cell that no diagnosis knows of: it reads squares.
    #[derive(Default)]
    struct BentCell;

    impl Effect for BentCell {
        const NAME: &'static str = "bent-cell";
        const SUMMARY: &'static str = "the load cell is bent";
        const PARAMS: &'static [Param] = SHARE;
        const REFERENCE: &'static str = "chosen form and prior";
        const TOUCHES: &'static [Touch] = &[Touch::Sensor];
        const SCOPE: Scope = Scope::Rig;
        const REGIME: &'static str = "pull only";
        const ISOLATED_BY: &'static str = "a known weight";

        fn report<T: Real>(&self, e: &[T], channel: Channel, truth: T, _rate: T) -> T {
            if channel == Channel::DrawbarPull {
                truth + e[0] * truth * truth * 0.05
            } else {
                truth
            }
        }
    }

    /// The gain of the load cell by another formula.
    #[derive(Default)]
    struct OtherGain;

    impl Effect for OtherGain {
        const NAME: &'static str = "drawbar-gain";
        const FORM: &'static str = "other";
        const SUMMARY: &'static str = "the load cell is off by a factor";
        const PARAMS: &'static [Param] = SHARE;
        const REFERENCE: &'static str = "chosen form and prior";
        const TOUCHES: &'static [Touch] = &[Touch::Sensor];
        const SCOPE: Scope = Scope::Rig;
        const REGIME: &'static str = "pull only";
        const ISOLATED_BY: &'static str = "a known weight";

        fn report<T: Real>(&self, e: &[T], channel: Channel, truth: T, _rate: T) -> T {
            if channel == Channel::DrawbarPull {
                truth * (e[0] * 2.0 + 1.0)
            } else {
                truth
            }
        }
    }

    fn made(
        library: &Library,
        kinds: &str,
        n: usize,
    ) -> Result<(Challenge, Vec<MadeCase>), CliError> {
        let mut cases = vec![];
        let shares = Shares::parse(kinds)?;
        let challenge = make(
            &Design::named("rig")?,
            library,
            shares,
            n,
            9,
            &|| (),
            &mut |case| {
                cases.push(case.clone());
                Ok(())
            },
        )?;
        Ok((challenge, cases))
    }

    /// Effects of the generator alone join with one line each and are drawn under their kind; without any, asking is an
    /// error.
    #[test]
    fn the_generators_own_effects_join_with_one_line() {
        let bare = Library::new(Registry::builtin());
        let kinds = "off-library=1,form-variant=1";
        let library = bare
            .clone()
            .with_off_library::<BentCell>()
            .with_form_variant::<OtherGain>();
        assert_eq!(library.known(), bare.known());
        let (challenge, _) = made(&library, kinds, 6).unwrap();
        for case in &challenge.key.cases {
            let key = case.read().unwrap();
            let effect = &key.effects[0];
            match key.kind.as_str() {
                "off-library" => {
                    assert_eq!(effect.name, "bent-cell");
                    assert_eq!(key.truth(), "unknown");
                }
                "form-variant" => {
                    assert_eq!(
                        (effect.name.as_str(), effect.form.as_str()),
                        ("drawbar-gain", "other")
                    );
                    assert_eq!(key.truth(), "drawbar-gain");
                }
                other => panic!("{other}"),
            }
        }
        assert_eq!(challenge.counts[3].1, 3);
        assert_eq!(challenge.counts[4].1, 3);
        let e = made(&bare, "off-library=1", 2).unwrap_err();
        assert_eq!(e.exit_code(), 2);
    }

    /// Every case moves, with its effects and without, whatever its kind; the key counts what was drawn in vain.
    #[test]
    fn kept_draws_move() {
        let library = Library::new(Registry::builtin());
        let design = Design::named("ramp").unwrap();
        let shares = Shares::parse("none=1,single=1").unwrap();
        let challenge = make(&design, &library, shares, 10, 3, &|| (), &mut |_| Ok(())).unwrap();
        let gate = challenge.key.draws.unwrap();
        assert_eq!((gate.moving_windows, gate.speed_m_s), (10, 0.12));
        let mut rejected = 0;
        for case in &challenge.key.cases {
            let key = case.read().unwrap();
            rejected += key.rejected;
            let mut scenario = quiet(&scenario_of(&key, &design).unwrap());
            for _ in 0..2 {
                let log = simulate(&scenario, &design.rover, library.registry()).unwrap();
                assert!(moves(&log, design.rover.wheel.radius, 10), "{}", case.case);
                scenario.effects.clear();
            }
        }
        assert_eq!(gate.rejected, rejected);
    }

    /// The key alone makes the log again, byte for byte.
    #[test]
    fn a_key_makes_its_log_again() {
        let library = Library::new(Registry::builtin());
        let (challenge, cases) = made(&library, "none=1,single=2,pair=1", 8).unwrap();
        let design = Design::of(challenge.key.design.as_ref().unwrap()).unwrap();
        let text = serde_json::to_string(&challenge.key).unwrap();
        let key: KeyFile = serde_json::from_str(&text).unwrap();
        for (sealed, made) in key.cases.iter().zip(&cases) {
            let scenario = scenario_of(&sealed.read().unwrap(), &design).unwrap();
            let log = simulate(&scenario, &design.rover, library.registry()).unwrap();
            assert!(log.bytes().unwrap() == made.log, "{}", made.name);
            assert_eq!(
                challenge
                    .commitment
                    .lines()
                    .find(|l| l.starts_with(&made.name))
                    .unwrap(),
                format!("{} {}", made.name, digest(sealed))
            );
        }
    }
}
