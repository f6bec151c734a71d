//! Transitions to the present state: conditions for entering it again, and for staying in it.

use serde_json::Value;

use crate::common::cli::{folder, hierarq, text};

use super::host::{Host, Seen};

/// Returns the number of entries of a state.
fn entries(host: &Host, state: &str) -> u64 {
    let index = host.controller.machine().states.iter().position(|s| s.name == state).expect("a state");
    host.controller.entries()[index]
}

fn states(host: &mut Host, ticks: usize) -> Vec<String> {
    (0..ticks).map(|_| host.step().state).collect()
}

const GUIDED: &str = "signal push : number
     signal near : flag
     signal again : event
     machine m {
       initial free  stack still
       on again -> guided
       when push > 2 -> guided
       when near -> free
       on fault(any) -> end
       state free { after 10 s -> end }
       state guided { initial led  enter log \"guided\"
         state led { when push > 4 -> far }
         state far { after 10 s -> end } }
       final state end
     }";

#[test]
fn a_condition_of_the_machine_enters_its_target_once() {
    let mut host = Host::new(GUIDED);
    assert_eq!(host.steps(3), "free");
    host.set("push", &[3.0]);
    let first = host.step();
    assert_eq!(first, Seen { state: "guided.led".into(), asked: vec!["+log guided".into()], fault: None });
    for _ in 0..50 {
        assert_eq!(host.step(), Seen { state: "guided.led".into(), asked: vec![], fault: None });
    }
    assert_eq!(entries(&host, "guided"), 1);
    // The condition also stays true in a substate.
    host.set("push", &[5.0]);
    assert_eq!(host.steps(5), "guided.far");
    assert_eq!(host.steps(5), "guided.far");
    assert_eq!(["guided", "guided.led", "guided.far"].map(|s| entries(&host, s)), [1, 1, 1]);
    // If it becomes false and true again, the machine has not left its target in between.
    host.set("push", &[0.0]);
    host.step();
    host.set("push", &[3.0]);
    assert_eq!((host.step().state.as_str(), entries(&host, "guided")), ("guided.far", 1));
}

#[test]
fn an_event_enters_its_target_anew() {
    let mut host = Host::new(GUIDED);
    host.step();
    host.set("push", &[5.0]);
    assert_eq!(host.steps(2), "guided.far");
    host.set("push", &[3.0]);
    host.raise("again");
    assert_eq!(host.step(), Seen { state: "guided.led".into(), asked: vec!["+log guided".into()], fault: None });
    assert_eq!(entries(&host, "guided"), 2);
}

/// The order of the text is a priority: the machine does not oscillate between two targets.
#[test]
fn what_keeps_the_machine_comes_before_conditions_behind_it() {
    let mut host = Host::new(GUIDED);
    host.step();
    host.set("push", &[3.0]);
    host.set("near", &[1.0]);
    assert!(states(&mut host, 20).iter().all(|s| s == "guided.led"));
    assert_eq!(entries(&host, "guided"), 1);
    host.set("push", &[1.0]);
    assert_eq!(host.step().state, "free", "now the second one counts");
    assert!(states(&mut host, 20).iter().all(|s| s == "free"));
    assert_eq!(entries(&host, "free"), 2);
}

#[test]
fn an_event_passes_what_keeps_the_machine() {
    let mut host = Host::new(
        "signal push : number
         signal stop : event
         machine m { initial a  stack still
           when push > 2 -> guided
           on stop -> end
           on fault(any) -> end
           state a { after 10 s -> end }
           state guided { after 10 s -> end }
           final state end }",
    );
    host.step();
    host.set("push", &[3.0]);
    assert_eq!(host.steps(3), "guided");
    host.raise("stop");
    assert_eq!(host.step().state, "end");
}

#[test]
fn a_time_and_a_target_that_is_reached_enter_their_state_once() {
    for (trigger, ticks) in [("after 30 ms", 5), ("on reached(reach, 1 mm)", 5)] {
        let mut host = Host::new(&format!(
            "task reach = frame_position(tool) {{ position initial(position)  gain 20 /s }}
             stack move from still {{ add motion {{ reach }} }}
             machine m {{ initial a  stack move
               {trigger} -> b
               on fault(any) -> end
               state a {{ after 10 s -> end }}
               state b {{ after 10 s -> end }}
               final state end }}",
        ));
        assert_eq!(host.steps(ticks), "b", "{trigger}");
        assert_eq!(host.steps(50), "b", "{trigger}");
        assert_eq!(["a", "b"].map(|s| entries(&host, s)), [1, 1], "{trigger}");
    }
}

