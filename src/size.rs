//! Amounts of memory: parsing, printing, and what the machine has.

use bytesize::ByteSize;

/// Parses `2GiB`, `500 MB` or a number of bytes.
pub(crate) fn parse(text: &str) -> Result<u64, String> {
    let size: ByteSize =
        text.parse().map_err(|_| format!("`{text}` is no size; write 2GiB, 500MB or a number of bytes"))?;
    Ok(size.as_u64())
}

/// A number of bytes in words.
pub(crate) fn text(bytes: u64) -> String {
    ByteSize(bytes).display().iec().to_string()
}

/// Bytes that values may take in memory when nobody says: 8 GiB, or three quarters of a smaller machine.
pub(crate) fn default_memory() -> u64 {
    const MOST: u64 = 8 << 30;
    let mut system = sysinfo::System::new();
    system.refresh_memory();
    // A container may have less than its machine.
    let total = system
        .cgroup_limits()
        .map_or(system.total_memory(), |limits| limits.total_memory.min(system.total_memory()));
    if total == 0 { MOST } else { MOST.min(total / 4 * 3) }
}
