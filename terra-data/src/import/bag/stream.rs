//! The bag from front to back: the samples of mapped fields, nothing else is kept.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;

use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::cdr::{self, Value};
use super::definition::Definition;
use super::map::{Clock, Map};
use super::{seconds, unknown};
use crate::error::{DataError, Origin};
use crate::problem::Problem;
use crate::source::unreadable;

/// Largest record in bytes: a length in a damaged file must not become an allocation.
const LARGEST: u64 = 1 << 30;
/// Largest record of a small bag: so many bytes, and so many times the file, because a record may be compressed.
const LEAST: u64 = 64 << 20;
const INFLATION: u64 = 64;

/// Most bytes read at once.
const PIECE: usize = 1 << 20;

/// Furthest time from the epoch \[ns\], in the year 2116: between two such there is a difference.
const LATEST: u64 = 1 << 62;

/// The samples of one column.
#[derive(Clone, Debug)]
pub(crate) enum Samples {
    Numbers(Vec<i64>, Vec<f64>),
    Text(Vec<i64>, Vec<String>),
}

/// What is kept of a topic.
#[derive(Clone, Debug)]
pub(crate) struct Topic {
    pub(crate) name: String,
    /// Type of its messages.
    pub(crate) kind: String,
    /// Of each message \[ns\], increasing.
    pub(crate) times: Vec<i64>,
    /// Whether the times are those of headers.
    pub(crate) by_header: bool,
    /// By column.
    pub(crate) samples: BTreeMap<String, Samples>,
}

/// A channel whose topic is mapped.
struct Channel {
    topic: usize,
    definition: Definition,
}

struct State<'a> {
    map: &'a Map,
    origin: &'a Origin,
    schemas: BTreeMap<u16, (String, String, Vec<u8>)>,
    channels: BTreeMap<u16, Channel>,
    topics: Vec<Topic>,
    /// All topics of the bag, for messages.
    seen: Vec<String>,
}

/// Reads the mapped topics.
pub(crate) fn read(mut file: File, origin: &Origin, map: &Map) -> Result<Vec<Topic>, DataError> {
    let damaged = |e: mcap::McapError| {
        origin.fail_file(Problem::Unreadable {
            reason: format!("as MCAP: {e}"),
        })
    };
    let mut state = State {
        map,
        origin,
        schemas: BTreeMap::new(),
        channels: BTreeMap::new(),
        topics: vec![],
        seen: vec![],
    };
    let length = file.metadata().map_err(|e| unreadable(origin, &e))?.len();
    let largest = LEAST
        .saturating_add(length.saturating_mul(INFLATION))
        .min(LARGEST);
    let options = LinearReaderOptions::default()
        .with_validate_chunk_crcs(true)
        .with_record_length_limit(usize::try_from(largest).unwrap_or(usize::MAX));
    let mut reader = LinearReader::new_with_options(options);
    while let Some(event) = reader.next_event() {
        match event.map_err(damaged)? {
            LinearReadEvent::ReadRequest(n) => {
                // A length is believed only as far as there are bytes.
                let n = n.min(PIECE);
                let got = file
                    .read(reader.insert(n))
                    .map_err(|e| unreadable(origin, &e))?;
                reader.notify_read(got);
            }
            LinearReadEvent::Record { data, opcode } => {
                if !believable(opcode, data) {
                    return Err(origin.fail_file(Problem::Unreadable {
                        reason: "as MCAP: a text is longer than its record".to_owned(),
                    }));
                }
                if matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE) {
                    state.take(mcap::parse_record(opcode, data).map_err(damaged)?)?;
                }
            }
        }
    }
    for name in map.topics() {
        if !state.topics.iter().any(|t| t.name == name) {
            let known = state.seen.iter().map(String::as_str);
            return Err(unknown(origin, "topic", name, known));
        }
    }
    state.all_found()?;
    Ok(state.topics)
}

