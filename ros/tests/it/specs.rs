//! Specs of the tests.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use runs::project::{Settings, load};
use runtime::Program;

/// Compiles a text for the arm of the examples.
pub fn program(text: &str) -> Program {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("ros");
    std::fs::create_dir_all(&folder).expect("a folder that can be written");
    // Tests run beside each other.
    static NEXT: AtomicUsize = AtomicUsize::new(0);
    let file = folder.join(format!("{}-{}.hq", std::process::id(), NEXT.fetch_add(1, Ordering::Relaxed)));
    std::fs::write(&file, format!("hierarq 1\n{text}")).expect("a folder that can be written");
    let compiled = load(&file, &Settings::default());
    compiled.program.unwrap_or_else(|| panic!("{}", compiled.report.render(compiler::Style::Plain, 100)))
}

/// The beginning of a spec of an arm. Ticks may be late: a machine that tests has other work too.
pub fn arm(more: &str) -> String {
    let urdf = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/robots/ur5.urdf");
    format!("robot arm {{ urdf \"{}\"  rate 100 Hz  deadline 3 s  tracking_gain 5 /s  {more}", urdf.display())
}
