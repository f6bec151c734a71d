//! The docs are correct: generated pages are up to date, every spec in them compiles, every named file exists.

use crate::common;

use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Compares a generated page with the file; `HIERARQ_UPDATE_DOCS=1` writes it instead.
fn generated(file: &str, text: &str) {
    let path = root().join(file);
    if std::env::var_os("HIERARQ_UPDATE_DOCS").is_some() {
        std::fs::write(&path, text).expect("writable");
    }
    let is = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(is == text, "{file} is stale: run `HIERARQ_UPDATE_DOCS=1 cargo test --test it documentation`");
}

#[test]
fn the_task_catalogue_is_fresh() {
    generated("docs/src/tasks.md", &hierarq::catalogue::markdown());
}

#[test]
fn the_code_index_is_fresh() {
    generated("docs/src/codes.md", &hierarq::catalogue::codes_markdown());
}

#[test]
fn the_page_of_keys_is_fresh() {
    generated("docs/src/language/keys.md", &hierarq::keys::markdown());
}

#[test]
fn the_table_of_functions_is_fresh() {
    let page = std::fs::read_to_string(root().join("docs/src/language/values.md")).expect("readable");
    let (before, rest) = page.split_once("## Functions\n\n").expect("a section of functions");
    let after = rest.find("\n## ").map_or("", |at| &rest[at..]);
    let table = compiler::expr::functions_markdown();
    generated("docs/src/language/values.md", &format!("{before}## Functions\n\n{table}{after}"));
}

fn markdown_files(folder: &Path, out: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> =
        std::fs::read_dir(folder).expect("readable").map(|e| e.expect("readable").path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() && path.file_name().is_some_and(|n| n != "book") {
            markdown_files(&path, out);
        } else if path.extension().is_some_and(|e| e == "md") {
            out.push(path);
        }
    }
}

/// Returns the code blocks of a page with the given language mark.
fn blocks(text: &str, mark: &str) -> Vec<String> {
    let mut out = Vec::new();
    let mut current: Option<String> = None;
    for line in text.lines() {
        match &mut current {
            Some(block) if line.trim_start().starts_with("```") => {
                out.push(std::mem::take(block));
                current = None;
            }
            Some(block) => {
                block.push_str(line);
                block.push('\n');
            }
            None if line.trim() == format!("```{mark}") => current = Some(String::new()),
            None => {}
        }
    }
    out
}

#[test]
fn every_whole_spec_in_the_docs_compiles() {
    let mut files = vec![root().join("README.md")];
    markdown_files(&root().join("docs"), &mut files);
    // The pages of the codes contain mistakes too; the compiler's tests compile them.
    files.retain(|f| !f.ends_with("codes.md"));
    let mut count = 0;
    for file in files {
        let text = std::fs::read_to_string(&file).expect("readable");
        for (mark, begins, syntax) in
            [("hq", "hierarq 1", dsl::Syntax::Native), ("yaml", "hierarq: 1", dsl::Syntax::Yaml)]
        {
            for block in blocks(&text, mark).iter().filter(|b| b.starts_with(begins)) {
                count += 1;
                let folder = common::example("");
                let input = compiler::Input {
                    name: "docs",
                    text: block,
                    syntax,
                    folder: &folder,
                    set: &[],
                    package_paths: &[],
                };
                let compiled = compiler::compile(&input);
                assert!(
                    compiled.is_good(),
                    "{}:\n{block}\n{}",
                    file.display(),
                    compiled.report.render(compiler::Style::Plain, 100)
                );
            }
        }
    }
    assert!(count >= 5, "only {count} whole specs were found in the docs");
}

/// Declarations that the example of a safety planner uses.
const PROTECTED: &str = "human operator { points [chest] }
safety_field nearness { of operator }
task hands = cooperative_motion {
  absolute { position initial(absolute.position) + [0.1, 0, 0] m * sin(t/(1 s))  orientation initial(absolute.orientation) }
  relative { position initial(relative.position)  orientation initial(relative.orientation) }
}
";

/// Obstacles of an example.
const ROOM: &str = "
obstacle table { box [1.2, 0.8, 0.04] m  position [2, 1.4, 0.74] m }
obstacle pillar { cylinder { radius 0.18 m  length 2.5 m }  position [2.2, -0.55, 1.25] m }
";

#[test]
fn every_example_of_the_catalogue_compiles() {
    let robot = |file: &str, name: &str| {
        let text = std::fs::read_to_string(common::example(file)).expect("readable");
        let start = text.find(&format!("robot {name}")).expect("a robot");
        let end = text[start..].find("\n}\n").expect("its end") + start + 3;
        text[start..end].to_string()
    };
    let (arms, legs) = (robot("common/canopies.hq", "canopies"), robot("stance.hq", "humanoid"));
    for kind in stdlib_tasks::KINDS {
        let robot = if kind.example.contains("left_sole") { &legs } else { &arms };
        let robot = robot
            .replace("../robots/", "robots/")
            .replace("    head head_link", "    head head_link\n    tool left_tool");
        let example = kind.example.replace("(tool)", "(left_tool)");
        let name = example.split_whitespace().nth(1).expect("task NAME = ..").to_string();
        // A planner protects a task on a lower level, and needs a human.
        let (around, above) = match () {
            () if kind.example.contains("(hands)") => (PROTECTED, "level first { hands }"),
            () if kind.example.contains("pillar") => (ROOM, ""),
            () => ("", ""),
        };
        let stack = format!("stack s {{ {above} level l {{ {name} }} }}");
        program_compiles(kind.name, &format!("hierarq 1\n{robot}\n{around}{example}\n{stack}\n"));
    }
}

