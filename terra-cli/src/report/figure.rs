//! Drawing: data coordinates in, SVG text out, colours by name, a text alternative on every figure.

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::ReportError;
use super::paint::{Paint, resolve};
use super::scale::Axis;

/// User units of the SVG per px: the drawing library rounds to whole units, and a quarter of a px is smooth.
const UNIT: i32 = 4;
/// Size of text \[px\].
const TEXT: f64 = 13.0;
/// What the drawing library divides font sizes by.
const FONT_FACTOR: f64 = 1.24;

/// Size and margins of a figure \[px\].
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    pub(super) width: i32,
    pub(super) height: i32,
    pub(super) left: i32,
    pub(super) right: i32,
    pub(super) top: i32,
    pub(super) bottom: i32,
}

impl Layout {
    /// One of several panels side by side.
    pub(super) const PANEL: Layout = Layout {
        width: 330,
        height: 280,
        left: 46,
        right: 10,
        top: 34,
        bottom: 44,
    };
    /// A panel that has the column to itself: as high, twice as wide, so that its words are the size of the others'.
    pub(super) const ALONE: Layout = Layout {
        width: 660,
        ..Self::PANEL
    };
}

/// What a figure shows and how it is said to those who do not see it.
pub(super) struct Plot {
    pub(super) layout: Layout,
    pub(super) x: Axis,
    pub(super) y: Axis,
    /// Its name, for errors and as first words of the text alternative.
    pub(super) title: String,
    /// What a reader would see.
    pub(super) description: String,
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;
pub(super) type Drawn = Result<(), String>;

/// The inside of a figure, in data coordinates.
pub(super) struct Canvas<'a> {
    area: Area<'a>,
}

/// How text hangs on its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    Left,
    Middle,
    Right,
}

