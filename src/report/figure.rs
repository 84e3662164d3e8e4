//! A picture of the HTML page: PNG bytes with a caption, embedded so that the page stays one file.

/// A picture with its caption.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Subject it belongs to; filled in when it is recorded.
    pub(super) subject: String,
    /// Title, one line.
    pub title: String,
    /// What is to be seen.
    pub caption: String,
    /// A PNG file.
    pub png: Vec<u8>,
}

impl Figure {
    /// A picture from the bytes of a PNG file.
    pub fn png(title: impl Into<String>, caption: impl Into<String>, png: Vec<u8>) -> Self {
        Self { subject: String::new(), title: title.into(), caption: caption.into(), png }
    }

    /// As the address of an image that needs no network.
    pub(super) fn address(&self) -> String {
        format!("data:image/png;base64,{}", base64(&self.png))
    }
}

/// Base64 with padding (RFC 4648, section 4).
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let word = group.iter().enumerate().fold(0u32, |word, (i, byte)| word | u32::from(*byte) << (16 - 8 * i));
        for i in 0..4 {
            let letter = LETTERS[(word >> (18 - 6 * i)) as usize & 63];
            text.push(if i <= group.len() { letter as char } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_rfc_4648() {
        // The test vectors of its section 10.
        for (plain, coded) in
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("foobar", "Zm9vYmFy")]
        {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
        assert_eq!(base64(&[0xff, 0xfe, 0xfd]), "//79");
    }
}
