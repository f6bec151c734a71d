//! Dependencies: licences, sources, duplicates and bans as `deny.toml` permits them, and the crates that a tick of the
//! controller may run, each with its reviewed version. No network: the crates are present after a build.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use serde_json::Value;
use toml_edit::{Document, Item};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

fn policy() -> Document<String> {
    let text = std::fs::read_to_string(Path::new(ROOT).join("deny.toml")).expect("deny.toml is there");
    text.parse().expect("deny.toml is TOML")
}

/// Returns the texts of a list, or those of one key of its tables.
fn words(item: &Item, key: Option<&str>) -> BTreeSet<String> {
    let list = item.as_array().expect("a list");
    let word = |value: &toml_edit::Value| match key {
        None => value.as_str().map(str::to_string),
        Some(key) => value.as_inline_table().and_then(|table| table.get(key)?.as_str().map(str::to_string)),
    };
    list.iter().map(|value| word(value).expect("a text")).collect()
}

/// Returns all crates of the lock file, as (name, version, source).
fn locked() -> Vec<(String, String, Option<String>)> {
    let text = std::fs::read_to_string(Path::new(ROOT).join("Cargo.lock")).expect("Cargo.lock is there");
    let lock: Document<String> = text.parse().expect("Cargo.lock is TOML");
    let text = |table: &toml_edit::Table, key: &str| table.get(key).and_then(Item::as_str).map(str::to_string);
    let packages = lock["package"].as_array_of_tables().expect("packages");
    packages
        .iter()
        .map(|p| (text(p, "name").expect("a name"), text(p, "version").expect("a version"), text(p, "source")))
        .collect()
}

