//! What a case holds: kind and effects by an even deal over the whole challenge, numbers by the case's own stream.

use std::collections::BTreeMap;

use terra_data::{Rover, Start};
use terra_mme::{Centre, FitSpace, Priors};
use terra_model::{Law, Param, Registry, catalogue};

use super::library::{Known, Size};
use super::random::{Draws, six_digits};
use super::shares::{Kind, Shares};
use crate::error::CliError;

/// Magnitudes lie between these shares of an effect's prior standard deviation.
const SMALLEST: f64 = 0.3;
const LARGEST: f64 = 2.0;
/// A soil lies within so many prior standard deviations of the start, each parameter on its own.
const SOIL_LIMIT: f64 = 2.0;

/// What a design can carry, by kind.
#[derive(Clone, Debug, Default)]
pub(crate) struct Carried {
    pub(crate) known: Vec<Known>,
    pub(crate) off_library: Vec<Known>,
    pub(crate) form_variants: Vec<Known>,
}

/// A case before its numbers are drawn.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Draft {
    pub(crate) kind: Kind,
    pub(crate) effects: Vec<Known>,
}

/// Shares that this design and library can fill.
///
/// # Errors
/// A kind that was asked for and has nothing to draw from.
pub(crate) fn possible(mut shares: Shares, carried: &Carried) -> Result<Shares, CliError> {
    let lists = [
        (Kind::Single, carried.known.len(), 1, "effect"),
        (Kind::Pair, carried.known.len(), 2, "pair of effects"),
        (
            Kind::OffLibrary,
            carried.off_library.len(),
            1,
            "off-library effect",
        ),
        (
            Kind::FormVariant,
            carried.form_variants.len(),
            1,
            "other form of an effect",
        ),
    ];
    for (kind, found, needed, what) in lists {
        if !shares.holds(kind) || found >= needed {
            continue;
        }
        if shares.asks_for(kind) {
            return Err(CliError::usage(
                format!(
                    "{kind} cases were asked for, and there is no {what} that this design can carry"
                ),
                format!("leave {kind} out of --kinds"),
            ));
        }
        shares = shares.without(kind);
    }
    Ok(shares)
}

/// Kinds and effects of all cases, in an order that says nothing.
pub(crate) fn drafts(n: usize, seed: u64, shares: &Shares, carried: &Carried) -> Vec<Draft> {
    let mut draws = Draws::new(seed, 0);
    let mut all = Vec::with_capacity(n);
    for (kind, count) in shares.split(n) {
        let one = |list: &[Known], draws: &mut Draws| -> Vec<Vec<Known>> {
            draws
                .deal(list, count)
                .into_iter()
                .map(|k| vec![k])
                .collect()
        };
        let effects = match kind {
            Kind::None => vec![vec![]; count],
            Kind::Single => one(&carried.known, &mut draws),
            Kind::OffLibrary => one(&carried.off_library, &mut draws),
            Kind::FormVariant => one(&carried.form_variants, &mut draws),
            Kind::Pair => pairs(&carried.known, count, &mut draws),
        };
        all.extend(effects.into_iter().map(|effects| Draft { kind, effects }));
    }
    draws.shuffle(&mut all);
    all
}

fn pairs(list: &[Known], count: usize, draws: &mut Draws) -> Vec<Vec<Known>> {
    let firsts = draws.deal(list, count);
    firsts
        .into_iter()
        .map(|first| {
            let others: Vec<&Known> = list.iter().filter(|k| k.name != first.name).collect();
            let mut pair = vec![first];
            if let Some(second) = others.get(draws.below(others.len())) {
                pair.push((*second).clone());
            }
            pair.sort();
            pair
        })
        .collect()
}

/// A magnitude of .3 to 2 prior standard deviations, of either sign where the effect has two, inside its range; or
/// between the ends that the truth simulation lists.
pub(crate) fn magnitude(size: &Size, draws: &mut Draws) -> f64 {
    match size {
        Size::Prior(param) => by_prior(param, draws),
        Size::Between(low, high) => six_digits(draws.between(*low, *high)).clamp(*low, *high),
    }
}

fn by_prior(param: &Param, draws: &mut Draws) -> f64 {
    let mut last = 0.0;
    for _ in 0..1000 {
        let size = draws.between(SMALLEST, LARGEST) * param.prior_sd;
        let negative = draws.coin();
        last = six_digits(if negative && !param.one_sided() {
            -size
        } else {
            size
        });
        if (param.min..=param.max).contains(&last) {
            return last;
        }
    }
    last.clamp(param.min, param.max)
}

/// True soils around a scenario's terrain, as far from it as the prior of a diagnosis allows.
pub(crate) struct Soils {
    law: Law,
    sides: [FitSpace; 2],
    one: bool,
}

