//! Against a simulator of another wheel law: other soil and effects that stand for each other.
//!
//! What the law's form hides and what an effect explains are alike there, and the evidence of the two need not tell them apart: the
//! first two answers then share their probability, and the reason says what would tell.

use crate::cause::{Ranking, by_probability};
use crate::contrast::needs_another_form;
use crate::setup::OTHER_SOIL;

/// Nats within which an effect of the ground stands beside other soil that leads, against a foreign wheel law. Other soil that
/// needs another error of the law's form has one beside it at any distance: it led so in 57 of 288 mock contrasts (seeds 13013
/// and 15015), by up to 290 nats where it took the place of an effect whose formula the law does not have, and was right in 26.
/// An effect that leads over so free a soil stands alone: other soil was the truth in none of 15 such cases within 20 nats.
const STAND_IN: f64 = 20.0;
/// Nats over other soil from which an effect on it stands without it, and what share of what other soil gains they must be. Of 28
/// contrasts between two wheel laws without an effect, by another generator, the best of thirty effects gained up to 39 on other soil,
/// four hundredths of that soil's; of 18 mock contrasts of other soil (seed 900104) one 63, of 4608, where eight right ones gained
/// 46 to 1526, a sixth and more.
const ALONE: f64 = 40.0;
const ALONE_SHARE: f64 = 0.05;
/// Share of the probability of both that other soil has where an effect on it leads by less: of 30 such contrasts by that generator
/// the effect was right in twelve.
const SOIL_FIRST: f64 = 2.0 / 3.0;
/// Answers up to which an effect by itself is told beside other soil and an effect on it.
const WITH_SOIL: usize = 3;
/// Why other soil and an effect stand for each other.
const ANOTHER_LAW: &str = "another soil and an effect stand for each other, or are there together, where the simulator's wheel law is another; a simulator's log of the same ground (--same-bed) tells them apart";
/// Why two effects do.
const TOO_NEAR: &str = "the simulator's wheel law is another, and beside so large a difference what these explain is too near to tell them apart";

impl Ranking {
    /// Puts other soil beside the effects that may be there instead of it or with it, where one of them leads and their evidences are
    /// near or say nothing. The first two share their probability, for the evidence did not tell them apart.
    pub(crate) fn stand_in(&mut self, on_other_soil: Option<&str>, by_itself: Option<&str>) {
        let Some(top) = self.causes.first() else {
            return;
        };
        if self.set.first() != Some(&top.name) {
            return;
        }
        let at = |name: &str| self.causes.iter().position(|c| c.name == name);
        let gain = |at: usize| self.causes[at].log_evidence_gain;
        let (rival, share) = if top.name == OTHER_SOIL {
            let bends = needs_another_form(&top.weighed);
            let near = |at: &usize| bends || gain(*at) > gain(0) - STAND_IN;
            let by_itself = by_itself.and_then(at).filter(near);
            let with_it = on_other_soil.and_then(at).filter(|_| bends);
            (with_it.or(by_itself), 0.5)
        } else if top.on_other_soil {
            let soil = at(OTHER_SOIL);
            let soil = soil.filter(|at| gain(0) < gain(*at) + ALONE.max(ALONE_SHARE * gain(*at)));
            let mut others = self.causes.iter().skip(1).filter(|c| c.on_other_soil);
            let next = others.next().and_then(|c| at(&c.name));
            let said = at(OTHER_SOIL).map_or(0.0, gain);
            let next = next.filter(|at| gain(0) < gain(*at) + ALONE_SHARE * said);
            match (soil, next) {
                (Some(soil), _) => (Some(soil), SOIL_FIRST),
                (None, next) => (next, 1.0 - SOIL_FIRST),
            }
        } else {
            (None, 0.0)
        };
        let Some(rival) = rival else {
            return;
        };
        let both = self.causes[0].probability + self.causes[rival].probability;
        let soil = self.causes[rival].name == OTHER_SOIL || self.causes[0].name == OTHER_SOIL;
        let why = if soil { ANOTHER_LAW } else { TOO_NEAR };
        self.stand_in = Some((both, why));
        self.causes[rival].probability = share * both;
        self.causes[0].probability = (1.0 - share) * both;
        let name = self.causes[rival].name.clone();
        if share > 0.5 {
            // Of what says a little more on other soil, the first stands for all.
            let first = self.causes[0].name.clone();
            let stays = |n: &String| *n == first || n == "none" || n == "unknown";
            self.set.retain(stays);
            self.set.insert(0, name);
        } else {
            self.add(Some(name));
        }
        if self.set.len() < WITH_SOIL && soil {
            self.add(by_itself.map(str::to_owned));
        }
        self.causes.sort_by(by_probability);
    }
}
