//! HiGHS, a powerful external engine: its library is found at run time and called by its C interface.
//!
//! Search order: the file or folder in the environment variable `HIERARQ_HIGHS`, the usual library folders, and of the packages
//! of `python3` `highsbox`, which contains the library, and `highspy` up to 1.14, whose extension module exports its C functions. One thread and a fixed seed: the same program gives the
//! same answer unless the time limit ends it.
//!
//! This is the only file of the project with `unsafe`: calls of C functions.
#![expect(unsafe_code, reason = "the library is C; each call says why it is sound")]

use std::ffi::{CStr, CString, c_char, c_double, c_int, c_void};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use libloading::Library;

use crate::plan::Limit;

use super::{Answer, Budget, EngineError, Milp, Model};

const INSTALL: &str = "python3 -m pip install highsbox";

type Handle = *mut c_void;
type Create = unsafe extern "C" fn() -> Handle;
type Destroy = unsafe extern "C" fn(Handle);
type Act = unsafe extern "C" fn(Handle) -> c_int;
type SetInt = unsafe extern "C" fn(Handle, *const c_char, c_int) -> c_int;
type SetDouble = unsafe extern "C" fn(Handle, *const c_char, c_double) -> c_int;
type SetText = unsafe extern "C" fn(Handle, *const c_char, *const c_char) -> c_int;
type Number = unsafe extern "C" fn() -> c_int;
type Text = unsafe extern "C" fn() -> *const c_char;
type GetDouble = unsafe extern "C" fn(Handle, *const c_char, *mut c_double) -> c_int;
type GetLong = unsafe extern "C" fn(Handle, *const c_char, *mut i64) -> c_int;
type SetSparse = unsafe extern "C" fn(Handle, c_int, *const c_int, *const c_double) -> c_int;
type GetSolution = unsafe extern "C" fn(Handle, *mut c_double, *mut c_double, *mut c_double, *mut c_double) -> c_int;
type PassMip = unsafe extern "C" fn(
    Handle,
    c_int,
    c_int,
    c_int,
    c_int,
    c_int,
    c_double,
    *const c_double,
    *const c_double,
    *const c_double,
    *const c_double,
    *const c_double,
    *const c_int,
    *const c_int,
    *const c_double,
    *const c_int,
) -> c_int;

/// Constants of the C interface, `highs_c_api.h`.
const ROW_WISE: c_int = 2;
const MINIMISE: c_int = 1;
const STATUS_ERROR: c_int = -1;
const MODEL_OPTIMAL: c_int = 7;
const MODEL_INFEASIBLE: c_int = 8;
/// No cost of a planner is unbounded, so that this status means infeasible.
const MODEL_UNBOUNDED_OR_INFEASIBLE: c_int = 9;
const MODEL_TIME_LIMIT: c_int = 13;
const MODEL_SOLUTION_LIMIT: c_int = 16;
const PRIMAL_FEASIBLE: c_int = 2;

/// The functions of a loaded library that this module calls.
struct Functions {
    create: Create,
    destroy: Destroy,
    pass: PassMip,
    run: Act,
    model_status: Act,
    set_int: SetInt,
    set_bool: SetInt,
    set_double: SetDouble,
    set_text: SetText,
    set_sparse: SetSparse,
    get_solution: GetSolution,
    get_double: GetDouble,
    get_long: GetLong,
    get_int: unsafe extern "C" fn(Handle, *const c_char, *mut c_int) -> c_int,
    /// Keeps the functions loaded; dropped last.
    _library: Library,
}

/// HiGHS as a [`Milp`].
pub struct Highs {
    functions: Functions,
    name: String,
    path: PathBuf,
}

