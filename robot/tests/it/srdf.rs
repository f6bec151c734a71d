//! SRDF: groups, postures, pairs; rejected files with message and place; damaged ones.

use std::fmt::Write;

use hierarq_robot::srdf::{SrdfCode, SrdfMessage, VirtualMotion};
use hierarq_robot::{Model, Options, Srdf, contacts};
use proptest::prelude::*;

const ARM: &str = include_str!("arm.urdf");

fn model() -> Model {
    Model::from_urdf(ARM, &Options::default()).unwrap().0
}

/// Wraps elements in the description of the arm.
fn of_arm(elements: &str) -> String {
    format!("<?xml version=\"1.0\"?>\n<robot name=\"{}\">\n{elements}\n</robot>\n", model().name)
}

fn read(elements: &str) -> Srdf {
    let text = of_arm(elements);
    match Srdf::read(&text, &model()) {
        Ok((srdf, warnings)) if warnings.is_empty() => srdf,
        Ok((_, messages)) | Err(messages) => panic!("{}", render(&text, &messages)),
    }
}

/// Message, place, the line with the span underlined, help.
fn render(text: &str, messages: &[SrdfMessage]) -> String {
    let mut out = String::new();
    for message in messages {
        let before = &text[..message.span.start];
        let (line, start) = (before.matches('\n').count(), before.rfind('\n').map_or(0, |i| i + 1));
        let column = before[start..].chars().count();
        let _ = writeln!(out, "{}: {}", message.code, message.text);
        let covered = text[message.span.clone()].lines().next().unwrap_or("").chars().count();
        let _ = writeln!(out, "  | {}", text.lines().nth(line).unwrap_or(""));
        let _ = writeln!(out, "  | {}{}", " ".repeat(column), "^".repeat(covered.max(1)));
        if let Some(help) = &message.help {
            let _ = writeln!(out, "  help: {help}");
        }
    }
    out
}

/// Errors of a file, or its warnings.
fn messages(text: &str) -> Vec<SrdfMessage> {
    match Srdf::read(text, &model()) {
        Ok((_, warnings)) => warnings,
        Err(errors) => errors,
    }
}

fn said(elements: &str) -> String {
    let text = of_arm(elements);
    render(&text, &messages(&text))
}

fn joint_names(model: &Model, srdf: &Srdf, group: &str) -> Vec<String> {
    let group = srdf.group(group).unwrap();
    group.joints.iter().map(|j| model.joint_ref(*j).name.clone()).collect()
}

/// Names of the joints and links of the arm, from the root outwards to a finger.
struct Chain {
    links: Vec<String>,
    joints: Vec<String>,
}

fn chain(model: &Model) -> Chain {
    let mut at = model.link("left_finger").unwrap();
    let (mut links, mut joints) = (vec![model.link_ref(at).name.clone()], Vec::new());
    while let Some(joint) = model.link_ref(at).parent_joint {
        joints.insert(0, model.joint_ref(joint).name.clone());
        at = model.joint_ref(joint).parent;
        links.insert(0, model.link_ref(at).name.clone());
    }
    Chain { links, joints }
}

#[test]
fn groups_are_chains_joints_links_and_other_groups() {
    let model = model();
    let Chain { links, joints } = chain(&model);
    let (base, tip) = (&links[0], links.last().unwrap());
    let srdf = read(&format!(
        "<group name=\"arm\"><chain base_link=\"{base}\" tip_link=\"{tip}\"/></group>
         <group name=\"first\"><joint name=\"{}\"/></group>
         <group name=\"second\"><link name=\"{}\"/></group>
         <group name=\"both\"><group name=\"first\"/><group name=\"second\"/><group name=\"first\"/></group>",
        joints[0], links[2],
    ));
    assert_eq!(joint_names(&model, &srdf, "arm"), joints);
    assert_eq!(srdf.group("arm").unwrap().tip, model.link(tip));
    assert_eq!(joint_names(&model, &srdf, "both"), joints[..2]);
    assert_eq!(srdf.group("both").unwrap().tip, None);
    let carried = srdf.group("first").unwrap().links.clone();
    assert_eq!(carried, [model.link(&links[1]).unwrap()]);
}

#[test]
fn a_chain_may_go_up_and_down() {
    let model = model();
    let Chain { links, joints } = chain(&model);
    let tip = links.last().unwrap();
    let up = read(&format!("<group name=\"g\"><chain base_link=\"{tip}\" tip_link=\"{}\"/></group>", links[1]));
    assert_eq!(joint_names(&model, &up, "g"), joints[1..]);
    assert_eq!(up.group("g").unwrap().tip, None, "the chain ends nearer to the root than it begins");
}

