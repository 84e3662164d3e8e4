//! JSON with places: a parser with limits whose values know where they stood, and a check against a schema that reports
//! every problem with its path.
//!
//! Three steps, so that nothing is believed before it is checked: the text becomes [`Node`]s under the limits of its
//! [`Size`]; the nodes are checked against a [`Rule`] made from the published schema; only then serde builds the message.

mod check;
mod node;
mod parse;
mod problem;
mod rule;

pub use node::{Kind, Node};
pub use parse::{Parsed, Size, parse};
pub use problem::{Complaint, Problem};
pub use rule::Rule;

#[cfg(test)]
mod tests;
