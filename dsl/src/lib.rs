//! The Hierarq language: grammar, YAML reader, spanned tree and printers
