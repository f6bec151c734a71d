//! The package as Python sees it: the module that was built, with the tests of `tests/*.py` run by an interpreter that has NumPy and
//! pytest. `HIERARQ_PYTHON` names it; `.ci/run` makes one. Without it, only the module itself is looked at.

use std::path::{Path, PathBuf};
use std::process::Command;

/// The library that this build has made.
fn library() -> PathBuf {
    let test = std::env::current_exe().expect("this test has a path");
    let folder = test.parent().expect("a test is in a folder, beside the libraries that it depends on");
    let (prefix, suffix) = (std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    folder.join(format!("{prefix}_hierarq{suffix}"))
}

#[test]
fn the_module_has_an_entry_for_the_interpreter() {
    let bytes = std::fs::read(library()).expect("the library was built with this test");
    let name = b"PyInit__hierarq";
    assert!(bytes.windows(name.len()).any(|w| w == name), "no entry `PyInit__hierarq`");
}

#[test]
fn the_tests_in_python_pass() {
    let Some(python) = std::env::var_os("HIERARQ_PYTHON") else {
        println!("not run: HIERARQ_PYTHON names no interpreter with NumPy and pytest");
        return;
    };
    // The tests import the package as it is installed: its files, and the module beside them.
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("package");
    let package = folder.join("hierarq");
    std::fs::create_dir_all(&package).expect("a folder");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for entry in std::fs::read_dir(root.join("package/hierarq")).expect("the package") {
        let path = entry.expect("an entry").path();
        if path.is_file() {
            std::fs::copy(&path, package.join(path.file_name().expect("a file"))).expect("a copy");
        }
    }
    let module = if cfg!(windows) { "_hierarq.pyd" } else { "_hierarq.abi3.so" };
    std::fs::copy(library(), package.join(module)).expect("a copy");
    let mut command = Command::new(python);
    let command = command.args(["-m", "pytest", "-q", "-p", "no:cacheprovider"]).arg(root.join("tests"));
    let command = command.env("PYTHONPATH", &folder).env("PYTHONDONTWRITEBYTECODE", "1").current_dir(&folder);
    let output = command.output().expect("the interpreter runs");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}\n{}", String::from_utf8_lossy(&output.stderr));
}
