//! Checks of missions and their members that both readers share.

use std::collections::BTreeMap;

use crate::diagnostic::clip;
use crate::tree::{Block, Comments, Entry, MissionMember, MissionRepeat, ValueKind};
use crate::vocabulary::ROLES;
use crate::words::nearest;
use crate::{Diagnostic, Help, Snippet, Span, Spanned, checks};

/// Content of the braces of a mission, a member or a repetition.
#[derive(Debug, Default)]
pub(crate) struct Body {
    pub settings: Block,
    pub members: Vec<MissionMember>,
    pub repeats: Vec<MissionRepeat>,
}

impl Body {
    /// Creates an empty body.
    pub fn empty(span: Span) -> Body {
        Body { settings: Block { span, ..Block::default() }, ..Body::default() }
    }

    /// Converts the body to a member.
    pub fn member(
        self,
        (role, name): (Spanned<String>, Spanned<String>),
        action: Option<Spanned<String>>,
        span: Span,
        comments: Comments,
    ) -> MissionMember {
        let Body { settings, members, repeats } = self;
        MissionMember { role, name, action, settings, members, repeats, span, comments }
    }
}

/// Returns the role whose members are listed below a key of YAML.
pub(crate) fn role_below(key: &str) -> Option<&'static str> {
    ROLES.iter().find(|role| key.strip_suffix('s') == Some(role)).copied()
}

/// True for the mission, and for a role whose members hold members.
pub(crate) fn holds_members(what: &str) -> bool {
    ["mission", "layer"].contains(&what)
}

/// Reports and removes settings that would have another meaning in one of the syntaxes. `what` describes their owner.
pub(crate) fn settings(settings: &mut Block, what: &str, diags: &mut Vec<Diagnostic>) {
    checks::duplicates(&settings.entries, diags);
    let holds = holds_members(what) || what == owner("layer");
    settings.entries.retain(|entry| {
        if !holds && matches!(entry.value.kind, ValueKind::List(_)) {
            return true;
        }
        let key = entry.key.value.as_str();
        let Some(role) = role_below(key).or(Some(key).filter(|key| ["task", "layer"].contains(key))) else {
            return true;
        };
        let text = format!("`{key}` cannot be a setting of a {what}");
        let help = format!("a {role} is written `{role} NAME {{ .. }}`, in YAML below `{role}s:`");
        let diagnostic = Diagnostic::error("HQ0121", entry.key.span, text);
        diags.push(diagnostic.note("the word begins members of a mission in one of the two syntaxes").help(help));
        false
    });
    checks::reserved(settings, &["for"], what, diags);
}

/// Describes the owner of a body for [`settings`].
pub(crate) fn owner(role: &str) -> String {
    format!("{role} of a mission")
}

/// Reports sibling members with the same role and name; removes the second one.
pub(crate) fn distinct(members: &mut Vec<MissionMember>, diags: &mut Vec<Diagnostic>) {
    let mut seen: BTreeMap<(String, String), Span> = BTreeMap::new();
    members.retain(|member| {
        let key = (member.role.value.clone(), member.name.value.clone());
        match seen.get(&key) {
            Some(first) => {
                diags.push(checks::duplicate(&member.name.value, *first, member.name.span));
                false
            }
            None => {
                seen.insert(key, member.name.span);
                true
            }
        }
    });
}

/// Reports members that follow a repetition with members of their role: in YAML repetitions come last, so that the
/// order would depend on the syntax.
pub(crate) fn in_order(members: &[MissionMember], repeats: &[MissionRepeat], diags: &mut Vec<Diagnostic>) {
    for repeat in repeats {
        let behind = |m: &&MissionMember| m.span.start > repeat.span.start && repeats_role(repeat, &m.role);
        if let Some(member) = members.iter().find(behind) {
            let role = &member.role.value;
            let text = format!("the {role} `{}` follows a `for` with {role}s in it", clip(&member.name.value));
            let word = Span { end: repeat.span.start + "for".len() as u32, ..repeat.span };
            diags.push(
                Diagnostic::unknown_key("HQ0145", member.name.span, text)
                    .label(word, "repetitions must come last, because the order of members matters")
                    .help(format!("write it before the `for`, or write the {role}s of the `for` out")),
            );
        }
    }
}

