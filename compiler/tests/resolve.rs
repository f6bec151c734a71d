//! The symbols and references of every example: they are those of the compilation.

use std::path::{Path, PathBuf};
use std::rc::Rc;

use dsl::Syntax;
use dsl::holes::{self, Part};
use hierarq_compiler::resolve::{FileId, Meaning, Resolution, SymbolId, SymbolKind, read_urdf, resolve};
use hierarq_compiler::{Compiled, Input, Texts, compile};

/// All specs of the examples and of the corpus.
fn specs() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let folders = ["examples", "examples/common", "tests/corpus/specs"];
    let files = folders.iter().flat_map(|f| std::fs::read_dir(root.join(f)).expect("a folder"));
    let mut all: Vec<PathBuf> = files.map(|e| e.expect("an entry").path()).collect();
    all.retain(|p| Syntax::of_path(p).is_some());
    all.sort();
    assert!(all.len() > 60, "{}", all.len());
    all
}

fn with_input<T>(path: &Path, text: &str, f: impl FnOnce(&Input) -> T) -> T {
    let (name, syntax) = (path.display().to_string(), Syntax::of_path(path).expect("a spec"));
    // The specs of the corpus name the robots of the examples.
    let folder = match path.parent().expect("a folder") {
        f if f.ends_with("corpus/specs") => Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples"),
        f => f.to_path_buf(),
    };
    f(&Input { name: &name, text, syntax, folder: &folder, set: &[], package_paths: &[] })
}

fn resolved(path: &Path, text: &str) -> Resolution {
    with_input(path, text, |input| resolve(input, &Texts::new(), &|urdf| read_urdf(urdf).map(Rc::new)))
}

fn compiled(path: &Path, text: &str) -> Compiled {
    with_input(path, text, compile)
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).expect("readable")
}

/// Names with holes are those of several declarations.
fn has_holes(name: &str) -> bool {
    name.contains("${")
}

#[test]
fn every_name_of_an_example_is_known_and_stands_where_it_is_said() {
    let mut unknown = Vec::new();
    for path in specs() {
        let text = read(&path);
        let names = resolved(&path, &text);
        for r in &names.references {
            let written = text.get(r.place.clone()).expect("whole characters");
            match &r.meaning {
                Meaning::Unknown(kind, name) => {
                    let line = text[..r.place.start].matches('\n').count() + 1;
                    unknown.push(format!("{}:{line}: {} `{name}`", path.display(), kind.word()));
                }
                Meaning::File(file) => assert!(file.is_some(), "{}: {written}", path.display()),
                Meaning::Symbol(id) if r.exact => {
                    let symbol = names.symbol(*id);
                    let good = written == symbol.name || has_holes(&symbol.name) || symbol.kind == SymbolKind::Outcome;
                    assert!(good, "{}: `{written}` is no `{}`", path.display(), symbol.name);
                }
                _ => {}
            }
        }
        for symbol in names.symbols.iter().filter(|s| s.kind != SymbolKind::Outcome) {
            let text = names.text(&names.files[symbol.file.0]);
            assert_eq!(text.get(symbol.place.clone()), Some(symbol.name.as_str()), "{}", path.display());
        }
    }
    assert!(unknown.is_empty(), "{}", unknown.join("\n"));
}

/// The compiled program as text.
fn program(compiled: &Compiled) -> String {
    format!("{:?} {:?}", compiled.program, compiled.missions)
}

/// Renames a symbol in all exact references of the spec.
fn renamed(text: &str, names: &Resolution, id: SymbolId, new: &str) -> String {
    let mut out = text.to_string();
    let same = |m: &Meaning| matches!(m, Meaning::Symbol(other) if *other == id);
    for r in names.references.iter().rev().filter(|r| same(&r.meaning)) {
        out.replace_range(r.place.clone(), new);
    }
    out
}

/// True if a word with holes in the text could be this name: a repetition makes it.
fn may_be_made(text: &str, name: &str) -> bool {
    let letter = |c: char| c.is_ascii_alphanumeric() || "_${} +-*".contains(c);
    text.split(|c| !letter(c)).flat_map(|words| words.split("  ")).any(|word| {
        let parts: Vec<&str> =
            holes::parts(word).filter_map(|p| if let Part::Text(t) = p { Some(t.trim()) } else { None }).collect();
        has_holes(word) && parts.iter().all(|part| name.contains(part.rsplit(' ').next().unwrap_or("")))
    })
}

/// A symbol that is renamed everywhere gives the same program: every use that the compiler accepts is a reference.
#[test]
fn a_renamed_symbol_gives_the_same_program() {
    let mut count = 0;
    let mut bad = Vec::new();
    for path in specs().iter().filter(|p| !p.to_string_lossy().contains("examples/common")) {
        let text = read(path);
        let names = resolved(path, &text);
        let before = compiled(path, &text);
        assert!(before.is_good(), "{}", path.display());
        let before = program(&before);
        for (i, symbol) in names.symbols.iter().enumerate() {
            if symbol.file != FileId(0) || has_holes(&symbol.name) || symbol.kind == SymbolKind::Outcome {
                continue;
            }
            let new = format!("{}_q", symbol.name);
            let text = renamed(&text, &names, SymbolId(i), &new);
            let after = compiled(path, &text);
            count += 1;
            // Some task types take the arms `left` and `right` by default.
            let by_default = symbol.kind == SymbolKind::Arm && ["left", "right"].contains(&symbol.name.as_str());
            if !after.is_good() && (by_default || may_be_made(&text, &symbol.name)) {
                continue;
            }
            if program(&after).replace(&new, &symbol.name) != before {
                let why = after.report.diagnostics.first().map(|d| d.message.clone());
                bad.push(format!("{}: {} `{}`: {why:?}", path.display(), symbol.kind.word(), symbol.name));
            }
        }
    }
    println!("{count}");
    assert!(bad.is_empty(), "{count}\n{}", bad.join("\n"));
}

/// Groups and postures of an SRDF are symbols of its text.
#[test]
fn names_of_an_srdf_lead_into_it() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/postures.hq");
    let text = read(&path);
    let names = resolved(&path, &text);
    for (word, kind) in
        [("ready", SymbolKind::Posture), ("wrist", SymbolKind::JointGroup), ("folded", SymbolKind::Posture)]
    {
        let at = text.find(word).expect("in the example");
        let Some(Meaning::Symbol(id)) = names.at(at).map(|r| r.meaning.clone()) else { panic!("{word} is no symbol") };
        let symbol = names.symbol(id);
        assert_eq!((symbol.kind, symbol.name.as_str()), (kind, word));
        assert!(names.file_of(id).path.ends_with("robots/arm7.srdf"), "{word}");
    }
    let offered: Vec<&str> = names.visible(SymbolKind::Posture).map(|(name, _)| name).collect();
    assert_eq!(offered, ["folded", "ready", "turned"]);
}
