//! MuJoCo's library, loaded at run time: the only module here with `unsafe`.
//!
//! Everything else builds and runs without it. What the library computes is reached through functions only, never through the
//! layout of a struct: models are given as MJCF (MuJoCo's XML), and states go in and out with `mj_setState` and `mj_getState`.
//! A library of a version that was not checked is refused, and so is one whose state is not what is expected.
//!
//! Two facts justify the calls, and each `SAFETY` comment names what else is needed:
//! - **Signatures.** Those here are those of `mujoco.h` in [`VERSIONS`], which `Api::load` checks first.
//! - **Whose memory.** A [`Simulation`] owns its model and its data, and is neither `Send` nor `Sync`.
#![expect(unsafe_code, reason = "MuJoCo is C; every call is one documented unsafe block")]

use std::env;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::fmt;
use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::ptr;
use std::rc::Rc;
use std::sync::OnceLock;

use libloading::Library;

/// The versions that were checked, as `mj_version` gives them, and their names.
pub const VERSIONS: [(i32, &str); 2] = [(3_017_000, "3.17.0"), (4_000_000, "4.0.0")];

/// The environment variable that names the folder of the library.
pub const VARIABLE: &str = "MUJOCO_LIB_DIR";

/// Parts of a state, bits of `mjtState` in all of [`VERSIONS`].
const POSITION: c_int = 1 << 1;
const VELOCITY: c_int = 1 << 2;
const WARM_START: c_int = 1 << 5;
const CONTROL: c_int = 1 << 6;

/// What makes the next step the same: the solver's result is where it starts in the next step.
const STATE: c_int = POSITION | VELOCITY | WARM_START;

/// Bytes of a message.
const MESSAGE: usize = 1000;

/// Why MuJoCo cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MujocoError {
    /// There is no library where it is looked for.
    #[error(
        "MuJoCo is missing, which half-cheetah and swimmer need: {0}; run `scripts/setup.sh mujoco`, or `pip install \
         mujoco=={latest}` in the environment whose `python3` comes first in PATH, or set {VARIABLE} to the folder of \
         libmujoco", latest = VERSIONS[VERSIONS.len() - 1].1
    )]
    Missing(String),
    /// A library of another version.
    #[error(
        "{}: MuJoCo {found} is not one of the versions that are known to work ({}); install one of them, for example \
         `pip install mujoco=={}`", path.display(), VERSIONS.map(|v| v.1).join(", "), VERSIONS[VERSIONS.len() - 1].1
    )]
    Version {
        /// The library.
        path: PathBuf,
        /// What it says of itself.
        found: String,
    },
    /// The library has not what its version should have.
    #[error("{}: {reason}; install MuJoCo again", path.display())]
    Damaged {
        /// The library.
        path: PathBuf,
        /// What it lacks.
        reason: String,
    },
    /// A model that MuJoCo refuses.
    #[error("MuJoCo refuses the model: {0}")]
    Model(String),
}

/// Structs of MuJoCo, which stay behind pointers.
#[repr(C)]
struct RawSpec([u8; 0]);
#[repr(C)]
struct RawModel([u8; 0]);
#[repr(C)]
struct RawData([u8; 0]);

/// Functions of the library.
struct Api {
    path: PathBuf,
    version: &'static str,
    parse: unsafe extern "C" fn(*const c_char, *const c_void, *mut c_char, c_int) -> *mut RawSpec,
    compile: unsafe extern "C" fn(*mut RawSpec, *const c_void) -> *mut RawModel,
    spec_error: unsafe extern "C" fn(*mut RawSpec) -> *const c_char,
    delete_spec: unsafe extern "C" fn(*mut RawSpec),
    delete_model: unsafe extern "C" fn(*mut RawModel),
    set_total_mass: unsafe extern "C" fn(*mut RawModel, f64),
    set_const: unsafe extern "C" fn(*mut RawModel, *mut RawData),
    make_data: unsafe extern "C" fn(*const RawModel) -> *mut RawData,
    delete_data: unsafe extern "C" fn(*mut RawData),
    reset: unsafe extern "C" fn(*const RawModel, *mut RawData),
    forward: unsafe extern "C" fn(*const RawModel, *mut RawData),
    step: unsafe extern "C" fn(*const RawModel, *mut RawData),
    state_size: unsafe extern "C" fn(*const RawModel, c_int) -> c_int,
    get_state: unsafe extern "C" fn(*const RawModel, *const RawData, *mut f64, c_int),
    set_state: unsafe extern "C" fn(*const RawModel, *mut RawData, *const f64, c_int),
}

/// The loaded library, for the rest of the process.
static LOADED: OnceLock<Result<Api, MujocoError>> = OnceLock::new();

