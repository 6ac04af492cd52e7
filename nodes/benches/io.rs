//! Throughput of the formats.

fn main() {
    divan::main();
}
