//! The library of MuJoCo: found at run time and called by its C interface.
//!
//! Search order: the file or folder in the environment variable `HIERARQ_MUJOCO`, the usual library folders, and the package
//! `mujoco` of `python3`, which contains the library. Functions are used, and one global variable, but no field of a
//! structure, so that one build works with many versions: the state is read and written by `mj_getState` and `mj_setState`,
//! and its layout is asked for.
//!
//! This is the only file of the crate with `unsafe`: calls of C functions.
#![expect(unsafe_code, reason = "the library is C; each call says why it is sound")]

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;

use libloading::Library;

/// Command that installs the library.
pub const INSTALL: &str = "python3 -m pip install mujoco";

/// Oldest version that is used, 3.3.0.
const OLDEST: c_int = 330;

/// Components of the state, from `mjtState`: their bits are the same in all versions.
const TIME: c_int = 1 << 0;
const QPOS: c_int = 1 << 1;
const QVEL: c_int = 1 << 2;

/// A model with components of different sizes, which shows their bits in this version: one joint, five actuators and one
/// mocap body.
const PROBE: &str = r#"<mujoco><worldbody>
<body mocap="true"><geom size="1" contype="0" conaffinity="0"/></body>
<body><joint name="j"/><geom size="1"/></body></worldbody>
<actuator><motor joint="j"/><motor joint="j"/><motor joint="j"/><motor joint="j"/><motor joint="j"/></actuator></mujoco>"#;

/// Reason why MuJoCo cannot be used.
#[derive(Clone, Debug, thiserror::Error, PartialEq, Eq)]
pub enum LibraryError {
    /// It was not found.
    #[error("MuJoCo is not installed: looked for in {searched}; `{INSTALL}` installs it")]
    Missing {
        /// Places that were searched.
        searched: String,
    },
    /// It cannot be used.
    #[error("the MuJoCo at {path} cannot be used: {why}")]
    Unusable {
        /// The file.
        path: String,
        /// The reason.
        why: String,
    },
    /// It refuses a model.
    #[error("MuJoCo refuses the model of the robot: {0}")]
    Refused(String),
}

type ParseText = unsafe extern "C" fn(*const c_char, *const c_void, *mut c_char, c_int) -> *mut c_void;
type Compile = unsafe extern "C" fn(*mut c_void, *const c_void) -> *mut c_void;
type GetError = unsafe extern "C" fn(*mut c_void) -> *const c_char;
type Act = unsafe extern "C" fn(*mut c_void);
type Make = unsafe extern "C" fn(*const c_void) -> *mut c_void;
type Advance = unsafe extern "C" fn(*const c_void, *mut c_void);
type StateSize = unsafe extern "C" fn(*const c_void, c_int) -> c_int;
type GetState = unsafe extern "C" fn(*const c_void, *const c_void, *mut f64, c_int);
type SetState = unsafe extern "C" fn(*const c_void, *mut c_void, *const f64, c_int);

/// A loaded MuJoCo.
pub struct MuJoCo {
    parse: ParseText,
    compile: Compile,
    error: GetError,
    delete_spec: Act,
    delete_model: Act,
    delete_data: Act,
    make_data: Make,
    step: Advance,
    forward: Advance,
    state_size: StateSize,
    get_state: GetState,
    set_state: SetState,
    version: String,
    controls: c_int,
    mocap_positions: c_int,
    mocap_rotations: c_int,
    /// Keeps the functions loaded; dropped last.
    _library: Library,
}

impl MuJoCo {
    /// Finds and loads the library.
    ///
    /// # Errors
    /// There is none, or the one that the environment names cannot be used.
    pub fn find() -> Result<Arc<MuJoCo>, LibraryError> {
        if let Some(named) = std::env::var_os("HIERARQ_MUJOCO").map(PathBuf::from) {
            let Some(path) = candidates(&named).into_iter().next() else {
                let searched = format!("HIERARQ_MUJOCO={}, where there is none", named.display());
                return Err(LibraryError::Missing { searched });
            };
            return MuJoCo::load(&path);
        }
        let folders = ["/usr/local/lib", "/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/lib64"];
        let usual = folders.into_iter().chain(["/usr/lib", "/opt/homebrew/lib"]).map(PathBuf::from);
        let mut last = None;
        for folder in usual.chain(packages()) {
            for path in candidates(&folder) {
                match MuJoCo::load(&path) {
                    Ok(found) => return Ok(found),
                    Err(e) => last = Some(e),
                }
            }
        }
        let searched = "HIERARQ_MUJOCO, the usual folders of libraries, the package mujoco of python3".to_string();
        Err(last.unwrap_or(LibraryError::Missing { searched }))
    }