/// Returns the version of the library, which this loads, and its path.
///
/// # Errors
///
/// [`MujocoError`] when there is none that can be used, with the way out.
pub fn version() -> Result<(&'static str, &'static Path), MujocoError> {
    let api = api()?;
    Ok((api.version, &api.path))
}

fn api() -> Result<&'static Api, MujocoError> {
    LOADED
        .get_or_init(|| Api::load(&library(env::var_os(VARIABLE).map(PathBuf::from))?))
        .as_ref()
        .map_err(MujocoError::clone)
}

/// Returns the library: in the given folder, else in that of Python's package `mujoco`.
fn library(folder: Option<PathBuf>) -> Result<PathBuf, MujocoError> {
    let named = folder.is_some();
    let folder = folder.map_or_else(package, Ok).map_err(MujocoError::Missing)?;
    let files = fs::read_dir(&folder).into_iter().flatten().flatten();
    let is_library = |name: &str| {
        name.starts_with("libmujoco.") && (name.contains(".so") || name.ends_with(".dylib"))
    };
    let mut found: Vec<PathBuf> = files
        .filter(|file| file.file_name().to_str().is_some_and(is_library))
        .map(|file| file.path())
        .collect();
    found.sort();
    found.pop().ok_or_else(|| {
        let whose = if named { format!(", which {VARIABLE} names,") } else { String::new() };
        MujocoError::Missing(format!("{}{whose} has no libmujoco", folder.display()))
    })
}

/// Returns the folder of Python's package, asked of the `python3` that comes first.
fn package() -> Result<PathBuf, String> {
    // Only where it is: importing it would take a second.
    let script = "import importlib.util as u; s = u.find_spec('mujoco'); print(s.submodule_search_locations[0] if s else '')";
    let output = Command::new("python3").args(["-c", script]).output();
    let output = output.map_err(|e| format!("{VARIABLE} is not set, and python3: {e}"))?;
    let folder = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    match folder.is_empty() {
        true => Err(format!("{VARIABLE} is not set, and python3 has no package mujoco")),
        false => Ok(folder.into()),
    }
}

impl Api {
    fn load(path: &Path) -> Result<Self, MujocoError> {
        let damaged = |reason: String| MujocoError::Damaged { path: path.to_owned(), reason };
        // SAFETY: MuJoCo's initialisers need nothing, and it is never unloaded, as it is leaked here.
        let library = unsafe { Library::new(path) }.map_err(|e| damaged(e.to_string()))?;
        let library: &'static Library = Box::leak(Box::new(library));
        macro_rules! function {
            ($name:literal) => {
                // SAFETY: the signature is that of mujoco.h, of a version that has been checked where it differs.
                *unsafe { library.get(concat!($name, "\0").as_bytes()) }
                    .map_err(|e| damaged(e.to_string()))?
            };
        }
        let number: unsafe extern "C" fn() -> c_int = function!("mj_version");
        // SAFETY: takes nothing.
        let number = unsafe { number() };
        let Some((_, version)) = VERSIONS.into_iter().find(|(known, _)| *known == number) else {
            return Err(MujocoError::Version { path: path.to_owned(), found: name(number) });
        };
        let warning: *mut Option<unsafe extern "C" fn(*const c_char)> =
            function!("mju_user_warning");
        // SAFETY: the symbol is a variable that holds a function or null, and nothing runs yet that reads it.
        unsafe { *warning = Some(warn) };
        Ok(Self {
            path: path.to_owned(),
            version,
            parse: function!("mj_parseXMLString"),
            compile: function!("mj_compile"),
            spec_error: function!("mjs_getError"),
            delete_spec: function!("mj_deleteSpec"),
            delete_model: function!("mj_deleteModel"),
            set_total_mass: function!("mj_setTotalmass"),
            set_const: function!("mj_setConst"),
            make_data: function!("mj_makeData"),
            delete_data: function!("mj_deleteData"),
            reset: function!("mj_resetData"),
            forward: function!("mj_forward"),
            step: function!("mj_step"),
            state_size: function!("mj_stateSize"),
            get_state: function!("mj_getState"),
            set_state: function!("mj_setState"),
        })
    }
}

/// Returns the name of a version: from 3.10 on a number has three digits for each part after the first, before one.
fn name(number: c_int) -> String {
    let base = if number >= 1_000_000 { 1000 } else { 10 };
    format!("{}.{}.{}", number / (base * base), number / base % base, number % base)
}

