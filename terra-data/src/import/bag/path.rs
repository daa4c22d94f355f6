//! Which number of a message: `twist.twist.linear.x`, `data[3]`, `velocity[front_left_wheel]`.

use std::fmt;

use super::cdr::Value;

/// One step into a message.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Step {
    Field(String),
    Index(usize),
    /// The place of that text in the message's `name` (as in sensor_msgs/JointState).
    Named(String),
}

/// A path into a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FieldPath(Vec<Step>);

impl FieldPath {
    /// None for what is no path.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let mut steps = vec![];
        let mut rest = text;
        while !rest.is_empty() {
            let end = rest.find(['.', '[']).unwrap_or(rest.len());
            let (field, after) = rest.split_at(end);
            if field.is_empty() || !field.chars().all(|c| c.is_alphanumeric() || c == '_') {
                return None;
            }
            steps.push(Step::Field(field.to_owned()));
            rest = after;
            while let Some(inside) = rest.strip_prefix('[') {
                let (key, after) = inside.split_once(']')?;
                steps.push(match key.parse() {
                    Ok(index) => Step::Index(index),
                    Err(_) if key.is_empty() => return None,
                    Err(_) => Step::Named(key.to_owned()),
                });
                rest = after;
            }
            match rest.strip_prefix('.') {
                Some("") => return None,
                Some(after) => rest = after,
                None if rest.is_empty() => {}
                None => return None,
            }
        }
        (!steps.is_empty()).then_some(FieldPath(steps))
    }

    /// What stands there. `Ok(None)`: an element that this message leaves out.
    ///
    /// # Errors
    /// The field that no such message has.
    pub(crate) fn find<'v>(&self, message: &'v Value) -> Result<Option<&'v Value>, String> {
        // The structure that the last list was a field of, which may hold its names.
        let mut owner = message;
        let mut at = message;
        for step in &self.0 {
            let next = match (step, at) {
                (Step::Field(name), Value::Struct(fields)) => {
                    owner = at;
                    let found = fields.iter().find(|(n, _)| **n == **name);
                    Some(found.map(|(_, v)| v).ok_or_else(|| name.clone())?)
                }
                (Step::Field(name), _) => return Err(name.clone()),
                (Step::Index(k), Value::List(items)) => items.get(*k),
                (Step::Named(key), Value::List(items)) => {
                    let Value::Struct(fields) = owner else {
                        return Err(format!("[{key}]"));
                    };
                    let names = fields.iter().find(|(n, _)| &**n == "name");
                    let Some((_, Value::List(names))) = names else {
                        return Err("name".to_owned());
                    };
                    let place = names
                        .iter()
                        .position(|n| matches!(n, Value::Text(t) if t == key));
                    place.and_then(|k| items.get(k))
                }
                (Step::Index(k), _) => return Err(format!("[{k}]")),
                (Step::Named(key), _) => return Err(format!("[{key}]")),
            };
            match next {
                Some(v) => at = v,
                None => return Ok(None),
            }
        }
        Ok(Some(at))
    }
}

impl fmt::Display for FieldPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, step) in self.0.iter().enumerate() {
            match step {
                Step::Field(name) if k == 0 => f.write_str(name)?,
                Step::Field(name) => write!(f, ".{name}")?,
                Step::Index(i) => write!(f, "[{i}]")?,
                Step::Named(key) => write!(f, "[{key}]")?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_read_back_as_written() {
        for good in [
            "data",
            "a.b.c",
            "data[3]",
            "velocity[front left]",
            "a[1].b[x]",
        ] {
            assert_eq!(FieldPath::parse(good).unwrap().to_string(), good);
        }
        for bad in [
            "", ".", "a.", ".a", "a..b", "a[", "a[]", "a b", "a[1]b", "[1]",
        ] {
            assert_eq!(FieldPath::parse(bad), None, "{bad}");
        }
    }
}
