//! Rejected files, with message and place: one snapshot each.

use std::collections::BTreeMap;

use hierarq_robot::{Base, Model, Options, UrdfCode, UrdfMessage};

/// Message, place, the line with the span underlined, help.
pub fn render(text: &str, messages: &[UrdfMessage]) -> String {
    let mut out = String::new();
    for message in messages {
        let (line, column) = message.line_column(text);
        out += &format!("{}: {}\n  at {line}:{column}\n", message.code, message.text);
        if let Some(source) = text.lines().nth(line - 1) {
            let covered = text[message.span.clone()].lines().next().unwrap_or("").chars().count();
            out += &format!("  | {source}\n  | {}{}\n", " ".repeat(column - 1), "^".repeat(covered.max(1)));
        }
        if let Some(help) = &message.help {
            out += &format!("  help: {help}\n");
        }
    }
    out
}

fn refuse_with(text: &str, options: &Options) -> String {
    match Model::from_urdf(text, options) {
        Ok((model, _)) => panic!("{model:?} should have been refused:\n{text}"),
        Err(messages) => {
            assert!(!messages.is_empty());
            render(text, &messages)
        }
    }
}

fn refuse(text: &str) -> String {
    refuse_with(text, &Options::default())
}

/// Three links in a row; `body` goes into the first joint.
fn joint(kind: &str, body: &str) -> String {
    format!(
        "<robot name=\"r\">\n<link name=\"a\"/><link name=\"b\"/>\n\
         <joint name=\"ab\" type=\"{kind}\">\n<parent link=\"a\"/><child link=\"b\"/>\n{body}\n</joint>\n</robot>\n"
    )
}

fn shape(geometry: &str) -> String {
    format!(
        "<robot name=\"r\">\n<link name=\"a\">\n<collision><geometry>\n{geometry}\n\
         </geometry></collision>\n</link>\n</robot>\n"
    )
}

#[test]
fn broken_files() {
    insta::assert_snapshot!("broken_xml", refuse("<robot name=\"r\">\n<link name=\"é\"></lnk>\n</robot>\n"));
    insta::assert_snapshot!("unclosed", refuse("<robot name=\"r\">\n<link name=\"a\"/>\n"));
    insta::assert_snapshot!("empty_text", refuse(""));
    insta::assert_snapshot!("no_robot", refuse("<sdf version=\"1.6\">\n<model/></sdf>"));
    insta::assert_snapshot!("no_links", refuse("<robot name=\"r\"/>"));
    insta::assert_snapshot!(
        "xacro",
        refuse(
            "<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n\
         <xacro:property name=\"x\" value=\"1\"/>\n</robot>"
        )
    );
    insta::assert_snapshot!(
        "entities",
        refuse(
            "<?xml version=\"1.0\"?>\n<!DOCTYPE r [<!ENTITY a \"aaaa\"><!ENTITY b \"&a;&a;&a;\">]>\n\
         <robot name=\"&b;\"><link name=\"l\"/></robot>"
        )
    );
}

