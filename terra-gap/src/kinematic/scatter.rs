//! How far two windows with the same wheel speeds differ: the floor under every kinematic prediction.
//!
//! Ground varies from place to place, and wheel speeds do not tell. Pairs of windows at nearly the same wheel speeds, from
//! different manoeuvres, show that scatter (and the sensors') without any model: σ² = Σ (y_a - y_b)²/(2 n), what a test for
//! lack of fit calls pure error by near neighbours.
//!
//! # Reference
//! C. Daniel, F. S. Wood, Fitting Equations to Data, 2nd ed., 1980, section 7.

/// One window as a place in the plane of side speeds.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    /// Rim speeds left and right \[m/s\].
    pub(crate) sides: [f64; 2],
    /// Nose up \[rad\].
    pub(crate) pitch: f64,
    /// Number of its segment.
    pub(crate) group: usize,
    /// Number of its ground.
    pub(crate) ground: usize,
}

/// Pairs farther apart than this share of the typical side speed do not count as repeats.
const NEAR: f64 = 0.1;
/// Nor on slopes that differ by more than this \[rad\].
const LEVEL: f64 = 0.02;
/// Fewest pairs to estimate a scatter from.
const FEWEST: usize = 8;
/// Windows beyond which only every n-th is paired: pairing is quadratic.
const MOST: usize = 1000;
/// Windows of one segment this far apart count as repeats too; those nearer by only where a log has too few others, as ground is alike
/// where it lies close together.
pub(crate) const APART: usize = 5;
pub(crate) const NEXT: usize = 1;

/// Disjoint pairs of repeats, nearest first, those of one segment so many windows `apart`.
pub(crate) fn pairs(places: &[Place], apart: usize) -> Vec<(usize, usize)> {
    let typical = (places
        .iter()
        .map(|p| p.sides[0].powi(2) + p.sides[1].powi(2))
        .sum::<f64>()
        / (2 * places.len().max(1)) as f64)
        .sqrt();
    let chosen: Vec<usize> = (0..places.len())
        .step_by(places.len().div_ceil(MOST).max(1))
        .collect();
    let mut near: Vec<(f64, usize, usize)> = vec![];
    for (k, &i) in chosen.iter().enumerate() {
        for &j in &chosen[k + 1..] {
            let (a, b) = (&places[i], &places[j]);
            if (a.group == b.group && j - i < apart)
                || a.ground != b.ground
                || (a.pitch - b.pitch).abs() > LEVEL
            {
                continue;
            }
            let d = (a.sides[0] - b.sides[0]).hypot(a.sides[1] - b.sides[1]);
            if d <= NEAR * typical {
                near.push((d, i, j));
            }
        }
    }
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut used = vec![false; places.len()];
    near.retain(|&(_, i, j)| {
        let free = !used[i] && !used[j];
        if free {
            used[i] = true;
            used[j] = true;
        }
        free
    });
    near.into_iter().map(|(_, i, j)| (i, j)).collect()
}

/// 1-sigma of one value between repeats; none from too few pairs that have it.
pub(crate) fn scatter(
    pairs: &[(usize, usize)],
    value: impl Fn(usize) -> Option<f64>,
) -> Option<(f64, usize)> {
    let squares: Vec<f64> = pairs
        .iter()
        .filter_map(|&(i, j)| Some((value(i)? - value(j)?).powi(2) / 2.0))
        .collect();
    let n = squares.len();
    (n >= FEWEST).then(|| ((squares.iter().sum::<f64>() / n as f64).sqrt(), n))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten places visited twice, by different segments; values differ by ±2 d between the visits, so σ = sqrt 2 d exactly.
    #[test]
    fn repeats_are_found_and_their_scatter_is_exact() {
        let places: Vec<Place> = (0..20)
            .map(|i| Place {
                sides: [(i % 10) as f64, 0.5 * (i % 10) as f64],
                pitch: 0.0,
                group: i / 10,
                ground: 0,
            })
            .collect();
        let found = pairs(&places, APART);
        assert_eq!(found.len(), 10);
        assert!(found.iter().all(|(i, j)| j - i == 10));
        let d = 0.3;
        let (sd, n) = scatter(&found, |i| Some(if i < 10 { d } else { -d })).unwrap();
        assert_eq!(n, 10);
        assert!((sd - 2f64.sqrt() * d).abs() < 1e-12);
        assert!(scatter(&found[..7], |_| Some(0.0)).is_none());
    }

    #[test]
    fn neighbours_in_time_are_no_repeats() {
        let same = |group| Place {
            sides: [1.0, 1.0],
            pitch: 0.0,
            group,
            ground: 0,
        };
        assert!(pairs(&[same(0), same(0), same(0)], APART).is_empty());
        assert_eq!(pairs(&[same(0), same(0), same(1)], APART).len(), 1);
        assert_eq!(pairs(&[same(0), same(0), same(0)], NEXT).len(), 1);
    }
}
