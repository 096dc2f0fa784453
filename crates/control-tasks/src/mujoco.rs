//! MuJoCo's library, loaded at run time: the only module here with `unsafe`.
//!
//! Everything else builds and runs without it. What the library computes is reached through functions only, never through the
//! layout of a struct: models are given as MJCF (MuJoCo's XML), and states go in and out with `mj_setState` and `mj_getState`.
//! A library of a version that was not checked is refused, and so is one whose state is not what is expected.
//! Two facts justify the calls, and each `SAFETY` comment names what else is needed:
//! - **Signatures.** Those here are those of `mujoco.h` in [`VERSIONS`], which `Api::load` checks first.
//! - **Whose memory.** A [`Simulation`] owns its model and its data, and is neither `Send` nor `Sync`.
#![expect(unsafe_code, reason = "MuJoCo is C; every call is one documented unsafe block")]

use std::cell::OnceCell;
use std::env;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::fmt;
use std::fs;
use std::io::{self, Write as _};
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::ptr;
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
    /// The library or a model is not what is expected.
    #[error("{0}")]
    Unfit(String),
}

#[repr(C)]
struct Raw<const KIND: u8>([u8; 0]);
type RawSpec = Raw<0>;
type RawModel = Raw<1>;
type RawData = Raw<2>;

/// Makes the table of the library's functions, with what loads it.
macro_rules! functions {
    ($($field:ident = $name:literal: fn($($argument:ty),*) $(-> $result:ty)?;)*) => {
        struct Api {
            path: PathBuf,
            version: &'static str,
            $($field: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
        }

        impl Api {
            fn of(library: &'static Library, path: &Path, version: &'static str) -> Result<Self, libloading::Error> {
                Ok(Self {
                    path: path.to_owned(),
                    version,
                    // SAFETY: the signatures are those of mujoco.h.
                    $($field: *unsafe { library.get(concat!($name, "\0").as_bytes()) }?,)*
                })
            }
        }
    };
}

functions! {
    parse = "mj_parseXMLString": fn(*const c_char, *const c_void, *mut c_char, c_int) -> *mut RawSpec;
    compile = "mj_compile": fn(*mut RawSpec, *const c_void) -> *mut RawModel;
    spec_error = "mjs_getError": fn(*mut RawSpec) -> *const c_char;
    delete_spec = "mj_deleteSpec": fn(*mut RawSpec);
    delete_model = "mj_deleteModel": fn(*mut RawModel);
    set_total_mass = "mj_setTotalmass": fn(*mut RawModel, f64);
    set_const = "mj_setConst": fn(*mut RawModel, *mut RawData);
    make_data = "mj_makeData": fn(*const RawModel) -> *mut RawData;
    delete_data = "mj_deleteData": fn(*mut RawData);
    reset = "mj_resetData": fn(*const RawModel, *mut RawData);
    forward = "mj_forward": fn(*const RawModel, *mut RawData);
    step = "mj_step": fn(*const RawModel, *mut RawData);
    state_size = "mj_stateSize": fn(*const RawModel, c_int) -> c_int;
    get_state = "mj_getState": fn(*const RawModel, *const RawData, *mut f64, c_int);
    set_state = "mj_setState": fn(*const RawModel, *mut RawData, *const f64, c_int);
}

/// The loaded library, for the rest of the process.
static LOADED: OnceLock<Result<Api, MujocoError>> = OnceLock::new();

/// Returns the version of the library, which this loads, and its path.
/// Fails with [`MujocoError`] when there is none that can be used, with the way out.
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

fn library(folder: Option<PathBuf>) -> Result<PathBuf, MujocoError> {
    let folder = folder.map_or_else(package, Ok).map_err(MujocoError::Missing)?;
    let files = fs::read_dir(&folder).into_iter().flatten().flatten();
    let is_library = |name: &str| {
        name.starts_with("libmujoco.") && (name.contains(".so") || name.ends_with(".dylib"))
    };
    let found = files.filter(|file| file.file_name().to_str().is_some_and(is_library));
    let none = || MujocoError::Missing(format!("{} has no libmujoco", folder.display()));
    found.map(|file| file.path()).max().ok_or_else(none)
}

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
        let unfit = |e: libloading::Error| damaged(path, &e.to_string());
        // SAFETY: MuJoCo's initialisers need nothing, and it is never unloaded, as it is leaked here.
        let library = unsafe { Library::new(path) }.map_err(unfit)?;
        let library: &'static Library = Box::leak(Box::new(library));
        // SAFETY: the signature is that of mujoco.h.
        let number = unsafe { library.get::<unsafe extern "C" fn() -> c_int>(b"mj_version\0") };
        // SAFETY: takes nothing.
        let number = unsafe { number.map_err(unfit)?() };
        let Some((_, version)) = VERSIONS.into_iter().find(|(known, _)| *known == number) else {
            return Err(other_version(path, number));
        };
        // SAFETY: the symbol is a variable that holds a function or null.
        let warning = unsafe { library.get::<*mut Option<Handler>>(b"mju_user_warning\0") };
        // SAFETY: nothing runs yet that reads it.
        unsafe { **warning.map_err(unfit)? = Some(warn) };
        Self::of(library, path, version).map_err(unfit)
    }
}