impl Highs {
    /// Finds and loads the library.
    ///
    /// # Errors
    ///
    /// [`EngineError::Missing`] with the command that installs it.
    pub fn find() -> Result<Highs, EngineError> {
        let named = std::env::var_os("HIERARQ_HIGHS").map(PathBuf::from);
        if let Some(named) = named {
            let found = candidates(&named).into_iter().find_map(|path| Highs::load(&path).ok());
            return found.ok_or_else(|| missing(format!("nothing to load at HIERARQ_HIGHS={}", named.display())));
        }
        let folders = ["/usr/local/lib", "/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/lib64"];
        let more = ["/usr/lib", "/opt/homebrew/lib"];
        let usual = folders.into_iter().chain(more).map(PathBuf::from);
        let found = usual.flat_map(|folder| candidates(&folder)).find_map(|path| Highs::load(&path).ok());
        let python =
            || packages().iter().flat_map(|folder| candidates(folder)).find_map(|path| Highs::load(&path).ok());
        let searched = "HIERARQ_HIGHS, the usual folders of libraries, the package highsbox of python3";
        found.or_else(python).ok_or_else(|| missing(format!("looked for in {searched}")))
    }

    /// Loads the library of this file.
    ///
    /// # Errors
    ///
    /// [`EngineError::Missing`] if it is not HiGHS, version 1.7 or newer, with 32-bit indices.
    pub fn load(path: &Path) -> Result<Highs, EngineError> {
        // SAFETY: loading a file runs its initialisers; the file is named `libhighs` or was chosen by the user. The
        // initialisers of HiGHS only set up static data.
        let library = unsafe { Library::new(path) }.map_err(|error| missing(error.to_string()))?;
        let functions = functions(library).map_err(|error| missing(error.to_string()))?;
        // SAFETY: the function of this name takes nothing and returns the size of an index in bytes.
        let size = unsafe { functions._library.get::<Number>(b"Highs_getSizeofHighsInt\0") };
        if let Ok(size) = size {
            // SAFETY: as above.
            if unsafe { size() } != 4 {
                return Err(missing(format!("{} has 64-bit indices", path.display())));
            }
        }
        // SAFETY: the function of this name takes nothing and returns a static text that ends in 0.
        let version = unsafe {
            let text = functions._library.get::<Text>(b"Highs_version\0").map(|version| version());
            text.map(|text| CStr::from_ptr(text).to_string_lossy().into_owned()).unwrap_or_default()
        };
        Ok(Highs { functions, name: format!("HiGHS {version}"), path: path.to_owned() })
    }

    /// Returns the path of the loaded file.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

fn missing(searched: String) -> EngineError {
    EngineError::Missing { engine: "HiGHS".into(), searched, install: INSTALL.into() }
}

/// Returns the library files in a folder, sorted by name; or the file itself.
fn candidates(path: &Path) -> Vec<PathBuf> {
    if path.is_file() {
        return vec![path.to_owned()];
    }
    let Ok(entries) = std::fs::read_dir(path) else { return Vec::new() };
    let library = |path: &PathBuf| {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let dynamic = name.contains(".so") || name.ends_with(".dylib") || name.ends_with(".dll");
        dynamic && ["libhighs.", "highs.", "_core."].iter().any(|begin| name.starts_with(begin))
    };
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(library).collect();
    files.sort();
    files
}

/// Returns the folders of the libraries in packages that `python3` would import, except for the working folder. Runs no code of
/// the packages.
fn packages() -> Vec<PathBuf> {
    let ask = "import site; print(*site.getsitepackages(), site.getusersitepackages(), sep='\\n')";
    let output = Command::new("python3").args(["-I", "-c", ask]).stdin(Stdio::null()).stderr(Stdio::null()).output();
    let text = output.ok().and_then(|output| String::from_utf8(output.stdout).ok()).unwrap_or_default();
    let inside = ["highsbox/highs_dist/lib", "highsbox/highs_dist/bin", "highspy"];
    let folders = text.lines().flat_map(|folder| inside.map(|inside| Path::new(folder).join(inside)));
    folders.filter(|path| path.is_dir()).collect()
}

/// Resolves the functions by name.
fn functions(library: Library) -> Result<Functions, libloading::Error> {
    // SAFETY: each type is the one that `highs_c_api.h` declares for the name, unchanged since version 1.7; the library
    // is kept beside the pointers, so that they stay valid.
    unsafe {
        Ok(Functions {
            create: *library.get(b"Highs_create\0")?,
            destroy: *library.get(b"Highs_destroy\0")?,
            pass: *library.get(b"Highs_passMip\0")?,
            run: *library.get(b"Highs_run\0")?,
            model_status: *library.get(b"Highs_getModelStatus\0")?,
            set_int: *library.get(b"Highs_setIntOptionValue\0")?,
            set_bool: *library.get(b"Highs_setBoolOptionValue\0")?,
            set_double: *library.get(b"Highs_setDoubleOptionValue\0")?,
            set_text: *library.get(b"Highs_setStringOptionValue\0")?,
            set_sparse: *library.get(b"Highs_setSparseSolution\0")?,
            get_solution: *library.get(b"Highs_getSolution\0")?,
            get_double: *library.get(b"Highs_getDoubleInfoValue\0")?,
            get_long: *library.get(b"Highs_getInt64InfoValue\0")?,
            get_int: *library.get(b"Highs_getIntInfoValue\0")?,
            _library: library,
        })
    }
}

/// An instance of the solver, freed with this value.
struct Solver<'a> {
    functions: &'a Functions,
    handle: Handle,
}

