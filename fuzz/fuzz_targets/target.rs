//! Every fuzz target: which of them it is, its name says.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| orograph_fuzz::run(env!("CARGO_BIN_NAME"), bytes));