fn repeats_role(repeat: &MissionRepeat, role: &str) -> bool {
    repeat.members.iter().any(|member| *member.role == *role)
        || repeat.repeats.iter().any(|inner| repeats_role(inner, role))
}

/// Returns the diagnostic for a mission without a kind.
pub(crate) fn no_kind(name: &str, span: Span) -> Diagnostic {
    let name = clip(name);
    Diagnostic::error("HQ0144", span, format!("the mission `{name}` has no kind")).help(Help::with(
        "write its kind: {}",
        [Snippet::each(format!("mission {name} : schedule {{ .. }}"), format!("{name}: {{ schedule: {{ .. }} }}"))],
    ))
}

/// Returns the diagnostic for a task without an action.
pub(crate) fn no_action(name: &str, span: Span) -> Diagnostic {
    let name = clip(name);
    Diagnostic::incomplete("HQ0107", span, format!("the task `{name}` has no action"))
        .help(Snippet::each(format!("task {name} = ACTION {{ .. }}"), format!("{name}: {{ ACTION: {{ .. }} }}")))
}

/// Returns true for a key before an action in place of the action itself: `action pick`.
pub(crate) fn says_action(key: &str) -> bool {
    matches!(key, "action" | "skill")
}

/// Returns the diagnostic for a YAML task with a key for its action in place of the action itself.
pub(crate) fn keyed_action(key: &Spanned<String>, fix: &str) -> Diagnostic {
    let text = format!("`{}` is not a setting of a task: its settings are indented below the action", clip(&key.value));
    Diagnostic::error("HQ0131", key.span, text).help(format!("write `{fix}`"))
}

/// Returns the diagnostic for a task whose action is inside its braces; `alone` if they contain nothing else.
pub(crate) fn action_inside(name: &Spanned<String>, action: &str, alone: bool) -> Diagnostic {
    let (name, action) = (Spanned::new(clip(&name.value), name.span), clip(action));
    let block = if alone { "" } else { " { .. }" };
    Diagnostic::incomplete(
        "HQ0107",
        name.span,
        format!("the action of the task `{}` must precede its braces", name.value),
    )
    .help(format!("write `task {} = {action}{block}`", name.value))
}

/// Removes the action that a task without one has among its settings, `{ pick { .. } }` or `{ action pick }`, and
/// returns it.
pub(crate) fn meant_action(settings: &mut Block) -> Option<String> {
    let named = settings.entries.iter().position(|entry| says_action(&entry.key.value));
    if let Some((at, ValueKind::Name(name))) = named.map(|at| (at, &settings.entries[at].value.kind)) {
        let name = name.clone();
        settings.entries.remove(at);
        return Some(name);
    }
    let [Entry { key, value, .. }] = settings.entries.as_slice() else { return None };
    let ValueKind::Block(own) = &value.kind else { return None };
    let (name, own) = (key.value.clone(), own.clone());
    *settings = own;
    Some(name)
}

/// Returns the diagnostic for a member without a name.
pub(crate) fn no_name(role: &str, span: Span) -> Diagnostic {
    Diagnostic::incomplete("HQ0116", span, format!("this `{role}` has no name"))
        .help(format!("write the name after `{role}`: letters, digits and `_`"))
}

/// Returns the diagnostic for a member without a block.
pub(crate) fn no_block(role: &str, span: Span) -> Diagnostic {
    Diagnostic::incomplete("HQ0117", span, format!("this `{role}` has no block"))
        .help(format!("write `{role} NAME {{ .. }}`"))
}

/// Returns the diagnostic for a repeated element that is no member.
pub(crate) fn not_repeated(key: &Spanned<String>) -> Diagnostic {
    Diagnostic::error("HQ0125", key.span, format!("`{}` cannot be repeated", clip(&key.value)))
        .note("a `for` in a mission can repeat members, such as `robot NAME { .. }`, and `for`")
        .help("write it outside the `for`")
}

/// Recognises `robt m1 { .. }`: returns the role that the key nearly is, and the entry with the name and the settings.
pub(crate) fn misspelt(entry: &Entry) -> Option<(&'static str, &Entry)> {
    let ValueKind::Block(outer) = &entry.value.kind else { return None };
    let [inner] = outer.entries.as_slice() else { return None };
    if !outer.tagged || !matches!(inner.value.kind, ValueKind::Block(_)) {
        return None;
    }
    nearest(&entry.key.value, ROLES).map(|role| (role, inner))
}
