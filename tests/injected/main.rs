//! Faults of the file system at every call by which outputs, the cache and what a user keeps are written: no room, no
//! permission, a broken disk, short writes.
//!
//! `tests/shim` makes the calls fail; it is built here and loaded into the program before anything else.

// A helper that fails is a test that fails.
#![allow(clippy::unwrap_used)]

#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod faults;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
#[path = "../support/mod.rs"]
mod support;

#[cfg(not(all(target_os = "linux", target_arch = "x86_64")))]
#[test]
fn faults_are_left_out() {
    println!("left out: calls are made to fail on Linux on x86-64 alone");
}
