//! Conversion between `file:` addresses and paths.

use std::path::{Component, Path, PathBuf};

use lsp_types::Uri;

/// Path of a `file:` address on this machine.
pub(super) fn path(uri: &Uri) -> Option<PathBuf> {
    let rest = uri.as_str().strip_prefix("file://")?;
    let rest = rest.strip_prefix("localhost").unwrap_or(rest);
    let rest = rest.split(['?', '#']).next()?;
    let mut bytes = Vec::with_capacity(rest.len());
    let mut at = rest.bytes();
    while let Some(b) = at.next() {
        if b != b'%' {
            bytes.push(b);
            continue;
        }
        let digits = [at.next()?, at.next()?];
        bytes.push(u8::from_str_radix(std::str::from_utf8(&digits).ok()?, 16).ok()?);
    }
    let text = String::from_utf8(bytes).ok()?;
    // `/C:/robots` starts with a drive.
    let drive = text.as_bytes();
    if cfg!(windows) && drive.len() > 2 && drive[0] == b'/' && drive[2] == b':' {
        return Some(PathBuf::from(&text[1..]));
    }
    text.starts_with('/').then(|| PathBuf::from(text))
}

/// Absolute path without `..`, for comparison with paths of editors.
pub(super) fn absolute(path: &Path) -> Option<PathBuf> {
    let whole = std::path::absolute(path).ok()?;
    let mut out = PathBuf::new();
    for part in whole.components() {
        match part {
            Component::ParentDir => {
                out.pop();
            }
            other => out.push(other),
        }
    }
    Some(out)
}

/// Address of a path.
pub(super) fn of(path: &Path) -> Option<Uri> {
    let path = absolute(path)?;
    let text = path.to_str()?;
    let mut out = String::from(if text.starts_with('/') { "file://" } else { "file:///" });
    for b in text.bytes() {
        match b {
            b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' => out.push(char::from(b)),
            b'\\' if cfg!(windows) => out.push('/'),
            b':' if cfg!(windows) => out.push(':'),
            _ => out.push_str(&format!("%{b:02X}")),
        }
    }
    out.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back() {
        for name in ["/a/b.hq", "/mit Leerzeichen/ü😀/100%.hq", "/a+b/[c]#?.yaml"] {
            let uri = of(Path::new(name)).expect("an address");
            assert_eq!(path(&uri), Some(PathBuf::from(name)), "{}", uri.as_str());
        }
    }

    #[test]
    fn other_addresses() {
        for text in ["untitled:Untitled-1", "http://example.org/a.hq", "file:///a/%ff.hq", "file:///a%2"] {
            assert_eq!(text.parse::<Uri>().ok().and_then(|u| path(&u)), None, "{text}");
        }
    }
}
