//! A figure of one's own in the hand of the reports: axes and series in, the files of a figure out.

use super::data::{Datum, Look, Series};
use super::paint::Paint;
use super::plot::{Layout, Plot};
use super::scale::Axis;
use super::standalone::FigureFiles;

/// One axis.
#[derive(Clone, Debug, PartialEq)]
pub struct GraphAxis {
    /// Quantity and shown unit (`drawbar pull, N`).
    pub title: String,
    /// Its column in the figure's table, in SI (`drawbar_pull_N`).
    pub column: String,
    /// Unit shown.
    pub unit: String,
    /// Shown value of one SI unit.
    pub factor: f64,
    /// First and last value, in the unit shown; `None` for a little more than all values.
    pub range: Option<(f64, f64)>,
}

impl GraphAxis {
    /// An axis in SI units over all values.
    pub fn new(title: &str, column: &str, unit: &str) -> Self {
        GraphAxis {
            title: title.to_owned(),
            column: column.to_owned(),
            unit: unit.to_owned(),
            factor: 1.0,
            range: None,
        }
    }

    /// Shown in another unit, `factor` of them an SI unit.
    #[must_use]
    pub fn shown_in(mut self, unit: &str, factor: f64) -> Self {
        (self.unit, self.factor) = (unit.to_owned(), factor);
        self
    }

    /// From `low` to `high`, in the unit shown.
    #[must_use]
    pub fn between(mut self, low: f64, high: f64) -> Self {
        self.range = Some((low, high));
        self
    }

    fn axis(&self, values: impl Iterator<Item = f64>) -> Axis {
        let axis = match self.range {
            Some(range) => Axis::linear(self.title.as_str(), range, 5),
            None => Axis::over(self.title.as_str(), values.map(|v| v * self.factor), 5),
        };
        axis.named(&self.column, &self.unit, self.factor)
    }
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GraphLook {
    /// A line in one of six colours, each with a dash of its own; values with an sd get a band of one sd each way.
    Line(usize),
    /// Small points.
    Dots,
}

/// Values that belong together, in SI units. Series of one name and look share an entry of the legend.
#[derive(Clone, Debug, PartialEq)]
pub struct GraphSeries {
    /// What the legend says.
    pub name: String,
    /// How it is drawn.
    pub look: GraphLook,
    /// x, y and the sd of y; an sd that is not finite is none, a y that is not finite breaks a line.
    pub points: Vec<[f64; 3]>,
}

/// One figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Graph {
    /// Its name: first words of the text alternative, and of its files.
    pub title: String,
    /// What a reader would see.
    pub description: String,
    /// The level axis.
    pub x: GraphAxis,
    /// The upright axis.
    pub y: GraphAxis,
    /// What it shows, first below.
    pub series: Vec<GraphSeries>,
}

impl Graph {
    /// The picture with its legend, and the numbers it shows.
    pub fn files(&self) -> FigureFiles {
        let series: Vec<Series> = self.series.iter().map(GraphSeries::series).collect();
        let extent = || series.iter().flat_map(Series::extent);
        let plot = Plot {
            layout: Layout::ALONE,
            x: self.x.axis(extent().map(|p| p.0)),
            y: self.y.axis(extent().map(|p| p.1)),
            title: self.title.clone(),
            description: self.description.clone(),
            series,
        };
        FigureFiles::of(&plot.draw())
    }
}

impl GraphSeries {
    /// A line.
    pub fn line(name: &str, colour: usize, points: Vec<[f64; 3]>) -> Self {
        GraphSeries {
            name: name.to_owned(),
            look: GraphLook::Line(colour),
            points,
        }
    }

    /// Small points.
    pub fn dots(name: &str, points: Vec<[f64; 3]>) -> Self {
        GraphSeries {
            name: name.to_owned(),
            look: GraphLook::Dots,
            points,
        }
    }

    fn series(&self) -> Series {
        let look = match self.look {
            GraphLook::Line(colour) => Look::Line(Paint::Series(colour)),
            GraphLook::Dots => Look::Dots,
        };
        let datum = |p: &[f64; 3]| Datum::at(p[0], p[1]).sd(f64::NAN, p[2]);
        Series::new(
            self.name.as_str(),
            look,
            self.points.iter().map(datum).collect(),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Shown in kPa, written in Pa; two lines of one name are one entry of the legend; the axis holds every band.
    #[test]
    fn a_graph_is_a_figure_of_the_reports() {
        let line = |y: f64| GraphSeries::line("winner", 1, vec![[0.0, y, 1e3], [1.0, y, 1e3]]);
        let graph = Graph {
            title: "Normal stress, sand".to_owned(),
            description: "Flat.".to_owned(),
            x: GraphAxis::new("slip", "slip", "").between(0.0, 1.0),
            y: GraphAxis::new("normal stress, kPa", "normal_stress_Pa", "kPa")
                .shown_in("kPa", 1e-3),
            series: vec![line(2e3), line(9e3)],
        };
        let files = graph.files();
        assert_eq!(files.name, "normal-stress-sand");
        assert_eq!(files.svg.matches(">winner</text>").count(), 1);
        assert!(files.svg.contains(">10</text>"), "the band ends at 10 kPa");
        assert_eq!(
            files.csv.lines().nth(1),
            Some("winner,0,2000,1000"),
            "{}",
            files.csv
        );
    }
}
