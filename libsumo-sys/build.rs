//! Finds libsumo, compiles the shim against it as a shared object and generates its declarations.
//!
//! The shared object is embedded into the crate and loaded at run time, so a program that uses
//! this crate starts without SUMO and can say that it is missing.

use std::env;
use std::fs;
use std::panic::{self, AssertUnwindSafe};
use std::path::{Path, PathBuf};
use std::process::Command;

/// libsumo as the eclipse-sumo wheel and SUMO's own build name it.
const LIBRARY: &str = "libsumocpp.so";
/// Debian's headers; their folder is on the include path anyway.
const DEBIAN_HEADERS: &str = "/usr/include";
/// Debian's only build of libsumo: the Python extension module, which exports the C++ symbols too.
const DEBIAN_MODULES: &str = "/usr/lib/python3/dist-packages/libsumo";
/// File name of that module up to the Python version, as in `_libsumo.cpython-311-x86_64-...`.
const DEBIAN_MODULE: &str = "_libsumo.cpython-";
/// A function of libsumo whose texts are laid out as before C++11, as in the wheel of SUMO 1.15.
const OLD_TEXTS: &[u8] = b"_ZN7libsumo10Simulation5closeERKSs";

/// A libsumo that can be linked to.
struct Found {
    /// `custom`, `eclipse-sumo` or `debian`.
    kind: &'static str,
    /// Folder that contains `libsumo/libsumo.h`.
    include: PathBuf,
    library: PathBuf,
}

fn main() {
    for name in ["SUMO_INCLUDE_DIR", "SUMO_LIB_DIR", "SUMO_HOME"] {
        println!("cargo:rerun-if-env-changed={name}");
    }
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=csrc");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    let found = custom().or_else(wheel).or_else(debian).unwrap_or_else(|| {
        panic!(
            "libsumo was not found. There are three ways out:\n\
             1. Debian or Ubuntu: `apt-get install sumo libpython3-dev`;\n\
             2. `pip install eclipse-sumo==1.15.0`, then set SUMO_HOME to the folder `sumo` in \
             site-packages, which has `include` and `lib64/{LIBRARY}`;\n\
             3. set SUMO_INCLUDE_DIR to the folder above `libsumo/libsumo.h` and SUMO_LIB_DIR to \
             the folder of {LIBRARY}.\n\
             Or build without SUMO: `cargo build --no-default-features`."
        )
    });
    // The folder of the library becomes the shim's run path, which must not be relative.
    let found = Found {
        library: fs::canonicalize(&found.library).expect("the library was found"),
        ..found
    };
    println!("cargo:rerun-if-changed={}", found.library.display());
    println!("cargo:rerun-if-changed={}", found.include.join("libsumo/libsumo.h").display());
    println!("cargo:rustc-env=LIBSUMO_KIND={}", found.kind);
    println!("cargo:rustc-env=LIBSUMO_INCLUDE={}", found.include.display());
    println!("cargo:rustc-env=LIBSUMO_LIBRARY={}", found.library.display());
    compile_shim(&found, &out.join("libtscsumo.so"));
    declare(&found, &out);
}

/// Returns what SUMO_INCLUDE_DIR and SUMO_LIB_DIR name; being explicit, they must be right.
fn custom() -> Option<Found> {
    let include = PathBuf::from(env::var_os("SUMO_INCLUDE_DIR")?);
    let folder = PathBuf::from(env::var_os("SUMO_LIB_DIR")?);
    assert!(
        has_headers(&include),
        "SUMO_INCLUDE_DIR is {}, which has no libsumo/libsumo.h",
        include.display()
    );
    let library = library_in(&folder).unwrap_or_else(|| {
        panic!("SUMO_LIB_DIR is {}, which has no {LIBRARY}", folder.display());
    });
    Some(Found { kind: "custom", include, library })
}

/// Returns the libsumo of a wheel; Debian's SUMO_HOME has neither headers nor a library.
fn wheel() -> Option<Found> {
    let home = PathBuf::from(env::var_os("SUMO_HOME")?);
    let include = home.join("include");
    let library =
        ["lib64", "lib", "bin"].iter().map(|d| home.join(d).join(LIBRARY)).find(|l| l.exists())?;
    has_headers(&include).then_some(Found { kind: "eclipse-sumo", include, library })
}

fn debian() -> Option<Found> {
    let include = PathBuf::from(DEBIAN_HEADERS);
    let library = library_in(Path::new(DEBIAN_MODULES))?;
    has_headers(&include).then_some(Found { kind: "debian", include, library })
}

fn has_headers(include: &Path) -> bool {
    include.join("libsumo/libsumo.h").exists()
}

