//! Messages in the Common Data Representation, read by their definition.
//!
//! # Reference
//! OMG, *DDS Interoperability Wire Protocol* 2.2, section 10 (encapsulation `CDR_BE`, `CDR_LE`); OMG, *CORBA* 3.4,
//! section 9.3: each primitive lies on a multiple of its size, counted from behind the encapsulation's four bytes.

use std::sync::Arc;

use super::definition::{Definition, Field, Kind, Many};

/// A value of a message.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Number(f64),
    Text(String),
    List(Vec<Value>),
    Struct(Vec<(Arc<str>, Value)>),
}

/// Reads a message.
///
/// # Errors
/// What is wrong with it, in words.
pub(crate) fn read(definition: &Definition, bytes: &[u8]) -> Result<Value, String> {
    let (head, body) = bytes
        .split_at_checked(4)
        .ok_or("shorter than its encapsulation")?;
    let little = match head {
        [0, 0, ..] => false,
        [0, 1, ..] => true,
        [a, b, ..] => return Err(format!("encapsulation {a:#04x}{b:02x}, expected plain CDR")),
        _ => return Err("shorter than its encapsulation".to_owned()),
    };
    let mut cursor = Cursor {
        definition,
        body,
        at: 0,
        little,
    };
    cursor.message(&definition.root)
}

struct Cursor<'a> {
    definition: &'a Definition,
    body: &'a [u8],
    at: usize,
    little: bool,
}

