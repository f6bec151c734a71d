//! Missions of a compiled spec: the problems of their planners, and how plans are executed.
//!
//! A spec may declare missions beside a robot, or missions alone. A compiled file holds both: the fields of the
//! [`Program`], if there is one, and `missions`.

use mission::any_mission::AnyMission;
use serde::{Deserialize, Serialize};

use super::{AllowedWarning, FORMAT, MissionScenarioProgram, Program, ProgramError, Running, error};

/// A mission.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MissionProgram {
    /// Its name in the spec.
    pub name: String,
    /// Its problem, of one of the kinds.
    #[serde(flatten)]
    pub kind: AnyMission,
    /// Members that run controllers of their own in scenarios.
    #[serde(default, skip_serializing_if = "Running::is_empty")]
    pub running: Running,
    /// Executions of it in worlds of their own, with what is expected of them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub scenarios: Vec<MissionScenarioProgram>,
    /// Warnings of the compiler that the spec allows, for reports.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub allowed: Vec<AllowedWarning>,
}

impl MissionProgram {
    /// Checks that it can be planned; a mission that the compiler lowered always can.
    ///
    /// # Errors
    /// The first part that cannot be planned.
    pub fn check(&self) -> Result<(), ProgramError> {
        let own = |e: ProgramError| error(format!("{}: {}", self.name, e.place), e.message);
        self.kind.check().map_err(|mistake| own(error(mistake.place, mistake.why)))?;
        self.running.check(&*self.kind).map_err(own)?;
        let each = |(i, s): (usize, &MissionScenarioProgram)| {
            let place = format!("scenarios[{i}]");
            s.check(self, &place)?;
            self.running.check_scenario(s, &place)
        };
        self.scenarios.iter().enumerate().try_for_each(each).map_err(own)
    }
}

/// Content of a compiled file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CompiledFile {
    /// The program of the robot; none for a spec of missions alone.
    pub program: Option<Program>,
    /// Missions, in the order declared.
    pub missions: Vec<MissionProgram>,
}

/// A file with a program.
#[derive(Serialize)]
struct Both<'a, S: Serialize> {
    #[serde(flatten)]
    program: &'a Program,
    #[serde(skip_serializing_if = "<[MissionProgram]>::is_empty")]
    missions: &'a [MissionProgram],
    /// For readers of the file; nothing reads it back.
    #[serde(skip_serializing_if = "Option::is_none")]
    stopping: Option<S>,
}

/// A file of missions alone.
#[derive(Serialize)]
struct Missions<'a> {
    format: u32,
    name: &'a str,
    missions: &'a [MissionProgram],
}

/// Keys by which the two forms of a file differ; the others are read later.
#[derive(Deserialize)]
struct Head {
    format: Option<u32>,
    robot: Option<serde::de::IgnoredAny>,
    #[serde(default)]
    missions: Vec<MissionProgram>,
}

impl CompiledFile {
    /// The text of the file. `name` is that of the spec.
    ///
    /// # Errors
    /// A number of it is not finite, which no compiled spec has.
    pub fn to_json(
        name: &str,
        program: Option<&Program>,
        missions: &[MissionProgram],
    ) -> Result<String, serde_json::Error> {
        CompiledFile::to_json_with(name, program, missions, None::<()>)
    }

    /// The text of the file, with the bounds of a stop of each stack for its readers.
    ///
    /// # Errors
    /// A number of it is not finite, which no compiled spec has.
    pub fn to_json_with(
        name: &str,
        program: Option<&Program>,
        missions: &[MissionProgram],
        stopping: Option<impl Serialize>,
    ) -> Result<String, serde_json::Error> {
        let text = match program {
            Some(program) => serde_json::to_string_pretty(&Both { program, missions, stopping }),
            None => serde_json::to_string_pretty(&Missions { format: FORMAT, name, missions }),
        };
        text.map(|text| text + "\n")
    }

    /// Reads a file and checks all of it.
    ///
    /// # Errors
    /// Returns the reason why the file cannot be run or planned, as a sentence.
    pub fn read(text: &str) -> Result<CompiledFile, String> {
        let unread = |e: serde_json::Error| format!("it is no compiled program: {e}");
        let head: Head = serde_json::from_str(text).map_err(unread)?;
        let program = match head.robot {
            None if !head.missions.is_empty() => None,
            _ => Some(serde_json::from_str::<Program>(text).map_err(unread)?),
        };
        let refused = |e: ProgramError| format!("it is no program that can be run: {e}");
        if head.format != Some(FORMAT) {
            let e = error("format", "this program was compiled by another version; compile the spec again");
            return Err(refused(e));
        }
        program.iter().try_for_each(Program::check).map_err(refused)?;
        head.missions.iter().try_for_each(MissionProgram::check).map_err(refused)?;
        Ok(CompiledFile { program, missions: head.missions })
    }
}
