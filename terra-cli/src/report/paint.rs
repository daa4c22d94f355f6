//! Colours by meaning. The drawing library writes fixed colours, so each paint is drawn in a colour that occurs nowhere
//! else, and its name of the page's style sheet is put in its place afterwards.

use plotters::style::RGBColor;

/// What a mark stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Paint {
    /// Text and measured points.
    Ink,
    /// Tick labels and remarks.
    Muted,
    /// Axes.
    Rule,
    /// Grid lines.
    Hair,
    /// The page behind.
    Paper,
    /// Bars.
    Bar,
    /// The model before anything was added: dashed.
    Before,
    /// The model with what was added: solid.
    After,
    /// One of the [`SERIES`] series of a plot, each with its own dash.
    Series(usize),
}

/// Number of series that can be told apart.
pub(super) const SERIES: usize = 6;

/// Dash of each series in px; the first is solid.
const DASHES: [&[i32]; SERIES] = [
    &[],
    &[7, 4],
    &[2, 3],
    &[10, 3, 2, 3],
    &[14, 4],
    &[5, 2, 2, 2, 2, 2],
];

impl Paint {
    fn all() -> impl Iterator<Item = Paint> {
        use Paint::{After, Bar, Before, Hair, Ink, Muted, Paper, Rule};
        [Ink, Muted, Rule, Hair, Paper, Bar, Before, After]
            .into_iter()
            .chain((0..SERIES).map(Paint::Series))
    }

    fn number(self) -> u8 {
        match self {
            Paint::Ink => 0,
            Paint::Muted => 1,
            Paint::Rule => 2,
            Paint::Hair => 3,
            Paint::Paper => 4,
            Paint::Bar => 5,
            Paint::Before => 6,
            Paint::After => 7,
            Paint::Series(k) => 8 + (k % SERIES) as u8,
        }
    }

    /// The colour it is drawn in.
    pub(super) fn sentinel(self) -> RGBColor {
        RGBColor(1, 2, self.number())
    }

    fn variable(self) -> String {
        match self {
            Paint::Ink => "var(--ink)".to_owned(),
            Paint::Muted => "var(--muted)".to_owned(),
            Paint::Rule => "var(--rule)".to_owned(),
            Paint::Hair => "var(--hair)".to_owned(),
            Paint::Paper => "var(--paper)".to_owned(),
            Paint::Bar => "var(--bar)".to_owned(),
            Paint::Before => "var(--before)".to_owned(),
            Paint::After => "var(--after)".to_owned(),
            Paint::Series(k) => format!("var(--series-{})", k % SERIES),
        }
    }

    fn dash(self) -> &'static [i32] {
        match self {
            Paint::Before => &[7, 5],
            Paint::Series(k) => DASHES[k % SERIES],
            _ => &[],
        }
    }
}

/// Puts the style sheet's names where the sentinels stand, and the dashes beside them; `unit` is the px in user units.
pub(super) fn resolve(svg: &str, unit: i32) -> String {
    let mut out = svg.to_owned();
    for paint in Paint::all() {
        let RGBColor(r, g, b) = paint.sentinel();
        let name = paint.variable();
        let dash: Vec<String> = paint
            .dash()
            .iter()
            .map(|d| (d * unit).to_string())
            .collect();
        let dash = if dash.is_empty() {
            String::new()
        } else {
            format!(" stroke-dasharray=\"{}\"", dash.join(" "))
        };
        out = out
            .replace(
                &format!("stroke=\"#{r:02X}{g:02X}{b:02X}\""),
                &format!("stroke=\"{name}\"{dash}"),
            )
            .replace(
                &format!("fill=\"#{r:02X}{g:02X}{b:02X}\""),
                &format!("fill=\"{name}\""),
            );
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_paint_has_its_own_sentinel() {
        let mut seen: Vec<u8> = Paint::all().map(Paint::number).collect();
        let n = seen.len();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), n);
    }

    #[test]
    fn every_style_sheet_name_is_defined_for_light_and_dark() {
        let css = include_str!("page.css");
        for paint in Paint::all() {
            let name = paint.variable();
            let name = name.trim_start_matches("var(").trim_end_matches(')');
            assert_eq!(css.matches(&format!("{name}:")).count(), 2, "{name}");
        }
    }
}
