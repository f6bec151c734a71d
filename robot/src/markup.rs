//! Detection of XML elements with too many attributes, before the text is parsed: the parser compares each attribute of
//! an element with all others, which takes quadratic time.

use std::ops::Range;

/// Maximum number of attributes of an element. URDF and COLLADA define about a dozen.
pub const MAX_ATTRIBUTES: usize = 500;

/// Returns the range of the name, with the bracket before it, of the first element with more than [`MAX_ATTRIBUTES`]
/// attributes. The result is arbitrary if the text is not valid XML: the parser then rejects it.
#[must_use]
pub fn crowded(text: &str) -> Option<Range<usize>> {
    let bytes = text.as_bytes();
    let mut at = 0;
    while let Some(start) = text[at..].find('<').map(|n| at + n) {
        let behind = &text[start..];
        let end = |close: &str| behind.find(close).map(|n| start + n + close.len());
        if behind.starts_with("<!--") {
            at = end("-->")?;
            continue;
        }
        if behind.starts_with("<![CDATA[") {
            at = end("]]>")?;
            continue;
        }
        let mut values = 0;
        at = start + 1;
        while let Some(&byte) = bytes.get(at) {
            at += 1;
            match byte {
                b'>' => break,
                b'"' | b'\'' => {
                    values += 1;
                    if values > MAX_ATTRIBUTES {
                        let name = behind.find(|c: char| c.is_ascii_whitespace()).unwrap_or(1);
                        return Some(start..start + name);
                    }
                    at += bytes[at..].iter().position(|b| *b == byte)? + 1;
                }
                _ => {}
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn element(attributes: usize) -> String {
        let all: String = (0..attributes).map(|i| format!(" a{i}='>\"'")).collect();
        format!(
            "<robot name=\"r\"><!-- <{} --><![CDATA[ <' ]]><link{all}/></robot>",
            "\"\" ".repeat(MAX_ATTRIBUTES + 1)
        )
    }

    #[test]
    fn attributes_are_counted_for_each_element() {
        let good = element(MAX_ATTRIBUTES);
        assert!(roxmltree::Document::parse(&good).is_ok());
        assert_eq!(crowded(&good), None);
        let bad = element(MAX_ATTRIBUTES + 1);
        assert_eq!(crowded(&bad).map(|place| &bad[place]), Some("<link"));
    }

    #[test]
    fn what_is_no_xml_ends() {
        for text in ["", "<", "<!--", "<![CDATA[", "<a b=\"", "<a b='", "<<<>>>", "é<é é=\"é\">"] {
            assert_eq!(crowded(text), None, "{text}");
        }
    }
}
