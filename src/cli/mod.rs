//! What was typed and what it means: one verb a file.
