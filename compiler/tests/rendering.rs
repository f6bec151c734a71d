//! Rendering of diagnostics as text, and equality of their JSON.

use crate::common;

use common::{cases, examples};
use dsl::Syntax;
use hierarq_compiler::{Report, Style};

/// One example of each: a span in the spec, in a second file, two spans, notes with a help, a help of two lines.
const CASES: &str = r#"
==== [3] several
param speed = 5 cm
task reach = hold(toool) { gain speed }
task both = uncooperative_motion { right { position [0, 0, 0] m  orientation rpy(0, 0, 0) }  left { position [0, 0, 0] m  orientation rpy(0, 0, 0) } }
task go = frame_position(tool) { position [0.5 m + 0.2 rad, 0 m, 0 m] }
==== a label in another file
robot r { urdf "r.urdf"  rate 100 Hz }
---- r.urdf
<robot name="r">
  <link name="a"/><link name="b"/>
  <joint name="j" type="revolute"><parent link="a"/><child link="c"/><axis xyz="0 0 1"/></joint>
</robot>
==== a warning
task reach = frame_orientation(tool) { orientation rpy(0, 0, 45) }
==== a check of the finished program
task wall = virtual_wall(elbow) { through [[0, 0, 0], [1, 0, 0], [0, 1, 0]] m  d_min 3 m }
==== the rate in a file that is imported
!alone
import "rob.hq" { arm }


stack s { level l { hold(tool) { gain 20 /s } } }
---- rob.hq
hierarq 1
robot arm { urdf "robots/arm7.urdf"  rate 10 Hz  home { joint_4 1 rad } }
==== the first place far above
task reach = hold(tool)


let far = 1 m
task reach = hold(tool)
==== nothing to point at
!alone
"#;

fn reports() -> Vec<Report> {
    cases(CASES, Syntax::Native).iter().map(|c| c.compile().report).collect()
}

#[test]
fn plain() {
    let text: Vec<String> = reports().iter().map(|r| r.render(Style::Plain, 100)).collect();
    let text = text.join("").replace(&examples().display().to_string(), "EXAMPLES");
    // The renderer pads empty lines with blanks, which are not compared.
    let lines: Vec<&str> = text.lines().map(str::trim_end).collect();
    insta::assert_snapshot!("plain", lines.join("\n"));
}

/// The first picture is that of the primary span, whatever the labels refer to.
#[test]
fn the_primary_place_is_drawn_first() {
    for report in reports() {
        for d in &report.diagnostics {
            let one = Report { diagnostics: vec![d.clone()], sources: report.sources.clone(), ..Report::default() };
            let text = one.render(Style::Plain, 100);
            let (line, _) = report.sources.line_column(d.primary.span.source, d.primary.span.start);
            let Some(source) = report.sources.get(d.primary.span.source).filter(|s| !s.text.trim().is_empty()) else {
                continue;
            };
            let first = text.lines().find_map(|l| l.split_once("╭─[")).map(|(_, place)| place).unwrap_or_default();
            let rest = first.strip_prefix(&format!("{}:", source.name)).unwrap_or_else(|| panic!("{text}"));
            let number = |s: &str| s.trim().split([':', ']', ' ']).next().and_then(|n| n.parse::<usize>().ok());
            assert_eq!(number(rest), Some(line), "{text}");
            // One line of context, and a label on the line before.
            let above = text.lines().skip_while(|l| !l.contains("╭─[")).nth(1).and_then(number);
            assert!(above.is_none_or(|n| n + 2 >= line), "{text}");
        }
    }
}

#[test]
fn colours_change_nothing_else() {
    for report in reports() {
        let (mut bare, mut inside) = (String::new(), false);
        for c in report.render(Style::Terminal, 100).chars() {
            match c {
                '\u{1b}' => inside = true,
                'm' if inside => inside = false,
                c if !inside => bare.push(c),
                _ => {}
            }
        }
        let normal = |s: &str| s.split_whitespace().collect::<Vec<_>>().join(" ").replace(['─', '┬'], "");
        assert_eq!(normal(&bare), normal(&report.render(Style::Plain, 100)));
    }
}

#[test]
fn notes_and_helps_keep_to_the_width() {
    for report in reports() {
        for width in [40, 60, 100] {
            for line in report.render(Style::Plain, width).lines() {
                let words = line.trim_start();
                if words.starts_with("note:") || words.starts_with("help:") {
                    assert!(line.chars().count() <= width, "{line}");
                }
            }
        }
    }
}

#[test]
fn json_says_the_same() {
    for report in reports() {
        let json = report.to_json();
        assert_eq!(json["version"], 1);
        assert_eq!(json["errors"], report.errors());
        assert_eq!(json["warnings"], report.warnings());
        let all = json["diagnostics"].as_array().expect("a list");
        assert_eq!(all.len(), report.diagnostics.len());
        for (j, d) in all.iter().zip(&report.diagnostics) {
            assert_eq!((j["code"].as_str(), j["message"].as_str()), (Some(d.code), Some(d.message.as_str())));
            assert_eq!(j["help"].as_str(), d.help.as_deref());
            let (line, column) = report.sources.line_column(d.primary.span.source, d.primary.span.start);
            assert_eq!((&j["place"]["line"], &j["place"]["column"]), (&line.into(), &column.into()));
        }
    }
}
