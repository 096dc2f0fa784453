//! Finds libsumo, compiles the shim against it as a shared object and generates its declarations.
//!
//! The shared object is embedded into the crate and loaded at run time, so a program that uses
//! this crate starts without SUMO and can say that it is missing.

use std::env;
use std::fs;
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

/// Value of SUMO_LIB_DIR that asks for a build without SUMO.
const WITHOUT: &str = "none";

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
    println!("cargo:rerun-if-changed=src/stamp.rs");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    if env::var_os("SUMO_LIB_DIR").is_some_and(|folder| folder == WITHOUT) {
        return without(&out);
    }
    let found = custom().or_else(wheel).or_else(debian).unwrap_or_else(|| {
        panic!(
            "libsumo was not found. There are three ways out:\n\
             1. Debian or Ubuntu: `apt-get install sumo libpython3-dev`;\n\
             2. `pip install eclipse-sumo==1.15.0`, then set SUMO_HOME to the folder `sumo` in \
             site-packages, which has `include` and `lib64/{LIBRARY}`;\n\
             3. set SUMO_INCLUDE_DIR to the folder above `libsumo/libsumo.h` and SUMO_LIB_DIR to \
             the folder of {LIBRARY}.\n\
             With SUMO_LIB_DIR={WITHOUT} a program is built that cannot simulate traffic."
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
    let bytes = fs::read(&found.library).expect("the library was found");
    println!("cargo:rustc-env=LIBSUMO_VERSION={}", version(&bytes).unwrap_or_default());
    println!("cargo:rustc-env=LIBSUMO_STAMP={}", stamp(&found.library).unwrap_or_default());
    compile_shim(&found, &out.join("libtscsumo.so"));
    let header = found.include.join("libsumo/TraCIConstants.h");
    let header = fs::read_to_string(&header)
        .unwrap_or_else(|e| panic!("cannot read {}: {e}", header.display()));
    let constant = |name: &str| {
        let value =
            header.split_once(&format!("int {name} = ")).and_then(|(_, v)| v.split_once(';'));
        let (value, _) = value.unwrap_or_else(|| panic!("TraCIConstants.h lacks {name}"));
        format!("pub const {name}: i32 = {value};\n")
    };
    declare(constant, &out);
}

/// Embeds a shim that cannot be loaded.
fn without(out: &Path) {
    for name in ["KIND", "INCLUDE", "LIBRARY", "VERSION", "STAMP"] {
        println!("cargo:rustc-env=LIBSUMO_{name}={WITHOUT}");
    }
    fs::write(out.join("libtscsumo.so"), "").expect("OUT_DIR can be written");
    // Any numbers that differ.
    declare(|name| format!("pub const {name}: i32 = {};\n", name.len()), out);
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

/// Returns the text with which a library says its version, such as `SUMO 1.15.0`, if it has one such text.
fn version(library: &[u8]) -> Option<&str> {
    let texts = library.split(|byte| *byte == 0).filter(|text| text.starts_with(b"SUMO "));
    let texts = texts.filter_map(|text| str::from_utf8(text).ok());
    let mut versions = texts.filter(|text| {
        let number = text[5..].trim_start_matches('v');
        let is_part = |c: char| c.is_ascii_alphanumeric() || ['.', '_', '+', '-'].contains(&c);
        number.starts_with(|c: char| c.is_ascii_digit()) && number.chars().all(is_part)
    });
    versions.next().filter(|_| versions.next().is_none())
}

include!("src/stamp.rs");

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
fn declare(constant: impl Fn(&str) -> String, out: &Path) {
    let shim = fs::read_to_string("csrc/shim.h").expect("the shim has a header");
    fs::write(out.join("shim.rs"), declarations(&shim)).expect("OUT_DIR can be written");
    let constants = ["TRACI_VERSION", "TRAFFICLIGHT_TYPE_STATIC", "TRAFFICLIGHT_TYPE_ACTUATED"];
    let constants = constants.map(constant).concat();
    fs::write(out.join("constants.rs"), constants).expect("OUT_DIR can be written");
}

/// Returns in Rust what `shim.h` declares, and a type that loads its functions. The header keeps to `#define`s of numbers,
/// `typedef struct`s, and functions; what else it has does not compile. bindgen would take 30 s of the processor
/// and libclang on every machine.
fn declarations(header: &str) -> String {
    let (mut rust, mut code) = (String::new(), String::new());
    for line in header.lines().map(str::trim) {
        if let Some((name, value)) =
            line.strip_prefix("#define SUMO_").and_then(|line| line.split_once(' '))
        {
            rust += &format!("pub const SUMO_{name}: i32 = {value};\n");
        } else if !line.starts_with(['#', '/']) && !["extern \"C\" {", "}"].contains(&line) {
            code += line;
            code += " ";
        }
    }
    let (mut fields, mut symbols, mut methods) = (String::new(), String::new(), String::new());
    let mut rest = code.trim();
    while !rest.is_empty() {
        if let Some(body) = rest.strip_prefix("typedef struct {") {
            let (members, after) = body.split_once('}').expect("a struct ends");
            let (name, after) = after.split_once(';').expect("a struct has a name");
            let name = name.trim();
            rust += &format!(
                "#[repr(C)]\n#[derive(Debug, Clone, Copy, Default)]\npub struct {name} {{\n"
            );
            for member in members.split_terminator(';').filter(|m| !m.trim().is_empty()) {
                let (name, kind) = declared(member);
                rust += &format!("    pub {name}: {kind},\n");
            }
            rust += "}\n";
            rest = after.trim();
            continue;
        }
        let (function, after) = rest.split_once(");").expect("a function ends");
        let (head, arguments) = function.split_once('(').expect("a function has arguments");
        let (name, result) = declared(head);
        let arguments = arguments.split(',').filter(|a| *a != "void").map(declared);
        let (names, typed): (Vec<String>, Vec<String>) =
            arguments.map(|(name, kind)| (name.clone(), format!("{name}: {kind}"))).unzip();
        let (names, typed) = (names.join(", "), typed.join(", "));
        fields += &format!("    {name}: unsafe extern \"C\" fn({typed}) -> {result},\n");
        symbols += &format!("            {name}: *unsafe {{ library.get(b\"{name}\\0\") }}?,\n");
        methods += &format!(
            "    pub unsafe fn {name}(&self, {typed}) -> {result} {{\n        \
             unsafe {{ (self.{name})({names}) }}\n    }}\n"
        );
        rest = after.trim();
    }
    format!(
        "use std::ffi::c_char;\n{rust}pub struct Shim {{\n{fields}    _library: libloading::Library,\n}}\n\
         impl Shim {{\n    \
             pub unsafe fn new(file: &std::path::Path) -> Result<Self, libloading::Error> {{\n        \
                 let library = unsafe {{ libloading::Library::new(file) }}?;\n        \
                 Ok(Self {{\n{symbols}            _library: library,\n        }})\n    \
             }}\n{methods}}}\n"
    )
}

/// Returns the name and the Rust type of a declaration in C, such as `const char *const *argv`.
fn declared(c: &str) -> (String, String) {
    let c = c.trim();
    let at = c.rfind(|c: char| !c.is_alphanumeric() && c != '_').expect("a type and a name") + 1;
    // A word of Rust.
    let name = if &c[at..] == "type" { "type_" } else { &c[at..] };
    (name.to_owned(), rust_type(&c[..at]))
}

fn rust_type(c: &str) -> String {
    let c = c.trim();
    if let Some(target) = c.strip_suffix('*').map(str::trim) {
        let fixed = match target.strip_suffix("const") {
            Some(target) => Some(target),
            None if target.contains('*') => None,
            None => target.strip_prefix("const "),
        };
        return match fixed {
            Some(target) => format!("*const {}", rust_type(target)),
            None => format!("*mut {}", rust_type(target)),
        };
    }
    // Of what a pointer to a constant pointer leads to.
    match c.strip_prefix("const ").unwrap_or(c) {
        "double" => "f64",
        "int32_t" => "i32",
        "uint32_t" => "u32",
        "uint8_t" => "u8",
        "size_t" => "usize",
        "char" => "c_char",
        "bool" => "bool",
        name if name.starts_with("Sumo") => name,
        _ => panic!("shim.h has the type {c}, which build.rs does not know"),
    }
    .to_owned()
}
