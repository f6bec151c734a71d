//! `hierarq init DIR`

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use hierarq::init::{Project, Refusal, Request, propose};
use robot::Base;

use super::{Outcome, output};

#[derive(Args)]
pub struct Arguments {
    /// Folder of the project; created if it does not exist. No file is overwritten.
    dir: PathBuf,
    /// URDF of the robot [default: an example arm with seven joints]. A `*.xacro` file is expanded by the program `xacro`.
    #[arg(long, value_name = "FILE")]
    urdf: Option<PathBuf>,
    /// SRDF of the robot [default: one of the same name beside the URDF].
    #[arg(long, value_name = "FILE", requires = "urdf")]
    srdf: Option<PathBuf>,
    /// Kind of the robot's base [default: guessed from the names of the joints].
    #[arg(long, value_enum, requires = "urdf")]
    base: Option<BaseName>,
    /// Folder in which `package://` addresses of the URDF are searched. May be repeated.
    #[arg(long, value_name = "DIR", requires = "urdf")]
    package_path: Vec<PathBuf>,
    /// Argument of the xacro file, such as `ur_type:=ur5e`. May be repeated.
    #[arg(long, value_name = "NAME:=VALUE", requires = "urdf")]
    xacro_arg: Vec<String>,
    /// Write the spec in the YAML syntax.
    #[arg(long)]
    yaml: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum BaseName {
    Fixed,
    Planar,
    Unicycle,
    Floating,
}

impl From<BaseName> for Base {
    fn from(name: BaseName) -> Base {
        match name {
            BaseName::Fixed => Base::Fixed,
            BaseName::Planar => Base::Planar,
            BaseName::Unicycle => Base::Unicycle,
            BaseName::Floating => Base::Floating,
        }
    }
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    if a.dir.is_file() {
        return Err(file_for_folder(&a.dir));
    }
    let request = Request {
        folder: a.dir.clone(),
        urdf: a.urdf.clone(),
        srdf: a.srdf.clone(),
        base: a.base.map(Base::from),
        yaml: a.yaml,
        package_paths: a.package_path.clone(),
        xacro_arguments: a.xacro_arg.iter().map(|given| argument(given)).collect::<Result<_, _>>()?,
    };
    let project = match propose(&request) {
        Ok(project) => project,
        Err(Refusal::Wrong(report)) => {
            output::show(&report);
            output::error_line("nothing was written");
            return Ok(Outcome::Failed);
        }
        Err(Refusal::Trouble(text)) => return Err(text),
    };
    let text = write(&a.dir, &project)?;
    output::show(&project.report);
    output::print(&text);
    Ok(Outcome::Good)
}

/// An argument in the form that xacro reads, `NAME:=VALUE`; `NAME=VALUE` is understood too.
fn argument(given: &str) -> Result<String, String> {
    let parts = given.split_once(":=").or_else(|| given.split_once('='));
    match parts {
        Some((name, value)) if !name.is_empty() => Ok(format!("{name}:={value}")),
        _ => Err(format!("`--xacro-arg {given}` is no `NAME:=VALUE`")),
    }
}

/// Words for a file in the place of the folder: most likely the robot, which has an option of its own.
fn file_for_folder(file: &Path) -> String {
    let shown = file.display();
    let command = match file.extension().and_then(|e| e.to_str()) {
        Some("urdf" | "xml" | "xacro") => format!("hierarq init DIR --urdf {shown}"),
        Some("srdf") => format!("hierarq init DIR --urdf ROBOT.urdf --srdf {shown}"),
        _ => "hierarq init DIR".to_string(),
    };
    format!("{shown} is a file, and `init` writes a folder: {command}")
}

/// Writes all files without overwriting any; returns the list of files, with the next steps.
fn write(folder: &Path, project: &Project) -> Result<String, String> {
    if let Some((path, _)) = project.files.iter().find(|(path, _)| path.symlink_metadata().is_ok()) {
        return Err(format!("{} exists already; nothing was written", path.display()));
    }
    let mut said: String = project.remarks.iter().map(|r| format!("{r}\n")).collect();
    for (path, text) in &project.files {
        let parent = path.parent().unwrap_or(folder);
        std::fs::create_dir_all(parent).map_err(|e| format!("cannot create {}: {e}", parent.display()))?;
        // Does not overwrite a file that was created in the meantime.
        files::create(path, text).map_err(|e| format!("cannot write {}: {e}", path.display()))?;
        said += &format!("wrote {}\n", path.display());
    }
    if let Some((spec, _)) = project.files.last() {
        let spec = spec.display();
        said += &format!("\nnext:\n  hierarq check {spec}\n  hierarq run {spec}\n");
    }
    Ok(said)
}
