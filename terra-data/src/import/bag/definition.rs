//! Message definitions as bags carry them: the text of a `.msg` file and of all files it names.
//!
//! # Reference
//! ROS 2 documentation, "Interfaces", and the MCAP registry's `ros2msg` encoding.

use std::collections::BTreeMap;
use std::sync::Arc;

/// Deepest message inside a message.
const DEEPEST: usize = 20;

/// A type of one value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Bytes of an integer; signed or not.
    Whole(usize, bool),
    /// Bytes of a floating-point number.
    Real(usize),
    Text,
    /// Another message.
    Message(String),
}

/// How many of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Many {
    One,
    Fixed(usize),
    Sequence,
}

/// One field of a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Field {
    pub(crate) name: Arc<str>,
    pub(crate) kind: Kind,
    pub(crate) many: Many,
}

/// A message and all messages inside it, by `package/Type`.
#[derive(Clone, Debug)]
pub(crate) struct Definition {
    pub(crate) root: String,
    pub(crate) messages: BTreeMap<String, Vec<Field>>,
}

impl Definition {
    /// Of a schema's name and text.
    ///
    /// # Errors
    /// What cannot be understood, in words.
    pub(crate) fn parse(name: &str, text: &str) -> Result<Self, String> {
        let root = short(name);
        let mut messages = BTreeMap::new();
        let (mut message, mut fields) = (root.clone(), vec![]);
        for line in text.lines() {
            let line = line.trim();
            if line.len() > 10 && line.bytes().all(|b| b == b'=') {
                continue;
            }
            if let Some(next) = line.strip_prefix("MSG:") {
                messages.insert(message, std::mem::take(&mut fields));
                message = short(next.trim());
                continue;
            }
            if let Some(field) = field(line, &message)? {
                fields.push(field);
            }
        }
        messages.insert(message, fields);
        let definition = Definition { root, messages };
        definition.depth(&definition.root, &mut BTreeMap::new())?;
        Ok(definition)
    }

    /// Every message is there, and none holds itself: how deep one is nested. Each is looked at once, or a few lines that
    /// name each other would take for ever.
    fn depth<'a>(
        &'a self,
        message: &'a str,
        known: &mut BTreeMap<&'a str, Option<usize>>,
    ) -> Result<usize, String> {
        let too_deep = || format!("{message} is nested too deep");
        match known.get(message) {
            Some(Some(depth)) => return Ok(*depth),
            // It is being looked at: it holds itself.
            Some(None) => return Err(too_deep()),
            None => {}
        }
        if known.values().filter(|d| d.is_none()).count() > DEEPEST {
            return Err(too_deep());
        }
        known.insert(message, None);
        let fields = self
            .messages
            .get(message)
            .ok_or_else(|| format!("no definition of {message}"))?;
        let mut depth = 0;
        for field in fields {
            if let Kind::Message(inner) = &field.kind {
                depth = depth.max(1 + self.depth(inner, known)?);
            }
        }
        if depth > DEEPEST {
            return Err(too_deep());
        }
        known.insert(message, Some(depth));
        Ok(depth)
    }
}

/// `package/msg/Type` as `package/Type`.
fn short(name: &str) -> String {
    name.replace("/msg/", "/")
}

/// A line of a definition; none for a comment and a constant.
fn field(line: &str, message: &str) -> Result<Option<Field>, String> {
    let line = line.split('#').next().unwrap_or_default();
    let mut words = line.split_whitespace();
    let Some(kind) = words.next() else {
        return Ok(None);
    };
    let name = words
        .next()
        .ok_or_else(|| format!("{message}: a field without a name: '{line}'"))?;
    let constant = name.contains('=') || words.next().is_some_and(|w| w.starts_with('='));
    if constant {
        return Ok(None);
    }
    let (kind, many) = match kind.split_once('[') {
        None => (kind, Many::One),
        Some((kind, size)) => {
            let size = size.trim_end_matches(']');
            match size.parse() {
                Ok(0) => return Err(format!("{message}: an array of no elements")),
                Ok(n) => (kind, Many::Fixed(n)),
                Err(_) if size.is_empty() || size.starts_with("<=") => (kind, Many::Sequence),
                Err(_) => return Err(format!("{message}: '{size}' is no length of an array")),
            }
        }
    };
    // A bound on a text's length changes nothing about its bytes.
    let kind = kind.split("<=").next().unwrap_or(kind);
    let kind = match kind {
        "bool" | "byte" | "uint8" => Kind::Whole(1, false),
        "char" | "int8" => Kind::Whole(1, kind == "int8"),
        "uint16" => Kind::Whole(2, false),
        "int16" => Kind::Whole(2, true),
        "uint32" => Kind::Whole(4, false),
        "int32" => Kind::Whole(4, true),
        "uint64" => Kind::Whole(8, false),
        "int64" => Kind::Whole(8, true),
        "float32" => Kind::Real(4),
        "float64" => Kind::Real(8),
        "string" => Kind::Text,
        "wstring" => return Err(format!("{message}: wstring is not understood")),
        other => Kind::Message(match other.split_once('/') {
            Some(_) => short(other),
            None if other == "Header" => "std_msgs/Header".to_owned(),
            // In the package of the message that names it.
            None => match message.split_once('/') {
                Some((package, _)) => format!("{package}/{other}"),
                None => other.to_owned(),
            },
        }),
    };
    Ok(Some(Field {
        name: name.into(),
        kind,
        many,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_definition_with_constants_comments_and_inner_messages() {
        let text = "# a comment\nuint8 A=1\nint32 B = 2\nstd_msgs/Header header\nfloat64[] velocity # rad/s\nfloat64[9] k\nstring<=10 name default\nPoint p\n\
                    ================================================================================\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
                    ================================================================================\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n\
                    ================================================================================\nMSG: my/Point\nfloat32 x\n";
        let d = Definition::parse("my/msg/Thing", text).unwrap();
        let names: Vec<&str> = d.messages["my/Thing"].iter().map(|f| &*f.name).collect();
        assert_eq!(names, ["header", "velocity", "k", "name", "p"]);
        assert_eq!(d.messages["my/Thing"][1].many, Many::Sequence);
        assert_eq!(d.messages["my/Thing"][2].many, Many::Fixed(9));
        assert_eq!(
            d.messages["my/Thing"][4].kind,
            Kind::Message("my/Point".into())
        );
    }

    #[test]
    fn what_is_missing_or_circular_is_said() {
        let missing = Definition::parse("my/msg/A", "Inner x\n").unwrap_err();
        assert!(missing.contains("my/Inner"), "{missing}");
        assert!(Definition::parse("my/msg/A", "A a\n").is_err());
        assert!(Definition::parse("my/msg/A", "float64\n").is_err());
        assert!(Definition::parse("my/msg/A", "float64[x] a\n").is_err());
        assert!(Definition::parse("my/msg/A", "float64[0] a\n").is_err());
    }

    /// Twenty messages, each with ten of the next: 10^20 ways down.
    #[test]
    fn many_ways_to_one_message_are_looked_at_once() {
        let chain = |n: usize| {
            let mut text = String::new();
            for k in 0..n {
                for field in 0..10 {
                    text += &format!("my/M{} f{field}\n", k + 1);
                }
                text += &format!("MSG: my/M{}\n", k + 1);
            }
            text + "float64 x\n"
        };
        assert!(Definition::parse("my/msg/M0", &chain(20)).is_ok());
        let deep = Definition::parse("my/msg/M0", &chain(21)).unwrap_err();
        assert!(deep.contains("nested too deep"), "{deep}");
    }
}
