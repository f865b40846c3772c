//! Compiles the C of this folder into one static library. CC, AR and CFLAGS are read as the crate
//! cc reads them: CC_x86_64_unknown_linux_gnu, then TARGET_CC, then CC.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

const FLAGS: [&str; 4] = ["-O2", "-std=c99", "-ffp-contract=fast", "-fPIC"];

/// Return a variable of the environment for the target that is built, or a default.
fn setting(name: &str, default: &str) -> String {
    let target = env::var("TARGET").unwrap();
    let plain = target.replace('-', "_");
    let names = [
        format!("{name}_{target}"),
        format!("{name}_{plain}"),
        format!("TARGET_{name}"),
        name.to_string(),
    ];
    for variable in &names {
        println!("cargo:rerun-if-env-changed={variable}");
    }
    let value = names.iter().find_map(|variable| env::var(variable).ok());
    value.unwrap_or_else(|| default.to_string())
}

/// Run a command, which is words between spaces and arguments.
fn run(words: &str, arguments: &[&Path]) {
    let mut parts = words.split_whitespace();
    let program = parts.next().expect("CC and AR are commands");
    match Command::new(program).args(parts).args(arguments).status() {
        Ok(status) if status.success() => {}
        Ok(status) => panic!("{words}: {status}"),
        Err(error) => panic!("{program}: {error}; set CC and AR to gcc or clang and their ar"),
    }
}

fn main() {
    let folder = PathBuf::from(env::var("CARGO_MANIFEST_DIR").unwrap());
    let out = PathBuf::from(env::var("OUT_DIR").unwrap());
    let compiler = format!("{} {} {}", setting("CC", "cc"), FLAGS.join(" "), setting("CFLAGS", ""));
    let mut objects = Vec::new();
    for entry in fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        let ending = path.extension().unwrap_or_default();
        if ending == "c" || ending == "h" {
            println!("cargo:rerun-if-changed={}", path.display());
        }
        if ending == "c" {
            let object = out.join(path.file_name().unwrap()).with_extension("o");
            run(&compiler, &[Path::new("-c"), &path, Path::new("-o"), &object]);
            objects.push(object);
        }
    }
    objects.sort();
    let library = out.join("lib{{ name }}_model.a");
    let _ = fs::remove_file(&library);
    let mut members = vec![library.as_path()];
    members.extend(objects.iter().map(PathBuf::as_path));
    run(&format!("{} crs", setting("AR", "ar")), &members);
    println!("cargo:rustc-link-search=native={}", out.display());
    println!("cargo:rustc-link-lib=static={{ name }}_model");
    if env::var("CARGO_CFG_TARGET_OS").unwrap() != "none" {
        println!("cargo:rustc-link-lib=m"); // on bare metal, the program names its libm
    }
    println!("cargo:include={}", folder.display());
}
