//! Numbers as a person reads them: few digits, a true minus sign, powers of ten written out, never NaN.

/// What is printed for a number that could not be had.
pub(super) const UNKNOWN: &str = "n/a";
const MINUS: char = '\u{2212}';
const SPACE: char = '\u{a0}';

/// `value` to `digits` significant digits.
pub(super) fn number(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return UNKNOWN.to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let power = exponent(value, digits);
    if (-4..6).contains(&power) {
        return fixed(value, decimals(power, digits));
    }
    let lead = value / 10f64.powi(power);
    format!(
        "{}{SPACE}×{SPACE}10{}",
        fixed(lead, digits.saturating_sub(1)),
        superscript(power)
    )
}

/// A value somebody chose, to three digits and without idle zeros: `0.4`, `80`.
pub(super) fn plain(value: f64) -> String {
    let text = number(value, 3);
    if text.contains('.') && !text.contains('×') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// A sentence from elsewhere with the decimals of its numbers cut to four.
pub(super) fn shortened(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut decimals: Option<usize> = None;
    let mut last = ' ';
    for c in text.chars() {
        decimals = match decimals {
            Some(n) if c.is_ascii_digit() => Some(n + 1),
            None if c == '.' && last.is_ascii_digit() => Some(0),
            _ => None,
        };
        if decimals.is_none_or(|n| n <= 4) {
            out.push(c);
        }
        last = c;
    }
    out
}

/// `number` with its sign always shown.
pub(super) fn signed(value: f64, digits: usize) -> String {
    let text = number(value, digits);
    if value > 0.0 {
        format!("+{text}")
    } else {
        text
    }
}

/// Mean and sd, cut where the sd's second digit stands.
pub(super) fn with_sd(mean: f64, sd: f64) -> String {
    if !(mean.is_finite() && sd.is_finite() && sd > 0.0) {
        return number(mean, 3);
    }
    let power = exponent(mean.abs().max(sd), 3);
    if (-4..6).contains(&power) {
        let places = decimals(exponent(sd, 2), 2);
        format!("{} ± {}", fixed(mean, places), fixed(sd, places))
    } else {
        let unit = 10f64.powi(power);
        let places = decimals(exponent(sd / unit, 2), 2);
        format!(
            "({} ± {}){SPACE}×{SPACE}10{}",
            fixed(mean / unit, places),
            fixed(sd / unit, places),
            superscript(power)
        )
    }
}

/// A probability in percent; near 0 and 1 it says so rather than pretend certainty.
pub(super) fn percent(p: f64) -> String {
    match p {
        p if !p.is_finite() => UNKNOWN.to_owned(),
        p if p > 0.0 && p < 0.005 => format!("<{SPACE}1{SPACE}%"),
        p if (0.995..1.0).contains(&p) => format!(">{SPACE}99{SPACE}%"),
        p => format!("{}{SPACE}%", fixed(100.0 * p, 0)),
    }
}

/// A share, which may be negative or above one.
pub(super) fn share(s: f64) -> String {
    if s.is_finite() {
        format!("{}{SPACE}%", fixed(100.0 * s, 0))
    } else {
        UNKNOWN.to_owned()
    }
}

/// `1 thing`, `2 things`.
pub(super) fn count(n: usize, thing: &str) -> String {
    format!("{n} {thing}{}", if n == 1 { "" } else { "s" })
}

/// Power of ten of the leading digit, after rounding to `digits`.
fn exponent(value: f64, digits: usize) -> i32 {
    let power = value.abs().log10().floor() as i32;
    let step = 10f64.powi(power + 1 - digits as i32);
    let rounded = (value.abs() / step).round() * step;
    if rounded >= 10f64.powi(power + 1) * (1.0 - 1e-12) {
        power + 1
    } else {
        power
    }
}

fn decimals(power: i32, digits: usize) -> usize {
    (digits as i32 - 1 - power).max(0) as usize
}

fn fixed(value: f64, places: usize) -> String {
    let text = format!("{value:.places$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().any(|c| ('1'..='9').contains(&c)) => format!("{MINUS}{rest}"),
        Some(rest) => rest.to_owned(),
        None => text,
    }
}

/// A whole number as superscript.
pub(super) fn superscript(power: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    power
        .to_string()
        .chars()
        .map(|c| match c.to_digit(10) {
            Some(d) => DIGITS[d as usize],
            None => '⁻',
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!(number(0.012345, 2), "0.012");
        assert_eq!(number(-6.5, 2), "\u{2212}6.5");
        assert_eq!(number(99.96, 3), "100");
        assert_eq!(number(1.5e6, 2), "1.5\u{a0}×\u{a0}10⁶");
        assert_eq!(number(f64::NAN, 3), "n/a");
        assert_eq!(number(-0.0, 3), "0");
        assert_eq!(signed(0.5, 1), "+0.5");
        assert_eq!(
            (plain(0.4), plain(80.0)),
            ("0.4".to_owned(), "80".to_owned())
        );
        assert_eq!(
            shortened("c1 = 1.0514394323039515, line 12. Next"),
            "c1 = 1.0514, line 12. Next"
        );
    }

    #[test]
    fn spread_decides_the_digits() {
        assert_eq!(with_sd(0.2134, 0.0301), "0.213 ± 0.030");
        assert_eq!(with_sd(1.523e6, 3.1e5), "(1.52 ± 0.31)\u{a0}×\u{a0}10⁶");
        assert_eq!(with_sd(12.0, f64::NAN), "12.0");
    }

    #[test]
    fn probabilities_never_claim_certainty() {
        assert_eq!(percent(0.9999), ">\u{a0}99\u{a0}%");
        assert_eq!(percent(1e-9), "<\u{a0}1\u{a0}%");
        assert_eq!(percent(0.0), "0\u{a0}%");
        assert_eq!(percent(0.554), "55\u{a0}%");
        assert_eq!(share(-0.3), "\u{2212}30\u{a0}%");
    }
}
