//! The headers of a Parquet file, walked before its library reads them.
//!
//! Headers are structures of Thrift's compact protocol, whose lists give their length first. The library skips the lists it
//! does not know element by element and takes a boolean for an element without bytes, so that a list of 2^31 of them in a few
//! bytes holds it for seconds, and a list of such lists for days. No header of the format has a list, set or map of booleans:
//! a file that has one is refused.
//!
//! # Source
//! Apache Thrift, "Thrift compact protocol encoding" (doc/specs/thrift-compact-protocol.md); Apache Parquet, "File format"
//! and `parquet.thrift` (PageHeader, field 3: compressed_page_size).

use std::io::{self, BufReader, Read, Seek, SeekFrom};

/// Structures within structures up to which a header is walked; real ones have five.
const DEPTH: usize = 32;
/// Bytes of the largest number of 64 bits.
const LONGEST: u32 = 10;
/// Length of the footer and the mark of the format, at the end of the file.
const END: i64 = 8;
const MARK: &[u8; 4] = b"PAR1";
/// The page header's field with the number of bytes that follow it.
const PAGE_SIZE: i64 = 3;

const BOOLEANS: &str = "a header holds a list of booleans, which the format has nowhere";

/// Types on the wire.
mod kind {
    pub(super) const STOP: u8 = 0;
    pub(super) const TRUE: u8 = 1;
    pub(super) const FALSE: u8 = 2;
    pub(super) const BYTE: u8 = 3;
    pub(super) const I16: u8 = 4;
    pub(super) const I64: u8 = 6;
    pub(super) const DOUBLE: u8 = 7;
    pub(super) const BINARY: u8 = 8;
    pub(super) const LIST: u8 = 9;
    pub(super) const SET: u8 = 10;
    pub(super) const MAP: u8 = 11;
    pub(super) const STRUCT: u8 = 12;
    pub(super) const UUID: u8 = 13;
}

/// The footer of a file; one without the format's mark is left to the library, which says so.
///
/// # Errors
/// What is wrong with it.
pub(super) fn footer(file: &mut (impl Read + Seek)) -> Result<(), String> {
    let Ok(end) = file.seek(SeekFrom::End(-END)) else {
        return Ok(());
    };
    let (mut length, mut mark) = ([0; 4], [0; 4]);
    file.read_exact(&mut length).map_err(said)?;
    file.read_exact(&mut mark).map_err(said)?;
    if &mark != MARK {
        return Ok(());
    }
    let length = u64::from(u32::from_le_bytes(length));
    let start = end
        .checked_sub(length)
        .ok_or("the footer is longer than the file")?;
    file.seek(SeekFrom::Start(start)).map_err(said)?;
    Walk::of(file, length).structure(DEPTH).map(drop)
}

/// The page headers in `length` bytes from `start`.
///
/// # Errors
/// What is wrong with one.
pub(super) fn pages(
    file: &mut (impl Read + Seek),
    mut start: u64,
    mut length: u64,
) -> Result<(), String> {
    while length > 0 {
        file.seek(SeekFrom::Start(start)).map_err(said)?;
        let mut walk = Walk::of(&mut *file, length);
        let size = walk.structure(DEPTH)?;
        let size = size
            .and_then(|s| u64::try_from(s).ok())
            .ok_or("a page without a size")?;
        let whole = walk.taken + size;
        start += whole;
        length = length
            .checked_sub(whole)
            .ok_or("a page is longer than its column")?;
    }
    Ok(())
}

fn said(e: io::Error) -> String {
    e.to_string()
}

/// A way through one header.
struct Walk<R> {
    bytes: R,
    /// Bytes walked so far.
    taken: u64,
}

impl<'a, R: Read> Walk<BufReader<io::Take<&'a mut R>>> {
    fn of(file: &'a mut R, length: u64) -> Self {
        Walk {
            bytes: BufReader::with_capacity(512, file.take(length)),
            taken: 0,
        }
    }
}

impl<R: Read> Walk<R> {
    fn byte(&mut self) -> Result<u8, String> {
        let mut byte = [0];
        self.bytes.read_exact(&mut byte).map_err(said)?;
        self.taken += 1;
        Ok(byte[0])
    }

    /// A number, seven bits a byte.
    fn number(&mut self) -> Result<u64, String> {
        let mut whole = 0;
        for k in 0..LONGEST {
            let byte = self.byte()?;
            whole |= u64::from(byte & 0x7f) << (7 * k);
            if byte & 0x80 == 0 {
                return Ok(whole);
            }
        }
        Err("a number of more than 64 bits".to_owned())
    }

    /// A number whose last bit is its sign.
    fn signed(&mut self) -> Result<i64, String> {
        let n = self.number()?;
        Ok((n >> 1) as i64 ^ -((n & 1) as i64))
    }

    fn pass(&mut self, count: u64) -> Result<(), String> {
        let passed = io::copy(&mut (&mut self.bytes).take(count), &mut io::sink());
        self.taken += count;
        match passed.map_err(said)? {
            n if n == count => Ok(()),
            _ => Err("a header ends within a value".to_owned()),
        }
    }

