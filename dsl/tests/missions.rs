//! Missions: the two syntaxes side by side, what the printers make of them, and where one thing ends and the next
//! begins, written out by hand.

use crate::common;

use common::good;
use hierarq_dsl::tree::*;
use hierarq_dsl::{Syntax, print};

const HQ: &str = include_str!("common/missions.hq");
const YAML: &str = include_str!("common/missions.yaml");

#[test]
fn the_syntaxes_are_equal() {
    assert_eq!(good(HQ, Syntax::Native), good(YAML, Syntax::Yaml));
}

#[test]
fn the_formatted_texts_stay_as_they_are() {
    assert_eq!(print(&good(HQ, Syntax::Native), Syntax::Native), HQ);
    assert_eq!(print(&good(YAML, Syntax::Yaml), Syntax::Yaml), YAML);
}

#[test]
fn translations_give_the_same_texts() {
    assert_eq!(print(&good(HQ, Syntax::Native), Syntax::Yaml), YAML);
    assert_eq!(print(&good(YAML, Syntax::Yaml), Syntax::Native), HQ);
}

fn missions(text: &str, syntax: Syntax) -> Vec<Mission> {
    let missions = good(text, syntax).items.into_iter().filter_map(|item| match item.kind {
        ItemKind::Mission(mission) => Some(mission),
        _ => None,
    });
    missions.collect()
}

/// A body as a line: settings as `key`, members as `role name(..)`, repetitions as `for`.
fn shape(settings: &Block, members: &[MissionMember], repeats: &[MissionRepeat]) -> String {
    let keys = settings.entries.iter().map(|e| e.key.value.clone());
    let members = members.iter().map(|m| {
        let action = m.action.as_ref().map_or(String::new(), |a| format!("={}", a.value));
        format!("{} {}{action}({})", m.role.value, m.name.value, shape(&m.settings, &m.members, &m.repeats))
    });
    let none = Block::default();
    let repeats = repeats.iter().map(|r| format!("for {}({})", r.variable.value, shape(&none, &r.members, &r.repeats)));
    keys.chain(members).chain(repeats).collect::<Vec<_>>().join(" ")
}

fn check(body: &str, expected: &str) {
    let read = missions(&format!("hierarq 1\nmission m : k {{ {body} }}\n"), Syntax::Native);
    let [m] = read.as_slice() else { panic!("{} missions in {body}", read.len()) };
    assert_eq!(shape(&m.settings, &m.members, &m.repeats), expected, "{body}");
}

#[test]
fn settings_and_members_are_told_apart() {
    check("place [1, 2] m  place shelf { at [1, 2] m }", "place place shelf(at)");
    check("human h { place shelf, worker table {} }", "human h(place worker table())");
    check("robot m1 { place shelf  robot m2 }", "robot m1(place robot)");
    check("object [a, b]  object a { object b }", "object object a(object)");
    check("x robot\n robot m1 {}", "x robot m1()");
    check("a 1 m\n human h1 { b 2 s\n}; worker w1 {}", "a human h1(b) worker w1()");
    check("robot m1\n{ a 1 }", "robot m1(a)");
    check("task a = wait  task b = wait, task c = pick { to [0, 0] m }", "task a=wait() task b=wait() task c=pick(to)");
    check("task a =\n pick\n { b 1 }  layer l { task a = layer {} }", "task a=pick(b) layer l(task a=layer())");
    check(
        "for i in 1..2 { for j in [a, b] { place p${i}_${j} {} } }  robot r {}",
        "robot r() for i(for j(place p${i}_${j}()))",
    );
    check("forward 1  robots_in_all 3  task_time 5 s  layered true", "forward robots_in_all task_time layered");
    check("schedule { robot m1 }  weights { place 1  task 2  robots 3 }", "schedule weights");
}

#[test]
fn a_mission_at_the_beginning_of_a_line_ends_what_was_open() {
    let text = "hierarq 1\nmission a : k {\n  robot r { b [1,\nmission c : k { robot d {} }\n";
    let (spec, diags) = hierarq_dsl::parse(hierarq_dsl::SourceId(0), text, Syntax::Native);
    assert!(diags.iter().all(|d| d.code == "HQ0105"), "{}", common::render(text, &diags));
    let names: Vec<&str> = spec
        .items
        .iter()
        .filter_map(|item| match &item.kind {
            ItemKind::Mission(m) => Some(m.name.value.as_str()),
            _ => None,
        })
        .collect();
    assert_eq!(names, ["a", "c"]);
}