impl Plot {
    /// Draws axes, then what `draw` adds, and returns the SVG.
    pub(super) fn draw(
        &self,
        draw: impl FnOnce(&Canvas<'_>) -> Drawn,
    ) -> Result<String, ReportError> {
        let mut svg = String::new();
        self.draw_into(&mut svg, draw)
            .map_err(|reason| ReportError::Figure {
                title: self.title.clone(),
                reason,
            })?;
        let svg = resolve(&svg, UNIT);
        Ok(self.with_alternative(&svg))
    }

    fn draw_into(&self, svg: &mut String, draw: impl FnOnce(&Canvas<'_>) -> Drawn) -> Drawn {
        let l = self.layout;
        let size = ((l.width * UNIT) as u32, (l.height * UNIT) as u32);
        let root: DrawingArea<SVGBackend<'_>, Shift> =
            SVGBackend::with_string(svg, size).into_drawing_area();
        let pixels = (
            l.left * UNIT..(l.width - l.right) * UNIT,
            // Values grow upwards, pixels downwards.
            (l.height - l.bottom) * UNIT..l.top * UNIT,
        );
        let coordinates = Cartesian2d::<RangedCoordf64, RangedCoordf64>::new(
            self.x.range.0..self.x.range.1,
            self.y.range.0..self.y.range.1,
            pixels,
        );
        let canvas = Canvas {
            area: root.apply_coord_spec(coordinates),
        };
        self.axes(&canvas)?;
        draw(&canvas)?;
        canvas.area.present().map_err(|e| e.to_string())
    }

    /// Grid and ticks; the title of the upright axis stands above it, where it reads without turning the head.
    fn axes(&self, canvas: &Canvas<'_>) -> Drawn {
        let ((x0, x1), (y0, y1)) = (self.x.range, self.y.range);
        for (at, text) in &self.y.ticks {
            canvas.line(&[(x0, *at), (x1, *at)], Paint::Hair, 1)?;
            canvas.text((x0, *at), (-7, 0), text, Paint::Muted, Anchor::Right)?;
        }
        for (at, text) in &self.x.ticks {
            canvas.stroke_px((*at, y0), (0, 0), (0, 4), Paint::Rule)?;
            canvas.text((*at, y0), (0, 15), text, Paint::Muted, Anchor::Middle)?;
        }
        canvas.line(&[(x0, y0), (x1, y0)], Paint::Rule, 1)?;
        canvas.text(
            (x0, y1),
            (-self.layout.left, -18),
            &self.y.title,
            Paint::Ink,
            Anchor::Left,
        )?;
        canvas.text((x1, y0), (0, 34), &self.x.title, Paint::Ink, Anchor::Right)
    }

    /// Replaces the fixed size by the column's width, and adds the text alternative.
    fn with_alternative(&self, svg: &str) -> String {
        let l = self.layout;
        let body = svg.split_once('>').map_or("", |(_, body)| body);
        let alternative = escape(&format!("{}. {}", self.title, self.description));
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{alternative}\"><title>{}</title>{body}",
            l.width * UNIT,
            l.height * UNIT,
            escape(&self.title),
        )
    }
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

fn stroke(paint: Paint, px: u32) -> ShapeStyle {
    ShapeStyle {
        color: paint.sentinel().to_rgba(),
        filled: false,
        stroke_width: px * UNIT as u32,
    }
}

fn finite(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    points
        .iter()
        .copied()
        .filter(|p| p.0.is_finite() && p.1.is_finite())
        .collect()
}

impl Canvas<'_> {
    /// A line through the finite points, px wide.
    pub(super) fn line(&self, points: &[(f64, f64)], paint: Paint, px: u32) -> Drawn {
        let points = finite(points);
        if points.len() < 2 {
            return Ok(());
        }
        let line = PathElement::new(points, stroke(paint, px));
        self.area.draw(&line).map_err(|e| e.to_string())
    }

    /// A line between two offsets \[px\] from a point.
    pub(super) fn stroke_px(
        &self,
        at: (f64, f64),
        from: (i32, i32),
        to: (i32, i32),
        paint: Paint,
    ) -> Drawn {
        let path = vec![scaled(from), scaled(to)];
        let line = EmptyElement::at(at) + PathElement::new(path, stroke(paint, 1));
        self.area.draw(&line).map_err(|e| e.to_string())
    }

    /// Text at an offset \[px\] from a point.
    pub(super) fn text(
        &self,
        at: (f64, f64),
        offset: (i32, i32),
        text: &str,
        paint: Paint,
        anchor: Anchor,
    ) -> Drawn {
        let h = match anchor {
            Anchor::Left => HPos::Left,
            Anchor::Middle => HPos::Center,
            Anchor::Right => HPos::Right,
        };
        let size = TEXT * FONT_FACTOR * f64::from(UNIT);
        let colour = paint.sentinel();
        let style = TextStyle::from(("sans-serif", size).into_font())
            .color(&colour)
            .pos(Pos::new(h, VPos::Center));
        let element = EmptyElement::at(at) + Text::new(text.to_owned(), scaled(offset), style);
        self.area.draw(&element).map_err(|e| e.to_string())
    }

    /// A measured point, filled or hollow, with one sd each way where it is known.
    pub(super) fn point(&self, at: (f64, f64), sd: (f64, f64), hollow: bool) -> Drawn {
        if !(at.0.is_finite() && at.1.is_finite()) {
            return Ok(());
        }
        let ((x, y), (dx, dy)) = (at, sd);
        if dx.is_finite() {
            self.line(&[(x - dx, y), (x + dx, y)], Paint::Ink, 1)?;
        }
        if dy.is_finite() {
            self.line(&[(x, y - dy), (x, y + dy)], Paint::Ink, 1)?;
        }
        self.dot(at, 4, Paint::Ink)?;
        if hollow {
            self.dot(at, 2, Paint::Paper)?;
        }
        Ok(())
    }

    /// A filled circle of radius `px`.
    pub(super) fn dot(&self, at: (f64, f64), px: i32, paint: Paint) -> Drawn {
        let dot = Circle::new(at, px * UNIT, paint.sentinel().filled());
        self.area.draw(&dot).map_err(|e| e.to_string())
    }

    /// A translucent band between two lines of equal length.
    pub(super) fn band(&self, low: &[(f64, f64)], high: &[(f64, f64)], paint: Paint) -> Drawn {
        let mut outline = finite(high);
        outline.extend(finite(low).into_iter().rev());
        if outline.len() < 4 {
            return Ok(());
        }
        let band = Polygon::new(outline, paint.sentinel().mix(0.18));
        self.area.draw(&band).map_err(|e| e.to_string())
    }

    /// A bar from `from` to `to` along x, `px` thick around `y`.
    pub(super) fn bar(&self, y: f64, from: f64, to: f64, px: i32, paint: Paint) -> Drawn {
        let half = px * UNIT / 2;
        let (a, b) = (
            self.area.map_coordinate(&(from.min(to), y)),
            self.area.map_coordinate(&(from.max(to), y)),
        );
        let corner = (b.0 - a.0, half);
        let bar = EmptyElement::at((from.min(to), y))
            + Rectangle::new([(0, -half), corner], paint.sentinel().filled());
        self.area.draw(&bar).map_err(|e| e.to_string())
    }

    /// Where a value of y stands \[px from the top\].
    pub(super) fn height_of(&self, y: f64) -> i32 {
        self.area
            .map_coordinate(&(self.area.get_x_range().start, y))
            .1
            / UNIT
    }
}

fn scaled(offset: (i32, i32)) -> (i32, i32) {
    (offset.0 * UNIT, offset.1 * UNIT)
}
