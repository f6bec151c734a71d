//! Files of sweeps: files of others are neither replaced nor removed, and damage is reported.

use std::path::{Path, PathBuf};

use super::{call, contents, folder, names, utf8};

fn spec(dir: &Path) -> PathBuf {
    let spec = super::arm(dir, "first", "50 ms");
    let text = contents(&spec) + "\nscenario s {\n  seed 1\n}\n";
    std::fs::write(&spec, text).expect("writable");
    spec
}

fn sweep(spec: &Path, out: &Path, more: &[&str]) -> (Option<i32>, String, String) {
    call(&[&["sweep", utf8(spec), "--runs", "4", "--out", utf8(out)], more].concat())
}

#[test]
fn files_of_others_stay() {
    let dir = folder("sweep_others");
    let spec = spec(&dir);
    let (out, journal) = (dir.join("m.parquet"), dir.join("m.parquet.journal"));
    for foreign in ["no end of line", "two\nlines\n", "{\"version\"", "{\"version\":1,"] {
        let begun = foreign.starts_with('{');
        std::fs::write(&journal, foreign).expect("writable");
        let (code, _, err) = sweep(&spec, &out, &[]);
        assert_eq!(code, Some(if begun { 0 } else { 2 }), "{err}");
        if begun {
            // A truncated head is that of a sweep that was killed.
            assert!(out.exists() && !journal.exists());
            std::fs::remove_file(&out).expect("removed");
        } else {
            assert!(err.contains("is no journal of a sweep") && !out.exists(), "{err}");
            assert_eq!(contents(&journal), foreign);
            std::fs::remove_file(&journal).expect("removed");
        }
    }
    for foreign in ["mine", "PAR1 but no more", "PAR1\u{0}\u{0}\u{0}\u{0}PAR1"] {
        std::fs::write(&out, foreign).expect("writable");
        let (code, _, err) = sweep(&spec, &out, &[]);
        assert_eq!((code, err.contains("is not the file of a sweep")), (Some(2), true), "{foreign:?}: {err}");
        assert_eq!(contents(&out), foreign);
        let (code, _, err) = call(&["sweep", "--merge", utf8(&spec), "--out", utf8(&out)]);
        assert_eq!((code, err.contains("is not the file of a sweep")), (Some(2), true), "{err}");
    }
    std::fs::remove_file(&out).expect("removed");
    // A file of a sweep is replaced, by the same sweep and by another one.
    for runs in ["4", "4", "3"] {
        assert_eq!(sweep(&spec, &out, &["--seed", runs]).0, Some(0));
    }
    let (code, _, err) = call(&["sweep", "--merge", utf8(&out), "--out", utf8(&out)]);
    assert_eq!((code, err.contains("would overwrite what it is made from")), (Some(2), true), "{err}");
    assert_eq!(names(&dir), ["m.parquet", "two.hq", "two.urdf"]);
}

#[cfg(unix)]
#[test]
fn a_journal_that_is_a_link_is_not_followed() {
    let dir = folder("sweep_links");
    let spec = spec(&dir);
    let other = dir.join("other");
    std::fs::write(&other, "").expect("writable");
    std::os::unix::fs::symlink(&other, dir.join("m.parquet.journal")).expect("a link");
    let (code, _, err) = sweep(&spec, &dir.join("m.parquet"), &[]);
    assert_eq!((code, err.contains("it is a link")), (Some(2), true), "{err}");
    assert_eq!(contents(&other), "");
}

/// Every byte is protected: no changed byte is accepted as data, and none lets the library panic.
#[test]
fn a_damaged_file_is_refused_by_its_name() {
    let dir = folder("sweep_damaged");
    let spec = spec(&dir);
    let (a, b) = (dir.join("a.parquet"), dir.join("b.parquet"));
    assert_eq!(sweep(&spec, &a, &["--shard", "1/2"]).0, Some(0));
    assert_eq!(sweep(&spec, &b, &["--shard", "2/2"]).0, Some(0));
    let whole = std::fs::read(&b).expect("written");
    assert!(hierarq::sweep::table::read(&b).is_ok());
    let damaged = dir.join("damaged.parquet");
    for at in 0..whole.len() {
        let mut bytes = whole.clone();
        bytes[at] ^= if at % 2 == 0 { 0x01 } else { 0x7f };
        std::fs::write(&damaged, &bytes).expect("writable");
        let e = hierarq::sweep::table::read(&damaged).expect_err("damaged");
        assert!(e.contains("damaged.parquet"), "byte {at}: {e}");
    }
    for length in (0..whole.len()).step_by(7) {
        std::fs::write(&damaged, &whole[..length]).expect("writable");
        assert!(hierarq::sweep::table::read(&damaged).is_err(), "{length} bytes");
    }
    let out = dir.join("all.parquet");
    let (code, _, err) = call(&["sweep", "--merge", utf8(&a), utf8(&damaged), "--out", utf8(&out)]);
    assert_eq!((code, err.contains("damaged.parquet")), (Some(2), true), "{err}");
    assert!(!err.contains("panicked"), "{err}");
    assert_eq!(call(&["sweep", "--merge", utf8(&a), utf8(&b), "--out", utf8(&out)]).0, Some(0));
}
