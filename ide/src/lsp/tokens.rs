//! Semantic highlighting, for distinctions that a pattern-based grammar cannot make.

use compiler::resolve::{FAULTS, Meaning, Resolution, SymbolKind};
use lsp_types::{SemanticToken, SemanticTokenType};

use super::document::Document;

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

fn kind(names: &Resolution, meaning: &Meaning) -> Option<u32> {
    Some(match meaning {
        Meaning::Key(_) => 0,
        Meaning::TaskType(_) => 1,
        Meaning::Parameter(..) | Meaning::Output(..) => 2,
        Meaning::Argument(_) => 6,
        Meaning::Symbol(id) => of_symbol(names.symbol(*id).kind),
        Meaning::Unknown(kind, _) => of_symbol(*kind),
        // Names with a value of their own are shown as constants; the others take arguments.
        Meaning::BuiltIn(name) if CONSTANTS.contains(&name.as_str()) => 5,
        Meaning::BuiltIn(name) if FAULTS.iter().any(|f| f.name == *name) => 5,
        Meaning::BuiltIn(_) | Meaning::Verb(_) => 4,
        Meaning::File(_) | Meaning::Unit(..) => return None,
    })
}

fn of_symbol(kind: SymbolKind) -> u32 {
    match kind {
        SymbolKind::Param | SymbolKind::Let | SymbolKind::Parameter => 6,
        SymbolKind::State | SymbolKind::Link | SymbolKind::Joint => 5,
        _ => 3,
    }
}

/// Tokens of a document, each relative to the previous one.
pub(super) fn of(document: &Document) -> Vec<SemanticToken> {
    let Some(names) = document.names() else { return Vec::new() };
    let mut out = Vec::new();
    let (mut line, mut column, mut end) = (0, 0, 0);
    for m in &names.references {
        let Some(token_type) = kind(names, &m.meaning).filter(|_| m.exact && m.place.start >= end) else { continue };
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