impl Soils {
    pub(crate) fn new(
        rover: &Rover,
        registry: &Registry,
        model: &str,
        left: &Start,
        right: &Start,
    ) -> Result<Self, CliError> {
        let law = registry.law(model)?;
        let mut widths = vec![rover.wheel.width];
        widths.extend(rover.conditions.values().map(|c| c.wheel.width));
        let priors = Priors::default().with(&rover.terrain.prior_sd, &rover.terrain.prior_abs_sd);
        let space = |start: &Start| -> Result<FitSpace, CliError> {
            Ok(match start {
                Start::Id(id) => FitSpace::new(
                    &law,
                    Centre::Terrain(catalogue::find(id)?),
                    &widths,
                    &priors,
                )?,
                Start::Own(soil) => FitSpace::new(&law, Centre::Terrain(soil), &widths, &priors)?,
                Start::Values(values) => {
                    FitSpace::new(&law, Centre::Values(values), &widths, &priors)?
                }
            })
        };
        let sides = [space(left)?, space(right)?];
        Ok(Soils {
            law,
            sides,
            one: left == right,
        })
    }

    /// Left and right soil by parameter name; one soil where the scenario has one.
    pub(crate) fn draw(&self, draws: &mut Draws) -> [BTreeMap<String, f64>; 2] {
        let [left, right] = &self.sides;
        let first = self.one_soil(left, draws);
        let second = if self.one {
            first.clone()
        } else {
            self.one_soil(right, draws)
        };
        [first, second]
    }

    fn one_soil(&self, space: &FitSpace, draws: &mut Draws) -> BTreeMap<String, f64> {
        let q: Vec<f64> = space
            .lower_bounds()
            .into_iter()
            .map(|low| {
                let z = draws.normal_within(SOIL_LIMIT);
                if z < low { -z } else { z }
            })
            .collect();
        let names = terra_model::ForceLaw::params(&self.law);
        names
            .iter()
            .map(|p| p.name.to_owned())
            .zip(space.parameters(&q).into_iter().map(six_digits))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use terra_model::Scale;

    use super::*;

    fn known(name: &str) -> Known {
        Known {
            name: name.into(),
            form: "default".into(),
        }
    }

    fn carried() -> Carried {
        Carried {
            known: ["slope", "torque-bias", "aero-drag"].map(known).to_vec(),
            ..Carried::default()
        }
    }

    #[test]
    fn a_kind_that_was_asked_for_must_have_something_to_draw() {
        let asked = Shares::parse("none=1,off-library=1").unwrap();
        let e = possible(asked, &carried()).unwrap_err();
        assert_eq!(e.exit_code(), 2);
        assert!(e.to_string().contains("off-library"), "{e}");
        let left = possible(Shares::default(), &carried()).unwrap();
        assert!(left.holds(Kind::Pair) && !left.holds(Kind::OffLibrary));
    }

    #[test]
    fn drafts_are_even_and_pairs_are_of_two() {
        let shares = possible(Shares::default(), &carried()).unwrap();
        let all = drafts(80, 3, &shares, &carried());
        let count = |kind| all.iter().filter(|d| d.kind == kind).count();
        assert_eq!(
            [count(Kind::None), count(Kind::Single), count(Kind::Pair)],
            [20, 50, 10]
        );
        for name in ["slope", "torque-bias", "aero-drag"] {
            let n = all
                .iter()
                .filter(|d| d.kind == Kind::Single && d.effects[0].name == name)
                .count();
            assert!((16..=17).contains(&n), "{name}: {n}");
        }
        for d in all.iter().filter(|d| d.kind == Kind::Pair) {
            assert!(d.effects[0].name < d.effects[1].name);
        }
        // Runs of one kind would tell the kind by the number of the case: 20, 50, 10 of 80 in random order have about
        // 43 changes of kind, and fewer than 30 once in ten thousand.
        let changes = all.windows(2).filter(|w| w[0].kind != w[1].kind).count();
        assert!(changes > 30, "{changes}");
    }

    #[test]
    fn magnitudes_keep_to_their_range_and_side() {
        let param = |min: f64, max: f64| Param {
            name: "magnitude",
            symbol: "e",
            unit: "1",
            min,
            max,
            scale: Scale::Linear,
            prior_sd: 0.5,
            doc: "",
        };
        let mut draws = Draws::new(5, 1);
        let mut negative = 0;
        for _ in 0..400 {
            let e = by_prior(&param(0.0, 0.6), &mut draws);
            assert!((0.15..=0.6).contains(&e), "{e}");
            let e = by_prior(&param(f64::NEG_INFINITY, f64::INFINITY), &mut draws);
            assert!((0.15..=1.0).contains(&e.abs()), "{e}");
            negative += usize::from(e < 0.0);
            let e = magnitude(&Size::Between(0.3, 1.2), &mut draws);
            assert!((0.3..=1.2).contains(&e), "{e}");
        }
        // Binomial(400, 1/2): 200 ± 10; five sigma.
        assert!((150..=250).contains(&negative), "{negative}");
    }
}
