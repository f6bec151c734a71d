//! Large texts: a realistic spec of 5,000 lines, and a mebibyte of each of several kinds of adversarial texts.
#![allow(dead_code)]

use dsl::Syntax;

/// Approximate size of each adversarial text (bytes).
pub const SIZE: usize = 1 << 20;

/// Robot of all texts.
const ROBOT: &str = "robot arm { urdf \"robots/arm7.urdf\"  rate 100 Hz  home { joint_4 1 rad } }\n";
const YAML_ROBOT: &str = "robots: { arm: { urdf: robots/arm7.urdf, rate: 100 Hz, home: { joint_4: 1 rad } } }\n";

/// Returns a valid spec of about `lines` lines: params, tasks and stacks that use all of them.
pub fn honest(lines: usize) -> String {
    let mut text = format!("hierarq 1\n\n{ROBOT}");
    // Two walls, targets and joint velocities take 30 lines with their stack.
    let tasks = (lines.saturating_sub(20) / 30).max(1) * 6;
    // No multiple of three, so that walls and targets use all of them.
    let widths = tasks / 4 + usize::from((tasks / 4).is_multiple_of(3));
    for i in 0..widths {
        text.push_str(&format!("param width_{i} = 0.{:03} m  // a figure of the cell\n", 1 + i % 900));
    }
    for i in 0..tasks {
        let width = i % widths;
        text.push_str(&match i % 3 {
            0 => format!(
                "task reach_{i} = frame_position(tool) {{\n  position initial(position) + [width_{width}, 0 m, 0.1 m] * \
                 sin(2*pi*t/({} s))\n  gain {}.5 /s\n}}\n",
                4 + i,
                1 + i % 9
            ),
            1 => format!(
                "task wall_{i} = virtual_wall(link_4, link_6) {{\n  through [[0, 0, -0.{0}], [1, 0, -0.{0}], [0, 1, -0.{0}]] m\n  \
                 d_min width_{width}\n}}\n",
                100 + i % 100
            ),
            _ => format!(
                "task swing_{i} = joint_velocity {{\n  velocity {{ joint_1 0.{:03} rad/s * sin(2*pi*t/({} s)) }}\n}}\n",
                1 + i % 900,
                3 + i
            ),
        });
    }
    for i in (0..tasks).step_by(6) {
        // Targets of one tool on one level are a compromise only if their weights differ.
        text.push_str(&format!(
            "stack s_{i} {{\n  level limits hard {{ joint_position_limits  joint_velocity_limits  joint_acceleration_limits }}\n  level walls {{ \
             wall_{}  wall_{} }}\n  level motion {{ reach_{i} weight 2  reach_{} }}\n  level rest {{ swing_{} weight 2  \
             swing_{} }}\n}}\n",
            i + 1,
            i + 4,
            i + 3,
            i + 2,
            i + 5
        ));
    }
    text.push_str("run { stack s_0  duration 1 s }\n");
    text
}

/// Concatenates `line(0)`, `line(1)` .. up to [`SIZE`] bytes.
fn lines(line: impl Fn(usize) -> String) -> String {
    let mut text = String::with_capacity(SIZE + 100);
    let mut i = 0;
    while text.len() < SIZE {
        text.push_str(&line(i));
        i += 1;
    }
    text
}