#[test]
fn postures_skip_what_has_no_position() {
    let model = model();
    let Chain { joints, .. } = chain(&model);
    let root = &model.links[0].name;
    let srdf = read(&format!(
        "<virtual_joint name=\"world\" type=\"planar\" parent_frame=\"map\" child_link=\"{root}\"/>
         <group name=\"g\"><joint name=\"{0}\"/><joint name=\"world\"/></group>
         <group_state name=\"up\" group=\"g\"><joint name=\"{0}\" value=\" 0.25 \"/><joint name=\"world\" value=\"0 0 1\"/></group_state>
         <group_state name=\"up\" group=\"all\"><joint name=\"root_joint\" value=\"0 0 1 0 0 0 1\"/></group_state>",
        joints[0],
    ));
    let [posture, all] = &srdf.postures[..] else { panic!("two postures") };
    assert_eq!((posture.positions.len(), posture.positions[0].value), (1, 0.25));
    assert!(all.positions.is_empty());
    assert!(srdf.group("g").unwrap().base);
    assert_eq!(srdf.virtual_joints[0].motion, VirtualMotion::Planar);
    assert_eq!(srdf.postures_named("up").count(), 2);
}

#[test]
fn pairs_are_disabled_one_by_one_or_for_a_link() {
    let model = model();
    let Chain { links, .. } = chain(&model);
    let srdf = read(&format!(
        "<disable_collisions link1=\"{1}\" link2=\"{0}\" reason=\"Adjacent\"/>
         <disable_default_collisions link=\"{2}\"/>
         <enable_collisions link1=\"{2}\" link2=\"{0}\"/>
         <disable_collisions link1=\"{0}\" link2=\"{1}\" reason=\"Never\"/>",
        links[0], links[1], links[2],
    ));
    let id = |name: &str| model.link(name).unwrap();
    let pairs = srdf.disabled_pairs();
    assert_eq!(pairs[&contacts::pair(id(&links[0]), id(&links[1]))], "Never", "the last one counts");
    assert!(!pairs.contains_key(&contacts::pair(id(&links[0]), id(&links[2]))));
    assert_eq!(pairs.len(), model.links.len() - 2 + 1);
}

#[test]
fn mistakes_have_a_place() {
    let Chain { links, joints } = chain(&model());
    let (link, joint) = (&links[1], &joints[0]);
    let cases = [
        "<group name=\"g\"><joint name=\"elbwo\"/></group>".to_string(),
        "<group name=\"g\"><link name=\"nothing\"/></group>".to_string(),
        "<group><joint name=\"x\"/></group>".to_string(),
        "<group name=\"g\"/><group name=\"g\"/>".to_string(),
        "<group name=\"g\"/>".to_string(),
        "<group name=\"a\"><group name=\"b\"/></group>\n<group name=\"b\"><group name=\"c\"/></group>\n\
         <group name=\"c\"><group name=\"a\"/></group>"
            .to_string(),
        format!("<group name=\"a\"><group name=\"a\"/><joint name=\"{joint}\"/></group>"),
        "<group name=\"a\"><group name=\"nobody\"/></group>".to_string(),
        format!("<group name=\"a\"><chain base_link=\"{link}\" tip_link=\"{link}\"/></group>"),
        format!("<group name=\"a\"><chain base_link=\"{link}\"/></group>"),
        format!(
            "<group name=\"a\"><joint name=\"{joint}\"/></group>\n<group_state name=\"s\" group=\"a\"><joint name=\"{joint}\" value=\"NaN\"/></group_state>"
        ),
        format!(
            "<group name=\"a\"><joint name=\"{joint}\"/></group>\n<group_state name=\"s\" group=\"a\"><joint name=\"{joint}\" value=\"1 2\"/></group_state>"
        ),
        format!(
            "<group name=\"a\"><joint name=\"{joint}\"/></group>\n<group_state name=\"s\" group=\"a\"><joint name=\"{joint}\" value=\"0\"/><joint name=\"{joint}\" value=\"1\"/></group_state>"
        ),
        format!(
            "<group name=\"a\"><joint name=\"{joint}\"/></group>\n<group_state name=\"s\" group=\"a\"/><group_state name=\"s\" group=\"a\"/>"
        ),
        format!("<group_state name=\"s\"><joint name=\"{joint}\" value=\"0\"/></group_state>"),
        format!("<virtual_joint name=\"v\" type=\"rolling\" parent_frame=\"w\" child_link=\"{link}\"/>"),
        format!("<end_effector name=\"e\" group=\"hand\" parent_link=\"{link}\"/>"),
        "<passive_joint name=\"wheel\"/>".to_string(),
        format!("<disable_collisions link1=\"{link}\" link2=\"{link}\"/>"),
        format!(
            "<disable_collisions link1=\"{link}\" link2=\"ghost\"/>\n<disable_collisions link1=\"ghost\" link2=\"{link}\"/>"
        ),
        format!("<disable_collisions link1=\"{link}\"/>"),
        format!(
            "<disable_collisions link1=\"{link}\" link2=\"{}\"><xacro:if xmlns:xacro=\"http://ros.org/wiki/xacro\"/></disable_collisions>",
            links[2]
        ),
    ];
    let all: Vec<String> = cases.iter().map(|case| format!("{case}\n{}", said(case))).collect();
    insta::assert_snapshot!("srdf_mistakes", all.join("\n"));
}

