//! One panel: axes and series in, a picture, its numbers and its legend out.

use serde::Serialize;
use serde_json::json;

use super::block::Key;
use super::data::{Datum, Look, Series, csv};
use super::paint::Paint;
use super::scale::Axis;
use super::svg::{Anchor, Px, Svg, escape};

/// Points from which they are drawn smaller.
const MANY: usize = 60;
/// Thickness of a bar \[px\].
pub(super) const BAR: f64 = 16.0;
/// Pitch of the rows of an exported legend, its first one below the figure, and widths of a sample and a letter \[px\].
const ROW: f64 = 20.0;
const SAMPLE: f64 = 36.0;
const LETTER: f64 = 7.0;

/// Size and margins of a panel \[px\].
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    pub(super) width: f64,
    pub(super) height: f64,
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) top: f64,
    pub(super) bottom: f64,
}

impl Layout {
    /// One of several panels side by side.
    pub(super) const PANEL: Layout = Layout {
        width: 330.0,
        height: 280.0,
        left: 46.0,
        right: 10.0,
        top: 34.0,
        bottom: 44.0,
    };
    /// A panel that has the column to itself: as high, twice as wide, so that its words are the size of the others'.
    pub(super) const ALONE: Layout = Layout {
        width: 660.0,
        ..Self::PANEL
    };

    /// Corners of the inside of the axes.
    fn frame(self) -> (Px, Px) {
        (
            (self.left, self.top),
            (self.width - self.right, self.height - self.bottom),
        )
    }
}

/// What a panel shows and how it is said to those who do not see it.
pub(super) struct Plot {
    pub(super) layout: Layout,
    pub(super) x: Axis,
    pub(super) y: Axis,
    /// Its name: first words of the text alternative, and of its files.
    pub(super) title: String,
    /// What a reader would see.
    pub(super) description: String,
    pub(super) series: Vec<Series>,
}

/// A drawn panel.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Panel {
    /// What its files are called; unique on a page.
    pub(super) file: String,
    pub(super) svg: String,
    /// The numbers it shows.
    pub(super) csv: String,
    #[serde(skip)]
    pub(super) legend: Vec<Key>,
}

/// Where to write what is no series: words and lines of reference, in the px of the panel.
pub(super) struct Canvas<'a> {
    plot: &'a Plot,
    pub(super) svg: Svg,
}

impl Plot {
    /// The panel, with nothing but its series.
    pub(super) fn draw(&self) -> Panel {
        self.draw_with(|_| {})
    }

    /// The panel, with what `decorate` writes over its series.
    pub(super) fn draw_with(&self, decorate: impl FnOnce(&mut Canvas<'_>)) -> Panel {
        let mut canvas = Canvas {
            plot: self,
            svg: Svg::default(),
        };
        canvas.axes();
        canvas.svg.open_clipped(self.layout.frame());
        for series in &self.series {
            canvas.series(series);
        }
        canvas.svg.close_clipped();
        canvas.svg.open("class=\"over\"");
        decorate(&mut canvas);
        canvas.svg.close();
        let legend = self.legend();
        let height = canvas.legend(&legend);
        Panel {
            file: slug(&self.title),
            svg: self.around(&canvas.svg.into_text(), height),
            csv: csv(&self.x, &self.y, &self.series),
            legend,
        }
    }

    fn around(&self, body: &str, export: f64) -> String {
        let l = self.layout;
        let axis = |axis: &Axis| {
            let data = json!({ "name": axis.column(), "sd": axis.sd_column(), "unit": axis.unit, "factor": axis.factor,
                "log": axis.log, "range": axis.range, "ticks": axis.ticks.len(), "title": axis.title });
            escape(&data.to_string())
        };
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" font-family=\"sans-serif\" role=\"img\" aria-label=\"{}. {}\" data-frame=\"{} {} {} {}\" data-x=\"{}\" data-y=\"{}\" data-export=\"{export}\"><title>{}</title><desc>{}</desc>\n{body}</svg>",
            l.width,
            l.height,
            escape(&self.title),
            escape(&self.description),
            l.left,
            l.width - l.right,
            l.top,
            l.height - l.bottom,
            axis(&self.x),
            axis(&self.y),
            escape(&self.title),
            escape(&self.description),
        )
    }

    /// One entry a kind of series that has values and a name.
    fn legend(&self) -> Vec<Key> {
        let mut keys: Vec<Key> = vec![];
        for s in self
            .series
            .iter()
            .filter(|s| s.data.iter().any(Datum::is_finite))
        {
            let key = Key {
                sample: s.look.key(),
                text: s.name.clone(),
            };
            if !s.name.is_empty() && !keys.contains(&key) {
                keys.push(key);
            }
        }
        keys
    }
}

