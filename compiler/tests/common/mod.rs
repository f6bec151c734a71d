//! Shared parts of the tests: cases in text files, compiled for small robots, and their diagnostics as text.

pub mod invariants;
pub mod state;

pub use compiler::Compiled;
use compiler::{Deep, Input, codes, compile, compile_deep};
use dsl::{Severity, Syntax};
use hierarq_compiler as compiler;
use std::path::{Path, PathBuf};

/// One case: a spec, its number of diagnostics, and additional files.
pub struct Case {
    /// Title of the case.
    pub title: String,
    /// Number of diagnostics: one mistake, one message.
    pub count: usize,
    /// The whole spec.
    pub text: String,
    /// Overridden parameters.
    pub set: Vec<(String, String)>,
    /// Names and texts of files.
    pub files: Vec<(String, String)>,
    /// Syntax.
    pub syntax: Syntax,
    /// True if it is checked at random postures too.
    pub deep: bool,
}

/// Number of random postures of cases and pages; their seed is 0.
pub const POSTURES: usize = 300;

/// Parses the cases of a file: `==== [N] title`, lines `!set NAME=VALUE`, `!deep` (random postures too), `!alone` (nothing is added) or `!robot` (only
/// the robot is added), the spec, then files, each after `---- NAME`.
pub fn cases(text: &str, syntax: Syntax) -> Vec<Case> {
    text.split("==== ").skip(1).map(|part| case(part, syntax)).collect()
}

fn case(part: &str, syntax: Syntax) -> Case {
    let mut sections = part.split("---- ");
    let first = sections.next().unwrap_or("");
    let files =
        sections.filter_map(|s| s.split_once('\n')).map(|(n, t)| (n.trim().to_string(), t.to_string())).collect();
    let (title, body) = first.split_once('\n').unwrap_or((first, ""));
    let (count, title) = match title.strip_prefix('[').and_then(|t| t.split_once("] ")) {
        Some((n, rest)) => (n.parse().expect("a number"), rest),
        None => (1, title),
    };
    let commands: Vec<&str> = body.lines().take_while(|l| l.starts_with('!')).collect();
    let body: String = body.lines().skip(commands.len()).map(|l| format!("{l}\n")).collect();
    let set = commands.iter().filter_map(|c| c.strip_prefix("!set ")).filter_map(|c| c.split_once('='));
    let set = set.map(|(n, v)| (n.to_string(), v.to_string())).collect();
    let text = match (commands.contains(&"!alone"), commands.contains(&"!robot")) {
        (true, _) if body.trim().is_empty() => body,
        (alone, robot) => whole(&body, syntax, !alone, !alone && !robot),
    };
    Case { title: title.trim().to_string(), count, text, set, files, syntax, deep: commands.contains(&"!deep") }
}

/// Adds the header, and the robot and a stack of all tasks if the case has none. The stack also has limits of
/// positions, velocities and accelerations, if the robot has them and the case has none of this kind.
pub fn whole(body: &str, syntax: Syntax, robot: bool, stack: bool) -> String {
    let hq = syntax == Syntax::Native;
    let begins = |word: &str| body.lines().any(|l| l.starts_with(word));
    let header = match hq {
        _ if body.starts_with("hierarq") => "",
        true => "hierarq 1\n",
        false => "hierarq: 1\n",
    };
    let mut text = format!("{header}{body}");
    if robot && !begins(if hq { "robot " } else { "robots:" }) {
        text.push('\n');
        text.push_str(if hq { codes::EXAMPLE_ROBOT } else { codes::EXAMPLE_ROBOT_YAML });
    }
    if stack && !begins(if hq { "stack " } else { "stacks:" }) {
        let tasks: Vec<&str> = if hq {
            body.lines()
                .filter_map(|l| l.strip_prefix("task ")?.split([' ', ':']).next())
                .filter(|t| !t.contains('('))
                .collect()
        } else {
            let inside =
                body.lines().skip_while(|l| !l.starts_with("tasks:")).skip(1).take_while(|l| l.starts_with(' '));
            inside
                .filter(|l| !l.starts_with("   ") && !l.trim().starts_with('#'))
                .filter_map(|l| l.trim().split(':').next())
                .collect()
        };
        let tasks: Vec<&str> =
            tasks.iter().enumerate().filter(|(i, t)| !tasks[..*i].contains(t)).map(|(_, t)| *t).collect();
        // The limits that the robot has from its description, unless the case is about limits of this kind. Limits of positions
        // count on those of velocities.
        let described = ["joint_position_limits", "joint_velocity_limits", "joint_acceleration_limits"];
        let described = if text.contains(described[1]) { &described[2..] } else { &described[..] };
        let bounded = text.contains("robots/arm7.urdf");
        let limits = described.iter().copied().filter(|kind| bounded && !text.contains(kind)).collect();
        let tasks = if tasks.is_empty() && !bounded { vec!["joint_velocity_limits"] } else { tasks };
        // Distances stand above the targets, which would otherwise have the right to violate them.
        let distance = |t: &&str| {
            let kinds = ["keep(", "virtual_wall", "self_collision"];
            kinds.iter().any(|k| body.lines().any(|l| l.starts_with(&format!("task {t} = {k}"))))
        };
        let (distances, targets): (Vec<&str>, Vec<&str>) = tasks.iter().copied().partition(|t| hq && distance(t));
        let mut levels = vec![("limits", true, limits)];
        match (distances.is_empty(), targets.is_empty()) {
            (false, false) => levels.extend([("safe", false, distances), ("all", false, targets)]),
            _ => levels.push(("all", false, tasks)),
        }
        levels.retain(|(_, _, tasks)| !tasks.is_empty());
        let level = |(name, hard, tasks): &(&str, bool, Vec<&str>)| match (hq, hard) {
            (true, true) => format!("level {name} hard {{ {} }}", tasks.join("  ")),
            (true, false) => format!("level {name} {{ {} }}", tasks.join("  ")),
            (false, true) => format!("{{ name: {name}, hard: true, tasks: [{}] }}", tasks.join(", ")),
            (false, false) => format!("{{ name: {name}, tasks: [{}] }}", tasks.join(", ")),
        };
        let levels: Vec<String> = levels.iter().map(level).collect();
        text.push_str(&match hq {
            true => format!("stack all {{ {} }}\n", levels.join("  ")),
            false => format!("stacks: {{ all: {{ levels: [ {} ] }} }}\n", levels.join(", ")),
        });
    }
    text
}