    /// Loads the library of this file.
    ///
    /// # Errors
    /// It is not MuJoCo, or too old.
    pub fn load(path: &Path) -> Result<Arc<MuJoCo>, LibraryError> {
        let unusable = |why: String| LibraryError::Unusable { path: path.display().to_string(), why };
        // SAFETY: loading a file runs its initialisers; the file is named `libmujoco` or was chosen by the user. The
        // initialisers of MuJoCo only set up static data.
        let library = unsafe { Library::new(path) }.map_err(|e| unusable(e.to_string()))?;
        let mut loaded = functions(library).map_err(|e| unusable(e.to_string()))?;
        // SAFETY: the functions of these names take nothing, and return a number and a static text that ends in 0.
        let (number, text) = unsafe {
            let number = loaded._library.get::<unsafe extern "C" fn() -> c_int>(b"mj_version\0").map(|f| f());
            let text = loaded._library.get::<unsafe extern "C" fn() -> *const c_char>(b"mj_versionString\0");
            (number, text.map(|f| CStr::from_ptr(f()).to_string_lossy().into_owned()))
        };
        let number = number.map_err(|e| unusable(e.to_string()))?;
        loaded.version = text.map_err(|e| unusable(e.to_string()))?;
        be_quiet(&loaded._library);
        if number < OLDEST {
            return Err(unusable(format!(
                "version {} is older than 3.3.0; `{INSTALL}` brings a newer one",
                loaded.version
            )));
        }
        let loaded = Arc::new(loaded);
        let bits = {
            let probe = Scene::new(&loaded, PROBE)?;
            let bit = |size: usize| (3..31).map(|k| 1 << k).find(|bit| probe.size(*bit) == size);
            (bit(5), bit(3), bit(4))
        };
        let (Some(controls), Some(mocap_positions), Some(mocap_rotations)) = bits else {
            return Err(unusable(format!("the state of version {} is laid out in an unknown way", loaded.version)));
        };
        // The probe is gone, so that there is no other owner.
        let mut loaded = Arc::into_inner(loaded).ok_or_else(|| unusable("it is in use".to_string()))?;
        (loaded.controls, loaded.mocap_positions, loaded.mocap_rotations) =
            (controls, mocap_positions, mocap_rotations);
        Ok(Arc::new(loaded))
    }

    /// Its version, `3.3.2`.
    pub fn version(&self) -> &str {
        &self.version
    }
}

/// Library files in a folder, sorted by name; or the file itself.
fn candidates(path: &Path) -> Vec<PathBuf> {
    if path.is_file() {
        return vec![path.to_owned()];
    }
    let Ok(entries) = std::fs::read_dir(path) else { return Vec::new() };
    let library = |path: &PathBuf| {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let dynamic = name.contains(".so") || name.ends_with(".dylib") || name.ends_with(".dll");
        dynamic && (name.starts_with("libmujoco.") || name.starts_with("mujoco."))
    };
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(library).collect();
    files.sort();
    files
}

/// Folders of the package `mujoco` that `python3` would import, except for the working folder. Runs no code of the package.
fn packages() -> Vec<PathBuf> {
    let ask = "import site; print(*site.getsitepackages(), site.getusersitepackages(), sep='\\n')";
    let output = Command::new("python3").args(["-I", "-c", ask]).stdin(Stdio::null()).stderr(Stdio::null()).output();
    let text = output.ok().and_then(|output| String::from_utf8(output.stdout).ok()).unwrap_or_default();
    text.lines().map(|folder| Path::new(folder).join("mujoco")).filter(|path| path.is_dir()).collect()
}

/// Resolves the functions by name.
fn functions(library: Library) -> Result<MuJoCo, libloading::Error> {
    // SAFETY: each type is the one that `mujoco.h` declares for the name since version 3.3; the library is kept beside the
    // pointers, so that they stay valid.
    unsafe {
        Ok(MuJoCo {
            parse: *library.get(b"mj_parseXMLString\0")?,
            compile: *library.get(b"mj_compile\0")?,
            error: *library.get(b"mjs_getError\0")?,
            delete_spec: *library.get(b"mj_deleteSpec\0")?,
            delete_model: *library.get(b"mj_deleteModel\0")?,
            delete_data: *library.get(b"mj_deleteData\0")?,
            make_data: *library.get(b"mj_makeData\0")?,
            step: *library.get(b"mj_step\0")?,
            forward: *library.get(b"mj_forward\0")?,
            state_size: *library.get(b"mj_stateSize\0")?,
            get_state: *library.get(b"mj_getState\0")?,
            set_state: *library.get(b"mj_setState\0")?,
            version: String::new(),
            controls: 0,
            mocap_positions: 0,
            mocap_rotations: 0,
            _library: library,
        })
    }
}

/// Takes no notice of a warning: a simulation that diverges is told by whoever runs it.
extern "C" fn ignore(_: *const c_char) {}

/// Keeps MuJoCo from printing its warnings, and from writing them to a file in the working folder.
fn be_quiet(library: &Library) {
    type Handler = Option<extern "C" fn(*const c_char)>;
    // SAFETY: `mujoco.h` declares this global variable with this type. It is written before any simulation is made; two
    // threads can only write the same value.
    unsafe {
        if let Ok(handler) = library.get::<*mut Handler>(b"mju_user_warning\0") {
            **handler = Some(ignore);
        }
    }
}

