//! Every example says the same in both spellings, survives conversion, and compiles to a reviewed program.

mod common;

use std::path::Path;

use dsl::{SourceId, Spelling};
use hierarq::project::{Settings, compile};
use runtime::Program;

/// The program of a text, as if it stood among the examples under the given name.
fn compile_text(name: &str, text: &str, spelling: Spelling) -> Program {
    let folder = common::example("");
    let input = compiler::Input { name, text, spelling, folder: &folder, set: &[], package_paths: &[] };
    let compiled = compiler::compile(&input);
    compiled.program.unwrap_or_else(|| panic!("{}", compiled.report.render(compiler::Style::Plain, 100)))
}

#[test]
fn no_example_is_forgotten() {
    let mut stems: Vec<String> = std::fs::read_dir(common::example(""))
        .expect("the folder is there")
        .filter_map(|e| {
            let path = e.expect("readable").path();
            Spelling::of_path(&path)?;
            Some(path.file_stem()?.to_str()?.to_string())
        })
        .collect();
    stems.sort();
    let mut expected: Vec<String> = common::EXAMPLES.iter().flat_map(|n| [n.to_string(), n.to_string()]).collect();
    expected.sort();
    assert_eq!(stems, expected, "each example in both spellings, and in common::EXAMPLES");
}

#[test]
fn both_spellings_are_the_same_program() {
    for name in common::EXAMPLES {
        let hq = common::program(&format!("{name}.hq"));
        let yaml = common::program(&format!("{name}.yaml"));
        assert_eq!(hq, yaml, "{name}");
    }
}

#[test]
fn conversion_and_formatting_keep_the_program() {
    for name in common::EXAMPLES {
        for (ending, spelling, other) in [("hq", Spelling::Hq, Spelling::Yaml), ("yaml", Spelling::Yaml, Spelling::Hq)]
        {
            let file = format!("{name}.{ending}");
            let text = std::fs::read_to_string(common::example(&file)).expect("readable");
            let program = common::program(&file);
            let (tree, diagnostics) = dsl::parse(SourceId(0), &text, spelling);
            assert!(diagnostics.is_empty(), "{file}: {diagnostics:?}");
            assert_eq!(dsl::print(&tree, spelling), text, "{file} is formatted");
            let converted = dsl::print(&tree, other);
            assert_eq!(compile_text(name, &converted, other), program, "{file} converted");
            let (back, _) = dsl::parse(SourceId(0), &converted, other);
            let again = dsl::print(&back, spelling);
            assert_eq!(compile_text(name, &again, spelling), program, "{file} there and back");
        }
    }
}

#[test]
fn no_example_has_a_warning() {
    for name in common::EXAMPLES {
        let compiled = compile(&common::example(&format!("{name}.hq")), &Settings::default());
        assert!(compiled.report.diagnostics.is_empty(), "{}", compiled.report.render(compiler::Style::Plain, 100));
    }
}

#[test]
fn compiled_programs() {
    for name in common::EXAMPLES {
        let program = common::program(&format!("{name}.hq"));
        let text = runtime::text::text(&program).expect("it can be executed");
        insta::assert_snapshot!(*name, text);
    }
}

#[test]
fn a_program_is_the_same_after_json() {
    for name in common::EXAMPLES {
        let program = common::program(&format!("{name}.hq"));
        let json = serde_json::to_string(&program).expect("plain data");
        let back: Program = serde_json::from_str(&json).expect("the same data");
        assert_eq!(back, program);
        assert_eq!(runtime::text::text(&back), runtime::text::text(&program));
    }
}

#[test]
fn paths_in_messages_are_those_of_the_user() {
    let compiled = compile(Path::new("no/such/file.hq"), &Settings::default());
    let text = compiled.report.render(compiler::Style::Plain, 100);
    assert!(text.contains("no/such/file.hq"), "{text}");
}
