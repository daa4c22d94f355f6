//! The page: sections in, one HTML text out.

use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{Environment, context};

use super::ReportError;
use super::block::Section;

/// A report, ready to be written to one file.
#[derive(Clone, Debug, Default)]
pub struct Page {
    /// What it is about.
    pub title: String,
    /// Data and simulator in one line; may be empty.
    pub subtitle: String,
    /// Its parts, in order.
    pub sections: Vec<Section>,
    /// Versions, digests, seeds, sources: name and value.
    pub provenance: Vec<(String, String)>,
}

impl Page {
    /// The page as HTML (UTF-8), with nothing outside it: no script, no font, no image, no link that is fetched.
    ///
    /// # Errors
    /// [`ReportError::Figure`] for a figure of a section that could not be drawn, [`ReportError::Template`] never,
    /// unless the built-in template is broken.
    pub fn render(&self) -> Result<String, ReportError> {
        if let Some(failure) = self.sections.iter().find_map(|s| s.failure.clone()) {
            return Err(failure);
        }
        let broken = |e: minijinja::Error| ReportError::Template(format!("{e:#}"));
        let mut env = Environment::new();
        let syntax = SyntaxConfig::builder()
            .trim_blocks(true)
            .lstrip_blocks(true)
            .build()
            .map_err(broken)?;
        env.set_syntax(syntax);
        // The name ends in .html, so every value but the figures and the style sheet is escaped.
        env.add_template("page.html", include_str!("page.html"))
            .map_err(broken)?;
        env.get_template("page.html")
            .and_then(|t| {
                t.render(context! {
                    style => include_str!("page.css"),
                    title => Serde(&self.title),
                    subtitle => Serde(&self.subtitle),
                    sections => Serde(&self.sections),
                    provenance => Serde(&self.provenance),
                })
            })
            .map_err(broken)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Text of a log (names of trials, columns) ends up in a report; it must not become markup.
    #[test]
    fn text_is_escaped() {
        let mut section = Section::new("<b>title</b>");
        section.lead("<script>alert(1)</script> & more");
        let page = Page {
            title: "a < b".to_owned(),
            sections: vec![section],
            provenance: vec![("log".to_owned(), "\"x\"<i>".to_owned())],
            ..Page::default()
        };
        let html = page.render().unwrap();
        assert!(!html.contains("<script") && !html.contains("<b>") && !html.contains("<i>"));
        assert!(html.contains("&lt;script&gt;") && html.contains("a &lt; b"));
    }

    #[test]
    fn a_figure_that_fails_is_not_left_out_in_silence() {
        let failure = ReportError::Figure {
            title: "t".to_owned(),
            reason: "r".to_owned(),
        };
        let mut section = Section::new("s");
        section.figure(Err(failure.clone()));
        let page = Page {
            sections: vec![section],
            ..Page::default()
        };
        assert_eq!(page.render(), Err(failure));
    }
}
