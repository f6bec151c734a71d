//! Imports between the files of a crate: no cycle leads from one folder (or file) at the top of a crate through another
//! one. Within a folder, a module and its children may import each other.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Path of a module; empty for the root of the crate.
type Module = Vec<String>;

/// The modules of a crate with their imports.
struct Imports {
    texts: BTreeMap<Module, String>,
    /// Re-exports by module: the name, and its path.
    reexports: BTreeMap<Module, BTreeMap<String, Vec<String>>>,
}

impl Imports {
    fn of(src: &Path) -> Imports {
        let mut texts = BTreeMap::new();
        collect(src, src, &mut texts);
        let reexports = |text: &String| {
            let uses = uses(text).filter(|(public, _)| *public);
            uses.filter_map(|(_, path)| Some((path.last()?.clone(), path))).collect()
        };
        let reexports = texts.iter().map(|(m, text)| (m.clone(), reexports(text))).collect();
        Imports { texts, reexports }
    }

    /// Resolves a path from a module; `None` outside of the crate.
    fn resolve(&self, from: &Module, path: &[String], depth: usize) -> Option<Module> {
        let (first, mut rest) = path.split_first()?;
        let mut at = match first.as_str() {
            "crate" => Module::new(),
            "self" => from.clone(),
            "super" => from[..from.len().checked_sub(1)?].to_vec(),
            child if self.texts.contains_key(&joined(from, child)) => joined(from, child),
            _ => return None,
        };
        while let Some((name, others)) = rest.split_first() {
            at = if name == "super" {
                at[..at.len().checked_sub(1)?].to_vec()
            } else if self.texts.contains_key(&joined(&at, name)) {
                joined(&at, name)
            } else {
                break;
            };
            rest = others;
        }
        let behind = rest.first().and_then(|name| self.reexports.get(&at)?.get(name)).filter(|_| depth < 8);
        let further = behind.and_then(|behind| self.resolve(&at, &[behind, &rest[1..]].concat(), depth + 1));
        Some(further.unwrap_or(at))
    }

    /// Returns for each module the modules that it imports.
    fn edges(&self) -> BTreeMap<Module, BTreeSet<Module>> {
        let of = |module: &Module, text: &String| {
            let mut paths: Vec<Vec<String>> = uses(text).map(|(_, path)| path).collect();
            // In the text, a path may begin with an imported or a child module.
            let named: BTreeMap<String, Vec<String>> =
                paths.iter().filter_map(|p| Some((p.last()?.clone(), p.clone()))).collect();
            for path in mentions(text) {
                paths.push(match named.get(&path[0]) {
                    Some(full) => [full.as_slice(), &path[1..]].concat(),
                    None => path,
                });
            }
            let targets = paths.iter().filter_map(|p| self.resolve(module, p, 0));
            targets.filter(|t| t != module && !t.is_empty()).collect()
        };
        self.texts.iter().filter(|(m, _)| !m.is_empty()).map(|(m, text)| (m.clone(), of(m, text))).collect()
    }
}

fn joined(at: &[String], name: &str) -> Module {
    [at, &[name.to_string()]].concat()
}

/// Reads the files below a folder, without comments and unit tests.
fn collect(src: &Path, folder: &Path, texts: &mut BTreeMap<Module, String>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            collect(src, &path, texts);
        } else if path.extension().is_some_and(|e| e == "rs") {
            let within = path.strip_prefix(src).expect("below").with_extension("");
            let mut module: Module = within.iter().map(|p| p.to_string_lossy().into_owned()).collect();
            if module.last().is_some_and(|m| m == "mod" || ((m == "lib" || m == "main") && within.iter().count() == 1))
            {
                module.pop();
            }
            let text = std::fs::read_to_string(&path).expect("text");
            let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
            let lines = text.lines().map(|l| l.split("//").next().unwrap_or_default());
            texts.insert(module, lines.collect::<Vec<_>>().join("\n"));
        }
    }
}

/// Returns the paths of all `use` declarations, with true for public ones.
fn uses(text: &str) -> impl Iterator<Item = (bool, Vec<String>)> + '_ {
    let mut found = Vec::new();
    for (at, _) in text.match_indices("use ") {
        let line = text[..at].rfind('\n').map_or(0, |n| n + 1);
        let before = text[line..at].trim();
        if !(before.is_empty() || before.starts_with("pub")) {
            continue;
        }
        let Some(end) = text[at..].find(';') else { continue };
        let tree: String = text[at + 4..at + end].split_whitespace().collect::<Vec<_>>().join(" ");
        let mut paths = Vec::new();
        expand("", &tree, &mut paths);
        found.extend(paths.into_iter().map(|path| (!before.is_empty(), path)));
    }
    found.into_iter()
}

