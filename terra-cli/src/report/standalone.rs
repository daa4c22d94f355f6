//! A panel as a file of its own: light colours in place of the style sheet's names, its legend below it.

use super::plot::Panel;

/// One figure as files: what `--figures` writes and the page's buttons save.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FigureFiles {
    /// What they are called, before the ending.
    pub name: String,
    /// The picture.
    pub svg: String,
    /// The numbers it shows, with their units in the header.
    pub csv: String,
}

impl FigureFiles {
    pub(super) fn of(panel: &Panel) -> Self {
        FigureFiles {
            name: panel.file.clone(),
            svg: standalone(&panel.svg),
            csv: panel.csv.clone(),
        }
    }
}

/// Names and values of the first, light, palette of the style sheet.
pub(super) fn palette() -> Vec<(&'static str, &'static str)> {
    let css = include_str!("page.css");
    let light = css.split('}').next().unwrap_or_default();
    light
        .split(['{', ';'])
        .filter_map(|rule| rule.trim().split_once(": "))
        .filter_map(|(name, value)| Some((name.trim().strip_prefix("--")?, value.trim())))
        .collect()
}

fn standalone(svg: &str) -> String {
    let Some((head, body)) = svg.split_once('>') else {
        return String::new();
    };
    let attribute = |name: &str| -> Option<&str> {
        let (_, rest) = head.split_once(&format!(" {name}=\""))?;
        Some(rest.split_once('"')?.0)
    };
    let number = |text: Option<&str>| text.and_then(|t| t.parse::<f64>().ok()).unwrap_or(0.0);
    let size = attribute("viewBox").unwrap_or_default();
    // A little room around.
    let width = number(size.split(' ').nth(2)) + 16.0;
    let height = number(attribute("data-export")) + 8.0;
    let mut body = body.replace("class=\"alone\" display=\"none\"", "class=\"alone\"");
    for (name, value) in palette() {
        body = body.replace(&format!("var(--{name})"), value);
    }
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"-8 -4 {width} {height}\" font-family=\"sans-serif\"><rect x=\"-8\" y=\"-4\" width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>{body}"
    )
}

#[cfg(test)]
mod tests {
    use super::super::data::{Datum, Look, Series};
    use super::super::paint::Paint;
    use super::super::plot::{Layout, Plot};
    use super::super::scale::Axis;
    use super::*;

    /// A file has no style sheet: no name of one may be left, and what the page keeps hidden is shown.
    #[test]
    fn a_file_stands_on_its_own() {
        let plot = Plot {
            layout: Layout::PANEL,
            x: Axis::over("slip", [0.0, 1.0], 4).named("slip", "", 1.0),
            y: Axis::over("Pull, N", [0.0, 9.0], 4).named("drawbar_pull_N", "N", 1.0),
            title: "Pull".to_owned(),
            description: "Rises.".to_owned(),
            series: vec![Series::new(
                "the <model>",
                Look::Line(Paint::Series(1)),
                vec![Datum::at(0.0, 1.0), Datum::at(1.0, 9.0)],
            )],
        };
        let files = FigureFiles::of(&plot.draw());
        assert!(!files.svg.contains("var(") && !files.svg.contains("display=\"none\""));
        let document = roxmltree::Document::parse(&files.svg).unwrap();
        assert!(
            document
                .descendants()
                .any(|n| n.has_tag_name("text") && n.text() == Some("the <model>"))
        );
        assert_eq!(files.csv.lines().count(), 3);
    }

    #[test]
    fn the_palette_is_the_light_one() {
        let palette = palette();
        assert!(palette.contains(&("paper", "#ffffff")) && palette.contains(&("ink", "#1c1d1f")));
        assert_eq!(palette.len(), 14);
    }
}