/// Returns a name, a syntax and a text of each adversarial text.
pub fn nuisances() -> Vec<(&'static str, Syntax, String)> {
    let repeated = |piece: &str| piece.repeat(SIZE / piece.len());
    let hq = |text: String| format!("hierarq 1\n{ROBOT}{text}");
    let yaml = |text: String| format!("hierarq: 1\n{YAML_ROBOT}{text}");
    let stack = "stack s { level l { joint_velocity_limits } }\n";
    let mut bomb = String::from("params:\n  a0: &a0 [1, 2, 3]\n");
    for i in 1..60 {
        bomb.push_str(&format!("  a{i}: &a{i} [*a{0}, *a{0}, *a{0}]\n", i - 1));
    }
    vec![
        ("open brackets", Syntax::Native, hq(format!("param a = {}", repeated("[")))),
        ("open braces", Syntax::Native, hq(repeated("task a = hold { "))),
        ("parentheses without end", Syntax::Native, hq(format!("param a = {}", repeated("(1 + ")))),
        (
            "balanced, too deep",
            Syntax::Native,
            hq(format!("param a = {}1{}", "[".repeat(SIZE / 2), "]".repeat(SIZE / 2))),
        ),
        ("one line of operators", Syntax::Native, hq(format!("param a = 1{}", repeated(" + 1")))),
        ("one line of fields", Syntax::Native, hq(format!("param a = x{}", repeated(".x")))),
        ("a list without end", Syntax::Native, hq(format!("param a = [{}0]\n{stack}", repeated("0, ")))),
        ("one long text", Syntax::Native, hq(format!("run {{ title \"{}\" }}\n{stack}", repeated("x")))),
        ("one long name", Syntax::Native, hq(format!("task {} = hold(tool)\n{stack}", repeated("x")))),
        ("one long comment", Syntax::Native, hq(format!("// {}\n{stack}", repeated("x ")))),
        ("many params", Syntax::Native, hq(format!("{}{stack}", lines(|i| format!("param p{i} = {i} m\n"))))),
        ("many params of one name", Syntax::Native, hq(format!("{}{stack}", repeated("param p = 1 m\n")))),
        ("a chain of params", Syntax::Native, {
            let line = |i: usize| format!("param p{} = p{i} + p{i}\n", i + 1);
            hq(format!("param p0 = 1\n{}{stack}", lines(line)))
        }),
        ("many tasks", Syntax::Native, hq(lines(|i| format!("task t{i} = hold(tool)\n")))),
        ("many tasks on a level", Syntax::Native, {
            let tasks: String = (0..SIZE / 30).map(|i| format!("task t{i} = hold(tool)\n")).collect();
            let names: String = (0..SIZE / 30).map(|i| format!("t{i} ")).collect();
            hq(format!("{tasks}stack s {{ level l {{ {names}}} }}\n"))
        }),
        ("many levels", Syntax::Native, {
            hq(format!("stack s {{\n{}}}\n", lines(|i| format!("level l{i} {{ hold(tool) {{ gain {i}e-9 /s }} }}\n"))))
        }),
        ("many unknown tasks", Syntax::Native, {
            let tasks: String = (0..5000).map(|i| format!("task reach_{i} = hold(tool)\n")).collect();
            hq(format!("{tasks}stack s {{ level l {{\n{}}} }}\n", lines(|i| format!("raech_{i} "))))
        }),
        ("unknown tasks just below the bounds", Syntax::Native, {
            let tasks: String = (0..4900).map(|i| format!("task reach_{i:04} = hold(tool)\n")).collect();
            let names: String = (0..4900).map(|i| format!("raech_{i:04} ")).collect();
            hq(format!("{tasks}stack s {{ level l {{\n{names}}} }}\n"))
        }),
        ("stacks just below the bounds", Syntax::Native, {
            let stacks: String =
                (0..199).map(|i| format!("stack s{i} {{ level l {{ joint_velocity_limits }} }}\n")).collect();
            hq(format!("{stacks}run {{ stack s1  duration 1 s }}\n"))
        }),
        ("rows just above the bound", Syntax::Native, {
            let names: String = (0..2000).map(|i| format!("hold(tool) {{ gain {i}e-4 /s }} ")).collect();
            hq(format!("stack s {{ level l {{\n{names}}} }}\n"))
        }),
        ("rows just below the bound", Syntax::Native, {
            let names: String = (0..330).map(|i| format!("hold(tool) {{ gain {i}e-4 /s }} ")).collect();
            hq(format!("stack s {{ level l {{\n{names}}} }}\n"))
        }),
        ("pairs above the bound", Syntax::Native, {
            let points = |side: &str, link: &str| (0..50).map(|i| format!("{side}{i} {link}\n")).collect::<String>();
            let names = |side: &str| (0..50).map(|i| format!("{side}{i}")).collect::<Vec<_>>().join(", ");
            format!(
                "hierarq 1\nrobot arm {{ urdf \"robots/arm7.urdf\"  rate 100 Hz  home {{ joint_4 1 rad }}\npoints {{ {}{} }} }}\n\
                 task a = self_collision {{ between [{}]  and [{}]  d_min 0 m }}\nstack s {{ level l {{ a }} }}\n",
                points("a", "link_6"),
                points("b", "base_link"),
                names("a"),
                names("b")
            )
        }),
        ("many stacks", Syntax::Native, {
            hq(lines(|i| format!("stack s{i} {{ level l {{ joint_velocity_limits }} }}\n")))
        }),
        ("many mistakes of form", Syntax::Native, hq(repeated("task $ = hold(tool) }\n"))),
        (
            "many mistakes of units",
            Syntax::Native,
            hq(format!("{}{stack}", lines(|i| format!("param p{i} = 1 m + 1 s\n")))),
        ),
        ("many declarations without a brace", Syntax::Native, hq(repeated("robot a\n x 1\n"))),
        ("many units misspelt", Syntax::Native, hq(format!("robot b {{\n{}}}\n", repeated(" x 1 hzx\n")))),
        ("huge numbers", Syntax::Native, hq(format!("param a = {}\n{stack}", repeated("9")))),
        ("huge exponents", Syntax::Native, hq(format!("{}{stack}", lines(|i| format!("param p{i} = 1e{i}\n"))))),
        ("huge powers", Syntax::Native, hq(format!("{}{stack}", lines(|i| format!("param p{i} = 2^{i}^{i}\n"))))),
        ("quotes", Syntax::Native, hq(repeated("\"\n"))),
        ("two bytes to a sign", Syntax::Native, hq(repeated("é"))),
        ("flow sequences", Syntax::Yaml, yaml(format!("params: {{ a: {}", repeated("[")))),
        ("block sequences", Syntax::Yaml, yaml(format!("params:\n a: {}", repeated("- ")))),
        ("aliases of aliases", Syntax::Yaml, yaml(bomb)),
        ("one anchor, many aliases", Syntax::Yaml, {
            yaml(format!("tasks:\n  t: &t {{ hold: {{ frames: tool }} }}\n{}", lines(|i| format!("  t{i}: *t\n"))))
        }),
        ("many anchors", Syntax::Yaml, yaml(format!("params:\n{}", lines(|i| format!("  p{i}: &a{i} {i} m\n"))))),
        ("merges of merges", Syntax::Yaml, {
            let line = |i: usize| format!("    a{}: &a{} {{ <<: [*a{i}, *a{i}], k{i}: 1 }}\n", i + 1, i + 1);
            yaml(format!("run:\n    a0: &a0 {{ x: 1 }}\n{}", lines(line)))
        }),
        ("keys without values", Syntax::Yaml, yaml(format!("robots:\n{}", lines(|i| format!("  r{i}:\n"))))),
        (
            "keys beside their section",
            Syntax::Yaml,
            yaml(format!("tasks:\n{}", lines(|i| format!("t{i}: hold(tool)\n")))),
        ),
        ("lines between columns", Syntax::Yaml, {
            yaml(format!("tasks:\n{}", lines(|i| format!("{}t{i}: hold(tool)\n", " ".repeat(2 + i % 2)))))
        }),
        ("tabs", Syntax::Yaml, yaml(repeated("\ta: b\n"))),
        ("one long scalar", Syntax::Yaml, yaml(format!("params: {{ a: \"{}\" }}\n", repeated("1 + ")))),
        (
            "many mistakes in YAML",
            Syntax::Yaml,
            yaml(format!("tasks:\n{}", lines(|i| format!("  t{i}: hold(tol{i})\n")))),
        ),
    ]
    .into_iter()
    .chain(repetitions())
    .collect()
}

