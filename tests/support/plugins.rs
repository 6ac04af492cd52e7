//! Plugins in C, built for a test.

// Each test file uses its part of this; a helper that fails is a test that fails.
#![allow(dead_code, clippy::unwrap_used)]

use std::{
    path::{Path, PathBuf},
    process::Command,
};

use super::Place;

/// Builds a C plugin into the folder `plugins` of a place.
pub(crate) fn build(place: &Place, source: &str, name: &str, flags: &[&str]) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = place.path("plugins");
    std::fs::create_dir_all(&folder).unwrap();
    let library = folder.join(name).with_extension(std::env::consts::DLL_EXTENSION);
    // What links Rust programs compiles C.
    let mut compiler = Command::new(std::env::var_os("CC").unwrap_or_else(|| "cc".into()));
    compiler.args(["-std=gnu11", "-shared", "-fPIC", "-O1", "-pthread", "-o"]).arg(&library);
    // Folders that `flags` name are looked through first.
    compiler.args(flags).arg("-I").arg(root.join("plugins")).arg(root.join("tests/plugins").join(source));
    let built = compiler.output().unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    library
}

pub(crate) fn unsound(place: &Place, case: &str, flags: &[&str]) -> PathBuf {
    let case_flag = format!("-DCASE={case}");
    let mut all = vec![case_flag.as_str()];
    if !flags.iter().any(|flag| flag.starts_with("-DANSWER")) {
        all.push("-DANSWER=42");
    }
    all.extend_from_slice(flags);
    build(place, "unsound.c", &case.to_lowercase(), &all)
}
