//! The pages of the diagnostic codes.

/// Code, title, explanation in Markdown.
pub static CODES: &[(&str, &str, &str)] = &[
    (
        "HQ0201",
        "unknown name",
        r#"Nothing of this name was declared, or the robot has no such link, joint, arm or point.

A controller that silently ignored the name would run without the task, limit or frame that you meant. Write the name as it was declared; where one is near, the message offers it.

```hq
level motion { reech }   // error: there is no task `reech`; did you mean `reach`?
```

Names of frames are links, not joints. What the robot does now cannot stand in an expression: `initial(frame(tool).position)` is where it was when the stack became active."#,
    ),
    (
        "HQ0202",
        "declared twice",
        r#"Two declarations share a name, or a name is a word of the language, and it would be unclear which one is meant. Rename one of them.

```hq
param t = 2 s   // error: `t` is the time since the stack became active
```"#,
    ),
    (
        "HQ0203",
        "never used",
        "A declaration that nothing uses usually means that a stack forgot it. A forgotten safety task is not a small thing: add it to a level, or remove it. This is a warning.",
    ),
    (
        "HQ0204",
        "unknown task type",
        r#"The task library has no type of this name. `hierarq tasks` lists all types, `hierarq tasks TYPE` describes one.

```hq
task reach = go_to(tool)   // error: there is no task type `go_to`
```"#,
    ),
    (
        "HQ0205",
        "unknown parameter",
        r#"This key has no meaning here, so what stands behind it would have no effect. `hierarq tasks TYPE` shows the parameters of a task type; the language reference those of other blocks.

```hq
task reach = hold(tool) { gian 2 /s }   // error: did you mean `gain`?
```"#,
    ),
    (
        "HQ0206",
        "missing parameter",
        r#"A parameter was left out that has no default, or whose default does not fit this robot. Nothing is guessed: write it.

```hq
task reach = frame_position(tool)   // error: task type `frame_position` needs `position`
```"#,
    ),
    (
        "HQ0207",
        "given twice",
        r#"The same parameter or joint is given in two places, and they might disagree. Keep one.

```hq
home { all 0 rad  joint_4 1 rad }   // error: joint `joint_4` is given twice
```"#,
    ),
    (
        "HQ0211",
        "import cannot be read",
        r#"The file that an import names is not there, or is no spec. The path is relative to the file that imports it; the name ends in `.hq` or `.yaml`, and either spelling can import the other.

```hq
import "common/safety.hq" { deck }
```"#,
    ),
    (
        "HQ0212",
        "imports in a circle",
        "A file imports one that, directly or through others, imports the first again. Then none of them could be read before the others. Move what both need to a file of its own, and import that.",
    ),
    (
        "HQ0213",
        "nothing of this name to import",
        r#"The imported file declares no param, let, robot, task or stack of this name. Where one is near, the message offers it.

```hq
import "common/safety.hq" { dek }   // error: `common/safety.hq` declares no `dek`; did you mean `deck`?
```"#,
    ),
    (
        "HQ0214",
        "wrong arguments",
        r#"A task or stack with parameters takes one argument for each of them, by place or by name. Those with a default may be left out. Types of the task library are different: their parameters stand in braces.

```hq
task reach(side: arm, goal: point, gain: rate = 5 /s) = frame_position(side) { position goal  gain gain }
stack s { level motion { reach(left, [0.4, 0.2, 0.9] m)  reach(side: right, goal: [0.4, -0.2, 0.9] m) } }
```"#,
    ),
    (
        "HQ0215",
        "argument of the wrong type",
        "What is given for a parameter is not what its type says: a number for an arm, an angle for a length, a name for a point. The message shows both places: what was given, and the parameter.",
    ),
    (
        "HQ0216",
        "defined by itself",
        r#"A declaration that uses itself, directly or through others, would expand without end: a task or stack with parameters, a stack or robot made from another one, a param or let.

```hq
let a = b + 1
let b = 2*a   // error: `a` is defined by itself
```"#,
    ),
    (
        "HQ0217",
        "change that does not fit",
        r#"A stack that is made from another one replaces or removes levels that the other one has, and adds levels that it has not. Changes apply from first to last.

```hq
stack semi from autonomous {
  replace motion { hold(left) }
  add extra { still } before posture
  remove posture
}
```"#,
    ),
    (
        "HQ0218",
        "expansion too large",
        "Imports, parameters and repetition may copy 100,000 nodes of the tree in all, read 200 files, and use each other 64 deep. The bounds keep the time and memory of compiling any file small.",
    ),
    (
        "HQ0219",
        "repetition or hole that means nothing",
        r#"`for` runs over a list, `[left, right]`, or over whole numbers, `1..4`, both ends among them. `${side}` in a name or a text stands for what a `for` around it runs over, or for a parameter of the declaration; inside a name it takes only letters, digits and `_`.

```hq
for side in [left, right] {
  task touch_${side} = frame_position(${side}_tool) { position [0.4, 0, 0.5] m }
}
```"#,
    ),
    (
        "HQ0301",
        "wrong unit",
        r#"The value has another physical dimension than the parameter. Units are checked so that a length in place of a rate, or an angle in place of a length, is found before anything moves. Write a number in the unit that the message names.

```hq
gain 5 cm   // error: a length, and a rate is needed: write 5 /s
```"#,
    ),
    (
        "HQ0302",
        "unlike quantities",
        r#"Only quantities of one dimension can be added, compared or stand in one vector. Adding metres to radians has no meaning, and a bare number behind `+` has no unit of its own.

```hq
position [0.5 m + 0.2, 0 m, 0 m]   // error: write 0.2 m
```"#,
    ),
    (
        "HQ0303",
        "unknown unit",
        "The unit is none that the language knows, or its powers are beyond anything meant. Lengths: m, cm, mm, um, km. Angles: rad, mrad, deg, turn. Times: s, ms, us, min, h. Rates: Hz, kHz, rpm, /s. Masses: kg, g. Forces, torques, energy, power: N, kN, mN, Nm, J, W.",
    ),
    (
        "HQ0304",
        "wrong type",
        r#"A value of another type is needed here: a number, a vector `[x, y, z]`, an orientation such as `rpy(..)`, a name, a list, or named values in braces.

```hq
task turn = frame_orientation(tool) { orientation [0, 0, 90] deg }   // error: write rpy(0, 0, 90 deg)
```

An exponent is a constant whole number without a unit: `2^3 /s` reads as `2^(3 /s)`, so write `(2^3) /s`."#,
    ),
    (
        "HQ0305",
        "bare number for an angle",
        r#"The number is read as radians. Degrees that are taken for radians are a classic: 45 instead of 0.785, seven turns instead of an eighth. Write the unit, `0.5 rad` or `30 deg`, and the doubt is gone. This is a warning.

```hq
orientation rpy(0, 0, 45)   // warning: 45 rad are 7.2 turns
```"#,
    ),
    (
        "HQ0306",
        "wrong argument",
        r#"A function was given something that it is not defined for, such as the sine of a length or of a time. An angle that grows with time is a rate times the time.

```hq
gain (2 + sin(t)) /s          // error: `sin` needs an angle, and this is a time
gain (2 + sin(2*pi*t/(25 s))) /s
```"#,
    ),
    (
        "HQ0307",
        "must not move",
        "This value is needed before the robot starts and cannot depend on `t`, `time` or captured values: a param, a wall's three points, a setting of the robot or the run. Write a constant.",
    ),
    (
        "HQ0308",
        "out of range",
        "The value lies outside the range that has a meaning, such as a negative distance, a gain of zero for a barrier function, limits upside down, or a run of no time. It is not moved into the range silently: write one inside it.",
    ),
    (
        "HQ0309",
        "undefined value",
        r#"The expression has no value: a division by zero, the root or logarithm of a negative number, an axis without direction, a result that is not finite.

```hq
gain 1/(2 - 2) /s   // error: this divides by zero
```"#,
    ),
    (
        "HQ0310",
        "wrong number of values",
        r#"A list has too few or too many values, or a function was given the wrong number of arguments. A vector has three numbers; a list for a group of joints has one value for each of them, in the group's order.

```hq
home { all [0, 0, 1] rad }   // error: 7 joints, and 3 values
```"#,
    ),
    (
        "HQ0311",
        "nothing to capture",
        r#"`initial(..)` captures a value at the moment the stack becomes active: `frame(LINK).position`, `frame(LINK).orientation`, `joint(NAME)`, or a value of the task itself, named like the parameter that it is the target of, such as `initial(position)` or `initial(absolute.position)`. It stands in the parameters of tasks only.

```hq
task lift = frame_position(tool) { position initial(position) + [0, 0, 0.1] m }
```"#,
    ),
    (
        "HQ0315",
        "outside the range of a param",
        r#"A param may say between which values it lies. Its own value, and one given with `--set`, must lie there; both places are shown.

```hq
param approach = 0.15 m { min 0.05 m  max 0.3 m }   // --set approach=0.5m is an error
```"#,
    ),
    (
        "HQ0401",
        "file not found",
        "A file that the spec names cannot be read. Paths are relative to the file that names them, not to the folder that the command was started in.",
    ),
    (
        "HQ0402",
        "broken URDF",
        "The URDF cannot be used; the message points into the URDF itself. A link that hangs on nothing, a circle of joints, numbers that are not finite or limits upside down leave no robot to control.",
    ),
    (
        "HQ0403",
        "doubtful URDF",
        r#"The URDF loads, and something in it was ignored or is probably not meant. Limits that are missing, zero or absurd are never guessed: the joint counts as unlimited until the spec gives a limit. This is a warning.

```hq
limits { joint_4 { lower -0.2 rad  upper 2.6 rad  velocity 2 rad/s } }
```"#,
    ),
    (
        "HQ0404",
        "home outside limits",
        "The home configuration, where the robot starts, or the place where a joint is locked, lies outside the joint's limits. No barrier function can keep a limit that is broken from the start. Move the joint inside, or set other limits under `limits`. Angles without a unit are radians: for degrees write `90 deg`.",
    ),
    (
        "HQ0405",
        "joint not at home",
        "The home configuration leaves out joints whose limits do not contain zero. They start at the limit nearest to it, on the very edge of what is allowed. Name them in `home`. This is a warning.",
    ),
    (
        "HQ0501",
        "overshoots in one step",
        r#"A gain K with control period T moves the error by `K T` of itself in one tick. Above 1 it overshoots, above 2 it diverges; a barrier function is broken already above 1 (mathematics, sampled time). Lower the gain or raise the rate.

```hq
robot arm { rate 100 Hz .. }
task reach = hold(tool) { gain 150 /s }   // error: 150 /s times 0.01 s is 1.5
```"#,
    ),
    (
        "HQ0502",
        "starts outside the safe set",
        "At the home configuration a limit is already violated, or a value is undefined, so no barrier function can promise anything. Move the home configuration or the limit. For a virtual wall the order of the three points says which side is free: swap two of them for the other side.",
    ),
    (
        "HQ0503",
        "cannot be built",
        r#"The parameters of the task are each well formed but make no sense together, such as three points on one line that should span a plane, or a pair of parts that cannot move against each other. `sampled_margin auto` needs speed limits that hold: `joint_velocity_limits` on a hard level, that of the task or one above it.

```hq
task wall = virtual_wall(elbow) { through [[0, 0, 0], [1, 0, 0], [2, 0, 0]] m }   // error
```"#,
    ),
    (
        "HQ0504",
        "hard limits not met at the start",
        "A hard level has no solution at the home configuration: what it asks for contradicts itself or the hard levels above. A hard level takes no slack, so the very first tick would be a fault. Relax one of them, or remove `hard` from the lower one.",
    ),
    (
        "HQ0505",
        "starts inside its reserve",
        r#"A wall or a collision limit holds a reserve back against what sampling in time can lose (`sampled_margin`), and at the home configuration the margin is smaller than it. The limit is not violated, but its row asks for distance from the first tick on: the robot is pushed away until the margin is as large as the reserve, whatever the levels below want.

The reserve `δ = A T / (2 φ)` grows with the square of the speeds and with the period. Start further away, lower the limits of `joint_velocity_limits`, raise the rate or the gain. This is a warning.

```hq
task wall = virtual_wall(tip) { through [[0, 0, 0.3], [1, 0, 0.3], [0, 1, 0.3]] m  sampled_margin auto }
stack s { level limits hard { joint_velocity_limits { max 2 rad/s }  wall } }   // warning: 40 mm of margin, 89 mm held back
```"#,
    ),
    (
        "HQ0506",
        "a limit wider than the robot's",
        r#"A task that keeps joints within limits was given a limit beyond that of the robot itself. Its rows then let through positions or speeds that the joint does not have. The joint stops or slows down at its own limit, the reference runs on, and after half a radian the controller stops the robot with a `tracking` fault. Margins are shown against the limit that was given, so the table says nothing of it.

Keep the limit within the robot's, or leave it out: the robot's own is the default. Where the URDF is wrong, correct it with the robot's `limits`. This is a warning.

```hq
task position_limits = joint_position_limits { upper { joint_1 3.5 rad } }   // warning: the URDF says 2.9 rad
task position_limits = joint_position_limits { upper { joint_1 2.5 rad } }   // good
```"#,
    ),
    (
        "HQ0601",
        "empty",
        r#"A stack without levels, or a level without tasks, asks for nothing, and a spec without a stack leaves the robot without anything to hold to.

```hq
stack safe { level limits hard { joint_position_limits  joint_velocity_limits } }
```"#,
    ),
    (
        "HQ0602",
        "task twice in a stack",
        "The task already stands in this stack. At the lower place it would only repeat what the higher one has settled. Keep it where it matters most.",
    ),
    (
        "HQ0603",
        "no run",
        r#"The spec has several stacks, and nothing says which one `hierarq run` runs. Name it. With exactly one stack no `run` is needed.

```hq
run { stack autonomous  duration 10 s }
```"#,
    ),
    (
        "HQ0604",
        "no freedom left",
        "The levels above, or what the stack locks, leave no degree of freedom for this level at the home configuration: its tasks will never have any influence there. Lower the demands above, or unlock joints. This is a warning.",
    ),
    (
        "HQ0605",
        "more than a run can be",
        "The run has more ticks than the tool will count: its duration divided by the control period is above a thousand million. Shorten it.",
    ),
    (
        "HQ0606",
        "soft level above a hard one",
        "A hard level that stands below a soft one must live with whatever the soft one has taken; it can become infeasible through it, which is a fault. Put hard levels first. This is a warning.",
    ),
    (
        "HQ0607",
        "not a compiled program",
        "The file is not a program as `hierarq compile --format json` writes it, or it was written by another version, or edited in a way that makes no sense. Compile the spec again.",
    ),
];
