//! Bends inputs: bits, bytes, numbers at their limits, pieces taken out, doubled, or put in from another input.

/// Numbers that only look random (xorshift64*), and what is done with them.
pub struct Mutator(u64);

/// Bytes at which numbers begin to mean something else.
const EDGES: [u8; 8] = [0x00, 0x01, 0x7f, 0x80, 0xff, 0x08, 0x18, b'"'];

impl Mutator {
    /// From a seed other than 0.
    pub fn new(seed: u64) -> Self {
        Self(seed.max(1))
    }

    fn roll(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    fn below(&mut self, limit: usize) -> usize {
        (self.roll() >> 16) as usize % limit.max(1)
    }

    /// One of the corpus, bent one to eight times, at most so long.
    pub fn bend(&mut self, corpus: &[Vec<u8>], longest: usize) -> Vec<u8> {
        let mut input = corpus[self.below(corpus.len())].clone();
        for _ in 0..=self.below(8) {
            self.once(&mut input, corpus);
        }
        input.truncate(longest);
        input
    }

    fn once(&mut self, input: &mut Vec<u8>, corpus: &[Vec<u8>]) {
        let at = self.below(input.len());
        let length = 1 + self.below(32.min(input.len().saturating_sub(at)));
        match self.below(8) {
            _ if input.is_empty() => input.push(self.roll() as u8),
            0 => input[at] ^= 1 << self.below(8),
            1 => input[at] = EDGES[self.below(EDGES.len())],
            2 => input[at] = input[at].wrapping_add(self.below(17) as u8).wrapping_sub(8),
            3 => {
                input.drain(at..at + length);
            }
            4 => {
                let piece = input[at..at + length].to_vec();
                let to = self.below(input.len() + 1);
                input.splice(to..to, piece);
            }
            5 => {
                let other = &corpus[self.below(corpus.len())];
                let from = self.below(other.len());
                let until = (from + 1 + self.below(64)).min(other.len());
                let to = self.below(input.len() + 1);
                input.splice(to..to, other[from.min(until)..until].iter().copied());
            }
            6 => input.truncate(at),
            _ => {
                for byte in &mut input[at..at + length] {
                    *byte = EDGES[(self.0 % 5) as usize];
                }
            }
        }
    }
}