    /// A structure and the number in its own field [`PAGE_SIZE`], where it has one.
    fn structure(&mut self, depth: usize) -> Result<Option<i64>, String> {
        let depth = depth
            .checked_sub(1)
            .ok_or("a header with too many structures within structures")?;
        let (mut field, mut size) = (0_i64, None);
        loop {
            let head = self.byte()?;
            let kind = head & 0x0f;
            if kind == kind::STOP {
                return Ok(size);
            }
            field = match i64::from(head >> 4) {
                0 => self.signed()?,
                step => field.wrapping_add(step),
            };
            match kind {
                // The type is the value.
                kind::TRUE | kind::FALSE => {}
                kind::I16..=kind::I64 if field == PAGE_SIZE => size = Some(self.signed()?),
                kind => self.value(kind, depth)?,
            }
        }
    }

    /// Passes a value.
    fn value(&mut self, kind: u8, depth: usize) -> Result<(), String> {
        match kind {
            kind::BYTE => self.pass(1),
            kind::I16..=kind::I64 => self.number().map(drop),
            kind::DOUBLE => self.pass(8),
            kind::UUID => self.pass(16),
            kind::BINARY => {
                let length = self.number()?;
                self.pass(length)
            }
            kind::STRUCT => self.structure(depth).map(drop),
            kind::LIST | kind::SET => {
                let head = self.byte()?;
                let count = match head >> 4 {
                    15 => self.number()?,
                    few => u64::from(few),
                };
                self.elements(count, &[head & 0x0f], depth)
            }
            kind::MAP => match self.number()? {
                0 => Ok(()),
                count => {
                    let kinds = self.byte()?;
                    self.elements(count, &[kinds >> 4, kinds & 0x0f], depth)
                }
            },
            other => Err(format!("a header with a value of unknown type {other}")),
        }
    }

    /// Passes so many elements of these types in turn.
    fn elements(&mut self, count: u64, kinds: &[u8], depth: usize) -> Result<(), String> {
        if kinds.iter().any(|k| matches!(*k, kind::TRUE | kind::FALSE)) {
            return Err(BOOLEANS.to_owned());
        }
        let depth = depth
            .checked_sub(1)
            .ok_or("a header with too many lists within lists")?;
        for _ in 0..count {
            for kind in kinds {
                self.value(*kind, depth)?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    /// A file that ends in this footer.
    fn with_footer(footer: &[u8]) -> Cursor<Vec<u8>> {
        let mut file = b"PAR1".to_vec();
        file.extend(footer);
        file.extend((footer.len() as u32).to_le_bytes());
        file.extend(b"PAR1");
        Cursor::new(file)
    }

    /// Field 1: i32 1; field 2: a list of two texts; field 20 by its number: a map of one byte to one structure that is empty.
    #[test]
    fn every_kind_of_value_is_passed() {
        let header = [
            0x15, 2, 0x19, 0x28, 1, b'a', 1, b'b', 0x0b, 40, 1, 0x3c, 7, 0, 0x11, 0,
        ];
        footer(&mut with_footer(&header)).unwrap();
        let cut = footer(&mut with_footer(&header[..header.len() - 1]));
        assert!(cut.is_err());
    }

    /// 2^31 - 1 booleans in seven bytes, and the same as elements of a list.
    #[test]
    fn lists_of_booleans_are_refused() {
        for kind in [1, 2] {
            let all = [0xf0 | kind, 0xff, 0xff, 0xff, 0xff, 7];
            let mut header = vec![0x19];
            header.extend(all);
            header.push(0);
            assert_eq!(footer(&mut with_footer(&header)).unwrap_err(), BOOLEANS);
            let mut header = vec![0x19, 0x19];
            header.extend(all);
            header.push(0);
            assert_eq!(footer(&mut with_footer(&header)).unwrap_err(), BOOLEANS);
        }
    }

    #[test]
    fn a_header_within_itself_without_end_is_refused() {
        let header = [0x1c; 4000];
        assert!(footer(&mut with_footer(&header)).is_err());
        let header = [0x19; 4000];
        assert!(footer(&mut with_footer(&header)).is_err());
    }

    /// Two pages of 3 and 2 bytes, whose headers give the size in field 3; the second has a list of booleans.
    #[test]
    fn pages_are_walked_by_their_sizes() {
        let good = [0x35, 6, 0, 9, 9, 9, 0x35, 4, 0, 9, 9];
        let end = good.len() as u64;
        pages(&mut Cursor::new(good), 0, end).unwrap();
        assert!(pages(&mut Cursor::new(good), 0, end - 1).is_err());
        let bad = [0x35, 6, 0, 9, 9, 9, 0x35, 4, 0x19, 0xf1, 0xff, 7, 0, 9, 9];
        let found = pages(&mut Cursor::new(bad), 0, bad.len() as u64);
        assert_eq!(found.unwrap_err(), BOOLEANS);
    }
}
