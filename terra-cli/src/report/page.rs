//! The page: sections in, one HTML text out.

use std::collections::BTreeSet;

use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{Environment, context};

use sha2::{Digest, Sha256};

use super::ReportError;
use super::block::Section;
use super::standalone::FigureFiles;

const SCRIPT: &str = include_str!("page.js");

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
    /// The page as HTML (UTF-8), with nothing outside it: no font, no image, no link that is fetched. Its one script is
    /// its own, and the only one its content policy lets run.
    ///
    /// # Errors
    /// [`ReportError::Template`] never, unless the built-in template is broken.
    pub fn render(&self) -> Result<String, ReportError> {
        let sections = self.named();
        let broken = |e: minijinja::Error| ReportError::Template(format!("{e:#}"));
        let mut env = Environment::new();
        let syntax = SyntaxConfig::builder()
            .trim_blocks(true)
            .lstrip_blocks(true)
            .build()
            .map_err(broken)?;
        env.set_syntax(syntax);
        // The name ends in .html, so every value but figures, style sheet and script is escaped.
        env.add_template("page.html", include_str!("page.html"))
            .map_err(broken)?;
        env.get_template("page.html")
            .and_then(|t| {
                t.render(context! {
                    style => include_str!("page.css"),
                    script => SCRIPT,
                    script_hash => base64(&Sha256::digest(SCRIPT.as_bytes())),
                    title => Serde(&self.title),
                    subtitle => Serde(&self.subtitle),
                    sections => Serde(&sections),
                    provenance => Serde(&self.provenance),
                })
            })
            .map_err(broken)
    }

    /// Each figure of the page as files of their own.
    pub fn figures(&self) -> Vec<FigureFiles> {
        let mut sections = self.named();
        let panels = sections.iter_mut().flat_map(Section::panels_mut);
        panels.map(|p| FigureFiles::of(p)).collect()
    }

    /// The sections, the files of their figures under names of their own.
    fn named(&self) -> Vec<Section> {
        let mut sections = self.sections.clone();
        let mut taken = BTreeSet::new();
        for panel in sections.iter_mut().flat_map(Section::panels_mut) {
            let stem = match panel.file.as_str() {
                "" => "figure".to_owned(),
                stem => stem.to_owned(),
            };
            let mut name = stem.clone();
            for k in 2.. {
                if taken.insert(name.clone()) {
                    break;
                }
                name = format!("{stem}-{k}");
            }
            panel.file = name;
        }
        sections
    }
}

/// Bytes as the content policy wants a digest.
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::new();
    for chunk in bytes.chunks(3) {
        let three = [0, 1, 2].map(|k| u32::from(chunk.get(k).copied().unwrap_or(0)));
        let bits = three[0] << 16 | three[1] << 8 | three[2];
        for k in 0..4 {
            let six = (bits >> (18 - 6 * k) & 63) as usize;
            out.push(if k <= chunk.len() {
                char::from(LETTERS[six])
            } else {
                '='
            });
        }
    }
    out
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
        assert_eq!(html.matches("<script").count(), 1);
        assert!(!html.contains("<b>") && !html.contains("<i>"));
        assert!(html.contains("&lt;script&gt;") && html.contains("a &lt; b"));
    }

    /// RFC 4648, section 10.
    #[test]
    fn base64_is_that_of_the_standard() {
        for (plain, coded) in [
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
    }
}
