//! The data elements of a file: tags, padding, compression.
//!
//! # Reference
//! The MathWorks, *MAT-File Format*, R2024b, "Level 5 MAT-File Format".

use std::io::Read;

use flate2::read::ZlibDecoder;

use super::matrix::{Array, matrix};

/// Kind of a data element.
pub(super) const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// Most bytes that compressed variables give: so many, and so many times what they take in the file. Deflate can do 1032
/// times, and a small file would fill the memory.
const INFLATED: u64 = 64 << 20;
const INFLATION: u64 = 64;

/// A file.
pub(super) struct Reader<R> {
    file: R,
    little: bool,
    /// Bytes that compressed variables may still give.
    room: u64,
}

impl<R: Read> Reader<R> {
    /// Reads the header.
    pub(super) fn new(mut file: R) -> Result<Self, String> {
        let mut header = Vec::new();
        file.by_ref()
            .take(128)
            .read_to_end(&mut header)
            .map_err(|e| e.to_string())?;
        if header.starts_with(b"\x89HDF") || header.starts_with(b"MATLAB 7.3") {
            return Err("it is of version 7.3 (HDF5); save it with -v7".to_owned());
        }
        let little = match header.get(124..128) {
            Some([0, 1, b'I', b'M']) => true,
            Some([1, 0, b'M', b'I']) => false,
            _ => return Err("no header of a version 5 file; save it with -v6 or -v7".to_owned()),
        };
        Ok(Reader {
            file,
            little,
            room: INFLATED,
        })
    }

    /// All variables.
    pub(super) fn arrays(mut self) -> Result<Vec<Array>, String> {
        let mut arrays = vec![];
        loop {
            let tag = self.bytes(8)?;
            if tag.is_empty() {
                return Ok(arrays);
            }
            let mut tag = Bytes::new(&tag, self.little);
            let (kind, size) = (tag.u32()?, tag.u32()?);
            let body = self.bytes(u64::from(size))?;
            if body.len() != size as usize {
                return Err(format!("it ends {} bytes into one of {size}", body.len()));
            }
            match kind {
                MATRIX => arrays.extend(matrix(&mut Bytes::new(&body, self.little), 0)?),
                COMPRESSED => {
                    let inflated = self.inflate(&body)?;
                    let mut bytes = Bytes::new(&inflated, self.little);
                    let (kind, mut inner) = bytes.element()?;
                    if kind == MATRIX {
                        arrays.extend(matrix(&mut inner, 0)?);
                    }
                }
                _ => {}
            }
            // Compressed elements are not padded.
            if kind != COMPRESSED {
                let padding = u64::from(size).next_multiple_of(8) - u64::from(size);
                self.bytes(padding)?;
            }
        }
    }

    /// A compressed variable, if there is room for it.
    fn inflate(&mut self, body: &[u8]) -> Result<Vec<u8>, String> {
        self.room = self
            .room
            .saturating_add((body.len() as u64).saturating_mul(INFLATION));
        let mut inflated = Vec::new();
        ZlibDecoder::new(body)
            .take(self.room.saturating_add(1))
            .read_to_end(&mut inflated)
            .map_err(|e| format!("a compressed variable: {e}"))?;
        self.room = self
            .room
            .checked_sub(inflated.len() as u64)
            .ok_or_else(|| {
                format!(
                    "its compressed variables are more than {INFLATION} times what they take, and more than {} MiB; save it \
                     with -v6",
                    INFLATED >> 20
                )
            })?;
        Ok(inflated)
    }

    /// As many bytes as there are, up to `n`.
    fn bytes(&mut self, n: u64) -> Result<Vec<u8>, String> {
        let mut out = Vec::new();
        self.file
            .by_ref()
            .take(n)
            .read_to_end(&mut out)
            .map_err(|e| e.to_string())?;
        Ok(out)
    }
}

/// Bytes that are taken from the front.
pub(super) struct Bytes<'a> {
    rest: &'a [u8],
    little: bool,
}

impl<'a> Bytes<'a> {
    pub(super) fn new(rest: &'a [u8], little: bool) -> Self {
        Bytes { rest, little }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    pub(super) fn take(&mut self, n: usize) -> Result<&'a [u8], String> {
        let (head, tail) = self
            .rest
            .split_at_checked(n)
            .ok_or_else(|| format!("{} bytes where {n} should be", self.rest.len()))?;
        self.rest = tail;
        Ok(head)
    }

    /// A value of up to eight bytes, least significant first.
    fn ordered(&mut self, n: usize) -> Result<[u8; 8], String> {
        let bytes = self.take(n)?;
        let mut out = [0; 8];
        for (k, slot) in out.iter_mut().take(n).enumerate() {
            let place = if self.little { k } else { n - 1 - k };
            *slot = bytes.get(place).copied().unwrap_or_default();
        }
        Ok(out)
    }

    pub(super) fn u32(&mut self) -> Result<u32, String> {
        let [a, b, c, d, ..] = self.ordered(4)?;
        Ok(u32::from_le_bytes([a, b, c, d]))
    }

    /// The next data element: its kind and its content, padding left behind.
    pub(super) fn element(&mut self) -> Result<(u32, Bytes<'a>), String> {
        let word = self.u32()?;
        // Up to four bytes stand in the tag itself.
        let (kind, size) = (word & 0xffff, (word >> 16) as usize);
        let content = if size > 0 {
            if size > 4 {
                return Err(format!("a small element of {size} bytes"));
            }
            self.take(4)?.get(..size).unwrap_or_default()
        } else {
            let size = self.u32()? as usize;
            let content = self.take(size)?;
            let padding = size.next_multiple_of(8) - size;
            // The last one of a file may go without.
            self.take(padding.min(self.rest.len()))?;
            content
        };
        Ok((kind, Bytes::new(content, self.little)))
    }

    /// The numbers of an element of that kind.
    pub(super) fn numbers(mut self, kind: u32) -> Result<Vec<f64>, String> {
        let size = match kind {
            1 | 2 | 16 => 1,
            3 | 4 | 17 => 2,
            5..=7 | 18 => 4,
            9 | 12 | 13 => 8,
            other => return Err(format!("numbers of unknown kind {other}")),
        };
        let mut out = Vec::with_capacity(self.rest.len() / size);
        while !self.is_empty() {
            let b = self.ordered(size)?;
            let raw = u64::from_le_bytes(b);
            out.push(match kind {
                1 => f64::from(raw as u8 as i8),
                3 => f64::from(raw as u16 as i16),
                5 => f64::from(raw as u32 as i32),
                7 => f64::from(f32::from_bits(raw as u32)),
                9 => f64::from_bits(raw),
                12 => raw as i64 as f64,
                _ => raw as f64,
            });
        }
        Ok(out)
    }
}