impl Canvas<'_> {
    /// A point of the plot's coordinates, SI, in px.
    pub(super) fn at(&self, x: f64, y: f64) -> Px {
        self.place(self.plot.x.place(x), self.plot.y.place(y))
    }

    /// A point of the axes' own coordinates in px.
    pub(super) fn place(&self, x: f64, y: f64) -> Px {
        let l = self.plot.layout;
        let share = |v: f64, (from, to): (f64, f64)| (v - from) / (to - from);
        (
            l.left + share(x, self.plot.x.range) * (l.width - l.left - l.right),
            l.height - l.bottom - share(y, self.plot.y.range) * (l.height - l.top - l.bottom),
        )
    }

    /// Grid and ticks; the title of the upright axis stands above it, where it reads without turning the head.
    fn axes(&mut self) {
        let (x, y, l) = (&self.plot.x, &self.plot.y, self.plot.layout);
        let ((x0, x1), (y0, y1)) = (x.range, y.range);
        self.svg.open("class=\"axes\"");
        for (at, text) in &y.ticks {
            let from = self.place(x0, *at);
            self.svg
                .line(&[from, self.place(x1, *at)], Paint::Hair, 1.0);
            let label = (from.0 - 7.0, from.1);
            self.svg.text(label, text, Paint::Muted, Anchor::Right);
        }
        for (at, text) in &x.ticks {
            let (px, py) = self.place(*at, y0);
            self.svg.line(&[(px, py), (px, py + 4.0)], Paint::Rule, 1.0);
            self.svg
                .text((px, py + 15.0), text, Paint::Muted, Anchor::Middle);
        }
        self.svg.close();
        self.svg
            .line(&[self.place(x0, y0), self.place(x1, y0)], Paint::Rule, 1.0);
        let (right, bottom) = self.place(x1, y0);
        let top = self.place(x0, y1).1;
        self.svg
            .text((0.0, top - 18.0), &y.title, Paint::Ink, Anchor::Left);
        let below = (right.min(l.width), bottom + 34.0);
        self.svg.text(below, &x.title, Paint::Ink, Anchor::Right);
    }

    fn series(&mut self, s: &Series) {
        self.svg.open(&format!(
            "data-key=\"{}\" data-name=\"{}\"",
            s.look.key(),
            escape(&s.name)
        ));
        match s.look {
            Look::Line(paint) => {
                for stretch in s.data.split(|d| !d.is_finite()) {
                    self.band(stretch, paint);
                    let points: Vec<Px> = stretch.iter().map(|d| self.at(d.x, d.y)).collect();
                    self.svg.line(&points, paint, 2.0);
                }
            }
            Look::Points { hollow } => {
                let radius = if s.data.len() > MANY { 2.6 } else { 4.0 };
                for d in s.data.iter().filter(|d| d.is_finite()) {
                    self.point(d, radius, hollow);
                }
            }
            Look::Dots => {
                for d in s.data.iter().filter(|d| d.is_finite()) {
                    let at = self.at(d.x, d.y);
                    self.svg.dot(at, 2.0, Paint::Ink);
                }
            }
            Look::Bars { from, last } => {
                for (k, d) in s.data.iter().enumerate().filter(|(_, d)| d.is_finite()) {
                    let (start, end) = (self.at(from, d.y), self.at(d.x, d.y));
                    let paint = if k + 1 == s.data.len() {
                        last
                    } else {
                        Paint::Bar
                    };
                    let half = 0.5 * BAR;
                    self.svg
                        .rect((start.0, start.1 - half), (end.0, end.1 + half), paint);
                }
            }
        }
        self.svg.close();
    }

    /// One sd each way around a line, where any of it is known.
    fn band(&mut self, stretch: &[Datum], paint: Paint) {
        if !stretch.iter().any(|d| d.y_sd > 0.0) {
            return;
        }
        let side = |sign: f64| {
            let edge = stretch.iter().map(move |d| {
                let sd = if d.y_sd.is_finite() { d.y_sd } else { 0.0 };
                (d.x, d.y + sign * sd)
            });
            edge.map(|(x, y)| self.at(x, y)).collect::<Vec<Px>>()
        };
        let mut outline = side(1.0);
        outline.extend(side(-1.0).into_iter().rev());
        self.svg.area(&outline, paint);
    }

    /// A measured point with one sd each way where it is known.
    fn point(&mut self, d: &Datum, radius: f64, hollow: bool) {
        let at = self.at(d.x, d.y);
        if d.x_sd.is_finite() {
            let ends = [self.at(d.x - d.x_sd, d.y), self.at(d.x + d.x_sd, d.y)];
            self.svg.line(&ends, Paint::Ink, 1.0);
        }
        if d.y_sd.is_finite() {
            let ends = [self.at(d.x, d.y - d.y_sd), self.at(d.x, d.y + d.y_sd)];
            self.svg.line(&ends, Paint::Ink, 1.0);
        }
        self.svg.dot(at, radius, Paint::Ink);
        if hollow {
            self.svg.dot(at, 0.6 * radius, Paint::Paper);
        }
    }

    /// The legend below the panel, shown only where the panel stands alone, and the height with it.
    fn legend(&mut self, keys: &[Key]) -> f64 {
        let l = self.plot.layout;
        self.svg.open("class=\"alone\" display=\"none\"");
        let (mut x, mut y) = (0.0, l.height + 0.5 * ROW);
        for key in keys {
            let width = SAMPLE + 8.0 + LETTER * key.text.chars().count() as f64 + 16.0;
            if x > 0.0 && x + width > l.width {
                (x, y) = (0.0, y + ROW);
            }
            self.sample(key, x, y);
            let text = (x + SAMPLE + 8.0, y);
            self.svg.text(text, &key.text, Paint::Ink, Anchor::Left);
            x += width;
        }
        self.svg.close();
        if keys.is_empty() {
            l.height
        } else {
            y + 0.75 * ROW
        }
    }

    fn sample(&mut self, key: &Key, x: f64, y: f64) {
        let series = self.plot.series.iter().find(|s| s.look.key() == key.sample);
        let middle = (x + 0.5 * SAMPLE, y);
        let ends = [(x, y), (x + SAMPLE, y)];
        match series.map(|s| s.look) {
            Some(Look::Line(paint)) => self.svg.line(&ends, paint, 2.0),
            Some(Look::Points { hollow }) => {
                self.svg.line(&ends, Paint::Ink, 1.0);
                self.svg.dot(middle, 4.0, Paint::Ink);
                if hollow {
                    self.svg.dot(middle, 2.4, Paint::Paper);
                }
            }
            Some(Look::Dots) => self.svg.dot(middle, 2.0, Paint::Ink),
            Some(Look::Bars { last, .. }) => {
                self.svg.rect((x, y - 5.0), (x + SAMPLE, y + 5.0), last);
            }
            None => {}
        }
    }
}

