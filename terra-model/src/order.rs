//! Orders by a number: one sort, compiled once, for whatever is put in order.

/// Puts items in the order of a number, least first. Equals keep their order; NaN goes by [`f64::total_cmp`].
pub fn ascending<T>(items: &mut [T], key: impl FnMut(&T) -> f64) {
    let keys: Vec<f64> = items.iter().map(key).collect();
    permute(items, &order(&keys));
}

/// The same, greatest first.
pub fn descending<T>(items: &mut [T], mut key: impl FnMut(&T) -> f64) {
    ascending(items, |item| -key(item));
}

fn order(keys: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..keys.len()).collect();
    order.sort_by(|&a, &b| keys[a].total_cmp(&keys[b]));
    order
}

/// Puts item `order[k]` at place k.
fn permute<T>(items: &mut [T], order: &[usize]) {
    for place in 0..order.len() {
        let mut from = order[place];
        // What stood there was swapped away when an earlier place was filled.
        while from < place {
            from = order[from];
        }
        items.swap(place, from);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// The standard library's stable sort, both ways, ties and NaN included.
        #[test]
        fn orders_are_those_of_a_stable_sort(keys in prop::collection::vec((-4i8..5).prop_map(f64::from), 0..40), nan in 0usize..40) {
            let mut items: Vec<(f64, usize)> = keys.into_iter().zip(0..).collect();
            if let Some(item) = items.get_mut(nan) {
                item.0 = f64::NAN;
            }
            let places = |items: &[(f64, usize)]| items.iter().map(|i| i.1).collect::<Vec<_>>();
            let (mut up, mut expected) = (items.clone(), items.clone());
            ascending(&mut up, |i| i.0);
            expected.sort_by(|a, b| a.0.total_cmp(&b.0));
            prop_assert_eq!(places(&up), places(&expected));
            let (mut down, mut expected) = (items.clone(), items);
            descending(&mut down, |i| i.0);
            expected.sort_by(|a, b| b.0.total_cmp(&a.0));
            prop_assert_eq!(places(&down), places(&expected));
        }
    }
}
