//! What a section is made of: sentences, tables, figures. The template knows how each looks.

use serde::Serialize;

use super::ReportError;

/// A part of a report with a heading of its own.
#[derive(Clone, Debug, Serialize)]
pub struct Section {
    pub(super) title: String,
    blocks: Vec<Block>,
    /// The first figure that could not be drawn; the page refuses to render rather than to leave it out.
    #[serde(skip)]
    pub(super) failure: Option<ReportError>,
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
    pub(super) panels: Vec<String>,
    pub(super) legend: Vec<Key>,
    pub(super) caption: String,
}

/// One entry of a legend: the class of the sample line, and what it stands for.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Key {
    pub(super) sample: &'static str,
    pub(super) text: String,
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
            failure: None,
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
    pub(super) fn figure(&mut self, figure: Result<Figure, ReportError>) {
        match figure {
            Ok(figure) => self.blocks.push(Block::Figure { figure }),
            Err(e) => {
                self.failure.get_or_insert(e);
            }
        }
    }
}