/// Returns Cargo's metadata of the crates that are built for this machine.
fn metadata() -> Value {
    let cargo = || Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    let version = cargo().arg("-vV").output().expect("cargo runs");
    let version = String::from_utf8(version.stdout).expect("text");
    let host = version.lines().find_map(|line| line.strip_prefix("host: ")).expect("a host");
    let mut command = cargo();
    command.current_dir(ROOT).args([
        "metadata",
        "--all-features",
        "--format-version",
        "1",
        "--offline",
        "--locked",
        "--filter-platform",
        host,
    ]);
    let output = command.output().expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

fn packages(metadata: &Value) -> BTreeMap<&str, &Value> {
    metadata["packages"].as_array().expect("packages").iter().map(|p| (p["id"].as_str().expect("an id"), p)).collect()
}

fn name(package: &Value) -> (&str, &str) {
    (package["name"].as_str().expect("a name"), package["version"].as_str().expect("a version"))
}

/// Returns true if the allowed licences satisfy an expression: `A OR B`, `A AND (B OR C)`, and the older `A/B`.
fn is_allowed(expression: &str, allowed: &BTreeSet<String>) -> bool {
    let text = expression.replace('/', " OR ").replace('(', " ( ").replace(')', " ) ");
    let tokens: Vec<&str> = text.split_whitespace().collect();
    let mut at = 0;
    let good = either(&tokens, &mut at, allowed);
    good && at == tokens.len()
}

fn either(tokens: &[&str], at: &mut usize, allowed: &BTreeSet<String>) -> bool {
    let mut good = both(tokens, at, allowed);
    while tokens.get(*at) == Some(&"OR") {
        *at += 1;
        good |= both(tokens, at, allowed);
    }
    good
}

fn both(tokens: &[&str], at: &mut usize, allowed: &BTreeSet<String>) -> bool {
    let mut good = one(tokens, at, allowed);
    while tokens.get(*at) == Some(&"AND") {
        *at += 1;
        good &= one(tokens, at, allowed);
    }
    good
}

fn one(tokens: &[&str], at: &mut usize, allowed: &BTreeSet<String>) -> bool {
    let Some(&token) = tokens.get(*at) else { return false };
    *at += 1;
    if token == "(" {
        let good = either(tokens, at, allowed);
        let closed = tokens.get(*at) == Some(&")");
        *at += 1;
        return good && closed;
    }
    let mut licence = token.to_string();
    if tokens.get(*at) == Some(&"WITH") {
        licence += &format!(" WITH {}", tokens.get(*at + 1).unwrap_or(&""));
        *at += 2;
    }
    allowed.contains(&licence)
}

#[test]
fn expressions_of_licences_are_understood() {
    let allowed = BTreeSet::from(["MIT", "ISC", "Apache-2.0 WITH LLVM-exception"].map(str::to_string));
    for good in ["MIT", "GPL-3.0 OR MIT", "GPL-3.0/MIT", "ISC AND (MIT OR GPL-3.0)", "Apache-2.0 WITH LLVM-exception"] {
        assert!(is_allowed(good, &allowed), "{good}");
    }
    for bad in ["", "GPL-3.0", "MIT AND GPL-3.0", "(MIT OR ISC) AND GPL-3.0", "Apache-2.0", "(MIT", "MIT ISC"] {
        assert!(!is_allowed(bad, &allowed), "{bad}");
    }
}

#[test]
fn every_crate_has_a_licence_that_is_allowed() {
    let (policy, metadata) = (policy(), metadata());
    let allowed = words(&policy["licenses"]["allow"], None);
    let licence = |p: &&Value| p["license"].as_str().unwrap_or_default().to_string();
    let exceptions = policy["licenses"]["exceptions"].as_array().expect("a list");
    let excepted = |p: &Value| {
        let of = exceptions.iter().filter_map(toml_edit::Value::as_inline_table);
        let own = of.filter(|e| e.get("crate").and_then(toml_edit::Value::as_str) == Some(name(p).0));
        let texts = own.filter_map(|e| e.get("allow")?.as_array()).flatten().filter_map(|text| text.as_str());
        is_allowed(&licence(&p), &texts.map(str::to_string).collect())
    };
    let packages = packages(&metadata);
    assert!(packages.len() > 200, "{} crates", packages.len());
    let wrong: Vec<_> = packages
        .values()
        .filter(|p| !is_allowed(&licence(p), &allowed) && !excepted(p))
        .map(|p| (name(p), licence(p)))
        .collect();
    assert!(wrong.is_empty(), "no licence of `deny.toml`: {wrong:?}");
}

#[test]
fn every_crate_is_of_the_workspace_or_of_the_registry_and_none_is_banned() {
    let policy = policy();
    let registries = words(&policy["sources"]["allow-registry"], None);
    let banned = words(&policy["bans"]["deny"], Some("crate"));
    for (name, version, source) in locked() {
        let ours = name == "hierarq" || name.starts_with("hierarq-");
        match source.as_deref() {
            None => assert!(ours, "{name} {version} comes from a folder"),
            Some(source) => {
                let known = source.strip_prefix("registry+").is_some_and(|registry| registries.contains(registry));
                assert!(known && !ours, "{name} {version} comes from {source}");
            }
        }
        assert!(!banned.contains(&name), "{name} is banned by `deny.toml`");
    }
}

#[test]
fn what_is_there_in_two_versions_is_named_with_a_reason() {
    let (policy, metadata) = (policy(), metadata());
    let skipped = words(&policy["bans"]["skip"], Some("crate"));
    assert!(!words(&policy["bans"]["skip"], Some("reason")).contains(""), "a reason is empty");
    let mut versions: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for package in packages(&metadata).values() {
        let (name, version) = name(package);
        versions.entry(name).or_default().push(version);
    }
    for (name, all) in &versions {
        let left: Vec<_> = all.iter().filter(|version| !skipped.contains(&format!("{name}@{version}"))).collect();
        assert!(left.len() <= 1, "{name} is there as {left:?}: say in `deny.toml` why, or do without");
    }
    let locked: BTreeSet<String> = locked().into_iter().map(|(name, version, _)| format!("{name}@{version}")).collect();
    let gone: Vec<_> = skipped.difference(&locked).collect();
    assert!(gone.is_empty(), "`deny.toml` names what is not there any longer: {gone:?}");
}

/// Returns the dependencies of the crates that a tick runs, without build dependencies.
fn behind_the_loop(metadata: &Value) -> BTreeSet<(String, String)> {
    let packages = packages(metadata);
    let nodes = metadata["resolve"]["nodes"].as_array().expect("nodes");
    let nodes: BTreeMap<&str, &Value> = nodes.iter().map(|n| (n["id"].as_str().expect("an id"), n)).collect();
    let of_a_tick = ["hierarq-robot", "hierarq-solver", "hierarq-stdlib-tasks"];
    let mut open: Vec<&str> =
        packages.iter().filter(|(_, p)| of_a_tick.contains(&name(p).0)).map(|(id, _)| *id).collect();
    assert_eq!(open.len(), of_a_tick.len());
    let (mut seen, mut out) = (BTreeSet::new(), BTreeSet::new());
    while let Some(id) = open.pop() {
        let package = packages[id];
        let builds = |t: &Value| t["kind"].as_array().is_some_and(|kinds| kinds.iter().any(|k| k == "proc-macro"));
        if !seen.insert(id) || package["targets"].as_array().is_some_and(|targets| targets.iter().any(builds)) {
            continue;
        }
        if !package["source"].is_null() {
            let (name, version) = name(package);
            out.insert((name.to_string(), version.to_string()));
        }
        for dependency in nodes[id]["deps"].as_array().expect("dependencies") {
            let normal = |kind: &Value| kind["kind"].is_null();
            if dependency["dep_kinds"].as_array().is_some_and(|kinds| kinds.iter().any(normal)) {
                open.push(dependency["pkg"].as_str().expect("an id"));
            }
        }
    }
    out
}

#[test]
fn crates_behind_the_control_loop_were_looked_at_in_this_version() {
    let page =
        std::fs::read_to_string(Path::new(ROOT).join("docs/src/internals/supply_chain.md")).expect("the page is there");
    let reviewed: BTreeSet<(String, String)> = page
        .lines()
        .filter_map(|line| {
            let mut cells = line.strip_prefix("| `")?.split(" | ");
            let (name, version) = cells.next()?.strip_suffix('`')?.split_once(' ')?;
            Some((name.to_string(), version.to_string()))
        })
        .collect();
    let there = behind_the_loop(&metadata());
    let missing: Vec<_> = there.difference(&reviewed).collect();
    assert!(missing.is_empty(), "look at these, and add them to docs/src/internals/supply_chain.md: {missing:?}");
    let gone: Vec<_> = reviewed.difference(&there).collect();
    assert!(gone.is_empty(), "the page names what is not there any longer: {gone:?}");
}
