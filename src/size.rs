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
    let total = sysinfo::System::new().map_or(0, |mut system| {
        system.refresh_memory();
        let machine = system.total_memory();
        // A container may have less than its machine.
        system.cgroup_limits().map_or(machine, |limits| limits.total_memory.min(machine))
    });
    if total == 0 { MOST } else { MOST.min(total / 4 * 3) }
}