#[test]
fn files_of_another_kind_or_robot() {
    let model = model();
    let other = "<robot name=\"other\">\n<group name=\"g\"><joint name=\"x\"/><joint name=\"y\"/></group>\n</robot>\n";
    let renamed = format!(
        "<robot name=\"other\">\n<group name=\"g\"><joint name=\"{}\"/></group>\n</robot>\n",
        chain(&model).joints[0]
    );
    let cases = [ARM, other, &renamed, "", "<sdf/>", "<robot", "<!DOCTYPE a [<!ENTITY b \"c\">]><robot name=\"r\"/>"];
    let all: Vec<String> = cases.iter().map(|text| render(text, &messages(text))).collect();
    insta::assert_snapshot!("srdf_files", all.join("\n"));
    let srdf = of_arm("<disable_collisions link1=\"a\" link2=\"b\"/>");
    let errors = Model::from_urdf(&srdf, &Options::default()).unwrap_err();
    assert_eq!(errors[0].text, "this is an SRDF, which describes groups and postures of a robot, not a URDF");
}

#[test]
fn sizes_are_bounded() {
    let only = |elements: &str| messages(&of_arm(elements)).first().map(|m| m.code);
    let states = "<group_state name=\"s\" group=\"all\"/>".repeat(100_001);
    assert_eq!(only(&states), Some(SrdfCode::TooLarge));
    let groups: String = (0..1_001).map(|i| format!("<group name=\"g{i}\"/>")).collect();
    assert_eq!(only(&groups), Some(SrdfCode::TooLarge));
    let attributes: String = (0..600).map(|i| format!(" a{i}=\"1\"")).collect();
    assert_eq!(only(&format!("<group name=\"g\"{attributes}/>")), Some(SrdfCode::TooLarge));
    // A ladder of groups, each with the one below it twice, is no exponential work.
    let joint = &chain(&model()).joints[0];
    let rungs: String = (1..900)
        .map(|i| format!("<group name=\"g{i}\"><group name=\"g{0}\"/><group name=\"g{0}\"/></group>", i - 1))
        .collect();
    let srdf = read(&format!("<group name=\"g0\"><joint name=\"{joint}\"/></group>{rungs}"));
    assert_eq!(srdf.group("g899").unwrap().joints.len(), 1);
    let wrong: String =
        (0..200).map(|i| format!("<passive_joint name=\"{joint}\"/><passive_joint name=\"p{i}\"/>")).collect();
    assert!(messages(&of_arm(&wrong)).len() <= 50);
}

/// A sound description, to be damaged.
fn sound() -> String {
    let model = model();
    let Chain { links, joints } = chain(&model);
    of_arm(&format!(
        "<virtual_joint name=\"world\" type=\"fixed\" parent_frame=\"w\" child_link=\"{0}\"/>
         <group name=\"arm\"><chain base_link=\"{0}\" tip_link=\"{1}\"/></group>
         <group name=\"more\"><group name=\"arm\"/><joint name=\"{2}\"/><link name=\"{1}\"/></group>
         <group_state name=\"up\" group=\"arm\"><joint name=\"{2}\" value=\"0.5\"/></group_state>
         <end_effector name=\"hand\" group=\"more\" parent_link=\"{1}\" parent_group=\"arm\"/>
         <passive_joint name=\"{2}\"/>
         <disable_default_collisions link=\"{0}\"/>
         <enable_collisions link1=\"{0}\" link2=\"{1}\"/>
         <disable_collisions link1=\"{0}\" link2=\"{1}\" reason=\"Never\"/>",
        links[0],
        links.last().unwrap(),
        joints[0],
    ))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Whatever is written over a part of the text, the reader answers, with places inside of it.
    #[test]
    fn damaged_files_are_read_or_refused(start in 0.0..1.0f64, len in 0_usize..40, new in "[a-z<>\"'/= é0-9.]{0,12}") {
        let text = sound();
        let begin = (start * text.len() as f64) as usize;
        let cut = |i: usize| (i.min(text.len())..).find(|i| text.is_char_boundary(*i)).unwrap_or(text.len());
        let damaged = format!("{}{new}{}", &text[..cut(begin)], &text[cut(begin + len)..]);
        for message in messages(&damaged) {
            prop_assert!(damaged.get(message.span.clone()).is_some(), "{message:?}");
            prop_assert!(!message.text.is_empty());
        }
    }

    /// Elements in any order give the same description, as far as it has no order.
    #[test]
    fn the_order_of_elements_does_not_matter(shuffled in Just(sound()).prop_flat_map(|text| {
        let inner: Vec<String> = text.lines().skip(2).filter(|l| *l != "</robot>").map(str::to_string).collect();
        Just(inner).prop_shuffle()
    })) {
        let text = of_arm(&shuffled.join("\n"));
        let (a, _) = Srdf::read(&text, &model()).unwrap();
        let (b, _) = Srdf::read(&sound(), &model()).unwrap();
        prop_assert_eq!(a.disabled_pairs(), b.disabled_pairs());
        prop_assert_eq!(joint_names(&model(), &a, "more"), joint_names(&model(), &b, "more"));
        prop_assert_eq!(a.postures.len(), b.postures.len());
    }
}
