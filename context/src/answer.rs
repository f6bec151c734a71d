//! The JSON in what a model says.
//!
//! Models put a fence around it, a sentence before and behind, drafts before the answer, and some think aloud before they
//! speak. Thoughts are passed over, up to `</think>`. Of what is left the last object with `layers` or `tasks` is the answer;
//! where none has them the longest, a bare list of objects too, so that the reader of layers can say what is wrong.

use serde_json::Value;

/// Where thoughts end.
const THOUGHT: &str = "</think>";

/// A part of what a model said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part<'a> {
    text: &'a str,
    from: usize,
    to: usize,
}

impl<'a> Part<'a> {
    /// The part alone.
    pub fn alone(&self) -> &'a str {
        &self.text[self.from..self.to]
    }

    /// The part with space before it in place of what was said before, so that it stands in the same line and column.
    pub fn in_place(&self) -> String {
        let before = &self.text[..self.from];
        let line = before.rfind('\n').map_or(before, |end| &before[end + 1..]);
        let lines = "\n".repeat(before.matches('\n').count());
        format!("{lines}{}{}", " ".repeat(line.chars().count()), self.alone())
    }

    /// Which lines it is, counted from 1; none where nothing else that was said could be meant.
    pub fn lines(&self) -> Option<(usize, usize)> {
        let line = |at: usize| self.text[..at].matches('\n').count() + 1;
        let others = self.text[..self.from].contains('{') || self.text[self.to..].contains('{');
        others.then(|| (line(self.from), line(self.to)))
    }
}

/// A complete value: whether it has layers (2), tasks (1) or neither, and where it is.
struct Found<'a> {
    rank: usize,
    part: Part<'a>,
}

impl Found<'_> {
    /// Of the same rank the last counts, but of those that have neither the longest.
    fn replaces(&self, other: &Found<'_>) -> bool {
        let length = |one: &Found<'_>| if one.rank == 0 { one.part.alone().len() } else { 0 };
        (self.rank, length(self)) >= (other.rank, length(other))
    }
}

/// The part of `text` that is the answer, or what was meant as one to the end; none without a brace.
pub fn part(text: &str) -> Option<Part<'_>> {
    let mut best: Option<Found<'_>> = None;
    // The first brace, and the first object since the best one that cannot be read: objects behind may be parts of it.
    let (mut brace, mut broken) = (None, None);
    let mut at = text.rfind(THOUGHT).map_or(0, |at| at + THOUGHT.len());
    while let Some(from) = text[at..].find(['{', '[']).map(|next| at + next) {
        let rest = &text[from..];
        let mut stream = serde_json::Deserializer::from_str(rest).into_iter::<Value>();
        let read = stream.next().and_then(Result::ok);
        if let Some(rank) = read.as_ref().and_then(rank) {
            at = from + stream.byte_offset();
            let found = Found { rank, part: Part { text, from, to: at } };
            if (broken.is_none() || rank == 2) && best.as_ref().is_none_or(|best| found.replaces(best)) {
                (best, broken) = (Some(found), None);
            }
            continue;
        }
        at = from + 1;
        if let Some(inside) = rest.strip_prefix('{') {
            brace.get_or_insert(from);
            // A brace that begins no object is passed over, such as `{name}` in a sentence.
            if inside.trim_start().starts_with('"') {
                broken.get_or_insert(from);
            }
        }
    }
    let meant = |from: &usize| ["\"layers\"", "\"tasks\""].iter().any(|key| text[*from..].contains(key));
    let to_the_end = |from: usize| Part { text, from, to: text.len() };
    match best {
        Some(best) => Some(broken.filter(meant).map_or(best.part, to_the_end)),
        None => broken.or(brace).map(to_the_end),
    }
}

/// See [`Found`]; none of what is no object and no list of them, or a list around the answer.
fn rank(value: &Value) -> Option<usize> {
    match value {
        Value::Object(object) if object.contains_key("layers") => Some(2),
        Value::Object(object) => Some(usize::from(object.contains_key("tasks"))),
        Value::Array(list) => {
            let objects = list.iter().any(Value::is_object) && !list.iter().any(|one| one.get("layers").is_some());
            objects.then_some(0)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn alone(text: &str) -> Option<&str> {
        part(text).map(|part| part.alone())
    }

    #[test]
    fn an_object_alone_in_a_fence_or_in_a_sentence() {
        for text in [
            r#"{"layers": []}"#,
            "```json\n{\"layers\": []}\n```",
            "Here you are: {\"layers\": []} Good luck {smile} {} [1]",
            "For {name} I made [see 1]\n{\"layers\": []}",
            "[{\"layers\": []}]",
        ] {
            assert_eq!(alone(text), Some(r#"{"layers": []}"#), "{text}");
        }
    }

    #[test]
    fn thoughts_and_drafts_are_passed_over() {
        let good = r#"{"layers": [{"name": "a"}]}"#;
        for before in [
            "<think>maybe {\"layers\": []} or so</think>\n",
            "maybe {\"layers\": [ or so</think>",
            "{\"layers\": []}\n\nBetter:\n",
            "{\"tasks\": []} or {\"layers\": [{\"name\": oops",
        ] {
            assert_eq!(alone(&format!("{before}{good}")), Some(good), "{before}");
        }
        // An answer that broke off is the answer, whatever was good before.
        assert_eq!(alone(&format!("{good} no: {{\"layers\": [")), Some("{\"layers\": ["));
        assert_eq!(alone(&format!("{good} as {{\"name\":")), Some(good));
    }

    #[test]
    fn what_cannot_be_read_is_given_as_it_is() {
        assert_eq!(alone("I cannot do that."), None);
        assert_eq!(alone("So: {\"layers\": [\n  {\"name\""), Some("{\"layers\": [\n  {\"name\""));
        // What stands inside of a broken object is not taken for the answer.
        assert_eq!(alone("{\"layers\": [{\"a\": 1}, oops"), Some("{\"layers\": [{\"a\": 1}, oops"));
        assert_eq!(alone("{layers: [{\"a\": 1}]}"), Some("[{\"a\": 1}]"));
        assert_eq!(alone("So: [{\"a\": 1}, {}] {}"), Some("[{\"a\": 1}, {}]"));
        assert_eq!(alone("{ü {"), Some("{ü {"));
    }

    #[test]
    fn places_are_those_of_the_whole_answer() {
        let part = part("one {ü}\ntwo {\"layers\":\n[]}\n\nend").unwrap();
        assert_eq!(part.in_place(), "\n    {\"layers\":\n[]}");
        assert_eq!(part.lines(), Some((2, 3)));
        assert_eq!(super::part("So:\n{} ").unwrap().lines(), None);
    }
}
