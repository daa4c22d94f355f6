//! The cases: structure, soil, cause and magnitude, each by the case's own stream.

use terra_data::{Rover, Start};
use terra_gap::is_instrument;
use terra_sim::{EffectSetting, Scenario};

use super::{STRUCTURES, Truth};
use crate::challenge::carry::{carried, quiet};
use crate::challenge::design::{AnyLog, Design, simulate};
use crate::challenge::draw::{Soils, magnitude};
use crate::challenge::moving::{moves, needed};
use crate::challenge::random::Draws;
use crate::challenge::{Known, Library};
use crate::error::CliError;

/// Of eight cases: two nothing, two instruments, one other soil, two physical effects, one in another form.
const KINDS: [Truth; 8] = [
    Truth::None,
    Truth::Instrument,
    Truth::Physical,
    Truth::OtherForm,
    Truth::None,
    Truth::Instrument,
    Truth::Physical,
    Truth::Soil,
];
/// Soils and magnitudes that are tried until rig or vehicle get through.
const ATTEMPTS: usize = 60;

/// What one structure can be the truth of.
struct Structure {
    name: &'static str,
    soils: Soils,
    instruments: Vec<Known>,
    physical: Vec<Known>,
    other_forms: Vec<Known>,
}

/// The design's programme under every structure.
pub(crate) struct Programme {
    design: Design,
    truths: Library,
    structures: Vec<Structure>,
}

/// One case.
pub(crate) struct Case {
    pub(crate) truth: Truth,
    /// Name of the right answer.
    pub(crate) name: String,
    /// Structure of the ground.
    pub(crate) ground: &'static str,
    /// Structure of the nominal simulator.
    pub(crate) nominal: &'static str,
    pub(crate) effect: Option<EffectSetting>,
    /// The outside simulator's log.
    pub(crate) sim: AnyLog,
    /// The log to be diagnosed.
    pub(crate) real: AnyLog,
}

impl Programme {
    /// # Errors
    /// An unknown design; a structure that it cannot be simulated with.
    pub(crate) fn new(design: &str) -> Result<Self, CliError> {
        let design = Design::named(design)?;
        let library = Library::builtin();
        let structures = STRUCTURES
            .into_iter()
            .map(|name| {
                let mut design = design.clone();
                design.scenario.model = name.to_owned();
                let without =
                    simulate(&quiet(&design.scenario), &design.rover, library.registry())?;
                let known = carried(&design, &library, &without, &library.known());
                let (physical, instruments) =
                    known.into_iter().partition(|k| is_physical(&library, k));
                Ok(Structure {
                    name,
                    soils: Soils::new(
                        &design.rover,
                        library.registry(),
                        name,
                        &design.scenario.left,
                        &design.scenario.right,
                    )?,
                    instruments,
                    physical,
                    other_forms: carried(&design, &library, &without, library.form_variants()),
                })
            })
            .collect::<Result<_, CliError>>()?;
        Ok(Programme {
            design,
            truths: library,
            structures,
        })
    }

    /// Name of the design.
    pub(crate) fn name(&self) -> &str {
        &self.design.sealed.name
    }

    /// Manoeuvres of a drive, none of a rig.
    pub(crate) fn manoeuvres(&self) -> usize {
        self.design.scenario.segments.len()
    }

    /// The nominal simulator of a structure.
    pub(crate) fn rover(&self, structure: &str) -> Rover {
        let mut rover = self.design.rover.clone();
        rover.terrain.model = structure.to_owned();
        rover
    }

    /// Case `k` of a seed.
    ///
    /// # Errors
    /// A structure that no soil can be simulated with.
    pub(crate) fn case(&self, seed: u64, k: usize) -> Result<Case, CliError> {
        let mut draws = Draws::new(seed, k as u64 + 1);
        let n = self.structures.len();
        let pair = k % (n * (n - 1));
        let (a, step) = (pair % n, 1 + pair / n);
        let (ground, nominal) = (&self.structures[a], self.structures[(a + step) % n].name);
        let truth = KINDS[(k / (n * (n - 1))) % KINDS.len()];
        let list = match truth {
            Truth::None | Truth::Soil => &[][..],
            Truth::Instrument => &ground.instruments,
            Truth::Physical => &ground.physical,
            Truth::OtherForm => &ground.other_forms,
        };
        let known = list.get(draws.below(list.len().max(1)));
        let mut last = None;
        for _ in 0..ATTEMPTS {
            match self.drawn(ground, truth, known, &mut draws) {
                Ok((effect, sim, real)) => {
                    return Ok(Case {
                        truth,
                        name: match truth {
                            Truth::None => "none".to_owned(),
                            Truth::Soil => "soil-change".to_owned(),
                            _ => known.map_or_else(String::new, |k| k.name.clone()),
                        },
                        ground: ground.name,
                        nominal,
                        effect,
                        sim,
                        real,
                    });
                }
                Err(e) => last = Some(e),
            }
        }
        let why = last.map(|e| e.to_string()).unwrap_or_default();
        Err(CliError::data(
            format!(
                "no soil of {} in {ATTEMPTS} draws; the last: {why}",
                ground.name
            ),
            "another seed",
        ))
    }

    fn drawn(
        &self,
        ground: &Structure,
        truth: Truth,
        known: Option<&Known>,
        draws: &mut Draws,
    ) -> Result<(Option<EffectSetting>, AnyLog, AnyLog), CliError> {
        let mut scenario = Scenario {
            model: ground.name.to_owned(),
            seed: draws.seed(),
            ..self.design.scenario.clone()
        };
        let [soil, _] = ground.soils.draw(draws);
        let [other, _] = ground.soils.draw(draws);
        let effect = known.map(|known| EffectSetting {
            name: known.name.clone(),
            magnitude: self
                .truths
                .sizes(known)
                .iter()
                .map(|size| magnitude(size, draws))
                .collect(),
            form: Some(known.form.clone()),
        });
        let on = |scenario: &mut Scenario, soil| {
            scenario.left = Start::Values(soil);
            scenario.right = scenario.left.clone();
            let log = simulate(scenario, &self.design.rover, self.truths.registry())?;
            if moves(&log, self.design.rover.wheel.radius, needed(&self.design)) {
                Ok(log)
            } else {
                Err(CliError::data("the vehicle hardly moves", "other soil"))
            }
        };
        let sim = on(&mut scenario, soil.clone())?;
        scenario.seed = draws.seed();
        scenario.effects.extend(effect.clone());
        let soil = if truth == Truth::Soil { other } else { soil };
        let real = on(&mut scenario, soil)?;
        Ok((effect, sim, real))
    }
}

/// What acts on the soil or between wheel and soil; the rest is instruments and measures, whose formula is exact.
fn is_physical(library: &Library, known: &Known) -> bool {
    let mut all = library.registry().effects().iter();
    all.find(|e| e.name() == known.name && e.form() == known.form)
        .is_some_and(|e| !is_instrument(&**e))
}