/// Folder of the example specs.
pub fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples")
}

/// Compiles a text with files in a folder.
pub fn compile_text(text: &str, syntax: Syntax, folder: &Path, set: &[(String, String)]) -> Compiled {
    compile(&Input { name: "spec", text, syntax, folder, set, package_paths: &[] })
}

/// Compiles a text in the native syntax, and the same spec printed as YAML, with the files of the examples.
pub fn compile_both(text: &str) -> [Compiled; 2] {
    let mut sources = dsl::Sources::default();
    let source = sources.add("spec", text);
    let (tree, found) = dsl::parse(source, text, Syntax::Native);
    assert!(found.is_empty(), "{found:?}\n{text}");
    let yaml = dsl::print(&tree, Syntax::Yaml);
    [(text, Syntax::Native), (yaml.as_str(), Syntax::Yaml)].map(|(t, s)| compile_text(t, s, &examples(), &[]))
}

/// The same as [`compile_text`], with the checks at a number of random postures that a seed determines.
pub fn compile_text_deep(text: &str, syntax: Syntax, folder: &Path, postures: usize, seed: u64) -> Compiled {
    let deep = Deep { postures, seed, progress: &|_, _| {} };
    compile_deep(&Input { name: "spec", text, syntax, folder, set: &[], package_paths: &[] }, &deep)
}

impl Case {
    /// Compiles the case, in a folder of its own if it has files.
    pub fn compile(&self) -> Compiled {
        let compiled = |folder: &Path| match self.deep {
            true => compile_text_deep(&self.text, self.syntax, folder, POSTURES, 0),
            false => compile_text(&self.text, self.syntax, folder, &self.set),
        };
        if self.files.is_empty() {
            return compiled(&examples());
        }
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(self.title.replace(' ', "_"));
        // The robot for cases that declare none.
        let urdf = std::fs::read_to_string(examples().join("robots/arm7.urdf")).expect("a URDF");
        let urdf = ("robots/arm7.urdf".to_string(), urdf);
        for (name, text) in self.files.iter().chain([&urdf]) {
            let path = folder.join(name);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            // Parallel tests compile the same case, so files are replaced atomically.
            if std::fs::read_to_string(&path).is_ok_and(|old| old == *text) {
                continue;
            }
            let part = folder.join(format!("{name}.{:?}", std::thread::current().id()));
            std::fs::write(&part, text).expect("a file");
            std::fs::rename(&part, &path).expect("a file");
        }
        compiled(&folder)
    }
}

/// Renders diagnostics under the lines that they refer to.
pub fn annotated(compiled: &Compiled) -> String {
    let report = &compiled.report;
    let mut out = String::new();
    for d in &report.diagnostics {
        let severity = if d.severity == Severity::Error { "error" } else { "warning" };
        let here = if d.primary.text.is_empty() { String::new() } else { format!(" ({})", d.primary.text) };
        out.push_str(&marked(report, d.primary.span, &format!("{severity} {}: {}{here}", d.code, d.message)));
        for l in &d.labels {
            out.push_str(&marked(report, l.span, &format!("- {}", l.text)));
        }
        for n in &d.notes {
            out.push_str(&format!("     why: {n}\n"));
        }
        if let Some(h) = &d.help {
            out.push_str(&format!("     help: {h}\n"));
        }
    }
    out.replace(&examples().display().to_string(), "EXAMPLES").replace(env!("CARGO_TARGET_TMPDIR"), "TMP")
}

fn marked(report: &compiler::Report, span: dsl::Span, text: &str) -> String {
    let Some(source) = report.sources.get(span.source) else { return format!("?? {text}\n") };
    let (line, column) = report.sources.line_column(span.source, span.start);
    let shown = source.text.lines().nth(line - 1).unwrap_or("");
    let snippet = report.sources.snippet(span);
    let width = snippet.lines().next().map_or(0, |l| l.chars().count()).max(1);
    let more = if snippet.contains('\n') { ".." } else { "" };
    let name = if source.name == "spec" { String::new() } else { format!("   > {}\n", source.name) };
    format!("{name}{line:4} {shown}\n     {}{}{more} {text}\n", " ".repeat(column - 1), "^".repeat(width))
}
