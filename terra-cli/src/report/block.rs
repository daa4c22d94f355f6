//! What a section is made of: sentences, tables, figures. The template knows how each looks.

use serde::Serialize;

use super::plot::Panel;

/// A part of a report with a heading of its own.
#[derive(Clone, Debug, Serialize)]
pub struct Section {
    pub(super) title: String,
    blocks: Vec<Block>,
}

#[derive(Clone, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum Block {
    /// The sentence that the section is for.
    Lead {
        text: String,
    },
    Text {
        text: String,
    },
    Heading {
        text: String,
    },
    List {
        items: Vec<Item>,
    },
    /// Name and answer, one a line.
    Facts {
        rows: Vec<(String, Vec<String>)>,
    },
    Table {
        table: Table,
    },
    Figure {
        figure: Figure,
    },
}

/// One item of a list: a name, if it has one, and what is said of it.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Item {
    pub(super) name: String,
    pub(super) text: String,
}

/// A table; short rows are an error of its author, not of the data.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Table {
    pub(super) caption: String,
    pub(super) head: Vec<Column>,
    pub(super) rows: Vec<Vec<Cell>>,
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct Column {
    title: String,
    numeric: bool,
}

/// What stands in a cell, and a small second line.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Cell {
    lines: Vec<String>,
    note: String,
}

/// Panels side by side, where there is room, under one caption.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Figure {
    pub(super) panels: Vec<Panel>,
    legend: Vec<Key>,
    caption: String,
}

/// One entry of a legend: the class of the sample line, and what it stands for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Key {
    pub(super) sample: String,
    pub(super) text: String,
}

impl Figure {
    /// With a legend of all that its panels show.
    pub(super) fn new(panels: Vec<Panel>, caption: impl Into<String>) -> Self {
        let mut legend: Vec<Key> = vec![];
        for key in panels.iter().flat_map(|p| &p.legend) {
            if !legend.contains(key) {
                legend.push(key.clone());
            }
        }
        Figure {
            legend,
            ..Figure::labelled(panels, caption)
        }
    }

    /// Without a legend: its series are named where they stand, or need no name.
    pub(super) fn labelled(panels: Vec<Panel>, caption: impl Into<String>) -> Self {
        Figure {
            panels,
            legend: vec![],
            caption: caption.into(),
        }
    }
}

impl Table {
    /// Columns from titles; a title that starts with `#` heads numbers.
    pub(super) fn new(caption: &str, titles: &[&str]) -> Self {
        let column = |t: &&str| Column {
            title: t.trim_start_matches('#').to_owned(),
            numeric: t.starts_with('#'),
        };
        Table {
            caption: caption.to_owned(),
            head: titles.iter().map(column).collect(),
            rows: vec![],
        }
    }
}

impl<S: Into<String>> From<S> for Cell {
    fn from(text: S) -> Self {
        Cell {
            lines: vec![text.into()],
            note: String::new(),
        }
    }
}

impl Cell {
    pub(super) fn lines(lines: Vec<String>) -> Self {
        Cell {
            lines,
            note: String::new(),
        }
    }
    pub(super) fn with_note(mut self, note: impl Into<String>) -> Self {
        self.note = note.into();
        self
    }
}

impl Section {
    pub(super) fn new(title: impl Into<String>) -> Self {
        Section {
            title: title.into(),
            blocks: vec![],
        }
    }
    pub(super) fn lead(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Lead { text: text.into() });
    }
    pub(super) fn text(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Text { text: text.into() });
    }
    pub(super) fn heading(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Heading { text: text.into() });
    }
    pub(super) fn list(&mut self, items: Vec<Item>) {
        self.blocks.push(Block::List { items });
    }
    pub(super) fn facts(&mut self, rows: Vec<(String, Vec<String>)>) {
        self.blocks.push(Block::Facts { rows });
    }
    pub(super) fn table(&mut self, table: Table) {
        self.blocks.push(Block::Table { table });
    }
    /// A figure without panels is left out.
    pub(super) fn figure(&mut self, figure: Figure) {
        if !figure.panels.is_empty() {
            self.blocks.push(Block::Figure { figure });
        }
    }
    /// All panels, in order.
    pub(super) fn panels_mut(&mut self) -> impl Iterator<Item = &mut Panel> {
        self.blocks.iter_mut().flat_map(|b| match b {
            Block::Figure { figure } => figure.panels.as_mut_slice(),
            _ => &mut [],
        })
    }
}
