//! Observations side by side: eight are predicted in the lanes of one evaluation, at half of what eight alone cost or less.
//!
//! Where one of them has no answer each is asked alone, and says so itself.

use terra_model::{Lanes, Vector};

use crate::error::GapError;
use crate::parallel::try_for_each;

/// Observations from which a group is cheaper than one plain number after the other.
pub(crate) const WORTH: usize = 3;

/// What observations have in common that go side by side.
pub(crate) trait Kind: PartialEq + Clone {
    /// What a group of this kind costs, whatever its size, in any unit.
    fn cost(&self) -> f64 {
        1.0
    }

    /// The kind of a group that holds both, where there is one.
    fn with(&self, _other: &Self) -> Option<Self> {
        None
    }
}

/// Share of a group's cost that an observation costs alone.
const ALONE: f64 = 0.35;

/// Places of observations that go together.
#[derive(Clone)]
struct Group<K> {
    kind: K,
    places: Vec<usize>,
}

impl<K: Kind> Group<K> {
    fn cost(&self, worth: usize) -> f64 {
        let alone = self.places.len() as f64 * ALONE;
        let share = if self.places.len() < worth {
            alone
        } else {
            1.0
        };
        share * self.kind.cost()
    }
}

/// Fills groups of each kind one after the other, and puts those together that are not full where that is cheaper.
fn gather<K: Kind>(indices: &[usize], kind: impl Fn(usize) -> K, worth: usize) -> Vec<Group<K>> {
    let (mut full, mut open): (Vec<Group<K>>, Vec<Group<K>>) = (vec![], vec![]);
    for (place, &index) in indices.iter().enumerate() {
        let kind = kind(index);
        let Some(k) = open.iter().position(|group| group.kind == kind) else {
            let places = vec![place];
            open.push(Group { kind, places });
            continue;
        };
        open[k].places.push(place);
        if open[k].places.len() == Lanes::WIDTH {
            full.push(open.swap_remove(k));
        }
    }
    while let Some((a, b, joined)) = cheapest(&open, worth) {
        // b stands behind a.
        open.swap_remove(b);
        open[a] = joined;
    }
    full.extend(open);
    full
}

/// The two groups whose joining saves most, and what it gives.
fn cheapest<K: Kind>(groups: &[Group<K>], worth: usize) -> Option<(usize, usize, Group<K>)> {
    let mut best: Option<(f64, (usize, usize, K))> = None;
    for (a, one) in groups.iter().enumerate() {
        for (b, other) in groups.iter().enumerate().skip(a + 1) {
            let count = one.places.len() + other.places.len();
            if count > Lanes::WIDTH {
                continue;
            }
            let Some(kind) = one.kind.with(&other.kind) else {
                continue;
            };
            let saves = one.cost(worth) + other.cost(worth) - kind.cost();
            if saves > best.as_ref().map_or(0.0, |(most, _)| *most) {
                best = Some((saves, (a, b, kind)));
            }
        }
    }
    let (_, (a, b, kind)) = best?;
    let places = [&groups[a].places[..], &groups[b].places].concat();
    Some((a, b, Group { kind, places }))
}

/// Answers of observations, in their order: up to eight of one `kind`, or of kinds that go together, at once by `together`, from
/// `worth` on.
///
/// # Errors
/// Of `alone`.
pub(crate) fn in_groups<K: Kind + Sync, A: Clone + Default + Send + Sync>(
    indices: &[usize],
    kind: impl Fn(usize) -> K,
    worth: usize,
    together: impl Fn(&[usize]) -> Result<Vec<A>, GapError> + Sync,
    alone: impl Fn(usize) -> Result<A, GapError> + Sync,
) -> Result<Vec<A>, GapError> {
    let groups = gather(indices, kind, worth);
    let found: Vec<Vec<A>> = try_for_each(groups.len(), |k| {
        let places = &groups[k].places;
        let members: Vec<usize> = places.iter().map(|&place| indices[place]).collect();
        if members.len() >= worth
            && let Ok(found) = together(&members)
        {
            return Ok(found);
        }
        members.iter().map(|&i| alone(i)).collect()
    })?;
    let mut out = vec![A::default(); indices.len()];
    for (group, found) in groups.iter().zip(found) {
        for (&place, answer) in group.places.iter().zip(found) {
            out[place] = answer;
        }
    }
    Ok(out)
}

/// One number of each member; the last fills the lanes that are left over.
pub(crate) fn side_by_side<M>(members: &[M], of: impl Fn(&M) -> f64) -> Lanes {
    let last = members.len().saturating_sub(1);
    Lanes::gather((0..Lanes::WIDTH).filter_map(|lane| members.get(lane.min(last)).map(&of)))
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Kind for bool {}

    /// A colour that a group of another may take in at a price.
    #[derive(Clone, Debug, PartialEq)]
    struct Colour(&'static str, f64);

    impl Kind for Colour {
        fn cost(&self) -> f64 {
            self.1
        }

        fn with(&self, other: &Self) -> Option<Self> {
            let both = [self.0, other.0];
            let grey = both.contains(&"black") && both.contains(&"white");
            grey.then_some(Colour("grey", 1.5))
        }
    }

    /// Ten black ones and nine white ones, one red: two groups of eight, and the three that are left together where that is
    /// cheaper than apart; what cannot be joined stays alone.
    #[test]
    fn what_is_left_over_goes_together_where_that_is_cheaper() {
        let sizes = |cost: f64| {
            let colour = |i: usize| match i {
                0..10 => Colour("black", cost),
                10..19 => Colour("white", cost),
                _ => Colour("red", cost),
            };
            let indices: Vec<usize> = (0..20).collect();
            let groups = gather(&indices, colour, 1);
            let mut places: Vec<usize> = groups.iter().flat_map(|g| g.places.clone()).collect();
            places.sort_unstable();
            assert_eq!(places, indices);
            let mut sizes: Vec<usize> = groups.iter().map(|g| g.places.len()).collect();
            sizes.sort_unstable();
            sizes
        };
        assert_eq!(sizes(1.0), [1, 3, 8, 8]);
        assert_eq!(sizes(0.7), [1, 1, 2, 8, 8]);
    }

    /// Twenty of one kind and three of another, in turn: every answer lies where its observation was asked, whatever the
    /// groups, and a group that fails is asked one by one.
    #[test]
    fn answers_lie_where_they_were_asked() {
        let indices: Vec<usize> = (100..123).collect();
        let answer = |i: usize| vec![i as f64];
        let found = in_groups(
            &indices,
            |i| i % 8 == 0,
            WORTH,
            |members| {
                assert!(members.len() <= Lanes::WIDTH);
                assert!(
                    members
                        .windows(2)
                        .all(|m| (m[0] % 8 == 0) == (m[1] % 8 == 0))
                );
                if members.contains(&110) {
                    return Err(GapError::Mismatch("no answer in lanes".to_owned()));
                }
                Ok(members.iter().map(|&i| answer(i)).collect())
            },
            |i| Ok(answer(i)),
        );
        let expected: Vec<Vec<f64>> = indices.iter().map(|&i| answer(i)).collect();
        assert_eq!(found.unwrap(), expected);
    }
}
