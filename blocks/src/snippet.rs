//! Pieces of a spec in the help of a message, in both syntaxes of the language: `serve 20 s` of a `*.hq` file is
//! `serve: 20 s` in YAML. A [`Help`] is a sentence with such pieces; it is shown in the syntax of the user's file.

use std::fmt;
use std::ops::Deref;

/// A piece of a spec, in both syntaxes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Snippet {
    native: String,
    yaml: String,
}

impl Snippet {
    /// A piece that both syntaxes write alike.
    pub fn same(text: impl Into<String>) -> Snippet {
        let native = text.into();
        Snippet { yaml: native.clone(), native }
    }

    /// A piece in each of the syntaxes.
    pub fn each(native: impl Into<String>, yaml: impl Into<String>) -> Snippet {
        Snippet { native: native.into(), yaml: yaml.into() }
    }

    /// A value: in YAML a list with a unit, and a call, are in quotes.
    pub fn value(text: impl Into<String>) -> Snippet {
        let text = text.into();
        Snippet { yaml: value_in_yaml(&text), native: text }
    }

    /// `key value`
    pub fn entry(key: impl fmt::Display, value: impl Into<String>) -> Snippet {
        Snippet::entry_of(key, Snippet::value(value))
    }

    /// `key value`, whose value is a piece with a form of its own.
    pub fn entry_of(key: impl fmt::Display, value: Snippet) -> Snippet {
        Snippet::each(format!("{key} {}", value.native), format!("{key}: {}", value.yaml))
    }

    /// `key { .. }`
    pub fn block(key: impl fmt::Display, parts: impl IntoIterator<Item = Snippet>) -> Snippet {
        Snippet::entry_of(key, Snippet::braces(parts))
    }

    /// `{ .. }`
    pub fn braces(parts: impl IntoIterator<Item = Snippet>) -> Snippet {
        let inner = Snippet::parts(parts);
        Snippet::each(format!("{{ {} }}", inner.native), format!("{{ {} }}", inner.yaml))
    }

    /// Entries beside each other.
    pub fn parts(parts: impl IntoIterator<Item = Snippet>) -> Snippet {
        let (native, yaml): (Vec<String>, Vec<String>) = parts.into_iter().map(|p| (p.native, p.yaml)).unzip();
        Snippet::each(native.join("  "), yaml.join(", "))
    }

    /// `..`, for parts that are left out.
    pub fn dots() -> Snippet {
        Snippet::same("..")
    }

    /// A declaration with a name and a block: `robot NAME { .. }`, in YAML `robots: { NAME: { .. } }`.
    pub fn declared(word: &str, name: impl fmt::Display, parts: impl IntoIterator<Item = Snippet>) -> Snippet {
        let body = Snippet::braces(parts);
        Snippet::each(format!("{word} {name} {}", body.native), format!("{word}s: {{ {name}: {} }}", body.yaml))
    }

    /// A declaration with a value: `param NAME = VALUE`, in YAML `params: { NAME: VALUE }`.
    pub fn defined(word: &str, name: impl fmt::Display, value: impl Into<String>) -> Snippet {
        let value = Snippet::value(value);
        Snippet::each(format!("{word} {name} = {}", value.native), format!("{word}s: {{ {name}: {} }}", value.yaml))
    }

    /// A declaration whose type has a block: `task NAME = TYPE { .. }`, in YAML `tasks: { NAME: { TYPE: { .. } } }`.
    pub fn typed(word: &str, name: impl fmt::Display, ty: &str, parts: impl IntoIterator<Item = Snippet>) -> Snippet {
        let body = Snippet::block(ty, parts);
        Snippet::each(format!("{word} {name} = {}", body.native), format!("{word}s: {{ {name}: {{ {} }} }}", body.yaml))
    }

    /// A declaration with a type: `signal NAME : flag`, in YAML `signals: { NAME: flag }`.
    pub fn of_type(word: &str, name: impl fmt::Display, ty: impl fmt::Display) -> Snippet {
        Snippet::each(format!("{word} {name} : {ty}"), format!("{word}s: {{ {name}: {ty} }}"))
    }

    /// A level of a stack: `level NAME hard { task }`.
    pub fn level(name: impl fmt::Display, hard: bool, task: impl fmt::Display) -> Snippet {
        let (native, yaml) = if hard { (" hard", ", hard: true") } else { ("", "") };
        Snippet::each(
            format!("level {name}{native} {{ {task} }}"),
            format!("{{ name: {name}{yaml}, tasks: [{task}] }}"),
        )
    }

    /// A transition of a state: `on EVENT -> STATE`, in YAML `{ on: EVENT, to: STATE }`.
    pub fn transition(event: &str, to: impl fmt::Display) -> Snippet {
        Snippet::each(format!("on {event} -> {to}"), format!("{{ on: {event}, to: {to} }}"))
    }

    /// A transition of a state while something holds: `when CONDITION -> STATE`, in YAML `{ when: CONDITION, to: STATE }`.
    pub fn transition_when(condition: &str, to: impl fmt::Display) -> Snippet {
        Snippet::each(format!("when {condition} -> {to}"), format!("{{ when: {condition}, to: {to} }}"))
    }

    /// The piece as an item of a list that the key of its block holds in YAML: `levels: [ .. ]`.
    #[must_use]
    pub fn listed(self, key: &str) -> Snippet {
        Snippet { yaml: format!("{key}: [ {} ]", self.yaml), ..self }
    }

    /// The piece as `*.hq` files write it.
    pub fn native(&self) -> &str {
        &self.native
    }

