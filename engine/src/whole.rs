//! Files that appear whole or not at all.

use std::{
    fs,
    io::{self, Write},
    path::Path,
};

use tempfile::NamedTempFile;

/// Puts a file with the content `parts` in its place at once, making its folder where there is none. It grows in the
/// folder `temporary`, which must lie on the same file system.
///
/// # Errors
/// Those of the file system; then what was there before, or nothing, is there still.
pub fn write_whole(temporary: &Path, path: &Path, parts: &[&[u8]]) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let mut file = NamedTempFile::new_in(temporary).map_err(plain)?;
    for part in parts {
        // Not through `NamedTempFile`, whose errors tell the temporary name.
        file.as_file_mut().write_all(part)?;
    }
    file.persist(path).map_err(|error| plain(error.error))?;
    Ok(())
}

/// As [`write_whole`], for a file that a user keeps: it stays readable to whom it was, and outlives a power cut.
///
/// # Errors
/// As [`write_whole`].
pub fn save_whole(path: &Path, content: &[u8]) -> io::Result<()> {
    // A link stays one, and what it leads to is replaced.
    let path = &fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    fs::create_dir_all(folder)?;
    let mut file = begin_ordinary(folder).map_err(plain)?;
    file.as_file_mut().write_all(content)?;
    if let Ok(before) = fs::metadata(path) {
        file.as_file().set_permissions(before.permissions())?;
    }
    file.as_file().sync_all()?;
    file.persist(path).map_err(|error| plain(error.error))?;
    Ok(())
}

/// A temporary file is private to its owner; this one is as any file that a program makes.
fn begin_ordinary(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // The user's mask takes from it.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

/// What the system said, without the temporary name that `tempfile` adds.
pub(crate) fn plain(error: io::Error) -> io::Error {
    if let Some(code) = error.raw_os_error() {
        return io::Error::from_raw_os_error(code);
    }
    // It keeps the system's error to itself; the words of that stand before the name.
    match error.to_string().split_once(" at path ") {
        Some((words, _)) => io::Error::new(error.kind(), words),
        None => io::Error::from(error.kind()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_whole_or_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/b.txt");
        write_whole(folder.path(), &path, &[b"one", b" two"]).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"one two");
        save_whole(&path, b"three").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"three");
        let error = write_whole(&folder.path().join("none"), &path, &[b"four"]).unwrap_err();
        let gone = fs::read(folder.path().join("none/file")).unwrap_err();
        assert_eq!(error.to_string(), gone.to_string(), "the system's words and nothing else");
        assert!(save_whole(&folder.path().join("a"), b"in the way").is_err());
        assert_eq!(fs::read(&path).unwrap(), b"three");
        let left = |folder: &Path| fs::read_dir(folder).unwrap().count();
        assert_eq!(
            (left(folder.path()), left(&folder.path().join("a"))),
            (1, 1),
            "nothing temporary is left"
        );
    }

    #[cfg(unix)]
    #[test]
    fn links_and_permissions_outlive_a_save() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, "one").unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
        symlink(&file, &link).unwrap();
        save_whole(&link, b"two").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"two");
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
    }
}