#[test]
fn broken_trees() {
    insta::assert_snapshot!(
        "duplicates",
        refuse(
            "<robot name=\"r\">\n<link name=\"a\"/>\n<link name=\"b\"/>\n<link name=\"b\"/>\n<link name=\"c\"/>\n\
         <joint name=\"j\" type=\"fixed\"><parent link=\"a\"/><child link=\"b\"/></joint>\n\
         <joint name=\"j\" type=\"fixed\"><parent link=\"b\"/><child link=\"c\"/></joint>\n</robot>"
        )
    );
    insta::assert_snapshot!(
        "unknown_links",
        refuse(
            "<robot name=\"r\">\n<link name=\"a\"/>\n<joint name=\"j\" type=\"fixed\">\n\
         <parent link=\"ä\"/>\n<child link=\"c\"/>\n</joint>\n</robot>"
        )
    );
    insta::assert_snapshot!(
        "two_parents",
        refuse(
            "<robot name=\"r\">\n<link name=\"a\"/><link name=\"b\"/><link name=\"c\"/>\n\
         <joint name=\"ab\" type=\"fixed\"><parent link=\"a\"/><child link=\"b\"/></joint>\n\
         <joint name=\"ac\" type=\"fixed\"><parent link=\"a\"/><child link=\"c\"/></joint>\n\
         <joint name=\"cb\" type=\"fixed\"><parent link=\"c\"/><child link=\"b\"/></joint>\n</robot>"
        )
    );
    insta::assert_snapshot!(
        "cycle",
        refuse(
            "<robot name=\"r\">\n<link name=\"root\"/><link name=\"a\"/><link name=\"b\"/><link name=\"c\"/>\n\
         <joint name=\"ab\" type=\"fixed\"><parent link=\"a\"/><child link=\"b\"/></joint>\n\
         <joint name=\"bc\" type=\"fixed\"><parent link=\"b\"/><child link=\"c\"/></joint>\n\
         <joint name=\"ca\" type=\"fixed\"><parent link=\"c\"/><child link=\"a\"/></joint>\n</robot>"
        )
    );
    insta::assert_snapshot!(
        "own_parent",
        refuse(
            "<robot name=\"r\">\n<link name=\"a\"/>\n\
         <joint name=\"aa\" type=\"fixed\"><parent link=\"a\"/><child link=\"a\"/></joint>\n</robot>"
        )
    );
    insta::assert_snapshot!(
        "several_roots",
        refuse(
            "<robot name=\"r\">\n<link name=\"a\"/>\n<link name=\"b\"/>\n<link name=\"c\"/>\n\
         <joint name=\"ac\" type=\"fixed\"><parent link=\"a\"/><child link=\"c\"/></joint>\n</robot>"
        )
    );
    insta::assert_snapshot!("free_base", refuse(&joint("floating", "")));
    insta::assert_snapshot!(
        "free_inside",
        refuse(
            "<robot name=\"r\">\n<link name=\"a\"/><link name=\"b\"/><link name=\"c\"/>\n\
         <joint name=\"ab\" type=\"fixed\"><parent link=\"a\"/><child link=\"b\"/></joint>\n\
         <joint name=\"bc\" type=\"planar\"><parent link=\"b\"/><child link=\"c\"/></joint>\n</robot>"
        )
    );
}

#[test]
fn broken_joints() {
    insta::assert_snapshot!(
        "missing_parts",
        refuse(
            "<robot name=\"r\">\n<link/>\n<link name=\"\"/>\n<joint type=\"fixed\">\n<parent/>\n</joint>\n\
         <joint name=\"j\"/>\n</robot>"
        )
    );
    insta::assert_snapshot!("joint_type", refuse(&joint("hinge", "")));
    insta::assert_snapshot!(
        "crossed_limits",
        refuse(&joint("revolute", "<limit lower=\"1\" upper=\"-1\" velocity=\"1\" effort=\"1\"/>"))
    );
    insta::assert_snapshot!(
        "half_limits",
        refuse(&joint("prismatic", "<limit lower=\"0.2\" velocity=\"1\" effort=\"1\"/>"))
    );
    insta::assert_snapshot!(
        "bad_numbers",
        refuse(&joint(
            "revolute",
            "<origin xyz=\"0 0\" rpy=\"0 nan 0\"/>\n<axis xyz=\"1 0 0,5\"/>\n\
         <limit lower=\"-inf\" upper=\"1e999\" velocity=\"fast\"/>\n<mimic joint=\"ab\" multiplier=\"\"/>"
        ))
    );
    insta::assert_snapshot!("zero_axis", refuse(&joint("continuous", "<axis xyz=\"0 0 0\"/>")));
    insta::assert_snapshot!("mimic_unknown", refuse(&joint("continuous", "<mimic joint=\"other\"/>")));
    insta::assert_snapshot!(
        "mimic_circle",
        refuse(
            "<robot name=\"r\">\n<link name=\"a\"/><link name=\"b\"/><link name=\"c\"/>\n\
         <joint name=\"ab\" type=\"continuous\"><parent link=\"a\"/><child link=\"b\"/>\n<mimic joint=\"bc\"/></joint>\n\
         <joint name=\"bc\" type=\"continuous\"><parent link=\"b\"/><child link=\"c\"/>\n<mimic joint=\"ab\"/></joint>\n</robot>"
        )
    );
}