    /// The piece as YAML files write it.
    pub fn yaml(&self) -> &str {
        &self.yaml
    }
}

/// Converts a value: in YAML a list with a unit behind it, a call and an expression are texts.
fn value_in_yaml(text: &str) -> String {
    let unquoted = match text.as_bytes().first() {
        Some(b'[') => text.ends_with(']'),
        Some(b'"' | b'{' | b'0'..=b'9' | b'-' | b'.') => true,
        _ => !text.contains([' ', '(', ',']),
    };
    if unquoted { text.to_string() } else { format!("\"{text}\"") }
}

/// A proposed correction in words, with pieces of a spec.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Help {
    text: String,
    /// The sentence for a YAML file, if it is another one.
    yaml: Option<String>,
}

impl Help {
    /// A sentence for each of the syntaxes.
    pub fn each(native: impl Into<String>, yaml: impl Into<String>) -> Help {
        let (text, yaml) = (native.into(), yaml.into());
        Help { yaml: (yaml != text).then_some(yaml), text }
    }

    /// A sentence with a piece of a spec at each `{}`.
    pub fn with(sentence: &str, pieces: impl IntoIterator<Item = Snippet>) -> Help {
        let (mut text, mut yaml) = (String::new(), String::new());
        let mut words = sentence.split("{}");
        let first = words.next().unwrap_or_default();
        text.push_str(first);
        yaml.push_str(first);
        let mut pieces = pieces.into_iter();
        for words in words {
            // Without a piece it is a part of the sentence, for instance of the name of a file.
            let (native, inner) = pieces.next().map_or_else(
                || ("{}".to_string(), "{}".to_string()),
                |piece| (format!("`{}`", piece.native), format!("`{}`", piece.yaml)),
            );
            text.push_str(&format!("{native}{words}"));
            yaml.push_str(&format!("{inner}{words}"));
        }
        Help::each(text, yaml)
    }

    /// "write `..`", with a piece of a spec.
    pub fn write(piece: Snippet) -> Help {
        Help::with("write {}", [piece])
    }

    /// "write for instance `..`", with a piece of a spec.
    pub fn write_for_instance(piece: Snippet) -> Help {
        Help::with("write for instance {}", [piece])
    }

    /// The sentence for a YAML file.
    #[must_use]
    pub fn in_yaml(self) -> Help {
        Help { text: self.yaml.unwrap_or(self.text), yaml: None }
    }

    /// The sentence for a `*.hq` file.
    #[must_use]
    pub fn in_native(self) -> Help {
        Help { yaml: None, ..self }
    }
}

impl Deref for Help {
    type Target = str;
    fn deref(&self) -> &str {
        &self.text
    }
}

impl fmt::Display for Help {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl From<&str> for Help {
    fn from(text: &str) -> Help {
        Help { text: text.into(), yaml: None }
    }
}

impl From<String> for Help {
    fn from(text: String) -> Help {
        Help { text, yaml: None }
    }
}

impl From<Snippet> for Help {
    fn from(piece: Snippet) -> Help {
        Help::write(piece)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_in_both_syntaxes() {
        let skills = || Snippet::block("skills", [Snippet::entry("SKILL", "2 s")]);
        for (piece, native, yaml) in [
            (Snippet::entry("serve", "20 s"), "serve 20 s", "serve: 20 s"),
            (Snippet::entry("depot", "[4, -1.5] m"), "depot [4, -1.5] m", "depot: \"[4, -1.5] m\""),
            (Snippet::entry("features", "[cube, red]"), "features [cube, red]", "features: [cube, red]"),
            (
                Snippet::entry("duration", "normal(204 s, 20 s)"),
                "duration normal(204 s, 20 s)",
                "duration: \"normal(204 s, 20 s)\"",
            ),
            (Snippet::braces([Snippet::entry("at", ".."), Snippet::dots()]), "{ at ..  .. }", "{ at: .., .. }"),
            (
                Snippet::declared("robot", "NAME", [Snippet::entry("serve", "20 s"), skills()]),
                "robot NAME { serve 20 s  skills { SKILL 2 s } }",
                "robots: { NAME: { serve: 20 s, skills: { SKILL: 2 s } } }",
            ),
            (
                Snippet::typed("task", "NAME", "TYPE", [Snippet::dots()]),
                "task NAME = TYPE { .. }",
                "tasks: { NAME: { TYPE: { .. } } }",
            ),
            (
                Snippet::declared("stack", "NAME", [Snippet::level("l", true, "t").listed("levels")]),
                "stack NAME { level l hard { t } }",
                "stacks: { NAME: { levels: [ { name: l, hard: true, tasks: [t] } ] } }",
            ),
            (Snippet::defined("param", "NAME", "VALUE"), "param NAME = VALUE", "params: { NAME: VALUE }"),
            (Snippet::of_type("signal", "work", "flag"), "signal work : flag", "signals: { work: flag }"),
        ] {
            assert_eq!((piece.native(), piece.yaml()), (native, yaml));
        }
    }

    #[test]
    fn a_help_shows_the_syntax_of_the_file() {
        let help = Help::with("write {}, or {}", [Snippet::entry("a", "1"), Snippet::same("b")]);
        assert_eq!(&*help, "write `a 1`, or `b`");
        assert_eq!(&*help.clone().in_native(), "write `a 1`, or `b`");
        assert_eq!(&*help.in_yaml(), "write `a: 1`, or `b`");
        assert_eq!(&*Help::from("as it is").in_yaml(), "as it is");
        assert_eq!(&*Help::with("write {} in `a{}b.hq`", [Snippet::entry("a", "1")]), "write `a 1` in `a{}b.hq`");
    }
}
