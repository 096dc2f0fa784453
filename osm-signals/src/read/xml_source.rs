//! The bytes under the XML reader: counted as they are stored, bounded per event.

use std::cell::Cell;
use std::io::{self, BufRead, Read};
use std::rc::Rc;

/// Most bytes of a tag or text, which has to fit into memory.
const MAX_EVENT_BYTES: usize = 16 * 1024 * 1024;

/// Counts the bytes of a file as they are used up.
pub(super) struct Counted<R> {
    /// The file.
    pub(super) inner: R,
    /// The count, shared with who tells the progress.
    pub(super) bytes: Rc<Cell<u64>>,
}

impl<R: BufRead> Read for Counted<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.inner.read(buffer)?;
        self.bytes.set(self.bytes.get() + n as u64);
        Ok(n)
    }
}

impl<R: BufRead> BufRead for Counted<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        self.inner.fill_buf()
    }

    fn consume(&mut self, n: usize) {
        self.bytes.set(self.bytes.get() + n as u64);
        self.inner.consume(n);
    }
}

/// Refuses to go on when too much was read since [`Bounded::reset`].
pub(super) struct Bounded<R> {
    inner: R,
    left: usize,
}

impl<R> Bounded<R> {
    pub(super) fn new(inner: R) -> Self {
        Self { inner, left: MAX_EVENT_BYTES }
    }

    /// Starts a new event.
    pub(super) fn reset(&mut self) {
        self.left = MAX_EVENT_BYTES;
    }
}

impl<R: BufRead> Read for Bounded<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.fill_buf()?.read(buffer)?;
        self.consume(n);
        Ok(n)
    }
}

impl<R: BufRead> BufRead for Bounded<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.left == 0 {
            let reason = format!("a tag or text of more than {MAX_EVENT_BYTES} bytes");
            return Err(io::Error::new(io::ErrorKind::InvalidData, reason));
        }
        let bytes = self.inner.fill_buf()?;
        Ok(&bytes[..bytes.len().min(self.left)])
    }

    fn consume(&mut self, n: usize) {
        self.left = self.left.saturating_sub(n);
        self.inner.consume(n);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tag_without_end_is_cut_off() {
        let mut endless = Bounded::new(io::BufReader::new(io::repeat(b'x')));
        let mut text = Vec::new();
        let error = endless.read_until(b'>', &mut text).unwrap_err();
        assert_eq!(error.to_string(), "a tag or text of more than 16777216 bytes");
        endless.reset();
        assert_eq!(endless.fill_buf().unwrap()[0], b'x');
    }
}