/// A name for files: lower-case words with dashes.
fn slug(title: &str) -> String {
    let mut out = String::new();
    for c in title.chars() {
        if c.is_ascii_alphanumeric() {
            out.push(c.to_ascii_lowercase());
        } else if !out.is_empty() && !out.ends_with('-') {
            out.push('-');
        }
    }
    out.truncate(60);
    out.trim_end_matches('-').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn file_names_are_plain() {
        assert_eq!(
            slug("Drawbar pull, N (smooth, pass 2)"),
            "drawbar-pull-n-smooth-pass-2"
        );
        assert_eq!(slug("../ä/"), "");
    }

    /// Values of the axis ends stand at the ends of the frame, in SI as in shown units, linear as logarithmic.
    #[test]
    fn values_stand_where_the_axes_say() {
        let plot = Plot {
            layout: Layout::PANEL,
            x: Axis::logarithmic("", 1.0, 100.0),
            y: Axis::linear("sinkage, mm", (0.0, 30.0), 3).named("sinkage_m", "mm", 1e3),
            title: "t".to_owned(),
            description: String::new(),
            series: vec![Series::new(
                "s",
                Look::Dots,
                vec![
                    Datum::at(1.0, 0.0),
                    Datum::at(10.0, 0.015),
                    Datum::at(100.0, 0.03),
                ],
            )],
        };
        let svg = plot.draw().svg;
        let document = roxmltree::Document::parse(&svg).unwrap();
        let number =
            |n: roxmltree::Node<'_, '_>, a| n.attribute(a).unwrap().parse::<f64>().unwrap();
        let dots: Vec<(f64, f64)> = document
            .descendants()
            .filter(|n| n.has_tag_name("circle") && n.attribute("r") == Some("2"))
            .map(|n| (number(n, "cx"), number(n, "cy")))
            .take(3)
            .collect();
        assert_eq!(dots, [(46.0, 236.0), (183.0, 135.0), (320.0, 34.0)]);
    }
}
