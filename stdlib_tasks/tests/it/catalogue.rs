//! The list of task types is complete and sound.

use std::collections::BTreeSet;

use hierarq_stdlib_tasks::dimension::NONE;
use hierarq_stdlib_tasks::kinds::safety_planner;
use hierarq_stdlib_tasks::params::{Form, ParamInfo, ParamType, Presence};
use hierarq_stdlib_tasks::task::{RowKind, TaskKind};
use hierarq_stdlib_tasks::{KINDS, find};
use robot::Base;

use crate::bound::valid;
use crate::common::*;

/// All parameters of a type, those of groups included.
fn all(infos: &'static [ParamInfo]) -> Vec<&'static ParamInfo> {
    let inner = |p: &'static ParamInfo| match p.ty {
        ParamType::Group(group) => all(group),
        ParamType::PerFrame(inner) => all(inner),
        ParamType::Deviations => all(safety_planner::PATH),
        _ => Vec::new(),
    };
    infos.iter().flat_map(|p| std::iter::once(p).chain(inner(p))).collect()
}

fn is_word(text: &str) -> bool {
    !text.is_empty() && text.chars().all(|c| c.is_ascii_lowercase() || c == '_')
}

#[test]
fn every_type_is_documented() {
    for kind in KINDS {
        let name = kind.name;
        let sources = ["Source: thesis", "Source: ISO"];
        assert!(sources.iter().any(|s| kind.docs.contains(s)), "`{name}` cites nothing");
        assert!(kind.docs.matches("```").count() % 2 == 0, "`{name}` leaves a code block open");
        assert!(!kind.summary.is_empty() && !kind.summary.ends_with('.'), "`{name}`: a summary is one line");
        assert!(
            kind.example.starts_with("task ") && kind.example.contains(&format!("= {name}")),
            "`{name}` shows no example"
        );
        assert_eq!(kind.example.matches('{').count(), kind.example.matches('}').count(), "`{name}`");
        for output in kind.outputs {
            assert!(
                is_word(output.name) && !output.description.is_empty(),
                "`{name}` has the output `{}`",
                output.name
            );
            assert_eq!(kind.outputs.iter().filter(|t| t.name == output.name).count(), 1, "`{name}` tells it twice");
        }
        for p in all(kind.params) {
            assert!(!p.text().is_empty(), "`{name}`: `{}` has no text", p.name);
            assert!(is_word(p.name), "`{name}`: `{}`", p.name);
        }
    }
}

#[test]
fn examples_give_what_is_required() {
    for kind in KINDS {
        let in_parentheses = kind.example.contains(&format!("{}(", kind.name));
        for p in kind.params.iter().filter(|p| p.presence == Presence::Required) {
            let given = in_parentheses && kind.positional.first() == Some(&p.name);
            assert!(given || kind.example.contains(&format!("{} ", p.name)), "`{}` lacks `{}`", kind.name, p.name);
        }
    }
}

#[test]
fn names_are_unique_and_found() {
    let names: BTreeSet<&str> = KINDS.iter().map(|k| k.name).collect();
    assert_eq!(names.len(), KINDS.len());
    for kind in KINDS {
        assert!(is_word(kind.name));
        assert!(std::ptr::eq(find(kind.name).unwrap(), *kind));
        let params: BTreeSet<&str> = kind.params.iter().map(|p| p.name).collect();
        assert_eq!(params.len(), kind.params.len(), "`{}` has a parameter twice", kind.name);
        assert!(kind.positional.iter().all(|p| params.contains(p)), "`{}`", kind.name);
        let current_values: BTreeSet<&str> = kind.current_values.iter().map(|a| a.name).collect();
        assert_eq!(current_values.len(), kind.current_values.len(), "`{}`", kind.name);
    }
    assert!(find("no_such_task").is_none() && find("").is_none());
}