impl Drop for Solver<'_> {
    fn drop(&mut self) {
        // SAFETY: the handle came from `create` and is freed once.
        unsafe { (self.functions.destroy)(self.handle) }
    }
}

fn text(text: &str) -> CString {
    CString::new(text).unwrap_or_default()
}

impl Solver<'_> {
    fn options(&self, budget: &Budget, effort: f64) {
        let nodes = c_int::try_from(budget.nodes).unwrap_or(c_int::MAX);
        // SAFETY: the handle is live and the names end in 0; an option that a version lacks gives an error value only.
        unsafe {
            let f = self.functions;
            (f.set_bool)(self.handle, text("output_flag").as_ptr(), 0);
            (f.set_text)(self.handle, text("parallel").as_ptr(), text("off").as_ptr());
            (f.set_int)(self.handle, text("threads").as_ptr(), 1);
            (f.set_int)(self.handle, text("random_seed").as_ptr(), 0);
            (f.set_int)(self.handle, text("mip_max_nodes").as_ptr(), nodes);
            // HiGHS's own primal heuristics would waste time where a planner has a good point to start from.
            (f.set_double)(self.handle, text("mip_heuristic_effort").as_ptr(), effort);
            (f.set_double)(self.handle, text("mip_rel_gap").as_ptr(), budget.gap / 4.0);
            (f.set_double)(self.handle, text("time_limit").as_ptr(), budget.time.as_secs_f64());
        }
    }

    fn double(&self, name: &str) -> f64 {
        let mut value = f64::NAN;
        // SAFETY: the handle is live, the name ends in 0 and the value is written in place.
        unsafe { (self.functions.get_double)(self.handle, text(name).as_ptr(), &mut value) };
        value
    }
}

impl Milp for Highs {
    fn name(&self) -> &str {
        &self.name
    }

