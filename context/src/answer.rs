//! Extraction of the JSON answer from a model's reply.
//!
//! Models put a fence around the JSON, sentences before and after it, and drafts before the final answer; some print
//! their reasoning first. The search skips the reasoning, up to the last `</think>`. In the rest, the last object with
//! the first key of the kind's answers is the answer, else the last one with the second, and so on. If no object has any of
//! the keys, it is the longest value, which may also be a list of objects: the reader of answers can then report the mistake.

use serde_json::Value;

/// End marker of a model's reasoning.
const THOUGHT: &str = "</think>";

/// A part of a model's reply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part<'a> {
    text: &'a str,
    from: usize,
    to: usize,
}

impl<'a> Part<'a> {
    /// Text of the part, without its surroundings.
    pub fn alone(&self) -> &'a str {
        &self.text[self.from..self.to]
    }

    /// Text of the part, padded with line breaks and spaces so that its line and column are those in the whole reply.
    pub fn in_place(&self) -> String {
        let before = &self.text[..self.from];
        let line = before.rfind('\n').map_or(before, |end| &before[end + 1..]);
        let lines = "\n".repeat(before.matches('\n').count());
        format!("{lines}{}{}", " ".repeat(line.chars().count()), self.alone())
    }

    /// First and last line of the part, counted from 1. None if the rest of the reply has no `{`: then the part is
    /// unambiguous.
    pub fn lines(&self) -> Option<(usize, usize)> {
        let line = |at: usize| self.text[..at].matches('\n').count() + 1;
        let others = self.text[..self.from].contains('{') || self.text[self.to..].contains('{');
        others.then(|| (line(self.from), line(self.to)))
    }
}

/// A complete JSON value. Its rank is the number of keys with the best one, 1 with the last one, 0 with none.
struct Found<'a> {
    rank: usize,
    part: Part<'a>,
}

impl Found<'_> {
    /// Returns true if this value, which follows `other`, is the better candidate: of a higher rank, or of the same
    /// rank; for rank 0 it must also be at least as long.
    fn replaces(&self, other: &Found<'_>) -> bool {
        let length = |one: &Found<'_>| if one.rank == 0 { one.part.alone().len() } else { 0 };
        (self.rank, length(self)) >= (other.rank, length(other))
    }
}

/// Returns the part of `text` that is the answer. If the answer is broken, the part extends to the end of `text`. None
/// if `text` has no usable JSON value and no `{`.
///
/// `keys` are those of the answer, the best first.
pub fn part<'a>(text: &'a str, keys: &[&str]) -> Option<Part<'a>> {
    let mut best: Option<Found<'_>> = None;
    // `brace` is the first `{`; `broken` is the first object since the best one that does not parse. Objects after
    // `broken` may be parts of it.
    let (mut brace, mut broken) = (None, None);
    let mut at = text.rfind(THOUGHT).map_or(0, |at| at + THOUGHT.len());
    while let Some(from) = text[at..].find(['{', '[']).map(|next| at + next) {
        let rest = &text[from..];
        let mut stream = serde_json::Deserializer::from_str(rest).into_iter::<Value>();
        let read = stream.next().and_then(Result::ok);
        if let Some(rank) = read.as_ref().and_then(|value| rank(value, keys)) {
            at = from + stream.byte_offset();
            let found = Found { rank, part: Part { text, from, to: at } };
            if (broken.is_none() || rank == keys.len()) && best.as_ref().is_none_or(|best| found.replaces(best)) {
                (best, broken) = (Some(found), None);
            }
            continue;
        }
        at = from + 1;
        if let Some(inside) = rest.strip_prefix('{') {
            brace.get_or_insert(from);
            // A brace that begins no object is skipped, such as `{name}` in a sentence.
            if inside.trim_start().starts_with('"') {
                broken.get_or_insert(from);
            }
        }
    }
    let meant = |from: &usize| keys.iter().any(|key| text[*from..].contains(&format!("\"{key}\"")));
    let to_the_end = |from: usize| Part { text, from, to: text.len() };
    match best {
        Some(best) => Some(broken.filter(meant).map_or(best.part, to_the_end)),
        None => broken.or(brace).map(to_the_end),
    }
}

/// Rank of a value, as in [`Found`]. None for a scalar, for a list without objects, and for a list around the answer.
fn rank(value: &Value, keys: &[&str]) -> Option<usize> {
    match value {
        Value::Object(object) => {
            let best = keys.iter().position(|key| object.contains_key(*key));
            Some(best.map_or(0, |best| keys.len() - best))
        }
        Value::Array(list) => {
            let answer = |one: &Value| keys.first().is_some_and(|key| one.get(*key).is_some());
            let objects = list.iter().any(Value::is_object) && !list.iter().any(answer);
            objects.then_some(0)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEYS: [&str; 2] = ["layers", "tasks"];

    fn alone(text: &str) -> Option<&str> {
        part(text, &KEYS).map(|part| part.alone())
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
        // A broken last answer is the answer, even if an earlier one was good.
        assert_eq!(alone(&format!("{good} no: {{\"layers\": [")), Some("{\"layers\": ["));
        assert_eq!(alone(&format!("{good} as {{\"name\":")), Some(good));
    }

    #[test]
    fn what_cannot_be_read_is_given_as_it_is() {
        assert_eq!(alone("I cannot do that."), None);
        assert_eq!(alone("So: {\"layers\": [\n  {\"name\""), Some("{\"layers\": [\n  {\"name\""));
        // Objects inside a broken object are not taken for the answer.
        assert_eq!(alone("{\"layers\": [{\"a\": 1}, oops"), Some("{\"layers\": [{\"a\": 1}, oops"));
        assert_eq!(alone("{layers: [{\"a\": 1}]}"), Some("[{\"a\": 1}]"));
        assert_eq!(alone("So: [{\"a\": 1}, {}] {}"), Some("[{\"a\": 1}, {}]"));
        assert_eq!(alone("{ü {"), Some("{ü {"));
    }

    #[test]
    fn places_are_those_of_the_whole_answer() {
        let part = part("one {ü}\ntwo {\"layers\":\n[]}\n\nend", &KEYS).unwrap();
        assert_eq!(part.in_place(), "\n    {\"layers\":\n[]}");
        assert_eq!(part.lines(), Some((2, 3)));
        assert_eq!(super::part("So:\n{} ", &KEYS).unwrap().lines(), None);
    }
}