#[test]
fn times_of_a_state_come_one_after_another() {
    let mut host = Host::new(
        "signal back : event
         machine m { initial a  stack still  on fault(any) -> end
           state a { initial x
             after 50 ms -> y
             after 100 ms -> z
             on back -> x
             after 1 s -> end
             state x { exit log \"x\" }
             state y { exit log \"y\" }
             state z { exit log \"z\" } }
           final state end }",
    );
    let seen = states(&mut host, 20);
    let changes: Vec<usize> = (1..20).filter(|&k| seen[k] != seen[k - 1]).collect();
    assert_eq!((changes.as_slice(), seen[5].as_str(), seen[19].as_str()), ([5, 10].as_slice(), "a.y", "a.z"));
    host.raise("back");
    assert_eq!(host.steps(50), "a.x", "a time is taken once for each entry of its state");
    assert_eq!(host.steps(40), "end");
}

#[test]
fn a_state_whose_own_condition_leads_to_it_begins_anew_when_that_becomes_true() {
    let mut host = Host::new(
        "signal push : number
         machine m { initial a  stack still  on fault(any) -> end
           state a { when push > 2 -> a  after 10 s -> end }
           final state end }",
    );
    // It has been true since the entry: there is no rising edge.
    host.set("push", &[3.0]);
    host.steps(10);
    assert_eq!(entries(&host, "a"), 1);
    for n in 2..4 {
        host.set("push", &[1.0]);
        host.step();
        host.set("push", &[3.0]);
        host.steps(10);
        assert_eq!(entries(&host, "a"), n);
    }
}

#[test]
fn with_a_time_it_begins_anew_each_time_that_the_condition_has_held_so_long() {
    let mut host = Host::new(
        "signal push : number
         machine m { initial a  stack still  on fault(any) -> end
           state a { when push > 2 for 50 ms -> a  after 10 s -> end }
           final state end }",
    );
    host.set("push", &[3.0]);
    host.step();
    // First evaluated one tick after the entry, it has held for 50 ms five ticks later.
    host.steps(12);
    assert_eq!(entries(&host, "a"), 3);
}

#[test]
fn a_state_inside_another_leads_back_to_where_that_begins() {
    let mut host = Host::new(
        "signal push : number
         machine m { initial outer  stack still  on fault(any) -> end
           state outer { initial near  after 10 s -> end
             state near { after 50 ms -> far }
             state far { when push > 2 -> outer } }
           final state end }",
    );
    host.set("push", &[3.0]);
    let seen = states(&mut host, 13);
    assert_eq!(seen.iter().filter(|s| *s == "outer.far").count(), 2, "{seen:?}");
    assert_eq!(entries(&host, "outer"), 3);
}

#[test]
fn a_target_that_stays_reached_does_not_begin_anew() {
    let text = |position: &str| {
        format!(
            "task reach = frame_position(tool) {{ position {position}  gain 20 /s }}
             stack move from still {{ add motion {{ reach }} }}
             machine m {{ initial a  on fault(any) -> end
               state a {{ stack move  on reached(reach, 1 mm) -> a  after 60 s -> end }}
               final state end {{ stack still }} }}"
        )
    };
    let mut host = Host::new(&text("[0.45, 0, 0.5] m"));
    host.steps(500);
    assert_eq!(entries(&host, "a"), 2, "once where it has arrived");
    // Each entry moves the target further.
    let mut host = Host::new(&text("initial(position) + [0, 0.01, 0] m"));
    host.steps(100);
    assert!((3..10).contains(&entries(&host, "a")), "{}", entries(&host, "a"));
}

/// A pulled hand satisfies the machine's own condition for guiding: the robot yields, and continues to yield.
#[test]
fn a_hand_that_is_pulled_is_led_in_both_syntaxes() {
    let folder = folder("machine_again");
    let robots = crate::common::example("robots");
    let spec = folder.join("pulled.hq");
    let urdf = robots.join("arm7.urdf").display().to_string();
    let text_of = include_str!("again.hq").replace("robots/arm7.urdf", &urdf);
    std::fs::write(&spec, text_of).expect("writable");
    let yaml = folder.join("pulled.yaml");
    let out = hierarq(&["fmt", "--to", "yaml", &spec.display().to_string()]);
    std::fs::write(&yaml, &out.stdout).expect("writable");
    for spec in [spec, yaml] {
        let (spec, out) = (spec.display().to_string(), folder.join("out").display().to_string());
        let arguments = ["run", &spec, "--scenario", "pulled", "--out", &out];
        let table = hierarq(&arguments);
        let shown = text(&table.stdout);
        assert!(table.status.success(), "{shown}{}", text(&table.stderr));
        assert!(shown.contains("entries: free 2, guided 1, guided.led 1\n"), "{shown}");
        let summary = std::fs::read_to_string(folder.join("out/summary.json")).expect("it was written");
        let summary: Value = serde_json::from_str(&summary).expect("JSON");
        assert_eq!(summary["entries"], serde_json::json!({ "free": 2, "guided": 1, "guided.led": 1 }));
        let stays: Vec<(&str, u64)> = (summary["states"].as_array().expect("states").iter())
            .map(|s| (s["state"].as_str().expect("a name"), s["entries"].as_u64().expect("a count")))
            .collect();
        assert_eq!(stays, [("free", 1), ("guided.led", 1), ("free", 1)]);
    }
}