/// Whether the texts of a record end in it. The parser makes room for a text by the length that it claims, four gigabytes
/// if need be, before it looks for its bytes.
fn believable(opcode: u8, record: &[u8]) -> bool {
    fn skip(rest: &mut &[u8], n: usize) -> Option<()> {
        *rest = rest.get(n..)?;
        Some(())
    }
    fn length(rest: &mut &[u8]) -> Option<usize> {
        let (head, tail) = rest.split_first_chunk::<4>()?;
        *rest = tail;
        usize::try_from(u32::from_le_bytes(*head)).ok()
    }
    fn text(rest: &mut &[u8]) -> Option<()> {
        let n = length(rest)?;
        skip(rest, n)
    }
    let mut rest = record;
    let whole = match opcode {
        // Its number, its name, its encoding.
        op::SCHEMA => skip(&mut rest, 2).and_then(|()| {
            text(&mut rest)?;
            text(&mut rest)
        }),
        // Its number and its schema's, its topic, its encoding, and names with values, their length in bytes before them.
        op::CHANNEL => skip(&mut rest, 4).and_then(|()| {
            text(&mut rest)?;
            text(&mut rest)?;
            let n = length(&mut rest)?;
            let end = rest.len().checked_sub(n)?;
            while rest.len() > end {
                text(&mut rest)?;
                text(&mut rest)?;
            }
            Some(())
        }),
        _ => Some(()),
    };
    whole.is_some()
}

