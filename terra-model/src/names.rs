//! "Did you mean": the nearest known name.

/// The candidate closest to `name`, if any is close enough to be a likely slip of the pen.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let wanted = name.to_lowercase().replace('_', "-");
    candidates
        .into_iter()
        .map(|c| {
            (
                strsim::normalized_damerau_levenshtein(
                    &wanted,
                    &c.to_lowercase().replace('_', "-"),
                ),
                c,
            )
        })
        .filter(|(score, _)| *score >= 0.5)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, c)| c)
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn finds_a_slip_of_the_pen_and_nothing_far() {
        let known = ["slip-sinkage", "grousers", "bulldozing"];
        assert_eq!(nearest("slip_sinkge", known), Some("slip-sinkage"));
        assert_eq!(nearest("xyz", known), None);
    }
}