/// Writes a warning to standard error. MuJoCo's own handler writes a file into the working folder.
unsafe extern "C" fn warn(message: *const c_char) {
    // SAFETY: MuJoCo gives a text that ends with a null byte.
    let message = unsafe { CStr::from_ptr(message) };
    // What cannot be written is lost: there is nowhere else to say it.
    let _ = writeln!(io::stderr(), "MuJoCo: {}", message.to_string_lossy());
}

/// A compiled model.
struct Model {
    api: &'static Api,
    pointer: *mut RawModel,
}

impl Drop for Model {
    fn drop(&mut self) {
        // SAFETY: it was compiled, and nobody else has it any more.
        unsafe { (self.api.delete_model)(self.pointer) }
    }
}

/// A model and its data. A state is its positions, velocities and where the solver starts, side by side; `N` numbers in all.
pub struct Simulation<const N: usize> {
    model: Rc<Model>,
    data: *mut RawData,
}

impl<const N: usize> Drop for Simulation<N> {
    fn drop(&mut self) {
        // SAFETY: it was made, and nobody else has it any more.
        unsafe { (self.model.api.delete_data)(self.data) }
    }
}

impl<const N: usize> fmt::Debug for Simulation<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Simulation")
    }
}

impl<const N: usize> Clone for Simulation<N> {
    fn clone(&self) -> Self {
        Self::of(Rc::clone(&self.model))
    }
}

impl<const N: usize> Simulation<N> {
    /// Compiles a model.
    ///
    /// # Arguments
    ///
    /// * `mjcf` — the model.
    /// * `controls` — how many numbers an action has.
    /// * `mass` — to which the masses and inertias of all bodies are scaled, in kg.
    ///
    /// # Errors
    ///
    /// [`MujocoError`] when the library is missing, or refuses the model, or the state is not of `N` numbers.
    pub fn new(mjcf: &str, controls: usize, mass: Option<f64>) -> Result<Self, MujocoError> {
        let api = api()?;
        let text = CString::new(mjcf).map_err(|e| MujocoError::Model(e.to_string()))?;
        let mut message: [c_char; MESSAGE] = [0; MESSAGE];
        // SAFETY: the text ends with a null byte, there is no file system, and the message has the size that is given.
        let spec = unsafe {
            (api.parse)(text.as_ptr(), ptr::null(), message.as_mut_ptr(), MESSAGE as c_int)
        };
        if spec.is_null() {
            // SAFETY: MuJoCo ends what it writes with a null byte, and there was one before.
            let message = unsafe { CStr::from_ptr(message.as_ptr()) };
            return Err(MujocoError::Model(message.to_string_lossy().into_owned()));
        }
        // SAFETY: it was parsed above.
        let pointer = unsafe { (api.compile)(spec, ptr::null()) };
        let refused = pointer.is_null().then(|| {
            // SAFETY: it was parsed above.
            let message = unsafe { (api.spec_error)(spec) };
            // SAFETY: a text of the spec, which still exists.
            unsafe { CStr::from_ptr(message) }.to_string_lossy().into_owned()
        });
        // SAFETY: it was parsed above, and a model does not need it.
        unsafe { (api.delete_spec)(spec) };
        if let Some(message) = refused {
            return Err(MujocoError::Model(message));
        }
        let simulation = Self::of(Rc::new(Model { api, pointer }));
        if let Some(mass) = mass {
            // SAFETY: nobody else has the model yet.
            unsafe { (api.set_total_mass)(pointer, mass) };
            // SAFETY: as above, and the data are those of the model.
            unsafe { (api.set_const)(pointer, simulation.data) };
        }
        simulation.check(controls)?;
        Ok(simulation)
    }

    fn of(model: Rc<Model>) -> Self {
        // SAFETY: the model was compiled.
        let data = unsafe { (model.api.make_data)(model.pointer) };
        assert!(!data.is_null(), "no memory for MuJoCo's data");
        Self { model, data }
    }

    /// Checks that the state has the parts and numbers that are expected, and comes out as it went in.
    fn check(&self, controls: usize) -> Result<(), MujocoError> {
        let api = self.model.api;
        // SAFETY: the model was compiled.
        let size = |part| unsafe { (api.state_size)(self.model.pointer, part) };
        let sizes = [POSITION, VELOCITY, WARM_START, CONTROL].map(size);
        let third = (N / 3) as c_int;
        let mut fits =
            sizes == [third, third, third, controls as c_int] && size(STATE) == N as c_int;
        if fits {
            let before: [f64; N] = std::array::from_fn(|i| 1.0 / (i + 3) as f64);
            let mut after = [f64::NAN; N];
            self.set(&before);
            self.get(&mut after);
            fits = before == after;
        }
        match fits {
            true => Ok(()),
            false => Err(MujocoError::Damaged {
                path: api.path.clone(),
                reason: format!("a state has other parts than expected: {sizes:?} numbers"),
            }),
        }
    }

