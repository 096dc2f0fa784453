//! The fields of a protobuf message, one after the other and without copies, so that what is not
//! needed of a block costs nothing.

use protobuf::CodedInputStream;

use super::Fault;

/// Bits of a field's key that say how its value is written.
const WIRE_BITS: u32 = 3;

/// The value of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Value<'a> {
    /// An integer or boolean.
    Number(u64),
    /// Text, bytes, a message or packed numbers.
    Bytes(&'a [u8]),
    /// A number of fixed width, which OpenStreetMap's messages do not have.
    Fixed,
}

/// Fields of a message: their numbers and values.
pub(super) struct Fields<'a> {
    bytes: &'a [u8],
    input: CodedInputStream<'a>,
}

impl<'a> Fields<'a> {
    /// Returns the fields of a message.
    pub(super) fn of(bytes: &'a [u8]) -> Self {
        Self { bytes, input: CodedInputStream::from_bytes(bytes) }
    }

    fn value(&mut self, wire: u32) -> Result<Value<'a>, Fault> {
        Ok(match wire {
            0 => Value::Number(self.input.read_raw_varint64()?),
            1 => self.input.skip_raw_bytes(8).map(|()| Value::Fixed)?,
            2 => {
                let length = self.input.read_raw_varint32()?;
                let start = self.input.pos() as usize;
                let bytes = self.bytes.get(start..).and_then(|rest| rest.get(..length as usize));
                self.input.skip_raw_bytes(length)?;
                Value::Bytes(bytes.ok_or("the data ends within a field")?)
            }
            5 => self.input.skip_raw_bytes(4).map(|()| Value::Fixed)?,
            _ => return Err("the data is garbled (no such type of a field)".into()),
        })
    }
}

impl<'a> Iterator for Fields<'a> {
    type Item = Result<(u32, Value<'a>), Fault>;

    fn next(&mut self) -> Option<Self::Item> {
        let key = self.input.read_raw_tag_or_eof().map_err(Fault::from).transpose()?;
        Some(key.and_then(|key| {
            if key >> WIRE_BITS == 0 {
                return Err("the data is garbled (a field without a number)".into());
            }
            let value = self.value(key & ((1 << WIRE_BITS) - 1))?;
            Ok((key >> WIRE_BITS, value))
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_found_without_copies() {
        let bytes = [0x08, 0x96, 0x01, 0x12, 2, b'h', b'i', 0x1d, 0, 0, 0, 0];
        let fields: Vec<_> = Fields::of(&bytes).map(Result::unwrap).collect();
        let expected = [(1, Value::Number(150)), (2, Value::Bytes(b"hi")), (3, Value::Fixed)];
        assert_eq!(fields, expected);
    }

    #[test]
    fn cut_off_fields_are_faults() {
        for bytes in [
            &[0x08][..],
            &[0x12, 2, 0],
            &[0x12, 0xff, 0xff, 0xff, 0xff, 0x0f],
            &[0x0b],
            &[0x80; 11],
        ] {
            assert!(Fields::of(bytes).any(|field| field.is_err()), "{bytes:?}");
        }
    }
}
