//! The JSON in what a model says.
//!
//! Models put a fence around it, or a sentence before and behind. The first object that can be read is the answer; where
//! none can, the place of the first mistake in the most promising text is told.

use serde_json::Value;

/// Why there is no JSON in an answer.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AnswerError {
    /// Not one brace.
    #[error("the answer holds no JSON object; answer with one object and nothing else")]
    None,
    /// It begins and cannot be read.
    #[error("the JSON of the answer cannot be read at line {line}, column {column}: {reason}")]
    Broken {
        /// Line in the object, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong there.
        reason: String,
    },
    /// It begins and does not end.
    #[error("the JSON of the answer ends at line {line} before it is complete")]
    Truncated {
        /// Line in the object, from 1.
        line: usize,
    },
}

/// The text of the first JSON object in `text`.
///
/// # Errors
///
/// If there is none, or it is not complete.
pub fn object(text: &str) -> Result<&str, AnswerError> {
    let mut first = None;
    let mut at = 0;
    // An object inside of one that cannot be read is not what was asked for; only text before the first brace that begins
    // an object is passed over, such as `{name}` in a sentence.
    while let Some(brace) = text[at..].find('{') {
        let rest = &text[at + brace..];
        let mut stream = serde_json::Deserializer::from_str(rest).into_iter::<Value>();
        match stream.next() {
            Some(Ok(Value::Object(_))) => return Ok(&rest[..stream.byte_offset()]),
            Some(Err(error)) => {
                let looks_meant = rest[1..].trim_start().starts_with(['"', '}']);
                if looks_meant || first.is_none() {
                    let told = tell(&error);
                    if looks_meant {
                        return Err(told);
                    }
                    first = Some(told);
                }
            }
            _ => {}
        }
        at += brace + 1;
    }
    Err(first.unwrap_or(AnswerError::None))
}

fn tell(error: &serde_json::Error) -> AnswerError {
    if error.is_eof() {
        return AnswerError::Truncated { line: error.line() };
    }
    let text = error.to_string();
    let reason = text.split(" at line ").next().unwrap_or(&text).to_string();
    AnswerError::Broken { line: error.line(), column: error.column(), reason }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_object_alone_in_a_fence_or_in_a_sentence() {
        for text in [
            r#"{"layers": []}"#,
            "```json\n{\"layers\": []}\n```",
            "Here you are: {\"layers\": []} Good luck {smile}",
            "For {name} I made\n{\"layers\": []}",
        ] {
            assert_eq!(object(text), Ok(r#"{"layers": []}"#), "{text}");
        }
    }

    #[test]
    fn what_is_wrong_is_told_with_its_place() {
        assert_eq!(object("I cannot do that."), Err(AnswerError::None));
        assert_eq!(object("{\"layers\": [\n  {\"name\": \"a\""), Err(AnswerError::Truncated { line: 2 }));
        let broken = object("{\"layers\": [1,\n  oops]}");
        assert!(matches!(broken, Err(AnswerError::Broken { line: 2, .. })), "{broken:?}");
        // What stands inside of a broken object is not taken for the answer.
        assert!(object("{\"layers\": [{\"a\": 1}, {\"b\": 2}, oops").is_err());
    }
}