#[test]
fn broken_shapes() {
    insta::assert_snapshot!("zero_radius", refuse(&shape("<sphere radius=\"0\"/>")));
    insta::assert_snapshot!("negative_length", refuse(&shape("<cylinder radius=\"0.1\" length=\"-1\"/>")));
    insta::assert_snapshot!("flat_box", refuse(&shape("<box size=\"1 1 0\"/>")));
    insta::assert_snapshot!("box_without_size", refuse(&shape("<box/>")));
    insta::assert_snapshot!("scale_of_nothing", refuse(&shape("<mesh filename=\"a.stl\" scale=\"1 0 1\"/>")));
    insta::assert_snapshot!(
        "negative_mass",
        refuse("<robot name=\"r\"><link name=\"a\">\n<inertial><mass value=\"-1\"/></inertial></link></robot>")
    );
}

#[test]
fn broken_options() {
    let text = joint("continuous", "<axis xyz=\"0 0 1\"/>").replace("\"ab\"", "\"base_yaw\"");
    let planar = Options { base: Base::Planar, ..Options::default() };
    insta::assert_snapshot!("reserved_name", refuse_with(&text, &planar));
    let lock = |name: &str, x: f64| Options { lock: BTreeMap::from([(name.to_owned(), x)]), ..Options::default() };
    insta::assert_snapshot!("unknown_lock", refuse_with(&text, &lock("elbow", 0.0)));
    insta::assert_snapshot!("lock_at_nothing", refuse_with(&text, &lock("base_yaw", f64::NAN)));
    let keep = Options { keep: Some(["wrist".to_owned()].into()), ..Options::default() };
    insta::assert_snapshot!("unknown_keep", refuse_with(&text, &keep));
}

fn only(text: &str) -> UrdfCode {
    let messages = Model::from_urdf(text, &Options::default()).unwrap_err();
    assert_eq!(messages.len(), 1, "{messages:?}");
    messages[0].code
}

#[test]
fn too_much_of_anything() {
    let long = format!("<robot name=\"r\">{}</robot>", " ".repeat(64 << 20));
    assert_eq!(only(&long), UrdfCode::TooLarge);
    let links: String = (0..100_001).map(|i| format!("<link name=\"{i}\"/>")).collect();
    assert_eq!(only(&format!("<robot name=\"r\">{links}</robot>")), UrdfCode::TooLarge);
    // A mebibyte of attributes took ten seconds.
    let attributes: String = (0..100_000).map(|i| format!(" a{i}=\"1\"")).collect();
    assert_eq!(only(&format!("<robot name=\"r\"{attributes}><link name=\"base\"/></robot>")), UrdfCode::TooLarge);
    let mut chain = String::from("<link name=\"0\"/>");
    for i in 0..5000 {
        chain += &format!(
            "<link name=\"{0}\"/><joint name=\"{i}\" type=\"continuous\"><parent link=\"{i}\"/><child link=\"{0}\"/></joint>",
            i + 1
        );
    }
    assert_eq!(only(&format!("<robot name=\"r\">{chain}</robot>")), UrdfCode::TooManyJoints);
    // Nesting is no danger to the stack.
    let deep = format!("<robot name=\"r\">{}{}", "<a>".repeat(200_000), "</a>".repeat(200_000));
    assert_eq!(only(&(deep + "</robot>")), UrdfCode::NoLinks);
}

#[test]
fn any_damage_is_survived_and_spans_stay_inside() {
    let text = include_str!("arm.urdf");
    let mut rng = crate::common::rng(17);
    for round in 0..400 {
        let mut bytes = text.as_bytes().to_vec();
        for _ in 0..=(round % 3) {
            let at = (rng() * bytes.len() as f64) as usize;
            match (rng() * 3.0) as u32 {
                0 => bytes[at] = b"\"<>=0- x/n"[(rng() * 10.0) as usize],
                1 => drop(bytes.drain(at..(at + 12).min(bytes.len()))),
                _ => bytes.truncate(at.max(1)),
            }
        }
        let damaged = String::from_utf8_lossy(&bytes).into_owned();
        let messages = match Model::from_urdf(&damaged, &Options::default()) {
            Ok((_, warnings)) => warnings,
            Err(errors) => {
                assert!(!errors.is_empty());
                errors
            }
        };
        // Slicing by the span must work, and rendering with it.
        render(&damaged, &messages);
    }
}
