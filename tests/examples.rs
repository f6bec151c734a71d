//! Every example means the same in both syntaxes, survives conversion, and compiles to a reviewed program.

use crate::common;

use std::path::Path;

use compiler::Compiled;
use dsl::{SourceId, Syntax};
use hierarq::project::{Settings, compile};
use runtime::program::CompiledFile;

/// Returns the result of a compilation: a program, missions, or both; panics with the diagnostics on failure.
fn good(compiled: Compiled) -> CompiledFile {
    assert!(compiled.is_good(), "{}", compiled.report.render(compiler::Style::Plain, 100));
    CompiledFile { program: compiled.program, missions: compiled.missions }
}

/// Compiles a text in the folder of the examples under the given name.
fn compile_text(name: &str, text: &str, syntax: Syntax) -> CompiledFile {
    let folder = common::example("");
    let input = compiler::Input { name, text, syntax, folder: &folder, set: &[], package_paths: &[] };
    good(compiler::compile(&input))
}

/// Compiles an example.
fn compiled(file: &str) -> CompiledFile {
    good(compile(&common::example(file), &Settings::default()))
}

/// Returns all examples.
fn all() -> impl Iterator<Item = &'static str> {
    common::EXAMPLES.iter().chain(common::MISSIONS).copied()
}

#[test]
fn no_example_is_forgotten() {
    let mut stems: Vec<String> = std::fs::read_dir(common::example(""))
        .expect("the folder is there")
        .filter_map(|e| {
            let path = e.expect("readable").path();
            Syntax::of_path(&path)?;
            Some(path.file_stem()?.to_str()?.to_string())
        })
        .collect();
    stems.sort();
    let mut expected: Vec<String> = all().flat_map(|n| [n.to_string(), n.to_string()]).collect();
    expected.sort();
    assert_eq!(stems, expected, "each example in both syntaxes, and in common::EXAMPLES or MISSIONS");
}

#[test]
fn both_syntaxes_are_the_same_program() {
    for name in all() {
        let hq = compiled(&format!("{name}.hq"));
        let yaml = compiled(&format!("{name}.yaml"));
        assert_eq!(hq, yaml, "{name}");
    }
}

#[test]
fn conversion_and_formatting_keep_the_program() {
    for name in all() {
        for (ending, syntax, other) in [("hq", Syntax::Native, Syntax::Yaml), ("yaml", Syntax::Yaml, Syntax::Native)] {
            let file = format!("{name}.{ending}");
            let text = std::fs::read_to_string(common::example(&file)).expect("readable");
            let program = compiled(&file);
            let (tree, diagnostics) = dsl::parse(SourceId(0), &text, syntax);
            assert!(diagnostics.is_empty(), "{file}: {diagnostics:?}");
            assert_eq!(dsl::print(&tree, syntax), text, "{file} is formatted");
            let converted = dsl::print(&tree, other);
            assert_eq!(compile_text(name, &converted, other), program, "{file} converted");
            let (back, _) = dsl::parse(SourceId(0), &converted, other);
            let again = dsl::print(&back, syntax);
            assert_eq!(compile_text(name, &again, syntax), program, "{file} there and back");
        }
    }
}

#[test]
fn no_example_has_a_warning() {
    for name in all() {
        let compiled = compile(&common::example(&format!("{name}.hq")), &Settings::default());
        assert!(compiled.report.diagnostics.is_empty(), "{}", compiled.report.render(compiler::Style::Plain, 100));
    }
}

/// Returns the complete result as text.
fn text(file: &CompiledFile) -> String {
    let program = file.program.iter().map(|p| runtime::text::text(p).expect("it can be executed"));
    program.chain(file.missions.iter().map(runtime::text::mission)).collect()
}

#[test]
fn compiled_programs() {
    for name in all() {
        insta::assert_snapshot!(name, text(&compiled(&format!("{name}.hq"))));
    }
}

#[test]
fn a_program_is_the_same_after_json() {
    for name in all() {
        let file = compiled(&format!("{name}.hq"));
        let json = CompiledFile::to_json(name, file.program.as_ref(), &file.missions).expect("plain data");
        let back = CompiledFile::read(&json).expect("the same data");
        assert_eq!(back, file);
        assert_eq!(text(&back), text(&file));
    }
}

#[test]
fn paths_in_messages_are_those_of_the_user() {
    let compiled = compile(Path::new("no/such/file.hq"), &Settings::default());
    let text = compiled.report.render(compiler::Style::Plain, 100);
    assert!(text.contains("no/such/file.hq"), "{text}");
}
