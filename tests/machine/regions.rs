//! Regions of a state that are active beside each other.

use std::fmt::Write;

use runtime::FaultKind;

use super::host::{ARM, Host, Seen, in_both_syntaxes};

fn seen(state: &str, asked: &[&str]) -> Seen {
    Seen { state: state.to_string(), asked: asked.iter().map(|a| (*a).to_string()).collect(), fault: None }
}

/// Two regions that log their entries and exits.
const LOGGED: &str = "signal go : event
signal away : event
signal again : event
machine m {
  initial w  stack still
  on fault(any) -> end
  state w {
    enter log \"w in\"  exit log \"w out\"
    on again -> w
    region l {
      initial a  enter log \"l in\"  exit log \"l out\"
      state a { enter log \"a in\"  exit log \"a out\"  on go -> b }
      state b { enter log \"b in\"  exit log \"b out\"  on away -> o.q  on go -> l } }
    region r {
      initial c  enter log \"r in\"  exit log \"r out\"
      state c { enter log \"c in\"  exit log \"c out\"  on go -> d  on away -> d }
      state d { initial e  enter log \"d in\"  exit log \"d out\"
        state e { enter log \"e in\"  exit log \"e out\" } } }
  }
  state o { initial p
    state p { on go -> w.r.d }
    state q { enter log \"q in\"  after 20 ms -> p } }
  final state end
}";

#[test]
fn regions_are_entered_in_order_and_left_in_reverse() {
    for mut host in in_both_syntaxes(LOGGED) {
        let start = ["+log w in", "+log l in", "+log a in", "+log r in", "+log c in"];
        assert_eq!(host.step(), seen("w.l.a | w.r.c", &start));
        // An event reaches all regions, and each takes its own transition.
        host.raise("go");
        let both = ["+log a out", "+log b in", "+log c out", "+log d in", "+log e in"];
        assert_eq!(host.step(), seen("w.l.b | w.r.d.e", &both));
        // A transition to the region enters it again, and leaves the other one alone.
        host.raise("go");
        assert_eq!(host.step(), seen("w.l.a | w.r.d.e", &["+log b out", "+log l out", "+log l in", "+log a in"]));
        // A transition of the state around them leaves all.
        host.raise("again");
        let left = ["+log e out", "+log d out", "+log r out", "+log a out", "+log l out", "+log w out"];
        assert_eq!(host.step(), seen("w.l.a | w.r.c", &[&left[..], &start].concat()));
        host.raise("go");
        host.step();
        // One that leads out of its region leaves all as well, and the regions behind it are not stepped.
        host.raise("away");
        let out = ["+log e out", "+log d out", "+log r out", "+log b out", "+log l out", "+log w out", "+log q in"];
        assert_eq!(host.step(), seen("o.q", &out));
        host.steps(3);
        // A target in a region enters the other ones at their initial states.
        host.raise("go");
        let into = ["+log w in", "+log l in", "+log a in", "+log r in", "+log d in", "+log e in"];
        assert_eq!(host.step(), seen("w.l.a | w.r.d.e", &into));
    }
}

#[test]
fn the_states_around_are_tested_by_each_region() {
    let mut host = Host::new(
        "signal stop : event
         machine m { initial w  stack still  on fault(any) -> end
           state w {
             on stop -> end
             region l { initial a  state a { after 20 ms -> b  on stop -> b }  state b {} }
             region r { initial c  state c { after 20 ms -> d }  state d {} } }
           final state end }",
    );
    host.steps(2);
    host.raise("stop");
    // Both regions change at this tick: none of them looks at the states around it.
    assert_eq!(host.step().state, "w.l.b | w.r.d");
    host.raise("stop");
    assert_eq!(host.step().state, "end");
}

#[test]
fn each_region_has_clocks_of_its_own() {
    let mut host = Host::new(
        "machine m { initial w  stack still  on fault(any) -> end
           state w {
             when t > 145 ms -> end
             region l { initial a  state a { after 30 ms -> b }  state b { when t > 35 ms -> a } }
             region r { initial c  state c { after 50 ms -> d }  state d { after 80 ms -> c } } }
           final state end }",
    );
    let mut states = Vec::new();
    for _ in 0..16 {
        let state = host.step().state;
        if states.last() != Some(&state) {
            states.push(state);
        }
    }
    let of = ["a c", "b c", "b d", "a d", "b d", "b c", "a c"].map(|s| format!("w.l.{} | w.r.{}", &s[..1], &s[2..]));
    assert_eq!(states, [&of[..], &["end".to_string()]].concat());
}

#[test]
fn a_state_waits_for_the_ends_of_its_regions() {
    let text = |ended: &str| {
        format!(
            "signal go : event
             machine m {{ initial w  stack still  on fault(any) -> end
               state w {{
                 on ended({ended}) -> end
                 region l {{ initial a  state a {{ after 20 ms -> b }}  final state b }}
                 region r {{ initial c  state c {{ on go -> d }}
                   final state d {{ initial e  state e {{ after 10 ms -> f }}  state f {{}} }} }} }}
               final state end }}"
        )
    };
    for ended in ["all", "l, r"] {
        let mut host = Host::new(&text(ended));
        assert_eq!(host.steps(5), "w.l.b | w.r.c");
        assert!(!host.controller.is_final(), "a region has ended, and not the machine");
        host.raise("go");
        assert_eq!(host.step().state, "w.l.b | w.r.d.e", "{ended}");
        assert_eq!(host.step().state, "end", "{ended}");
        assert!(host.controller.is_final());
    }
    let mut host = Host::new(&text("l"));
    assert_eq!(host.steps(2), "w.l.a | w.r.c");
    assert_eq!(host.step().state, "end", "one region is enough, and the other one sees it at the same tick");
}

#[test]
fn a_fault_is_answered_by_the_first_region_that_can_and_then_around() {
    let machine = |left: &str, right: &str, around: &str| {
        Host::new(&format!(
            "machine m {{ initial w  stack still
               {around}
               state w {{
                 region l {{ initial a  {left}  state a {{}}  state b {{ after 1 s -> a }} }}
                 region r {{ initial c  {right}  state c {{}}  state d {{ after 1 s -> c }} }} }}
               final state end }}"
        ))
    };
    let answers = |left: &str, right: &str, around: &str| {
        let mut host = machine(left, right, around);
        host.steps(3);
        let q = host.robot.measure().to_vec();
        let seen = host.step_at(f64::NAN, &q);
        assert_eq!(seen.fault, Some(FaultKind::NotFinite));
        (seen.state, host.controller.is_halted())
    };
    let any = "on fault(any) -> end";
    let (left, right) = ("on fault(not_finite) -> b", "on fault(not_finite) -> d");
    assert_eq!(answers(left, right, any), ("w.l.b | w.r.c".to_string(), false), "only one region answers");
    assert_eq!(answers("on fault(stale) -> b", right, any), ("w.l.a | w.r.d".to_string(), false));
    assert_eq!(answers("", "", any), ("end".to_string(), false));
    assert_eq!(answers("", "on fault(stale) -> d", ""), ("w.l.a | w.r.c".to_string(), true));
}

#[test]
fn events_of_one_region_reach_the_other() {
    let mut host = Host::new(
        "variable n : number = 0
         machine m { initial w  stack still  on fault(any) -> end
           state w {
             region l { initial a  state a { after 20 ms -> b }  state b { enter emit told  enter set(n, n + 1)  after 30 ms -> a } }
             region r { initial c  state c { on told -> d }  state d { when n >= 2 -> f }  state f {} } }
           final state end }",
    );
    let states: Vec<String> = (0..9).map(|_| host.step().state).collect();
    assert_eq!(states[2], "w.l.b | w.r.c", "the event is seen a tick later");
    assert_eq!(states[3], "w.l.b | w.r.d");
    assert_eq!(states[7], "w.l.b | w.r.d", "the variable is read a tick later");
    assert_eq!(states[8], "w.l.b | w.r.f");
}

#[test]
fn one_region_moves_the_robot_undisturbed() {
    let text = |right: &str| {
        format!(
            "task wave = joint_position {{ target {{ joint_1 0.3 rad * sin(2*pi*t/(1 s)) }}  gain 20 /s }}
             stack move from still {{ add motion {{ wave }} }}
             machine m {{ initial w  blend 0.2 s  on fault(any) -> end
               state w {{
                 region l {{ initial a
                   state a {{ stack move  after 0.4 s -> b }}
                   state b {{ stack still  after 0.3 s -> a }} }}
                 region r {{ {right} }} }}
               final state end {{ stack still }} }}"
        )
    };
    let busy = "initial c  state c { after 30 ms -> d }  state d { after 50 ms -> c  when t > 10 ms -> c }";
    let (mut busy, mut quiet) = (Host::new(&text(busy)), Host::new(&text("initial c  state c {}")));
    for tick in 0..200 {
        let (a, b) = (busy.step(), quiet.step());
        assert_eq!((a.fault, b.fault), (None, None));
        assert_eq!(busy.controller.velocity(), quiet.controller.velocity(), "tick {tick}");
    }
    assert!(busy.controller.entries().iter().any(|n| *n > 20));
}

/// States of a random region or machine, with events `e0` to `e2`, times, and a condition on a number.
fn random_states(numbers: &mut impl FnMut(usize) -> usize, prefix: &str) -> String {
    let (mut out, count) = (format!("initial {prefix}0\n"), 2 + numbers(4));
    let trigger = |numbers: &mut dyn FnMut(usize) -> usize| match numbers(5) {
        0 => format!("after {} ms", 10 * (1 + numbers(6))),
        1 => format!("when x > {} for {} ms", numbers(10), 10 * numbers(4)),
        2 => format!("when x < {}", numbers(10)),
        _ => format!("on e{}", numbers(3)),
    };
    if numbers(3) == 0 {
        let _ = writeln!(out, "{} -> {prefix}{}", trigger(numbers), numbers(count));
    }
    for s in 0..count {
        let _ = write!(out, "state {prefix}{s} {{ ");
        for _ in 0..1 + numbers(2) {
            let _ = write!(out, "{} -> {prefix}{}  ", trigger(numbers), numbers(count));
        }
        if numbers(3) == 0 {
            let _ = write!(
                out,
                "\ninitial i  state i {{ {} -> j }}  state j {{ {} -> i }}",
                trigger(numbers),
                trigger(numbers)
            );
        }
        let _ = writeln!(out, "}}");
    }
    out
}

#[test]
fn each_region_goes_its_way_like_a_machine_alone() {
    let signals = "signal e0 : event\nsignal e1 : event\nsignal e2 : event\nsignal x : number\n";
    for seed in 0..60_u64 {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let mut numbers = |below: usize| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state % below as u64) as usize
        };
        let parts: Vec<String> = ["a", "b", "c"].map(|p| random_states(&mut numbers, p)).to_vec();
        let mut alone: Vec<Host> = (parts.iter())
            .map(|part| Host::new(&format!("{signals}machine m {{ initial w  stack still  state w {{ {part} }} }}")))
            .collect();
        let regions: Vec<String> = parts.iter().enumerate().map(|(k, p)| format!("region r{k} {{ {p} }}")).collect();
        let together = format!("{signals}machine m {{ initial w  stack still  state w {{ {} }} }}", regions.join("\n"));
        let [mut host, mut yaml] = in_both_syntaxes(&together);
        for tick in 0..150 {
            let events: Vec<usize> = (0..3).filter(|_| numbers(4) == 0).collect();
            let x = numbers(11) as f64;
            for host in alone.iter_mut().chain([&mut host, &mut yaml]) {
                events.iter().for_each(|e| host.raise(&format!("e{e}")));
                host.set("x", &[x]);
            }
            let each: Vec<String> = (alone.iter_mut().enumerate())
                .map(|(k, host)| host.step().state.replacen("w.", &format!("w.r{k}."), 1))
                .collect();
            assert_eq!(host.step().state, each.join(" | "), "seed {seed}, tick {tick}\n{together}");
            assert_eq!(yaml.step().state, each.join(" | "));
        }
    }
}

#[test]
fn expectations_and_records_know_the_states_of_regions() {
    let program = crate::common::program_of(&format!(
        "{ARM}machine m {{ initial w  stack still  on fault(any) -> end
           state w {{
             region l {{ initial a  state a {{ after 0.3 s -> b }}  state b {{ after 0.2 s -> a }} }}
             region r {{ initial c  state c {{ after 0.4 s -> d }}  state d {{ after 1 s -> end }} }} }}
           final state end }}
         scenario s {{
           duration 2 s
           expect eventually in(w.l.b) and in(w.r.d)
           expect always not (in(w.l.a) and in(w.l.b))
           expect eventually in(end)
           expect always (in(w) or in(end))
           expect always (in(w.r.d) implies not in(w.r.c)) }}"
    ));
    let nothing = &mut crate::common::Everything::default();
    let (summary, outcomes) = crate::common::judged(&program, &program.scenarios[0], nothing);
    assert_eq!(outcomes.len(), 5);
    for outcome in &outcomes {
        assert_eq!(format!("{:?}", outcome.verdict), "Holds", "{outcome:?}");
    }
    let states: Vec<(&str, u64)> = summary.states.iter().map(|s| (s.state.as_str(), s.entries)).collect();
    let of = ["w.l.a | w.r.c", "w.l.b | w.r.c", "w.l.b | w.r.d", "w.l.a | w.r.d"];
    assert_eq!(states[..4], of.map(|s| (s, 1)));
    assert_eq!(states.last(), Some(&("end", 1)));
    assert_eq!((summary.entries["w"], summary.entries["w.r"], summary.entries["w.r.d"]), (1, 1, 1));
}
