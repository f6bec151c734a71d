//! Names: splitting into words, and conversion to identifiers of the language.

/// True for a name that needs no quotes.
pub(super) fn is_plain(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_')
}

/// Converts any text to an identifier; `otherwise` is the fallback and the prefix of numbers.
pub(super) fn plain(text: &str, otherwise: &str) -> String {
    let name: String = text.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    let name = name.trim_matches('_');
    match name.chars().next() {
        None => otherwise.to_string(),
        Some(c) if c.is_ascii_digit() => format!("{otherwise}_{name}"),
        Some(_) => name.to_string(),
    }
}

/// Words of a name in lower case, without numbers: `LShoulderPitch` has `left`, `shoulder`, `pitch`.
pub(super) fn words(name: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut before = ' ';
    let mut chars = name.chars().peekable();
    while let Some(c) = chars.next() {
        let next_small = chars.peek().is_some_and(char::is_ascii_lowercase);
        if c.is_ascii_alphabetic() {
            let begins = !before.is_ascii_alphabetic()
                || (c.is_ascii_uppercase() && (before.is_ascii_lowercase() || next_small));
            if begins {
                words.push(String::new());
            }
            if let Some(word) = words.last_mut() {
                word.push(c.to_ascii_lowercase());
            }
        }
        before = c;
    }
    for word in &mut words {
        match word.as_str() {
            "l" => *word = "left".to_string(),
            "r" => *word = "right".to_string(),
            _ => {}
        }
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_have_words() {
        assert_eq!(words("LShoulderPitch"), ["left", "shoulder", "pitch"]);
        assert_eq!(words("arm_left_2_link"), ["arm", "left", "link"]);
        assert_eq!(words("left_s0"), ["left", "s"]);
        assert_eq!(words("panda-joint7"), ["panda", "joint"]);
        assert_eq!(words("RWrist"), ["right", "wrist"]);
        assert_eq!(words("42"), Vec::<String>::new());
    }

    #[test]
    fn any_text_gives_a_plain_name() {
        for (text, name) in [("my robot!", "my_robot"), ("3dof", "robot_3dof"), ("", "robot"), ("--", "robot")] {
            assert_eq!(plain(text, "robot"), name);
            assert!(is_plain(name));
        }
    }
}
