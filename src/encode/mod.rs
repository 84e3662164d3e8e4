//! Formats: PNG, JPEG, EXR.
