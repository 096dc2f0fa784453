//! From the bytes of a file to text: UTF-8 with or without a mark before it, and UTF-16.

use std::borrow::Cow;

use super::fault::Fault;

/// Marks before text: of UTF-8, of UTF-16 with the low byte first, and with the high byte first.
const MARKS: [&[u8]; 3] = [b"\xef\xbb\xbf", b"\xff\xfe", b"\xfe\xff"];

/// How files start that hold something else, and what they are.
const OTHERS: [(&[u8], &str); 3] = [
    (
        b"PK\x03\x04",
        "a ZIP archive or a workbook such as .xlsx; unpack it first, or save the sheet as CSV",
    ),
    (b"\x1f\x8b", "gzip data; unpack it first"),
    (b"\xd0\xcf\x11\xe0", "an Excel workbook; save the sheet as CSV"),
];

/// Bytes from which UTF-16 without a mark is told by its zeros.
const LOOKED_AT: usize = 4096;

/// Returns the text of a file, without the mark before it.
///
/// # Errors
///
/// [`Fault`] with the line for what is no text, and what it probably is.
pub fn decode(bytes: &[u8]) -> Result<Cow<'_, str>, Fault> {
    for (start, what) in OTHERS {
        if bytes.starts_with(start) {
            return Err(Fault::new(1, what));
        }
    }
    let [utf8, low, high] = MARKS;
    if let Some(rest) = bytes.strip_prefix(low) {
        return utf16(rest, u16::from_le_bytes).map(Cow::Owned);
    }
    if let Some(rest) = bytes.strip_prefix(high) {
        return utf16(rest, u16::from_be_bytes).map(Cow::Owned);
    }
    let bytes = bytes.strip_prefix(utf8).unwrap_or(bytes);
    if bytes.contains(&0) {
        // Letters of tables are mostly ASCII, one byte of two is 0 then.
        let start = &bytes[..bytes.len().min(LOOKED_AT)];
        let zeros = |odd| start.iter().skip(odd).step_by(2).filter(|b| **b == 0).count();
        return match (zeros(0), zeros(1)) {
            (0, n) if 4 * n > start.len() => utf16(bytes, u16::from_le_bytes).map(Cow::Owned),
            (n, 0) if 4 * n > start.len() => utf16(bytes, u16::from_be_bytes).map(Cow::Owned),
            _ => Err(Fault::new(line_at(bytes, 0), "binary data, not text; give a text file")),
        };
    }
    std::str::from_utf8(bytes).map(Cow::Borrowed).map_err(|e| {
        let byte = bytes[e.valid_up_to()];
        let message = format!(
            "not UTF-8 text but probably Windows-1252 or Latin-1 (byte {byte:02X}); save the file as UTF-8, such as with \
             `iconv -f WINDOWS-1252 -t UTF-8`"
        );
        Fault { line: 1 + lines(&bytes[..e.valid_up_to()]), message }
    })
}

fn utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> Result<String, Fault> {
    let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
    let mut text = String::with_capacity(bytes.len() / 2);
    for letter in char::decode_utf16(units) {
        let Ok(letter) = letter else {
            let line = 1 + lines(text.as_bytes());
            return Err(Fault::new(line, "broken UTF-16 text; save the file as UTF-8"));
        };
        text.push(letter);
    }
    match bytes.len() % 2 {
        0 => Ok(text),
        _ => Err(Fault::new(
            1 + lines(text.as_bytes()),
            "UTF-16 text that ends within a letter; save the file as UTF-8",
        )),
    }
}

/// Returns the line of the first such byte.
fn line_at(bytes: &[u8], byte: u8) -> u64 {
    let at = bytes.iter().position(|b| *b == byte).unwrap_or(0);
    1 + lines(&bytes[..at])
}

/// Returns a text whose lines end with `\r`, as on old machines, with `\n` in its place; `None` where none does. The
/// reader would take all that follows a comment for the comment.
pub(super) fn with_line_feeds(text: &str) -> Option<String> {
    let bytes = text.as_bytes();
    let is_alone = |at: usize| bytes[at] == b'\r' && bytes.get(at + 1) != Some(&b'\n');
    if !(0..bytes.len()).any(is_alone) {
        return None;
    }
    let letters = text.char_indices();
    Some(letters.map(|(at, letter)| if is_alone(at) { '\n' } else { letter }).collect())
}

/// Returns how many lines end in a text: with `\n`, `\r\n` or, as on old machines, `\r`.
pub(super) fn lines(text: &[u8]) -> u64 {
    let ends = |(i, byte): (usize, &u8)| match byte {
        b'\n' => true,
        b'\r' => text.get(i + 1) != Some(&b'\n'),
        _ => false,
    };
    text.iter().enumerate().filter(|at| ends(*at)).count() as u64
}
