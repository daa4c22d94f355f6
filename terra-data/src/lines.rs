//! Which line of the file a record starts in.
//!
//! A CSV reader skips blank lines and swallows line ends inside quotes, so that counting records does not give lines,
//! and an error with a wrong line sends the user to the wrong place. [`LineWatch`] stands between the file and the CSV
//! reader and notes where each line with content begins, until the reader has passed it.

use std::collections::VecDeque;
use std::io::{self, Read};

/// A line that has something in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LineStart {
    /// Offset of its first byte in the stream.
    offset: u64,
    /// Number, from 1.
    pub(crate) line: u64,
    /// Quotes in the stream before it.
    pub(crate) quotes: u64,
}

/// Passes a stream through and remembers the lines that the CSV reader has not reached yet.
pub(crate) struct LineWatch<R> {
    inner: R,
    comment: Option<u8>,
    ahead: VecDeque<LineStart>,
    offset: u64,
    line: u64,
    quotes: u64,
    last: u8,
    fresh: bool,
    ended: bool,
}

impl<R> LineWatch<R> {
    /// Watches a stream; lines that begin with `comment` do not count as content.
    pub(crate) fn new(inner: R, comment: Option<u8>) -> Self {
        LineWatch {
            inner,
            comment,
            ahead: VecDeque::new(),
            offset: 0,
            line: 1,
            quotes: 0,
            last: b'\n',
            fresh: true,
            ended: false,
        }
    }

    /// The first line with content before `end`, where the record now read ends; forgets all lines before it. Records are
    /// passed in order, so the lines of earlier ones are forgotten already.
    pub(crate) fn line_until(&mut self, end: u64) -> Option<LineStart> {
        let mut first = None;
        while let Some(next) = self.ahead.front().copied().filter(|l| l.offset < end) {
            first = first.or(Some(next));
            self.ahead.pop_front();
        }
        first
    }

    /// True once the stream has ended.
    pub(crate) fn ended(&self) -> bool {
        self.ended
    }

    /// True when the last byte so far ends a line.
    pub(crate) fn ends_a_line(&self) -> bool {
        matches!(self.last, b'\n' | b'\r')
    }

    /// Quotes so far.
    pub(crate) fn quotes(&self) -> u64 {
        self.quotes
    }

    fn see(&mut self, byte: u8) {
        match byte {
            b'\n' if self.last == b'\r' => {} // the second half of CRLF
            b'\n' | b'\r' => {
                self.line += 1;
                self.fresh = true;
            }
            _ => {
                if std::mem::take(&mut self.fresh) && Some(byte) != self.comment {
                    let (offset, line, quotes) = (self.offset, self.line, self.quotes);
                    self.ahead.push_back(LineStart {
                        offset,
                        line,
                        quotes,
                    });
                }
                self.quotes += u64::from(byte == b'"');
            }
        }
        self.last = byte;
        self.offset += 1;
    }
}

impl<R: Read> Read for LineWatch<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.inner.read(buffer)?;
        self.ended |= n == 0 && !buffer.is_empty();
        for byte in buffer.iter().take(n) {
            self.see(*byte);
        }
        Ok(n)
    }
}
