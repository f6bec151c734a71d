//! Semantic highlighting, for distinctions that a pattern-based grammar cannot make.

use lsp_types::{SemanticToken, SemanticTokenType};

use super::document::Document;
use super::mentions::{Class, What};
use super::vocabulary::FAULTS;

/// Types of tokens; the index is the number in a token.
pub(super) fn legend() -> Vec<SemanticTokenType> {
    vec![
        SemanticTokenType::KEYWORD,
        SemanticTokenType::TYPE,
        SemanticTokenType::PROPERTY,
        SemanticTokenType::VARIABLE,
        SemanticTokenType::FUNCTION,
        SemanticTokenType::ENUM_MEMBER,
        SemanticTokenType::PARAMETER,
    ]
}

/// Built-in names without arguments.
const CONSTANTS: &[&str] = &["pi", "t", "time", "true", "false"];

fn kind(what: &What) -> Option<u32> {
    Some(match what {
        What::Key(_) => 0,
        What::Kind(_) => 1,
        What::Parameter(..) | What::Told(..) => 2,
        What::Declared(Class::Param | Class::Let | Class::Argument, _) => 6,
        What::Brought(Class::Param | Class::Let, _) => 6,
        What::Declared(Class::State, _) => 5,
        What::Declared(..) | What::Brought(..) => 3,
        // Names with a value of their own are shown as constants; the others take arguments.
        What::BuiltIn(name) if CONSTANTS.contains(&name.as_str()) => 5,
        What::BuiltIn(name) if FAULTS.iter().any(|f| f.name == *name) => 5,
        What::BuiltIn(_) | What::Verb(_) => 4,
        What::Link(_) | What::Joint(_) => 5,
        What::File | What::Spec(_) | What::Unit(_) => return None,
    })
}

/// Tokens of a document, each relative to the previous one.
pub(super) fn of(document: &Document) -> Vec<SemanticToken> {
    let Some(analysis) = document.analysis() else { return Vec::new() };
    let mut out = Vec::new();
    let (mut line, mut column, mut end) = (0, 0, 0);
    for m in &analysis.mentions.all {
        let Some(token_type) = kind(&m.what).filter(|_| m.exact && m.place.start >= end) else { continue };
        let range = document.text.range(m.place.clone());
        if range.start.line != range.end.line || m.place.is_empty() {
            continue;
        }
        let delta_line = range.start.line - line;
        let delta_start = if delta_line == 0 { range.start.character - column } else { range.start.character };
        let length = range.end.character - range.start.character;
        out.push(SemanticToken { delta_line, delta_start, length, token_type, token_modifiers_bitset: 0 });
        (line, column, end) = (range.start.line, range.start.character, m.place.end);
    }
    out
}
