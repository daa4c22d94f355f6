//! Drawing: points of a figure in px to SVG text. Only elements whose coordinates can be moved one by one are used, so
//! that the page's script zooms by moving them.

use std::fmt::Write;

use super::paint::Paint;

/// Size of text \[px\].
const TEXT: u32 = 13;
/// How far marks may stand out of their frame \[px\].
const EDGE: f64 = 5.0;

/// SVG in the making.
#[derive(Default)]
pub(super) struct Svg {
    text: String,
}

/// How text hangs on its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    Left,
    Middle,
    Right,
}

pub(super) type Px = (f64, f64);

impl Svg {
    pub(super) fn into_text(self) -> String {
        self.text
    }

    /// Opens a group; `attributes` are written as they are.
    pub(super) fn open(&mut self, attributes: &str) {
        let _ = write!(
            self.text,
            "<g{}{attributes}>",
            if attributes.is_empty() { "" } else { " " }
        );
    }

    /// Opens the place of the marks, which ends just outside the frame.
    pub(super) fn open_clipped(&mut self, ((left, top), (right, bottom)): (Px, Px)) {
        let [x, y] = [left - EDGE, top - EDGE];
        let [w, h] = [right - left + 2.0 * EDGE, bottom - top + 2.0 * EDGE];
        let _ = writeln!(
            self.text,
            "<svg class=\"marks\" x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" viewBox=\"{x} {y} {w} {h}\">"
        );
    }

    pub(super) fn close_clipped(&mut self) {
        self.text.push_str("</svg>\n");
    }

    pub(super) fn close(&mut self) {
        self.text.push_str("</g>\n");
    }

    /// A line through points, `width` px wide, dashed as its paint is.
    pub(super) fn line(&mut self, points: &[Px], paint: Paint, width: f64) {
        if points.len() < 2 {
            return;
        }
        let dash = match paint.dash() {
            "" => String::new(),
            dash => format!(" stroke-dasharray=\"{dash}\""),
        };
        let _ = write!(
            self.text,
            "<polyline fill=\"none\" stroke=\"{}\"{dash} stroke-width=\"{width}\" points=\"{}\"/>",
            paint.css(),
            path(points)
        );
    }

    /// A translucent area.
    pub(super) fn area(&mut self, outline: &[Px], paint: Paint) {
        if outline.len() < 3 {
            return;
        }
        let _ = write!(
            self.text,
            "<polygon fill=\"{}\" fill-opacity=\"0.18\" points=\"{}\"/>",
            paint.css(),
            path(outline)
        );
    }

    pub(super) fn dot(&mut self, at: Px, radius: f64, paint: Paint) {
        let _ = write!(
            self.text,
            "<circle fill=\"{}\" cx=\"{}\" cy=\"{}\" r=\"{radius}\"/>",
            paint.css(),
            px(at.0),
            px(at.1)
        );
    }

    /// A filled rectangle between two corners.
    pub(super) fn rect(&mut self, from: Px, to: Px, paint: Paint) {
        let _ = write!(
            self.text,
            "<rect fill=\"{}\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>",
            paint.css(),
            px(from.0.min(to.0)),
            px(from.1.min(to.1)),
            px((to.0 - from.0).abs()),
            px((to.1 - from.1).abs())
        );
    }

    /// Text centred in height on its point.
    pub(super) fn text(&mut self, at: Px, text: &str, paint: Paint, anchor: Anchor) {
        let anchor = match anchor {
            Anchor::Left => "start",
            Anchor::Middle => "middle",
            Anchor::Right => "end",
        };
        let _ = write!(
            self.text,
            "<text fill=\"{}\" x=\"{}\" y=\"{}\" dy=\"0.35em\" text-anchor=\"{anchor}\" font-size=\"{TEXT}\">{}</text>",
            paint.css(),
            px(at.0),
            px(at.1),
            escape(text)
        );
    }
}

fn path(points: &[Px]) -> String {
    let mut out = String::new();
    for p in points {
        let gap = if out.is_empty() { "" } else { " " };
        let _ = write!(out, "{gap}{},{}", px(p.0), px(p.1));
    }
    out
}

/// A coordinate to a hundredth of a px.
fn px(v: f64) -> f64 {
    let hundredths = (v * 100.0).round() / 100.0;
    // No sign on zero.
    hundredths + 0.0
}

/// Text as content or attribute of markup.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
