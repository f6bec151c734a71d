//! The mistakes of form, family `HQ01xx`: code, title, and what `hierarq explain` says.

/// `(code, title, explanation)` for every code this crate reports, in rising order.
pub static CODES: &[(&str, &str, &str)] = &[
    (
        "HQ0101",
        "header missing",
        "A spec begins with the version of the language it is written in: `hierarq 1` in a `*.hq` file, `hierarq: 1` in YAML. The line lets a later Hierarq read old specs as they were meant. Comments may stand before it.",
    ),
    (
        "HQ0102",
        "unsupported version",
        "This Hierarq reads version 1 of the language. A spec with another number needs another Hierarq, or, if the number was a guess, the number 1.",
    ),
    (
        "HQ0103",
        "unknown declaration",
        "At the top level stand `import`, `param`, `let`, `robot`, `task`, `stack`, `for` and `run`. In YAML the keys are `hierarq`, `import`, `params`, `lets`, `robots`, `tasks`, `stacks`, `for` and `run`.",
    ),
    (
        "HQ0104",
        "`=` missing or misplaced",
        "`param`, `let` and `task` give a name to something: `param reach = 0.8 m`, `task still = hold(left)`. The `=` stands between the name and what it names. `robot`, `stack` and `run` have a block and no `=`.",
    ),
    (
        "HQ0105",
        "bracket not closed",
        "A `{`, `[` or `(` has no partner. The reader takes a declaration at the beginning of a line as the end of everything left open before it, so the rest of the file is still checked.",
    ),
    (
        "HQ0106",
        "bracket not opened",
        "A `}`, `]` or `)` closes nothing. Usually one closing bracket too many, or one opening bracket deleted.",
    ),
    (
        "HQ0107",
        "value missing",
        "Every key in a block has a value: `d_min 0.5 m`. Here the block, or the line, ends behind the key. In YAML an empty value or `null` counts as missing.",
    ),
    (
        "HQ0108",
        "`:` or `=` between key and value",
        "In a `*.hq` file key and value stand side by side: `d_min 0.5 m`. The colon belongs to the YAML spelling, the equals sign to `param` and `task`.",
    ),
    (
        "HQ0109",
        "quotes",
        "A text stands between double quotes on one line: `urdf \"robots/arm.urdf\"`. Inside it, `\\\"` is a quote, `\\\\` a backslash and `\\n` a line break; `\\t`, `\\r` and `\\u{e9}` work too.",
    ),
    ("HQ0110", "`#` is not a comment here", "Comments in a `*.hq` file begin with `//`; `#` begins one in YAML only."),
    (
        "HQ0111",
        "number",
        "A number has a digit before and behind the point (`0.5`, not `.5` or `5.`), no separators inside (`1000`), may have an exponent (`1e-3`), and is finite.",
    ),
    (
        "HQ0112",
        "unknown unit",
        "A unit is a product of symbols such as `m`, `rad`, `s`, `kg`, `N` with whole powers: `0.5 m/s^2`, `253 N s/m`, `5 /s`. The word behind the number is none of them.",
    ),
    (
        "HQ0113",
        "unexpected text",
        "The reader expected something else at this place. The message says what it could not read; the rest of the line is skipped.",
    ),
    ("HQ0114", "operand missing", "`+`, `-`, `*`, `/` and `^` stand between two values. Here one of them is missing."),
    (
        "HQ0115",
        "key given twice",
        "A key stands once in a block. Which of two values was meant cannot be known, so neither is chosen silently.",
    ),
    (
        "HQ0116",
        "name missing",
        "A declaration has a name: letters, digits and `_`, not beginning with a digit. `level hard { .. }` has none: `hard` says what the level is, and no level can be called so.",
    ),
    (
        "HQ0117",
        "block missing",
        "`robot`, `stack`, `level` and `run` are followed by a block in braces. In YAML it is a mapping, for `levels` and `tasks` a sequence.",
    ),
    (
        "HQ0118",
        "`hard`",
        "`hard` stands once in the head of a level, behind its name: `level limits hard { .. }`. In YAML it is `hard: true` or `hard: false`.",
    ),
    (
        "HQ0119",
        "text expected",
        "The value of this key is a text, such as a path: it stands in double quotes in a `*.hq` file. In YAML no quotes are needed.",
    ),
    (
        "HQ0120",
        "unknown escape",
        "Inside a text, a backslash is followed by one of `\"`, `\\`, `n`, `t`, `r` or `u{..}` with the hexadecimal number of a character.",
    ),
    (
        "HQ0121",
        "word reserved here",
        "Some keys would mean two things in one of the two spellings: a robot cannot have a key `from`, a stack none called `level`, `levels`, `from`, `changes`, `replace`, `add` or `remove`, a level none called `name`, `hard`, `tasks`, `replace`, `add`, `remove`, `before` or `after`, a member of a level only `task` and `weight`. A pattern such as `\"arm_*\"` can be a key where joints are named, and no setting.",
    ),
    (
        "HQ0128",
        "parameters of a declaration",
        "What a task or a stack takes stands in parentheses behind its name, each parameter with its type: `task reach(side: arm, goal: point, gain: rate = 5 /s) = ..`. In YAML the same text is the key, in quotes. A robot takes nothing.",
    ),
    (
        "HQ0123",
        "arguments out of order",
        "Arguments without a name go to the parameters in their order, so they stand before those with a name: `reach(left, gain: 2 /s)`.",
    ),
    (
        "HQ0124",
        "incomplete import",
        "An import says which file and which of its names: `import \"common/safety.hq\" { deck, canopies as robot }`, in YAML `import: { common/safety.hq: [deck, canopies as robot] }`. What is not named is not visible.",
    ),
    (
        "HQ0125",
        "incomplete repetition",
        "`for NAME in VALUES { .. }` repeats declarations, or members of a level, once for each value of a list or of a range of whole numbers: `for side in [left, right] { .. }`, `for i in 1..4 { .. }`. In YAML it is a mapping with `name`, `in` and what is repeated. Imports, robots and runs cannot be repeated.",
    ),
    (
        "HQ0126",
        "changes of a stack",
        "A stack that is made from another one, `stack semi from autonomous { .. }`, says only what differs: `replace LEVEL { .. }`, `add LEVEL { .. } before OTHER`, `remove LEVEL`. Any other stack lists its levels.",
    ),
    (
        "HQ0127",
        "range of a param",
        "A param may say between which values it lies: `param approach = 0.15 m { min 0.05 m  max 0.3 m }`, in YAML `approach: { value: 0.15 m, min: 0.05 m, max: 0.3 m }`. Either bound may be left out.",
    ),
    (
        "HQ0130",
        "YAML syntax",
        "The text is not YAML. Frequent causes: a tab in the indentation, a bracket or quote left open, a `:` without a space behind it, a value with `: ` or `#` in it that needs quotes.",
    ),
    (
        "HQ0131",
        "wrong YAML shape",
        "A mapping, a sequence or a single value is expected here and another of the three was found.",
    ),
    ("HQ0132", "unknown YAML key", "The key is none of those that may stand here."),
    ("HQ0133", "several YAML documents", "A spec is one YAML document: `---` may stand before it, not inside it."),
    (
        "HQ0134",
        "alias or merge",
        "An alias `*name` repeats the node marked `&name` before it. It may not contain itself, and all aliases together may not expand to more than 100,000 nodes. `<<` merges mappings only.",
    ),
    (
        "HQ0135",
        "not a name",
        "Keys and names consist of letters, digits and `_` and do not begin with a digit. A frame or joint whose name has other characters is written as a text where a value may stand.",
    ),
    ("HQ0136", "YAML tag", "Tags such as `!!str` or `!custom` have no meaning in a spec."),
    (
        "HQ0190",
        "too large",
        "A text may have 8 MiB and 400,000 words and signs. The bounds keep the time and memory of reading any file small.",
    ),
    ("HQ0191", "nested too deeply", "Brackets and YAML collections may be nested 64 deep."),
    ("HQ0192", "too many mistakes", "Only the first 100 diagnostics of a text are kept."),
    ("HQ0193", "not UTF-8", "A spec is a text in UTF-8."),
    (
        "HQ0194",
        "control character",
        "The text contains a character that cannot be seen, other than a tab or the end of a line.",
    ),
    (
        "HQ0195",
        "expression too long",
        "An expression may have 200 operators in one row and 256 levels of operations in total. Name a part of it with `param`.",
    ),
];

/// Title and explanation of a code of this crate.
pub fn explain(code: &str) -> Option<(&'static str, &'static str)> {
    CODES.iter().find(|c| c.0 == code).map(|c| (c.1, c.2))
}
