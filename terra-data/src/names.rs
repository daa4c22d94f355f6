//! Names in messages: the nearest known one, and a bearable length.
//!
//! A damaged file can hold a name of many megabytes or a header of a million names. The edit distance needs memory in
//! proportion to the product of two lengths, so neither may reach it.

/// Longest text that is compared or shown.
const LONGEST: usize = 60;
/// Most candidates that are compared, most names that are listed.
const MOST: usize = 1000;

/// The candidate closest to `name`, if one is close enough to be a slip of the pen.
pub(crate) fn nearest<'a>(
    name: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> Option<String> {
    if name.len() > LONGEST {
        return None;
    }
    let sensible = candidates
        .into_iter()
        .filter(|c| c.len() <= LONGEST)
        .take(MOST);
    terra_model::nearest(name, sensible).map(str::to_owned)
}

/// The beginning of a text.
pub(crate) fn short(text: &str) -> String {
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}...", text.get(..end).unwrap_or_default()),
        None => text.to_owned(),
    }
}

/// The first names of a header.
pub(crate) fn first_names(names: &[String]) -> Vec<String> {
    const SHOWN: usize = 30;
    let mut shown: Vec<String> = names.iter().take(SHOWN).map(|n| short(n)).collect();
    if names.len() > SHOWN {
        shown.push(format!("and {} more", names.len() - SHOWN));
    }
    shown
}