    fn set(&self, state: &[f64; N]) {
        // SAFETY: the state has as many numbers as the model's, which `check` compares.
        unsafe {
            (self.model.api.set_state)(self.model.pointer, self.data, state.as_ptr(), STATE);
        }
    }

    fn get(&self, state: &mut [f64; N]) {
        // SAFETY: as in `set`.
        unsafe {
            (self.model.api.get_state)(self.model.pointer, self.data, state.as_mut_ptr(), STATE);
        }
    }

    /// Returns the state that begins with these positions and velocities, which the third part of the given state follows.
    pub fn begin(&self, mut state: [f64; N]) -> [f64; N] {
        state[N / 3 * 2..].fill(0.0);
        let Model { api, pointer } = &*self.model;
        // SAFETY: the data are those of the model.
        unsafe { (api.reset)(*pointer, self.data) };
        self.set(&state);
        // SAFETY: as above.
        unsafe { (api.forward)(*pointer, self.data) };
        self.get(&mut state);
        state
    }

    /// Goes on from a state by so many steps of the model, with one control for all of them.
    ///
    /// # Panics
    ///
    /// When there are not as many controls as actuators.
    pub fn step(&self, state: &mut [f64; N], control: &[f64], count: u32) {
        let Model { api, pointer } = &*self.model;
        self.set(state);
        // SAFETY: the model was compiled.
        let controls = unsafe { (api.state_size)(*pointer, CONTROL) };
        assert_eq!(controls as usize, control.len(), "one control per actuator");
        // SAFETY: there are as many controls as the model has.
        unsafe { (api.set_state)(*pointer, self.data, control.as_ptr(), CONTROL) };
        for _ in 0..count {
            // SAFETY: the data are those of the model.
            unsafe { (api.step)(*pointer, self.data) };
        }
        self.get(state);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_have_names() {
        assert_eq!([337, 3_017_000, 4_000_000].map(name), ["3.3.7", "3.17.0", "4.0.0"]);
    }

    #[test]
    fn a_folder_without_the_library_is_named_with_the_way_out() {
        let dir = tempfile::tempdir().unwrap();
        let folder = dir.path().display().to_string();
        let e =
            library(Some(dir.path().to_owned())).unwrap_err().to_string().replace(&folder, "DIR");
        insta::assert_snapshot!(e, @"MuJoCo is missing, which half-cheetah and swimmer need: DIR, which MUJOCO_LIB_DIR names, has no libmujoco; run `scripts/setup.sh mujoco`, or `pip install mujoco==4.0.0` in the environment whose `python3` comes first in PATH, or set MUJOCO_LIB_DIR to the folder of libmujoco");
        fs::write(dir.path().join("libmujoco.so.4.0.0"), "nothing").unwrap();
        let path = library(Some(dir.path().to_owned())).unwrap();
        let e = Api::load(&path).err().unwrap();
        assert!(matches!(&e, MujocoError::Damaged { .. }), "{e}");
        assert!(e.to_string().ends_with("; install MuJoCo again"), "{e}");
    }

    #[test]
    fn another_version_is_refused_with_those_that_work() {
        let e = MujocoError::Version { path: "libmujoco.so.3.3.7".into(), found: name(337) };
        insta::assert_snapshot!(e, @"libmujoco.so.3.3.7: MuJoCo 3.3.7 is not one of the versions that are known to work (3.17.0, 4.0.0); install one of them, for example `pip install mujoco==4.0.0`");
    }

    #[test]
    fn a_model_that_is_none_is_refused_in_mujoco_s_words() {
        if let Err(e) = version() {
            eprintln!("skipped: {e}");
            return;
        }
        let refused = |mjcf: &str| Simulation::<3>::new(mjcf, 0, None).unwrap_err().to_string();
        let e = refused("<mujoco><moon/></mujoco>");
        assert!(e.starts_with("MuJoCo refuses the model: ") && e.contains("moon"), "{e}");
        let e = refused("<mujoco><actuator><motor joint='none'/></actuator></mujoco>");
        assert!(e.contains("'none'"), "{e}");
        let slide = "<mujoco><worldbody><body><joint type='slide'/><geom size='.1'/></body></worldbody></mujoco>";
        assert!(Simulation::<3>::new(slide, 0, None).is_ok());
        let e = Simulation::<6>::new(slide, 0, None).unwrap_err().to_string();
        assert!(e.contains("a state has other parts than expected: [1, 1, 1, 0] numbers"), "{e}");
    }
}