fn damaged(path: &Path, reason: &str) -> MujocoError {
    MujocoError::Unfit(format!("{}: {reason}; install MuJoCo again", path.display()))
}

fn other_version(path: &Path, number: c_int) -> MujocoError {
    let (known, latest) = (VERSIONS.map(|v| v.1).join(", "), VERSIONS[VERSIONS.len() - 1].1);
    MujocoError::Unfit(format!(
        "{}: MuJoCo {} is not one of the versions that are known to work ({known}); install one of them, for example \
         `pip install mujoco=={latest}`",
        path.display(),
        name(number)
    ))
}

fn refused(message: impl fmt::Display) -> MujocoError {
    MujocoError::Unfit(format!("MuJoCo refuses the model: {message}"))
}

type Handler = unsafe extern "C" fn(*const c_char);

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

/// A model that is made when it is needed: most of what asks about a task does not need MuJoCo.
#[derive(Debug)]
pub struct Lazy<const N: usize> {
    mjcf: String,
    controls: usize,
    mass_kg: Option<f64>,
    made: OnceCell<Simulation<N>>,
}

impl<const N: usize> Lazy<N> {
    /// Returns a model; the arguments are those of `Simulation::new`.
    pub fn new(mjcf: String, controls: usize, mass_kg: Option<f64>) -> Self {
        Self { mjcf, controls, mass_kg, made: OnceCell::new() }
    }
}

impl<const N: usize> Clone for Lazy<N> {
    fn clone(&self) -> Self {
        Self::new(self.mjcf.clone(), self.controls, self.mass_kg)
    }
}

impl<const N: usize> Deref for Lazy<N> {
    type Target = Simulation<N>;

    fn deref(&self) -> &Simulation<N> {
        self.made.get_or_init(|| {
            Simulation::new(&self.mjcf, self.controls, self.mass_kg)
                .expect("the library is there, which a trial checks first, and the model is ours")
        })
    }
}

/// A model and its data. A state is its positions, velocities and where the solver starts, side by side; `N` numbers in all.
pub struct Simulation<const N: usize> {
    api: &'static Api,
    model: *mut RawModel,
    data: *mut RawData,
}

impl<const N: usize> Drop for Simulation<N> {
    fn drop(&mut self) {
        // SAFETY: they were made, and nobody else has them any more.
        unsafe { (self.api.delete_data)(self.data) }
        // SAFETY: as above.
        unsafe { (self.api.delete_model)(self.model) }
    }
}

impl<const N: usize> fmt::Debug for Simulation<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Simulation")
    }
}

