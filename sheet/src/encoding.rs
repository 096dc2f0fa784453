//! From the bytes of a file to text.

use std::borrow::Cow;

use encoding_rs::{Encoding, UTF_8, WINDOWS_1252};

use super::Fault;

/// Returns the text of a file without the mark before it: UTF-8, UTF-16 with a mark, else Windows-1252, as Excel writes
/// it.
///
/// # Errors
///
/// [`Fault`] for what is no text, such as a workbook.
pub fn decode(bytes: &[u8]) -> Result<Cow<'_, str>, Fault> {
    let (encoding, mark) = Encoding::for_bom(bytes).unwrap_or((UTF_8, 0));
    let text = &bytes[mark..];
    let decode = |encoding: &'static Encoding| {
        encoding.decode_without_bom_handling_and_without_replacement(text)
    };
    let decoded = decode(encoding).or_else(|| (mark == 0).then(|| decode(WINDOWS_1252)).flatten());
    decoded
        .filter(|text| !text.contains('\0'))
        .ok_or_else(|| Fault::new(1, "not text; save it as CSV in UTF-8"))
}

/// Returns the text of a table with `\n` at the end of every line.
pub(super) fn with_line_feeds(text: &str) -> Cow<'_, str> {
    match text.contains('\r') {
        true => text.replace("\r\n", "\n").replace('\r', "\n").into(),
        false => text.into(),
    }
}
