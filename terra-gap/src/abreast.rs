//! Observations side by side: eight are predicted in the lanes of one evaluation, at half of what eight alone cost or less.
//!
//! Where one of them has no answer each is asked alone, and says so itself.

use terra_model::{Lanes, Vector};

use crate::error::GapError;
use crate::parallel::for_each;

/// Observations from which a group is cheaper than one plain number after the other.
pub(crate) const WORTH: usize = 3;

/// Answers of observations, in their order: up to eight of one `kind` at once by `together`, from `worth` on.
///
/// # Errors
/// Of `alone`.
pub(crate) fn in_groups<K: PartialEq, A: Clone + Default + Send + Sync>(
    indices: &[usize],
    kind: impl Fn(usize) -> K,
    worth: usize,
    together: impl Fn(&[usize]) -> Result<Vec<A>, GapError> + Sync,
    alone: impl Fn(usize) -> Result<A, GapError> + Sync,
) -> Result<Vec<A>, GapError> {
    // The latest group of a kind is the one that may have room.
    let mut kinds: Vec<(K, usize)> = vec![];
    let mut groups: Vec<Vec<usize>> = vec![];
    for (place, &index) in indices.iter().enumerate() {
        let kind = kind(index);
        let known = kinds.iter_mut().find(|(k, _)| *k == kind);
        match known {
            Some((_, group)) if groups[*group].len() < Lanes::WIDTH => groups[*group].push(place),
            Some((_, group)) => {
                *group = groups.len();
                groups.push(vec![place]);
            }
            None => {
                kinds.push((kind, groups.len()));
                groups.push(vec![place]);
            }
        }
    }
    let found: Vec<Vec<A>> = for_each(groups.len(), |k| {
        let places = &groups[k];
        let members: Vec<usize> = places.iter().map(|&place| indices[place]).collect();
        if members.len() >= worth
            && let Ok(found) = together(&members)
        {
            return Ok(found);
        }
        members.iter().map(|&i| alone(i)).collect()
    })
    .into_iter()
    .collect::<Result<_, GapError>>()?;
    let mut out = vec![A::default(); indices.len()];
    for (places, found) in groups.iter().zip(found) {
        for (&place, answer) in places.iter().zip(found) {
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