#[test]
fn defaults_fit_their_types() {
    for kind in KINDS {
        for p in all(kind.params) {
            let Presence::Default(text) = p.presence else { continue };
            let what = format!("`{}`: `{}` defaults to `{text}`", kind.name, p.name);
            let mut words = text.split(' ');
            let (first, unit) = (words.next().unwrap(), words.next().unwrap_or("1"));
            match p.ty {
                ParamType::Scalar(q) | ParamType::AutoScalar(q) | ParamType::Expression(Form::Number(q)) => {
                    assert!(q.contains(first.parse().expect(&what)), "{what}");
                    // `/s` of the language is `1/s` of a dimension.
                    let written =
                        if let Some(rest) = unit.strip_prefix('/') { format!("1/{rest}") } else { unit.to_string() };
                    assert_eq!(q.dimension.to_string(), written, "{what}");
                }
                ParamType::Expression(Form::Size(_)) => assert_eq!(text, "0", "{what}"),
                ParamType::Gains(names) => {
                    assert!(!names.is_empty() && first.parse::<f64>().expect(&what) > 0.0 && unit == "/s", "{what}");
                }
                ParamType::Choice(list) => assert!(list.contains(&text), "{what}"),
                ParamType::Arm => assert!(["left", "right"].contains(&text), "{what}"),
                ParamType::Expression(Form::Vector(d)) => {
                    let behind = text.strip_prefix("[0, 0, 0] ").expect(&what);
                    assert_eq!(d.to_string(), behind, "{what}");
                }
                ParamType::Group(inner) => {
                    assert!(text == "{}" && inner.iter().all(|p| p.presence != Presence::Required), "{what}");
                }
                // A direction of a frame.
                ParamType::Vector(d) if d == NONE => assert_eq!(text, "[0, 0, 1]", "{what}"),
                ParamType::Rotation | ParamType::Vector(_) => {
                    let captured = text.strip_prefix("initial(").and_then(|t| t.strip_suffix(')'));
                    // Inside a group the group's name comes first.
                    let own = |a: &str| {
                        captured.is_some_and(|c| a == c || a.strip_suffix(c).is_some_and(|g| g.ends_with('.')))
                    };
                    assert!(kind.current_values.iter().any(|a| own(a.name)), "{what}");
                }
                _ => panic!("{what}, and no default of this type is known"),
            }
        }
        if let Some(gain) = kind.params.iter().find(|p| p.name == "gain") {
            assert!(matches!(gain.presence, Presence::Default(_)), "`{}` has no gain by default", kind.name);
        }
    }
}

/// The path under which a value is captured: that of the parameter whose target it is.
fn has_param(kind: &TaskKind, path: &str) -> bool {
    let (first, rest) = path.split_once('.').unwrap_or((path, ""));
    kind.params.iter().any(|p| {
        p.name == first
            && match p.ty {
                ParamType::Group(group) => group.iter().any(|q| q.name == rest),
                _ => rest.is_empty(),
            }
    })
}

#[test]
fn every_actual_value_is_answered() {
    let model = canopies(Base::Planar);
    let mut rng = rng(51);
    let place = Place::new(&model, &model.random_configuration(&mut rng));
    for kind in KINDS {
        let case = valid(kind.name, &model);
        let task = case.build(&model);
        for a in kind.current_values {
            let name = if a.name == "*" { "angle.left" } else { a.name };
            assert!(a.name == "*" || has_param(kind, a.name), "`{}` has no parameter `{}`", kind.name, a.name);
            let value = place.current_value(&*task, &case, 0.0, name, a.ty.len());
            assert!(value.iter().all(|x| x.is_finite()) && value.iter().any(|&x| x != 0.0), "`{}` {name}", kind.name);
            assert_eq!(a.ty.is_empty(), value.is_empty());
        }
        for name in ["", "nothing", "position.x", "absolute.", "left", ".", "angle.nobody"] {
            let mut out = [7.0; 4];
            let known = task.current_value(name, &place.state(&case.values, &case.rates), &mut out);
            let real =
                kind.current_values.iter().any(|a| a.name == name) || (kind.name == "swivel_angle" && name == "left");
            assert_eq!(known, real, "`{}` {name}", kind.name);
        }
    }
}

#[test]
fn natures_show_in_what_is_reported() {
    let model = canopies(Base::Planar);
    let place = Place::new(&model, &model.random_configuration(&mut rng(52)));
    for kind in KINDS {
        let case = valid(kind.name, &model);
        let mut task = case.build(&model);
        let w = place.write(&mut *task, &case, 0.0).unwrap();
        assert_eq!(task.measures().is_empty(), kind.row_kind == RowKind::Inequality, "`{}`", kind.name);
        let (n, loss) = (task.rows().len(), task.sampled_loss());
        assert!(n > 0);
        assert_eq!(loss.len(), task.sampled_margin().len());
        assert!(loss.is_empty() || loss.len() == n);
        let limits_speed = kind.name == "joint_velocity_limits";
        // Margins of what is only known once a velocity was chosen.
        let later = limits_speed || kind.name == "joint_acceleration_limits";
        for i in 0..n {
            match kind.row_kind {
                RowKind::Equality => assert!(w.lower[i] == w.upper[i] && w.margins[i] == f64::INFINITY),
                RowKind::Inequality => assert!(w.lower[i] < w.upper[i] && (w.margins[i].is_finite() != later)),
            }
        }
        let names: BTreeSet<String> = task.rows().into_iter().map(|r| r.name).collect();
        assert_eq!(names.len(), n, "`{}` has two rows of one name", kind.name);
        assert!(task.gains(&case.values).iter().all(|g| *g > 0.0));
        assert_eq!(!task.speed_limits(&case.values).is_empty(), limits_speed);
    }
}