impl<'a> Cursor<'a> {
    fn take(&mut self, n: usize) -> Result<&'a [u8], String> {
        let end = self.at.checked_add(n);
        match end.and_then(|end| self.body.get(self.at..end)) {
            Some(bytes) => {
                self.at += n;
                Ok(bytes)
            }
            None => Err(format!("ends after {} bytes, in a value", self.body.len())),
        }
    }

    /// The bytes of a primitive, least significant first.
    fn primitive(&mut self, size: usize) -> Result<[u8; 8], String> {
        self.at = self.at.next_multiple_of(size);
        let bytes = self.take(size)?;
        let mut out = [0; 8];
        let ordered = bytes.iter().enumerate();
        for (k, b) in ordered {
            let place = if self.little { k } else { size - 1 - k };
            if let Some(slot) = out.get_mut(place) {
                *slot = *b;
            }
        }
        Ok(out)
    }

    fn length(&mut self) -> Result<usize, String> {
        let n = u64::from_le_bytes(self.primitive(4)?);
        // Every element takes at least one byte, a message without fields too, so that a length can be believed before room is
        // made for it.
        match usize::try_from(n) {
            Ok(n) if n <= self.body.len() - self.at.min(self.body.len()) => Ok(n),
            _ => Err(format!(
                "a length of {n} with {} bytes left",
                self.body.len().saturating_sub(self.at)
            )),
        }
    }

    fn message(&mut self, name: &str) -> Result<Value, String> {
        let definition = self.definition;
        let fields = definition
            .messages
            .get(name)
            .ok_or_else(|| format!("no definition of {name}"))?;
        if fields.is_empty() {
            // ROS 2 gives a message without fields one byte, because a structure without any is none in IDL.
            self.take(1)?;
        }
        let values = fields
            .iter()
            .map(|f| Ok((Arc::clone(&f.name), self.field(f)?)))
            .collect::<Result<_, String>>()?;
        Ok(Value::Struct(values))
    }

    fn field(&mut self, field: &Field) -> Result<Value, String> {
        let count = match field.many {
            Many::One => return self.value(&field.kind),
            Many::Fixed(n) => n,
            Many::Sequence => self.length()?,
        };
        // Grows with what is really there.
        let mut items = Vec::new();
        for _ in 0..count {
            items.push(self.value(&field.kind)?);
        }
        Ok(Value::List(items))
    }

    fn value(&mut self, kind: &Kind) -> Result<Value, String> {
        Ok(match kind {
            Kind::Whole(size, signed) => {
                let raw = u64::from_le_bytes(self.primitive(*size)?);
                let unused = 64 - 8 * *size as u32;
                Value::Number(if *signed {
                    ((raw << unused) as i64 >> unused) as f64
                } else {
                    raw as f64
                })
            }
            Kind::Real(4) => {
                let [a, b, c, d, ..] = self.primitive(4)?;
                Value::Number(f64::from(f32::from_le_bytes([a, b, c, d])))
            }
            Kind::Real(_) => Value::Number(f64::from_le_bytes(self.primitive(8)?)),
            Kind::Text => {
                let n = self.length()?;
                let bytes = self.take(n)?;
                let bytes = bytes.strip_suffix(b"\0").unwrap_or(bytes);
                Value::Text(String::from_utf8_lossy(bytes).into_owned())
            }
            Kind::Message(name) => self.message(name)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn definition() -> Definition {
        Definition::parse(
            "my/msg/M",
            "uint8 a\nfloat64 b\nint16 c\nstring d\nfloat32[] e\nint8[2] f\n",
        )
        .unwrap()
    }

    /// Laid out by hand from the standard: a at 0, b at 8, c at 16, length of d at 20, "hi" and its NUL at 24, length of
    /// e at 28, e at 32, f at 36.
    #[test]
    fn alignment_and_byte_order() {
        let number = |v: f64| Value::Number(v);
        let expected = vec![
            number(7.0),
            number(-2.5),
            number(-3.0),
            Value::Text("hi".into()),
            Value::List(vec![number(0.5)]),
            Value::List(vec![number(-1.0), number(2.0)]),
        ];
        for little in [true, false] {
            let mut body = vec![0u8; 38];
            let mut put = |at: usize, mut bytes: Vec<u8>| {
                if !little {
                    bytes.reverse();
                }
                body[at..at + bytes.len()].copy_from_slice(&bytes);
            };
            put(0, vec![7]);
            put(8, (-2.5f64).to_le_bytes().to_vec());
            put(16, (-3i16).to_le_bytes().to_vec());
            put(20, 3u32.to_le_bytes().to_vec());
            put(24, vec![b'h']);
            put(25, vec![b'i']);
            put(28, 1u32.to_le_bytes().to_vec());
            put(32, 0.5f32.to_le_bytes().to_vec());
            put(36, vec![0xff]);
            put(37, vec![2]);
            let mut bytes = vec![0, u8::from(little), 0, 0];
            bytes.extend(&body);
            let Value::Struct(fields) = read(&definition(), &bytes).unwrap() else {
                panic!("not a structure");
            };
            let values: Vec<Value> = fields.into_iter().map(|(_, v)| v).collect();
            assert_eq!(values, expected);
            // Cut anywhere, it is an error and nothing else.
            for cut in 0..bytes.len() {
                assert!(read(&definition(), &bytes[..cut]).is_err(), "{cut}");
            }
        }
    }

    #[test]
    fn a_length_without_bytes_is_refused_before_room_is_made() {
        let sequence = Definition::parse("my/msg/S", "float64[] x\n").unwrap();
        let error = read(&sequence, &[0, 1, 0, 0, 0xff, 0xff, 0xff, 0xff]).unwrap_err();
        assert!(error.contains("4294967295"), "{error}");
    }

    /// A message without fields has the byte `structure_needs_at_least_one_member` (rosidl), so that a definition can ask
    /// for no more of them than there are bytes.
    #[test]
    fn a_message_without_fields_takes_a_byte() {
        let text = "Nothing a\nuint8 b\nNothing[1000000000000] c\nMSG: my/Nothing\n";
        let one = text.replace("1000000000000", "1");
        let one = Definition::parse("my/msg/M", &one).unwrap();
        let Value::Struct(fields) = read(&one, &[0, 1, 0, 0, 0, 7, 0]).unwrap() else {
            panic!("not a structure");
        };
        assert_eq!(fields[1].1, Value::Number(7.0));
        let many = Definition::parse("my/msg/M", text).unwrap();
        assert!(read(&many, &[0, 1, 0, 0, 0, 7, 0]).is_err());
    }
}