impl<const N: usize> Simulation<N> {
    /// `controls` is how many numbers an action has, `mass` that to which the masses and inertias of all bodies are scaled, kg.
    /// Fails with [`MujocoError`] when the library is missing, or refuses the model, or the state is not of `N` numbers.
    fn new(mjcf: &str, controls: usize, mass: Option<f64>) -> Result<Self, MujocoError> {
        let api = api()?;
        let text = CString::new(mjcf).map_err(refused)?;
        let mut message: [c_char; MESSAGE] = [0; MESSAGE];
        // SAFETY: the text ends with a null byte, there is no file system, and the message has the size that is given.
        let spec = unsafe {
            (api.parse)(text.as_ptr(), ptr::null(), message.as_mut_ptr(), MESSAGE as c_int)
        };
        if spec.is_null() {
            // SAFETY: MuJoCo ends what it writes with a null byte, and there was one before.
            let message = unsafe { CStr::from_ptr(message.as_ptr()) };
            return Err(refused(message.to_string_lossy()));
        }
        // SAFETY: it was parsed above.
        let model = unsafe { (api.compile)(spec, ptr::null()) };
        let message = model.is_null().then(|| {
            // SAFETY: it was parsed above.
            let message = unsafe { (api.spec_error)(spec) };
            // SAFETY: a text of the spec, which still exists.
            unsafe { CStr::from_ptr(message) }.to_string_lossy().into_owned()
        });
        // SAFETY: it was parsed above, and a model does not need it.
        unsafe { (api.delete_spec)(spec) };
        if let Some(message) = message {
            return Err(refused(message));
        }
        // SAFETY: the model was compiled.
        let data = unsafe { (api.make_data)(model) };
        assert!(!data.is_null(), "no memory for MuJoCo's data");
        let simulation = Self { api, model, data };
        if let Some(mass) = mass {
            // SAFETY: nobody else has the model yet.
            unsafe { (api.set_total_mass)(model, mass) };
            // SAFETY: as above, and the data are those of the model.
            unsafe { (api.set_const)(model, data) };
        }
        simulation.check(controls)?;
        Ok(simulation)
    }

    fn check(&self, controls: usize) -> Result<(), MujocoError> {
        // SAFETY: the model was compiled.
        let size = |part| unsafe { (self.api.state_size)(self.model, part) };
        let sizes = [POSITION, VELOCITY, WARM_START, CONTROL].map(size);
        let third = (N / 3) as c_int;
        let fits = sizes == [third, third, third, controls as c_int] && size(STATE) == N as c_int;
        let reason = || format!("a state has other parts than expected: {sizes:?} numbers");
        if fits { Ok(()) } else { Err(damaged(&self.api.path, &reason())) }
    }

    fn set(&self, state: &[f64; N]) {
        // SAFETY: the state has as many numbers as the model's, which `check` compares.
        unsafe {
            (self.api.set_state)(self.model, self.data, state.as_ptr(), STATE);
        }
    }

    fn get(&self, state: &mut [f64; N]) {
        // SAFETY: as in `set`.
        unsafe {
            (self.api.get_state)(self.model, self.data, state.as_mut_ptr(), STATE);
        }
    }

    /// Returns the state that begins with these positions and velocities, which the third part of the given state follows.
    pub fn begin(&self, mut state: [f64; N]) -> [f64; N] {
        state[N / 3 * 2..].fill(0.0);
        let Self { api, model, data } = self;
        // SAFETY: the data are those of the model.
        unsafe { (api.reset)(*model, *data) };
        self.set(&state);
        // SAFETY: as above.
        unsafe { (api.forward)(*model, *data) };
        self.get(&mut state);
        state
    }

    /// Goes on from a state by so many steps of the model, with one control for all of them.
    /// Panics when there are not as many controls as actuators.
    pub fn step(&self, state: &mut [f64; N], control: &[f64], count: u32) {
        let Self { api, model, data } = self;
        self.set(state);
        // SAFETY: the model was compiled.
        let controls = unsafe { (api.state_size)(*model, CONTROL) };
        assert_eq!(controls as usize, control.len(), "one control per actuator");
        // SAFETY: there are as many controls as the model has.
        unsafe { (api.set_state)(*model, *data, control.as_ptr(), CONTROL) };
        for _ in 0..count {
            // SAFETY: the data are those of the model.
            unsafe { (api.step)(*model, *data) };
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
        insta::assert_snapshot!(e, @"MuJoCo is missing, which half-cheetah and swimmer need: DIR has no libmujoco; run `scripts/setup.sh mujoco`, or `pip install mujoco==4.0.0` in the environment whose `python3` comes first in PATH, or set MUJOCO_LIB_DIR to the folder of libmujoco");
        fs::write(dir.path().join("libmujoco.so.4.0.0"), "nothing").unwrap();
        let path = library(Some(dir.path().to_owned())).unwrap();
        let e = Api::load(&path).err().unwrap();
        assert!(e.to_string().ends_with("; install MuJoCo again"), "{e}");
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
