//! Texts of up to a mebibyte need little time and memory. Since times differ between machines, allocations are counted:
//! their number, their bytes, and the memory held at once. `benches/front_end.rs` measures times.

#![allow(unsafe_code, reason = "a global allocator cannot be written without")]

#[path = "common/large.rs"]
mod large;

use std::alloc::{GlobalAlloc, Layout, System};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};

use dsl::{SourceId, Syntax, parse, print};

struct Counting;

static COUNT: AtomicUsize = AtomicUsize::new(0);
static HELD: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);
static BYTES: AtomicUsize = AtomicUsize::new(0);

fn grown(bytes: usize) {
    COUNT.fetch_add(1, SeqCst);
    BYTES.fetch_add(bytes, SeqCst);
    let held = HELD.fetch_add(bytes, SeqCst) + bytes;
    PEAK.fetch_max(held, SeqCst);
}

// SAFETY: every call is passed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        grown(layout.size());
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), SeqCst);
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        grown(size);
        HELD.fetch_sub(layout.size(), SeqCst);
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Expected diagnostics of some adversarial texts.
const CODES: &[(&str, &str)] = &[
    ("many tasks", "HQ0190"),
    ("many stacks", "HQ0190"),
    ("rows just above the bound", "HQ0623"),
    ("pairs above the bound", "HQ0623"),
    ("many mistakes of form", "HQ0192"),
    ("many groups", "HQ0190"),
    ("many points of a robot", "HQ0190"),
    ("robots made from a large one", "HQ0218"),
    ("a person of many points", "HQ0308"),
    ("parameters of a stack", "HQ0190"),
    ("changes of levels that are not there", "HQ0190"),
    ("many states", "HQ0190"),
    ("ways out of one state", "HQ0190"),
];

/// Maximum number of bytes held at once.
const MEMORY: usize = 256 << 20;
/// Maximum number of allocations. Half a million of them take about 20 ms; the work between two of them is bounded.
const ALLOCATIONS: usize = 12_000_000;
/// Maximum number of bytes allocated in all. A text that is copied at each of its words exceeds it.
const ALLOCATED: usize = 4 << 30;

fn check(text: &str, syntax: Syntax) -> compiler::Report {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let input = compiler::Input { name: "spec", text, syntax, folder: &folder, set: &[], package_paths: &[] };
    compiler::compile(&input).report
}

/// A spec with a recording of a person that has 1.5 million columns in addition to those of its point.
struct Recording(std::path::PathBuf);

impl Recording {
    fn of_many_columns() -> Recording {
        let path = std::env::temp_dir().join(format!("hierarq-columns-{}.csv", std::process::id()));
        let more: String = (0..1_500_000).map(|i| format!(",c{i}")).collect();
        std::fs::write(&path, format!("time,p.x,p.y,p.z{more}\n"))
            .expect("the folder for temporary files can be written");
        Recording(path)
    }

    fn nuisance(&self) -> (&'static str, Syntax, String) {
        let text = format!(
            "hierarq 1\nrobot arm {{ urdf \"robots/arm7.urdf\"  rate 100 Hz  home {{ joint_4 1 rad }} }}\n\
             human h {{ points [p] }}\nstack s {{ level l {{ joint_velocity_limits }} }}\n\
             scenario \"x\" {{ stack s  duration 1 s  humans {{ h {{ file {:?} }} }} }}\n",
            self.0
        );
        ("a recording of many columns", Syntax::Native, text)
    }
}

impl Drop for Recording {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// Names the part of the texts that a process checks, as `0/2`: the first of two.
const PART: &str = "HIERARQ_SIZE_PART";

// A single test: the allocations of a second one in this process would be counted too. Texts are shared out among processes.
#[test]
fn no_text_takes_long_or_much_memory() {
    match std::env::var(PART) {
        Ok(part) => {
            let (first, parts) = part.split_once('/').expect("a part");
            check_part(first.parse().expect("a number"), parts.parse().expect("a number"));
        }
        Err(_) => check_all(std::thread::available_parallelism().map_or(1, usize::from).min(8)),
    }
}

/// Checks all texts in this number of processes.
fn check_all(parts: usize) {
    let this = std::env::current_exe().expect("this test has a path");
    let start = |first: usize| {
        let mut command = Command::new(&this);
        command.args(["--exact", "no_text_takes_long_or_much_memory", "--nocapture"]);
        command.env(PART, format!("{first}/{parts}")).stdout(Stdio::piped()).stderr(Stdio::piped());
        command.spawn().expect("a process")
    };
    let started: Vec<_> = (0..parts).map(start).collect();
    // Each pipe is read by a thread of its own: what is written to one that nobody reads stops at some length.
    let reading: Vec<_> = started.into_iter().map(|child| std::thread::spawn(|| child.wait_with_output())).collect();
    for part in reading {
        let output = part.join().expect("a thread that ends").expect("a process that ends");
        let said = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat();
        println!("{said}");
        assert!(output.status.success() && said.contains("1 passed"), "{said}");
    }
}

/// Checks the texts of a part: each `parts`th.
fn check_part(first: usize, parts: usize) {
    if first == 0 {
        no_honest_text_is_refused();
    }
    let recording = Recording::of_many_columns();
    let mut wrong = Vec::new();
    for (name, syntax, text) in large::nuisances().into_iter().chain([recording.nuisance()]).skip(first).step_by(parts)
    {
        let (count, bytes, held) = (COUNT.load(SeqCst), BYTES.load(SeqCst), HELD.load(SeqCst));
        PEAK.store(held, SeqCst);
        let begun = std::time::Instant::now();
        let report = check(&text, syntax);
        if let Some((_, code)) = CODES.iter().find(|c| c.0 == name) {
            assert!(report.diagnostics.iter().any(|d| d.code == *code), "{name}: {:?}", report.diagnostics);
        }
        let shown = report.render(compiler::Style::Plain, 100).len();
        let (count, bytes) = (COUNT.load(SeqCst) - count, BYTES.load(SeqCst) - bytes);
        let (held, all) = ((PEAK.load(SeqCst) - held) >> 20, bytes >> 20);
        let found = format!("{name}: {count} allocations of {all} MiB, {held} MiB at once, {shown} bytes shown");
        println!("{found}, {:?}", begun.elapsed());
        if held > MEMORY >> 20 || count > ALLOCATIONS || bytes > ALLOCATED || shown > 1 << 20 {
            wrong.push(found);
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn no_honest_text_is_refused() {
    let spec = large::honest(5000);
    assert!(spec.lines().count() >= 4500, "{} lines", spec.lines().count());
    let report = check(&spec, Syntax::Native);
    assert_eq!(report.diagnostics.len(), 0, "{}", report.render(compiler::Style::Plain, 100));
    let (tree, _) = parse(SourceId(0), &spec, Syntax::Native);
    let report = check(&print(&tree, Syntax::Yaml), Syntax::Yaml);
    assert_eq!(report.diagnostics.len(), 0, "{}", report.render(compiler::Style::Plain, 100));
}
