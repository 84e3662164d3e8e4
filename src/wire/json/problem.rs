//! Problems: what is wrong at which place of a JSON text.

use crate::world::event::Refused;

/// What is wrong, with the place as an offset into the text.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// Byte offset of the value (or of the key, for an unknown field).
    pub offset: usize,
    /// What a client is told.
    pub refused: Refused,
}

/// What is wrong in a file, in the words that a person needs to mend it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Complaint {
    /// Path of the field, as in `entries[3].layers[0].base_m`; empty for the whole text.
    pub path: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// What is wrong with which value, and what is allowed.
    pub why: String,
}

impl std::fmt::Display for Complaint {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "line {}, column {}: ", self.line, self.column)?;
        if !self.path.is_empty() {
            write!(f, "{}: ", self.path)?;
        }
        f.write_str(&self.why)
    }
}

impl Problem {
    /// The problem as a complaint about this text.
    pub fn in_text(self, text: &str) -> Complaint {
        let before = text.get(..self.offset).unwrap_or(text);
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let Refused { field, value, limit, why } = self.refused;
        Complaint {
            path: field,
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            why: format!("{why} (found {value}; allowed: {limit})"),
        }
    }
}