/// Texts that once caused quadratic work: each of many parts was compared with all others, or caused a rescan of the
/// rest.
fn repetitions() -> Vec<(&'static str, Syntax, String)> {
    let repeated = |piece: &str| piece.repeat(SIZE / piece.len());
    let hq = |text: String| (Syntax::Native, format!("hierarq 1\n{ROBOT}{text}"));
    let yaml = |text: String| (Syntax::Yaml, format!("hierarq: 1\n{YAML_ROBOT}{text}"));
    let with_robot = |body: String| {
        let robot = "urdf \"robots/arm7.urdf\"  rate 100 Hz  home { joint_4 1 rad }";
        (Syntax::Native, format!("hierarq 1\nrobot arm {{ {robot}\n{body} }}\n"))
    };
    let stack = "stack s { level l { joint_velocity_limits } }\n";
    let machine = "machine m { initial a  state b { stack s }\nstate a { stack s\n";
    let named: Vec<(&'static str, (Syntax, String))> = vec![
        ("declarations without a block", hq(repeated("human0\n"))),
        ("blocks without a brace and without an end", hq(lines(|i| format!("humans h{i}\n x 1\n")))),
        ("one key, again and again", with_robot(repeated("joints, "))),
        ("many groups", {
            let groups = lines(|i| format!("g{} [g{i}]\n", i + 1));
            with_robot(format!("points {{ p link_6 }}  groups {{ g0 [p]  {groups} }}"))
        }),
        ("groups of groups", {
            let groups: String = (1..60).map(|i| format!("g{i} [g{0}, g{0}, g{0}]\n", i - 1)).collect();
            with_robot(format!("points {{ p link_6 }}  groups {{ g0 [p]\n{groups} }}"))
        }),
        ("arms of arms", {
            let arms: String = (1..60).map(|i| format!("a{i} {{ tip tool  points [arms] }}\n")).collect();
            with_robot(format!("points {{ p link_6 }}  arms {{ a0 {{ tip tool  points [p] }}\n{arms} }}"))
        }),
        ("many points of a robot", with_robot(format!("points {{ {} }}", lines(|i| format!("p{i} link_6\n"))))),
        ("robots made from a large one", {
            let keys: String = (0..20_000).map(|i| format!("key_{i} 1\n")).collect();
            let robots = (0..2_000).map(|i| format!("robot r{i} from arm {{ rate 50 Hz }}\n")).collect::<String>();
            let (syntax, text) = with_robot(keys);
            (syntax, text + &robots + stack)
        }),
        ("a person of many points", hq(format!("human h {{ points [{}] }}\n{stack}", lines(|i| format!("p{i}, "))))),
        ("arguments by name", {
            hq(format!("task a = hold({}tool)\nstack s {{ level l {{ a }} }}\n", lines(|i| format!("f{i}: 1, "))))
        }),
        ("parameters of a stack", {
            let parameters = lines(|i| format!("f{i}: arm, "));
            hq(format!("stack a({parameters}z: arm) {{ level l {{ hold(tool) }} }}\n{stack}"))
        }),
        ("changes of levels that are not there", {
            hq(format!("{stack}stack b from s {{\n{}}}\n", lines(|i| format!("remove l{i}\n"))))
        }),
        ("many states", hq(format!("{stack}{machine}}}\n{} }}\n", lines(|i| format!("state s{i} {{ stack s }}\n"))))),
        ("ways out of one state", {
            hq(format!("{stack}{machine}{} }} }}\n", lines(|i| format!("when t > {i} s -> b\n"))))
        }),
        ("ways out just below the bound", {
            let ways: String = (0..9_000).map(|i| format!("when t > {i} s -> b\n")).collect();
            hq(format!("{stack}{machine}{ways} }} }}\n"))
        }),
        ("keys with holes", {
            let keys: String = (0..20_000).map(|i| format!("k_${{i}}_{i} 1\n")).collect();
            hq(format!("for i in 1..2 {{ task a_${{i}} = hold(tool) {{\n{keys} }} }}\n{stack}"))
        }),
        ("holes without an end", hq(format!("run {{ title \"{}\" }}\n{stack}", repeated("${a")))),
        ("names that are holes without an end", hq(repeated("task ${\n"))),
        ("headers between mistakes", (Syntax::Native, repeated("task\nhierarq 1\n"))),
        ("one key of YAML, again and again", {
            (Syntax::Yaml, format!("hierarq: 1\nrobots: {{ r: {{{}}}}}\n", repeated("a: 1, ")))
        }),
        ("keys without values on a line", {
            (Syntax::Yaml, format!("hierarq: 1\nrobots: {{ r: {{{}}}}}\nbad\n", lines(|i| format!("a{i}: , "))))
        }),
        ("levels without names", yaml(format!("stacks: {{s: {{levels: [{}]}}}}\n", repeated("{foo: 1}, ")))),
        ("items in the place of levels", yaml(format!("stacks: {{s: {{levels: [{}]}}}}\n", repeated(":, ")))),
        ("merges of a large mapping", {
            let keys = lines(|i| format!("k{i}: 1, "));
            yaml(format!("params:\n  b: &b {{{keys}}}\n  c: {{ <<: *b }}\n  d: {{ <<: [*b, *b] }}\n"))
        }),
        ("states in YAML", yaml(format!("machines: {{m: {{states: {{{}}}}}}}\n", lines(|i| format!("s{i}: {{}}, "))))),
        ("scenarios in YAML", yaml(format!("scenarios:\n{}", lines(|i| format!("  s{i}: {{duration: 1 s}}\n"))))),
        ("imports in YAML", (Syntax::Yaml, format!("hierarq: 1\nimport:\n{}", lines(|i| format!("  f{i}.hq: []\n"))))),
        ("tags of YAML on a line", yaml(format!("params: {{{}}}\n", lines(|i| format!("a{i}: !x 1, "))))),
    ];
    named.into_iter().map(|(name, (syntax, text))| (name, syntax, text)).collect()
}