/// A compiled model with its state.
pub struct Scene {
    of: Arc<MuJoCo>,
    model: *mut c_void,
    data: *mut c_void,
}

// SAFETY: a model and its data are memory of their own, which no thread of MuJoCo touches outside of a call.
unsafe impl Send for Scene {}

impl Drop for Scene {
    fn drop(&mut self) {
        // SAFETY: both were made by this library, are not null, and are used nowhere else.
        unsafe {
            (self.of.delete_data)(self.data);
            (self.of.delete_model)(self.model);
        }
    }
}

impl Scene {
    /// Compiles a model in MuJoCo's XML.
    ///
    /// # Errors
    /// MuJoCo refuses it.
    pub fn new(of: &Arc<MuJoCo>, xml: &str) -> Result<Scene, LibraryError> {
        let refused = |why: &str| LibraryError::Refused(why.trim().replace('\n', " "));
        let text = CString::new(xml).map_err(|_| refused("a name has a zero byte"))?;
        let mut said = [0_u8; 1024];
        // SAFETY: the text ends in 0, there are no other files, and the buffer has the length that is passed. The spec is
        // deleted once, after the message that it owns was copied.
        let model = unsafe {
            let spec = (of.parse)(text.as_ptr(), std::ptr::null(), said.as_mut_ptr().cast(), said.len() as c_int);
            if spec.is_null() {
                let end = said.iter().position(|b| *b == 0).unwrap_or(said.len());
                return Err(refused(&String::from_utf8_lossy(&said[..end])));
            }
            let model = (of.compile)(spec, std::ptr::null());
            let why = (of.error)(spec);
            let why = if why.is_null() { String::new() } else { CStr::from_ptr(why).to_string_lossy().into_owned() };
            (of.delete_spec)(spec);
            if model.is_null() {
                return Err(refused(&why));
            }
            model
        };
        // SAFETY: the model is valid; its data is checked before it is used.
        let data = unsafe { (of.make_data)(model) };
        if data.is_null() {
            // SAFETY: the model was made by this library and is used nowhere else.
            unsafe { (of.delete_model)(model) };
            return Err(refused("there is not enough memory"));
        }
        Ok(Scene { of: Arc::clone(of), model, data })
    }

    /// Numbers of a component of the state.
    fn size(&self, component: c_int) -> usize {
        // SAFETY: the model is valid.
        usize::try_from(unsafe { (self.of.state_size)(self.model, component) }).unwrap_or(0)
    }

    fn get(&self, component: c_int, numbers: &mut [f64]) {
        assert_eq!(numbers.len(), self.size(component), "the size of the component");
        // SAFETY: model and data are valid and belong together, and the buffer has the size of the component.
        unsafe { (self.of.get_state)(self.model, self.data, numbers.as_mut_ptr(), component) };
    }

    fn set(&mut self, component: c_int, numbers: &[f64]) {
        assert_eq!(numbers.len(), self.size(component), "the size of the component");
        // SAFETY: as for reading.
        unsafe { (self.of.set_state)(self.model, self.data, numbers.as_ptr(), component) };
    }

    /// Number of joint positions.
    pub fn joints(&self) -> usize {
        self.size(QPOS)
    }

    /// Number of actuators.
    pub fn actuators(&self) -> usize {
        self.size(self.of.controls)
    }

    /// Time of the simulation (s). MuJoCo sets it back to zero when it has diverged.
    pub fn time(&self) -> f64 {
        let mut time = [0.0];
        self.get(TIME, &mut time);
        time[0]
    }

    /// Reads the positions of the joints, in the order of the model.
    pub fn positions(&self, into: &mut [f64]) {
        self.get(QPOS, into);
    }

    /// Sets the positions of the joints.
    pub fn set_positions(&mut self, positions: &[f64]) {
        self.set(QPOS, positions);
    }

    /// Reads the velocities of the joints.
    pub fn velocities(&self, into: &mut [f64]) {
        self.get(QVEL, into);
    }

    /// Sets what the actuators are asked for.
    pub fn set_controls(&mut self, controls: &[f64]) {
        self.set(self.of.controls, controls);
    }

    /// Number of mocap bodies: those that are placed from outside.
    pub fn placed(&self) -> usize {
        self.size(self.of.mocap_positions) / 3
    }

    /// Places all mocap bodies, in the order of the model: three numbers for each position (m), and four for each orientation,
    /// a unit quaternion `w x y z`.
    pub fn place(&mut self, positions: &[f64], orientations: &[f64]) {
        self.set(self.of.mocap_positions, positions);
        self.set(self.of.mocap_rotations, orientations);
    }

    /// Computes what follows from the state, without a step.
    pub fn forward(&mut self) {
        // SAFETY: model and data are valid and belong together.
        unsafe { (self.of.forward)(self.model, self.data) };
    }

    /// Advances by the time step of the model.
    pub fn step(&mut self) {
        // SAFETY: as above.
        unsafe { (self.of.step)(self.model, self.data) };
    }
}
