//! Amounts of memory: read, written, and what the machine has.

use bytesize::ByteSize;
use serde::{
    Deserialize, Deserializer, Serialize, Serializer,
    de::{self, Visitor},
};

/// Reads `2GiB`, `500 MB` or a number of bytes.
///
/// # Errors
/// A sentence that says what to write.
pub fn parse(text: &str) -> Result<u64, String> {
    let size: ByteSize =
        text.parse().map_err(|_| format!("`{text}` is no size; write 2GiB, 500MB or a number of bytes"))?;
    Ok(size.as_u64())
}

/// A number of bytes in words, rounded.
#[must_use]
pub fn text(bytes: u64) -> String {
    ByteSize(bytes).display().iec().to_string()
}

/// A number of bytes in the shortest words that [`parse`] reads as exactly that number.
#[must_use]
pub fn exact_text(bytes: u64) -> String {
    let units = [(1 << 40, "TiB"), (1 << 30, "GiB"), (1 << 20, "MiB"), (1 << 10, "KiB")];
    let whole = units.iter().find(|(unit, _)| bytes > 0 && bytes.is_multiple_of(*unit));
    whole.map_or_else(|| bytes.to_string(), |(unit, name)| format!("{}{name}", bytes / unit))
}

/// Bytes that values may take in memory when nobody says: 8 GiB, or three quarters of a smaller machine.
#[must_use]
pub fn default_memory() -> u64 {
    const MOST: u64 = 8 << 30;
    let total = sysinfo::System::new().map_or(0, |mut system| {
        system.refresh_memory();
        let machine = system.total_memory();
        // A container may have less than its machine.
        system.cgroup_limits().map_or(machine, |limits| limits.total_memory.min(machine))
    });
    if total == 0 { MOST } else { MOST.min(total / 4 * 3) }
}

/// An amount in a settings file: text, or a number of bytes.
pub(crate) mod setting {
    use super::*;

    struct Amount(u64);

    impl<'de> Deserialize<'de> for Amount {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            deserializer.deserialize_any(AmountVisitor)
        }
    }

    struct AmountVisitor;

    impl Visitor<'_> for AmountVisitor {
        type Value = Amount;

        fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            f.write_str("a size such as \"2GiB\", or a number of bytes")
        }
        fn visit_u64<E: de::Error>(self, bytes: u64) -> Result<Amount, E> {
            Ok(Amount(bytes))
        }
        fn visit_i64<E: de::Error>(self, bytes: i64) -> Result<Amount, E> {
            u64::try_from(bytes).map(Amount).map_err(|_| E::custom("an amount of memory is not negative"))
        }
        fn visit_str<E: de::Error>(self, text: &str) -> Result<Amount, E> {
            parse(text).map(Amount).map_err(E::custom)
        }
    }

    pub(crate) fn serialize<S: Serializer>(bytes: &Option<u64>, serializer: S) -> Result<S::Ok, S::Error> {
        bytes.map(exact_text).serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<u64>, D::Error> {
        Ok(Option::<Amount>::deserialize(deserializer)?.map(|amount| amount.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_are_read_and_written_exactly() {
        for (text, bytes) in [("2GiB", 2 << 30), ("500 MB", 500_000_000), ("17", 17), ("1536MiB", 1536 << 20)]
        {
            assert_eq!(parse(text), Ok(bytes), "{text}");
            assert_eq!(parse(&exact_text(bytes)), Ok(bytes), "{text}");
        }
        assert_eq!(exact_text(1536 << 20), "1536MiB");
        assert_eq!([exact_text(0), exact_text(1025)], ["0", "1025"]);
        assert!(parse("much").unwrap_err().contains("2GiB"));
        assert!(default_memory() > 0);
    }
}