fn program_compiles(what: &str, text: &str) {
    let folder = common::example("");
    let input = compiler::Input {
        name: "docs",
        text,
        syntax: dsl::Syntax::Native,
        folder: &folder,
        set: &[],
        package_paths: &[],
    };
    let compiled = compiler::compile(&input);
    assert!(compiled.is_good(), "{what}:\n{}", compiled.report.render(compiler::Style::Plain, 100));
}

#[test]
fn the_map_names_only_what_exists() {
    let text = std::fs::read_to_string(root().join("ARCHITECTURE.md")).expect("there is one");
    let mut named = 0;
    for word in text.split('`').skip(1).step_by(2) {
        let is_path = word.contains('/')
            && !word.starts_with("//")
            && !word.contains([' ', '(', ':', '<', '*', '{'])
            && !word.starts_with("http");
        if is_path {
            named += 1;
            assert!(root().join(word).exists(), "ARCHITECTURE.md names `{word}`, which does not exist");
        }
    }
    assert!(named > 10, "only {named} paths were found");
}

/// Checks the source files that other pages name; files in a user's own folder are not checked.
#[test]
fn pages_name_only_files_of_source_that_exist() {
    let mut pages = vec![root().join("CONTRIBUTING.md"), root().join("README.md"), root().join("SECURITY.md")];
    markdown_files(&root().join("docs/src"), &mut pages);
    let mut named = 0;
    for page in pages {
        let text = std::fs::read_to_string(&page).expect("text");
        for word in text.split('`').skip(1).step_by(2) {
            let is_source = (word.contains("src/") || word.starts_with("tests/") || word.starts_with("benches/"))
                && !word.starts_with('/')
                && !word.contains([' ', '(', ':', '<', '*', '{', '$', '"', '\n']);
            if is_source {
                named += 1;
                let beside = page.parent().is_some_and(|folder| folder.join(word).exists());
                assert!(
                    beside || root().join(word).exists(),
                    "{} names `{word}`, which does not exist",
                    page.display()
                );
            }
        }
    }
    assert!(named > 10, "only {named} files were found");
}

#[test]
fn links_between_pages_lead_somewhere() {
    let mut files = Vec::new();
    markdown_files(&root().join("docs/src"), &mut files);
    for file in files {
        let text = std::fs::read_to_string(&file).expect("readable");
        for target in text.split("](").skip(1).filter_map(|s| s.split(')').next()) {
            let path = target.split('#').next().unwrap_or("");
            if path.is_empty() || path.contains("://") {
                continue;
            }
            let full = file.parent().expect("a folder").join(path);
            assert!(full.exists(), "{} links to {target}", file.display());
        }
    }
}

/// Returns the anchors that the book generates for the headings of a page, and those of the form `<a id="..">`.
fn anchors(text: &str) -> Vec<String> {
    let ids = text.split("<a id=\"").skip(1).filter_map(|rest| rest.split('"').next());
    let mut anchors: Vec<String> = ids.map(String::from).collect();
    let mut fenced = false;
    for line in text.lines() {
        fenced ^= line.trim_start().starts_with("```");
        let heading = line.trim_start_matches('#').strip_prefix(' ').filter(|_| line.starts_with('#') && !fenced);
        let Some(heading) = heading else { continue };
        let kept = heading.trim().chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        let anchor: String = kept.flat_map(char::to_lowercase).map(|c| if c == ' ' { '-' } else { c }).collect();
        let same = (1..).map(|number| format!("{anchor}-{number}"));
        let free = std::iter::once(anchor.clone()).chain(same).find(|name| !anchors.contains(name));
        anchors.extend(free);
    }
    anchors
}

#[test]
fn anchors_of_links_exist() {
    let mut files = Vec::new();
    markdown_files(&root().join("docs/src"), &mut files);
    let mut count = 0;
    let mut dead = Vec::new();
    for file in files {
        let text = std::fs::read_to_string(&file).expect("readable");
        for target in text.split("](").skip(1).filter_map(|s| s.split(')').next()) {
            let Some((path, anchor)) = target.split_once('#').filter(|_| !target.contains("://")) else { continue };
            let page = match path {
                "" => file.clone(),
                path => file.parent().expect("a folder").join(path),
            };
            count += 1;
            let there = std::fs::read_to_string(&page).is_ok_and(|text| anchors(&text).iter().any(|is| is == anchor));
            if !there {
                dead.push(format!("{} links to {target}", file.display()));
            }
        }
    }
    assert!(dead.is_empty(), "{}", dead.join("\n"));
    assert!(count > 20, "only {count} anchors were found");
}

#[test]
fn every_picture_is_on_a_page() {
    let mut files = Vec::new();
    markdown_files(&root().join("docs/src"), &mut files);
    let pages: String = files.iter().map(|file| std::fs::read_to_string(file).expect("readable")).collect();
    let mut folders = vec![root().join("docs/src")];
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(folder).expect("readable").map(|e| e.expect("readable").path()) {
            let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "svg" || e == "png") {
                assert!(pages.contains(name), "no page shows {}", path.display());
            }
        }
    }
}
