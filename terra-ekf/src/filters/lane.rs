//! As many numbers side by side as one vector of the processor holds: wider ones would not fit its registers.

#[cfg(not(target_feature = "avx"))]
pub(super) use wide::f64x2 as Lane;
#[cfg(all(target_feature = "avx", not(target_feature = "avx512f")))]
pub(super) use wide::f64x4 as Lane;
#[cfg(target_feature = "avx512f")]
pub(super) use wide::f64x8 as Lane;

/// Numbers of a [`Lane`].
pub(super) const WIDTH: usize = size_of::<Lane>() / size_of::<f64>();

/// a·b over three places.
#[inline(always)]
pub(super) fn dot(a: &[Lane; 3], b: &[Lane; 3]) -> Lane {
    a[2].mul_add(b[2], a[1].mul_add(b[1], a[0] * b[0]))
}

/// a·b + c over the places from `FIRST` on.
#[inline(always)]
pub(super) fn add_dot<const FIRST: usize>(a: &[Lane; 3], b: &[Lane; 3], c: Lane) -> Lane {
    let mut sum = a[2].mul_add(b[2], c);
    if FIRST < 2 {
        sum = a[1].mul_add(b[1], sum);
    }
    if FIRST < 1 {
        sum = a[0].mul_add(b[0], sum);
    }
    sum
}

/// One number of a lane; NaN beyond its width.
#[inline]
pub(super) fn at(lane: &Lane, place: usize) -> f64 {
    lane.as_array().get(place).copied().unwrap_or(f64::NAN)
}

/// Sets one number of a lane.
#[inline]
pub(super) fn put(lane: &mut Lane, place: usize, value: f64) {
    if let Some(to) = lane.as_mut_array().get_mut(place) {
        *to = value;
    }
}
