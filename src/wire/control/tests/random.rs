//! No text at all makes the decoder panic.

use super::{decode, examples};

/// Counter-based random numbers (splitmix64): the same sequence in each run.
fn random(counter: &mut u64) -> u64 {
    *counter = counter.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut x = *counter;
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[test]
fn random_and_mutated_texts_are_refused_or_decoded_and_never_panic() {
    let mut counter = 1;
    let alphabet = b"{}[]\",:\\0123456789.eE+-ntfu \x00\xc3\xa9type";
    let mut refused = 0;
    for _ in 0..3000 {
        let length = random(&mut counter) % 60;
        let bytes: Vec<u8> = (0..length).map(|_| alphabet[random(&mut counter) as usize % alphabet.len()]).collect();
        refused += usize::from(decode(&String::from_utf8_lossy(&bytes)).is_err());
    }
    for example in examples() {
        let text = example.to_string();
        for _ in 0..300 {
            let mut bytes = text.clone().into_bytes();
            for _ in 0..1 + random(&mut counter) % 3 {
                let at = random(&mut counter) as usize % bytes.len();
                match random(&mut counter) % 3 {
                    0 => bytes[at] = alphabet[random(&mut counter) as usize % alphabet.len()],
                    1 => bytes.truncate(at.max(1)),
                    _ => bytes.insert(at, alphabet[random(&mut counter) as usize % alphabet.len()]),
                }
            }
            refused += usize::from(decode(&String::from_utf8_lossy(&bytes)).is_err());
        }
        for end in 0..text.len() {
            assert!(decode(&text[..end]).is_err(), "{}", &text[..end]);
        }
    }
    assert!(refused > 5000, "only {refused} were refused");
}