/// Expands a tree of imports.
fn expand(before: &str, tree: &str, paths: &mut Vec<Vec<String>>) {
    let tree = tree.trim();
    if let Some((prefix, group)) = tree.strip_suffix('}').and_then(|t| t.split_once('{')) {
        let (mut depth, mut start) = (0, 0);
        for (i, c) in group.char_indices() {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 0 => {
                    expand(&format!("{before}{prefix}"), &group[start..i], paths);
                    start = i + 1;
                }
                _ => {}
            }
        }
        expand(&format!("{before}{prefix}"), &group[start..], paths);
    } else if !tree.is_empty() {
        let path = format!("{before}{}", tree.split(" as ").next().unwrap_or(tree));
        paths.push(path.split("::").map(|p| p.trim().to_string()).filter(|p| p != "self").collect());
    }
}

/// Returns the paths in the text outside of `use`, `a::b::c`.
fn mentions(text: &str) -> Vec<Vec<String>> {
    let words = text.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':'));
    let paths = words.filter(|w| w.contains("::") && !w.starts_with(':'));
    paths.map(|w| w.split("::").map(str::to_string).filter(|p| !p.is_empty()).collect()).collect()
}

/// Returns all modules that are reachable from a module.
fn reached(edges: &BTreeMap<Module, BTreeSet<Module>>, from: &Module) -> BTreeSet<Module> {
    let mut seen = BTreeSet::new();
    let mut open = vec![from];
    while let Some(module) = open.pop() {
        for next in edges.get(module).into_iter().flatten() {
            if seen.insert(next.clone()) {
                open.push(next);
            }
        }
    }
    seen
}

#[test]
fn no_files_import_each_other_across_folders() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let crates = [
        ".",
        "blocks",
        "compiler",
        "context",
        "dsl",
        "expressions",
        "files",
        "ide",
        "learning",
        "mission",
        "names",
        "quantities",
        "robot",
        "runs",
        "runtime",
        "serve",
        "solver",
        "stdlib_tasks",
        "views",
    ];
    let mut wrong = Vec::new();
    for name in crates {
        let imports = Imports::of(&root.join(name).join("src"));
        let edges = imports.edges();
        let from: BTreeMap<&Module, BTreeSet<Module>> = edges.keys().map(|m| (m, reached(&edges, m))).collect();
        for (a, targets) in &edges {
            for b in targets.iter().filter(|b| b[0] != a[0] && from.get(b).is_some_and(|back| back.contains(a))) {
                wrong.push(format!("{name}/src: {} imports {}, and is imported by it", a.join("/"), b.join("/")));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn circles_are_seen() {
    let text = |t: &str| t.to_string();
    let texts: BTreeMap<Module, String> = [
        (vec![], text("mod a;\nmod b;\nmod c;\n")),
        (vec!["a".to_string()], text("pub use inner::{Thing, other as renamed};\n")),
        (vec!["a".to_string(), "inner".to_string()], text("use crate::{b, c::Leaf};\nfn f() { b::g() }\n")),
        (vec!["b".to_string()], text("use crate::a::Thing;\n")),
        (vec!["c".to_string()], text("")),
    ]
    .into();
    let reexports = texts
        .iter()
        .map(|(m, t)| (m.clone(), uses(t).filter(|u| u.0).map(|(_, p)| (p[p.len() - 1].clone(), p)).collect()))
        .collect();
    let edges = Imports { texts, reexports }.edges();
    let module = |path: &str| path.split('/').map(str::to_string).collect::<Module>();
    assert_eq!(edges[&module("b")], BTreeSet::from([module("a/inner")]));
    assert_eq!(edges[&module("a/inner")], BTreeSet::from([module("b"), module("c")]));
    assert!(reached(&edges, &module("b")).contains(&module("b")));
}

/// Stages of the compiler from bottom to top, as in `ARCHITECTURE.md`; stages in one line do not import each other.
const STAGES: [&[&str]; 13] = [
    &["demands", "sampled", "sections", "units"],
    &["diagnostics"],
    &["forms", "input", "paths"],
    &["cli_overrides", "expr", "recording"],
    &["block_binding"],
    &["expand", "robot_binding"],
    &["binding", "let_bindings"],
    &["source_map"],
    &["analysis"],
    &["lowering"],
    &["resolve"],
    &["checks"],
    &["compile"],
];

#[test]
fn stages_of_the_compiler_look_down() {
    let imports = Imports::of(&Path::new(env!("CARGO_MANIFEST_DIR")).join("compiler/src"));
    let stage = |module: &str| {
        STAGES.iter().position(|s| s.contains(&module)).unwrap_or_else(|| panic!("`{module}` is in no stage: add it"))
    };
    let mut wrong = Vec::new();
    for (from, targets) in imports.edges() {
        for to in targets.iter().filter(|to| to[0] != from[0] && stage(&to[0]) >= stage(&from[0])) {
            wrong.push(format!("{} imports {}", from.join("/"), to.join("/")));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