    fn solve(&self, model: &Model, start: &[(usize, f64)], budget: &Budget) -> Result<Answer, EngineError> {
        let failed = |message: &str| EngineError::Failed { engine: self.name.clone(), message: message.into() };
        let count = |n: usize| c_int::try_from(n).map_err(|_| failed("the program is too large"));
        let f = &self.functions;
        // SAFETY: no arguments.
        let handle = unsafe { (f.create)() };
        if handle.is_null() {
            return Err(failed("it gave no instance"));
        }
        let solver = Solver { functions: f, handle };
        solver.options(budget, if start.is_empty() { 0.05 } else { 0.0 });
        let costs: Vec<f64> = model.columns.iter().map(|column| column.cost).collect();
        let lows: Vec<f64> = model.columns.iter().map(|column| column.low).collect();
        let highs: Vec<f64> = model.columns.iter().map(|column| column.high).collect();
        let whole: Vec<c_int> = model.columns.iter().map(|column| c_int::from(column.integer)).collect();
        let row_lows: Vec<f64> = model.rows.iter().map(|row| row.low).collect();
        let row_highs: Vec<f64> = model.rows.iter().map(|row| row.high).collect();
        let (mut starts, mut indices, mut values) = (Vec::new(), Vec::new(), Vec::new());
        for row in &model.rows {
            starts.push(count(indices.len())?);
            for (column, coefficient) in &row.terms {
                indices.push(count(*column)?);
                values.push(*coefficient);
            }
        }
        let (columns, rows, entries) = (count(costs.len())?, count(row_lows.len())?, count(indices.len())?);
        // SAFETY: the handle is live and each array has the length that the counts say; the library copies them.
        let passed = unsafe {
            (f.pass)(
                handle,
                columns,
                rows,
                entries,
                ROW_WISE,
                MINIMISE,
                model.offset,
                costs.as_ptr(),
                lows.as_ptr(),
                highs.as_ptr(),
                row_lows.as_ptr(),
                row_highs.as_ptr(),
                starts.as_ptr(),
                indices.as_ptr(),
                values.as_ptr(),
                whole.as_ptr(),
            )
        };
        if passed == STATUS_ERROR {
            return Err(failed("it refused the program"));
        }
        if !start.is_empty() {
            let columns: Result<Vec<c_int>, _> = start.iter().map(|(column, _)| count(*column)).collect();
            let columns = columns?;
            let values: Vec<f64> = start.iter().map(|(_, value)| *value).collect();
            // SAFETY: both arrays have the length given, and the indices are columns of the program passed above.
            unsafe { (f.set_sparse)(handle, count(columns.len())?, columns.as_ptr(), values.as_ptr()) };
        }
        // SAFETY: the handle is live and holds a program.
        let (ran, status) = unsafe { ((f.run)(handle), (f.model_status)(handle)) };
        let stopped = match status {
            MODEL_OPTIMAL => None,
            MODEL_TIME_LIMIT => Some(Limit::Time),
            MODEL_SOLUTION_LIMIT => Some(Limit::Work),
            MODEL_INFEASIBLE | MODEL_UNBOUNDED_OR_INFEASIBLE => {
                return Err(EngineError::Infeasible { engine: self.name.clone() });
            }
            _ => return Err(failed(&format!("status {ran}, model status {status}"))),
        };
        let mut point = vec![0.0; model.columns.len()];
        let mut duals = vec![0.0; model.columns.len()];
        let mut rows = vec![0.0; model.rows.len()];
        let mut row_duals = vec![0.0; model.rows.len()];
        let (mut feasible, mut nodes) = (0, 0);
        // SAFETY: the handle is live and the arrays have the lengths of the program's columns and rows.
        unsafe {
            let (x, dx) = (point.as_mut_ptr(), duals.as_mut_ptr());
            (f.get_solution)(handle, x, dx, rows.as_mut_ptr(), row_duals.as_mut_ptr());
            (f.get_int)(handle, text("primal_solution_status").as_ptr(), &mut feasible);
            (f.get_long)(handle, text("mip_node_count").as_ptr(), &mut nodes);
        }
        let integer = model.columns.iter().any(|column| column.integer);
        let bound = solver.double(if integer { "mip_dual_bound" } else { "objective_function_value" });
        let bound = if bound.is_nan() { f64::NEG_INFINITY } else { bound };
        let values = (feasible == PRIMAL_FEASIBLE).then_some(point);
        Ok(Answer { values, bound, stopped, nodes: u64::try_from(nodes).unwrap_or(0) })
    }
}