impl State<'_> {
    fn take(&mut self, record: Record<'_>) -> Result<(), DataError> {
        match record {
            Record::Schema { header, data } => {
                let schema = (header.name, header.encoding, data.into_owned());
                self.schemas.insert(header.id, schema);
                Ok(())
            }
            Record::Channel(c) => self.channel(c),
            Record::Message { header, data } => {
                let Some(channel) = self.channels.get(&header.channel_id) else {
                    return Ok(());
                };
                let topic = channel.topic;
                let message = cdr::read(&channel.definition, &data);
                self.message(topic, header.log_time, message)
            }
            _ => Ok(()),
        }
    }

    /// A field that is in no message at all is a mistake of the map, not a gap.
    fn all_found(&self) -> Result<(), DataError> {
        for column in &self.map.columns {
            let topic = self.topics.iter().find(|t| t.name == column.topic);
            if let Some(t) = topic.filter(|t| !t.samples.contains_key(&column.name)) {
                return Err(self.bad(format!(
                    "{} is in none of the {} messages of {}",
                    column.field,
                    t.times.len(),
                    t.name
                )));
            }
        }
        Ok(())
    }

    fn bad(&self, reason: String) -> DataError {
        self.origin.fail_file(Problem::Unreadable { reason })
    }

    fn channel(&mut self, c: mcap::records::Channel) -> Result<(), DataError> {
        if !self.seen.contains(&c.topic) {
            self.seen.push(c.topic.clone());
        }
        // The summary at the end of a bag repeats its channels.
        if self.channels.contains_key(&c.id) || !self.map.topics().contains(c.topic.as_str()) {
            return Ok(());
        }
        let Some((kind, encoding, text)) = self.schemas.get(&c.schema_id) else {
            return Err(self.bad(format!("topic {} has no schema", c.topic)));
        };
        if encoding != "ros2msg" || c.message_encoding != "cdr" {
            return Err(self.bad(format!(
                "topic {} is '{}' described by '{encoding}', expected 'cdr' described by 'ros2msg'",
                c.topic, c.message_encoding
            )));
        }
        let definition = Definition::parse(kind, &String::from_utf8_lossy(text))
            .map_err(|e| self.bad(format!("topic {}: {kind}: {e}", c.topic)))?;
        let kind = kind.clone();
        let topic = match self.topics.iter().position(|t| t.name == c.topic) {
            Some(k) => k,
            None => {
                self.topics.push(Topic {
                    name: c.topic,
                    kind,
                    times: vec![],
                    by_header: false,
                    samples: BTreeMap::new(),
                });
                self.topics.len() - 1
            }
        };
        self.channels.insert(c.id, Channel { topic, definition });
        Ok(())
    }

    fn message(
        &mut self,
        topic: usize,
        log_time: u64,
        message: Result<Value, String>,
    ) -> Result<(), DataError> {
        let (map, origin) = (self.map, self.origin);
        let Some(topic) = self.topics.get_mut(topic) else {
            return Ok(());
        };
        let number = topic.times.len() + 1;
        let bad = |reason: String| {
            origin.fail_file(Problem::Unreadable {
                reason: format!("message {number} of {}: {reason}", topic.name),
            })
        };
        let message = message.map_err(&bad)?;
        let stamp = stamp(&message).filter(|_| map.clock == Clock::Header);
        let time = stamp.unwrap_or(i128::from(log_time));
        let time = i64::try_from(time)
            .ok()
            .filter(|t| t.unsigned_abs() <= LATEST)
            .ok_or_else(|| bad(format!("a time of {time} ns")))?;
        if let Some(&last) = topic.times.last()
            && time <= last
        {
            return Err(origin.fail_file(Problem::TimeNotIncreasing {
                column: format!("message {number} of {}", topic.name),
                previous: seconds(last),
                found: seconds(time),
                group: "a topic; clock = \"log\" takes the recorder's time".to_owned(),
            }));
        }
        for column in map.columns.iter().filter(|c| c.topic == topic.name) {
            let found = column.field.find(&message).map_err(|field| {
                let mut paths = vec![];
                walk(&message, String::new(), &mut paths);
                unknown(origin, "field", &field, paths.iter().map(String::as_str))
            })?;
            let wrong = |expected: &str| bad(format!("{} is no {expected}", column.field));
            match (found, column.is_text()) {
                (None, _) => {}
                (Some(Value::Number(v)), false) => {
                    let kept = topic
                        .samples
                        .entry(column.name.clone())
                        .or_insert_with(|| Samples::Numbers(vec![], vec![]));
                    if let (Samples::Numbers(times, values), true) = (kept, v.is_finite()) {
                        times.push(time);
                        values.push(*v);
                    }
                }
                (Some(Value::Text(text)), true) => {
                    let kept = topic
                        .samples
                        .entry(column.name.clone())
                        .or_insert_with(|| Samples::Text(vec![], vec![]));
                    if let Samples::Text(times, texts) = kept {
                        times.push(time);
                        texts.push(text.clone());
                    }
                }
                (Some(_), true) => return Err(wrong("text")),
                (Some(_), false) => return Err(wrong("number")),
            }
        }
        topic.by_header = stamp.is_some();
        topic.times.push(time);
        Ok(())
    }
}

/// The stamp of a message's header \[ns\].
fn stamp(message: &Value) -> Option<i128> {
    let inside = |v: &'_ Value, name: &str| match v {
        Value::Struct(fields) => fields
            .iter()
            .find(|(n, _)| &**n == name)
            .map(|(_, v)| v.clone()),
        _ => None,
    };
    let stamp = inside(&inside(message, "header")?, "stamp")?;
    match (inside(&stamp, "sec")?, inside(&stamp, "nanosec")?) {
        (Value::Number(s), Value::Number(n)) => {
            Some(i128::from(s as i64) * 1_000_000_000 + i128::from(n as i64))
        }
        _ => None,
    }
}

/// Paths of the values of a message, for errors; an element of a list as `[0]`.
fn walk(value: &Value, path: String, out: &mut Vec<String>) {
    match value {
        Value::Struct(fields) => {
            for (name, inner) in fields {
                let dot = if path.is_empty() { "" } else { "." };
                walk(inner, format!("{path}{dot}{name}"), out);
            }
        }
        Value::List(items) => {
            if let Some(first) = items.first() {
                walk(first, format!("{path}[0]"), out);
            }
        }
        Value::Number(_) | Value::Text(_) => out.push(path),
    }
}
