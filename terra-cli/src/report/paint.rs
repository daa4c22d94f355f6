//! Colours by meaning: names of the page's style sheet, so that a figure follows light, dark and print.

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

/// Dash of each series \[px\]; the first is solid.
const DASHES: [&str; SERIES] = ["", "7 4", "2 3", "10 3 2 3", "14 4", "5 2 2 2 2 2"];

impl Paint {
    /// Its name in the style sheet; also the class of its sample in a legend.
    pub(super) fn name(self) -> String {
        match self {
            Paint::Ink => "ink".to_owned(),
            Paint::Muted => "muted".to_owned(),
            Paint::Rule => "rule".to_owned(),
            Paint::Hair => "hair".to_owned(),
            Paint::Paper => "paper".to_owned(),
            Paint::Bar => "bar".to_owned(),
            Paint::Before => "before".to_owned(),
            Paint::After => "after".to_owned(),
            Paint::Series(k) => format!("series-{}", k % SERIES),
        }
    }

    /// As the value of an SVG attribute.
    pub(super) fn css(self) -> String {
        format!("var(--{})", self.name())
    }

    /// Dash of its lines \[px\]; empty for a solid one.
    pub(super) fn dash(self) -> &'static str {
        match self {
            Paint::Before => "7 5",
            Paint::Series(k) => DASHES[k % SERIES],
            _ => "",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_style_sheet_name_is_defined_for_light_and_dark() {
        use Paint::{After, Bar, Before, Hair, Ink, Muted, Paper, Rule};
        let css = include_str!("page.css");
        let all = [Ink, Muted, Rule, Hair, Paper, Bar, Before, After]
            .into_iter()
            .chain((0..SERIES).map(Paint::Series));
        for paint in all {
            let name = paint.name();
            assert_eq!(css.matches(&format!("--{name}:")).count(), 2, "{name}");
        }
    }
}