/// Returns libsumo in a folder, be it the plain library or Debian's module.
fn library_in(folder: &Path) -> Option<PathBuf> {
    let plain = folder.join(LIBRARY);
    if plain.exists() {
        return Some(plain);
    }
    let mut modules: Vec<PathBuf> =
        fs::read_dir(folder).ok()?.filter_map(|entry| Some(entry.ok()?.path())).collect();
    modules.retain(|path| python_of(path).is_some());
    modules.sort();
    modules.pop()
}

/// Returns the version of Python that an extension module needs, such as `3.11`.
fn python_of(library: &Path) -> Option<String> {
    let name = library.file_name()?.to_str()?;
    let (digits, _) = name.strip_prefix(DEBIAN_MODULE)?.split_once('-')?;
    let (major, minor) = digits.split_at_checked(1)?;
    Some(format!("{major}.{minor}"))
}

/// Whether a library takes C++ texts as compilers before C++11 laid them out.
fn has_old_texts(library: &Path) -> bool {
    let bytes = fs::read(library).expect("the library was found");
    bytes.windows(OLD_TEXTS.len()).any(|name| name == OLD_TEXTS)
}

fn compile_shim(found: &Found, shim: &Path) {
    let folder = found.library.parent().expect("a library lies in a folder");
    let name = found.library.file_name().expect("a library has a name").to_string_lossy();
    let mut command: Command = cc::Build::new().cpp(true).std("c++17").get_compiler().to_command();
    command
        .args(["-shared", "-fPIC", "-O2", "-s", "-Wall", "-Wextra", "-Wl,-z,defs"])
        // Another libsumo is an error when it is loaded; otherwise the process would end at the first call.
        .arg("-Wl,-z,now")
        .arg("csrc/shim.cpp")
        .arg("-o")
        .arg(shim)
        .arg("-L")
        .arg(folder)
        .arg(format!("-l:{name}"))
        .arg(format!("-Wl,-rpath,{}", folder.display()));
    // The compiler's own search path would come before an explicit -I for headers in it.
    if found.include != Path::new(DEBIAN_HEADERS) {
        command.arg("-I").arg(&found.include);
    }
    if has_old_texts(&found.library) {
        command.arg("-D_GLIBCXX_USE_CXX11_ABI=0");
    }
    if let Some(version) = python_of(&found.library) {
        // The module leaves Python's symbols to the interpreter, which is not there; the shim
        // itself uses none of them, so the linker would drop the library.
        command.args(["-Wl,--no-as-needed", &format!("-l:libpython{version}.so.1.0")]);
    }
    let output = command
        .output()
        .unwrap_or_else(|e| panic!("no C++ compiler ({e}); Debian: `apt-get install g++`"));
    assert!(
        output.status.success(),
        "the shim does not build against {} ({}); if it asks for libpython, install Debian's \
         `libpython3-dev`; otherwise SUMO 1.15 to 1.28 are known to work\n{command:?}\n{}",
        found.library.display(),
        found.kind,
        String::from_utf8_lossy(&output.stderr)
    );
}

/// Writes the Rust declarations of the shim and of the constants that are used with it.
fn declare(found: &Found, out: &Path) {
    let shim = bindgen::builder()
        .header("csrc/shim.h")
        .dynamic_library_name("Shim")
        .dynamic_link_require_all(true)
        .derive_default(true)
        .default_macro_constant_type(bindgen::MacroTypeVariation::Signed)
        .allowlist_item("(sumo_|Sumo|SUMO_).*");
    generate(shim, &out.join("shim.rs"));
    let constants = bindgen::builder()
        .header(found.include.join("libsumo/TraCIConstants.h").display().to_string())
        .clang_args(["-x", "c++", "-std=c++17"])
        .disable_name_namespacing()
        .allowlist_var("libsumo::TRACI_VERSION")
        .allowlist_var("libsumo::TRAFFICLIGHT_TYPE_(STATIC|ACTUATED)");
    generate(constants, &out.join("constants.rs"));
}

fn generate(builder: bindgen::Builder, file: &Path) {
    let builder = builder.rust_edition(bindgen::RustEdition::Edition2024).wrap_unsafe_ops(true);
    // bindgen panics, with a text about llvm-config, when there is no libclang.
    let bindings = panic::catch_unwind(AssertUnwindSafe(|| builder.generate()))
        .unwrap_or_else(|_| panic!("no libclang; Debian: `apt-get install libclang-dev`"))
        .unwrap_or_else(|e| panic!("bindgen cannot declare {}: {e}", file.display()));
    bindings.write_to_file(file).unwrap_or_else(|e| panic!("cannot write {}: {e}", file.display()));
}
