//! The JSON in what a model says.
//!
//! Models put a fence around it, or a sentence before and behind. The first object that can be read is the answer; where
//! none can, the text from the first brace on that seems meant as one, so that the reader of layers can say what is wrong.

use serde_json::Value;

/// The text of the first JSON object in `text`, or what was meant as one to the end; none without a brace.
pub fn object(text: &str) -> Option<&str> {
    let mut first = None;
    let mut at = 0;
    while let Some(brace) = text[at..].find('{') {
        let rest = &text[at + brace..];
        let mut stream = serde_json::Deserializer::from_str(rest).into_iter::<Value>();
        if let Some(Ok(Value::Object(_))) = stream.next() {
            return Some(&rest[..stream.byte_offset()]);
        }
        // An object inside of one that cannot be read is not what was asked for; only a brace that begins no object is passed
        // over, such as `{name}` in a sentence.
        if rest[1..].trim_start().starts_with(['"', '}']) {
            return Some(rest);
        }
        first.get_or_insert(rest);
        at += brace + 1;
    }
    first
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
            assert_eq!(object(text), Some(r#"{"layers": []}"#), "{text}");
        }
    }

    #[test]
    fn what_cannot_be_read_is_given_as_it_is() {
        assert_eq!(object("I cannot do that."), None);
        assert_eq!(object("So: {\"layers\": [\n  {\"name\""), Some("{\"layers\": [\n  {\"name\""));
        // What stands inside of a broken object is not taken for the answer.
        assert_eq!(object("{\"layers\": [{\"a\": 1}, oops"), Some("{\"layers\": [{\"a\": 1}, oops"));
        assert_eq!(object("{layers: [{\"a\": 1}]}"), Some("{\"a\": 1}"));
        assert_eq!(object("{ü {"), Some("{ü {"));
    }
}
