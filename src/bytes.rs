//! Bytes: a reader that cannot run past its end and a writer; the only byte arithmetic in the house.

/// Fewer bytes are there than were asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{needed} bytes are needed at offset {offset}, {left} are left")]
pub struct TooShort {
    /// Where the reader stood.
    pub offset: usize,
    /// Bytes asked for.
    pub needed: usize,
    /// Bytes left.
    pub left: usize,
}

/// Reads numbers from bytes, from the front.
#[derive(Clone, Debug)]
pub struct Reader<'a> {
    bytes: &'a [u8],
    offset: usize,
}

/// Writes numbers behind one another.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Writer {
    bytes: Vec<u8>,
}

/// One method a number type and byte order, for reader and writer alike.
macro_rules! numbers {
    ($($read_le:ident $read_be:ident $write_le:ident $write_be:ident $kind:ty, $name:literal;)+) => {
        impl Reader<'_> {
            $(
                #[doc = concat!("The next ", $name, ", least significant byte first.")]
                ///
                /// # Errors
                /// [`TooShort`]: nothing was read.
                pub fn $read_le(&mut self) -> Result<$kind, TooShort> {
                    self.array().map(<$kind>::from_le_bytes)
                }

                #[doc = concat!("The next ", $name, ", most significant byte first.")]
                ///
                /// # Errors
                /// [`TooShort`]: nothing was read.
                pub fn $read_be(&mut self) -> Result<$kind, TooShort> {
                    self.array().map(<$kind>::from_be_bytes)
                }
            )+
        }

        impl Writer {
            $(
                #[doc = concat!("Appends a ", $name, ", least significant byte first.")]
                pub fn $write_le(&mut self, value: $kind) {
                    self.bytes.extend_from_slice(&value.to_le_bytes());
                }

                #[doc = concat!("Appends a ", $name, ", most significant byte first.")]
                pub fn $write_be(&mut self, value: $kind) {
                    self.bytes.extend_from_slice(&value.to_be_bytes());
                }
            )+
        }
    };
}

numbers! {
    u16_le u16_be put_u16_le put_u16_be u16, "16-bit number without sign";
    u32_le u32_be put_u32_le put_u32_be u32, "32-bit number without sign";
    u64_le u64_be put_u64_le put_u64_be u64, "64-bit number without sign";
    i16_le i16_be put_i16_le put_i16_be i16, "16-bit number with sign";
    i32_le i32_be put_i32_le put_i32_be i32, "32-bit number with sign";
    f32_le f32_be put_f32_le put_f32_be f32, "32-bit float";
    f64_le f64_be put_f64_le put_f64_be f64, "64-bit float";
}

impl<'a> Reader<'a> {
    /// A reader at the front of these bytes.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, offset: 0 }
    }

    /// Bytes read so far.
    pub fn offset(&self) -> usize {
        self.offset
    }

    /// The bytes not read yet.
    pub fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.offset..).unwrap_or_default()
    }

    /// The next bytes.
    ///
    /// # Errors
    /// [`TooShort`]: nothing was read.
    pub fn take(&mut self, length: usize) -> Result<&'a [u8], TooShort> {
        let rest = self.rest();
        match rest.get(..length) {
            Some(taken) => {
                self.offset += length;
                Ok(taken)
            }
            None => Err(TooShort { offset: self.offset, needed: length, left: rest.len() }),
        }
    }

    /// The next byte.
    ///
    /// # Errors
    /// [`TooShort`]: nothing was read.
    pub fn u8(&mut self) -> Result<u8, TooShort> {
        self.array().map(|[byte]| byte)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], TooShort> {
        let short = TooShort { offset: self.offset, needed: N, left: self.rest().len() };
        self.take(N)?.try_into().map_err(|_| short)
    }
}

impl Writer {
    /// A writer with room for so many bytes.
    pub fn with_capacity(bytes: usize) -> Self {
        Self { bytes: Vec::with_capacity(bytes) }
    }

    /// Appends a byte.
    pub fn put_u8(&mut self, value: u8) {
        self.bytes.push(value);
    }

    /// Appends bytes as they are.
    pub fn put(&mut self, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
    }

    /// Appends a text filled up with zeros to a fixed length; what is beyond it is cut off.
    pub fn put_padded(&mut self, text: &[u8], length: usize) {
        let text = &text[..text.len().min(length)];
        self.bytes.extend_from_slice(text);
        self.bytes.resize(self.bytes.len() + length - text.len(), 0);
    }

    /// Bytes written so far.
    pub fn len(&self) -> usize {
        self.bytes.len()
    }

    /// Whether nothing was written yet.
    pub fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// The bytes.
    pub fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back_in_both_byte_orders() {
        let mut writer = Writer::with_capacity(8);
        writer.put_u8(0xab);
        writer.put_u16_le(0x0102);
        writer.put_u16_be(0x0102);
        writer.put_u32_le(0x0102_0304);
        writer.put_u64_be(u64::MAX - 1);
        writer.put_i16_be(-2);
        writer.put_i32_le(i32::MIN);
        writer.put_f32_be(-0.5);
        writer.put_f64_le(std::f64::consts::PI);
        writer.put_padded(b"ab", 4);
        writer.put_padded(b"abcdef", 4);
        let bytes = writer.into_bytes();
        assert_eq!(bytes[..9], [0xab, 2, 1, 1, 2, 4, 3, 2, 1]);
        let mut reader = Reader::new(&bytes);
        assert_eq!(reader.u8(), Ok(0xab));
        assert_eq!((reader.u16_le(), reader.u16_be()), (Ok(0x0102), Ok(0x0102)));
        assert_eq!(reader.u32_le(), Ok(0x0102_0304));
        assert_eq!(reader.u64_be(), Ok(u64::MAX - 1));
        assert_eq!((reader.i16_be(), reader.i32_le()), (Ok(-2), Ok(i32::MIN)));
        assert_eq!((reader.f32_be(), reader.f64_le()), (Ok(-0.5), Ok(std::f64::consts::PI)));
        assert_eq!(reader.take(8), Ok(&b"ab\0\0abcd"[..]));
        assert_eq!((reader.offset(), reader.rest()), (bytes.len(), &[][..]));
    }

    #[test]
    fn a_reader_stays_where_it_is_when_too_little_is_left() {
        let mut reader = Reader::new(&[1, 2, 3]);
        assert_eq!(reader.u32_le(), Err(TooShort { offset: 0, needed: 4, left: 3 }));
        assert_eq!(reader.u16_be(), Ok(0x0102));
        assert_eq!(reader.take(usize::MAX), Err(TooShort { offset: 2, needed: usize::MAX, left: 1 }));
        assert_eq!(reader.u8(), Ok(3));
        assert_eq!(reader.u8(), Err(TooShort { offset: 3, needed: 1, left: 0 }));
    }
}
