use super::*;

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn what_dead_runs_left_goes_and_what_living_runs_write_stays() {
    let root = tempfile::tempdir().unwrap();
    let living = OutputFolder::new(root.path());
    let mut under_way = living.create("a.txt").unwrap();
    under_way.write_all(b"whole").unwrap();
    let held = names(root.path());
    for left in [".orograph-dead.tmp", ".orograph-other.txt", "orograph-x.tmp"] {
        fs::write(root.path().join(left), "half").unwrap();
    }
    // Another run begins a file in the same folder.
    OutputFolder::new(root.path()).create("b.txt").unwrap().finish().unwrap();
    let mut expected =
        [held, vec![".orograph-other.txt".into(), "b.txt".into(), "orograph-x.tmp".into()]].concat();
    expected.sort();
    assert_eq!(names(root.path()), expected);
    under_way.finish().unwrap();
    assert_eq!(fs::read(root.path().join("a.txt")).unwrap(), b"whole");
    assert_eq!(names(root.path()), [".orograph-other.txt", "a.txt", "b.txt", "orograph-x.tmp"]);
}

#[test]
fn runs_that_begin_together_do_not_take_each_other_s_files() {
    let root = tempfile::tempdir().unwrap();
    std::thread::scope(|scope| {
        for writer in 0..8 {
            let root = root.path();
            scope.spawn(move || {
                for file in 0..25 {
                    let name = format!("{writer}-{file}");
                    let mut out = OutputFolder::new(root).create(&name).unwrap();
                    out.write_all(name.as_bytes()).unwrap();
                    out.finish().unwrap();
                }
            });
        }
    });
    assert_eq!(names(root.path()).len(), 200);
}

#[test]
fn errors_name_the_file_as_the_user_finds_it() {
    let folder = OutputFolder::new("out");
    let named = |path: &str| folder.located(Error::writing(path, "no room")).to_string();
    assert_eq!(named("maps/a.png"), "writing out/maps/a.png: no room");
    assert_eq!(named("out/a.png"), "writing out/a.png: no room");
    let other = Error::reading("a.png", "gone");
    assert_eq!(folder.located(other.clone()), other);
}

#[test]
fn no_name_leads_out() {
    let root = tempfile::tempdir().unwrap();
    let folder = OutputFolder::new(root.path().join("out"));
    let absolute = root.path().join("absolute.txt");
    for name in ["../x.txt", "a/../../x.txt", "", "..", absolute.to_str().unwrap(), "/x.txt", "./../x.txt"] {
        assert!(folder.create(name).is_err(), "{name}");
    }
    #[cfg(windows)]
    for name in ["C:\\x.txt", "C:x.txt", "\\x.txt", "..\\x.txt", "a\\..\\..\\x.txt", "\\\\host\\share\\x.txt"]
    {
        assert!(folder.create(name).is_err(), "{name}");
    }
    assert_eq!(names(root.path()), [""; 0], "nothing is made, not even the output folder");
}

#[cfg(unix)]
mod links {
    use std::os::unix::fs::symlink;

    use super::*;

    /// An output folder, and a folder beside it with a file.
    fn beside() -> (tempfile::TempDir, PathBuf, PathBuf) {
        let root = tempfile::tempdir().unwrap();
        let (out, other) = (root.path().join("out"), root.path().join("other"));
        fs::create_dir(&out).unwrap();
        fs::create_dir(&other).unwrap();
        fs::write(other.join("theirs.txt"), "theirs").unwrap();
        (root, out, other)
    }

    #[test]
    fn links_that_lead_out_are_refused_before_anything_is_made() {
        let (root, out, other) = beside();
        symlink(&other, out.join("link")).unwrap();
        symlink("..", out.join("up")).unwrap();
        symlink(root.path().join("none"), out.join("dangling")).unwrap();
        let folder = OutputFolder::new(&out);
        for name in ["link/x.txt", "link/deep/er/x.txt", "up/x.txt", "up/new/x.txt", "dangling/x.txt"] {
            assert!(folder.create(name).is_err(), "{name}");
        }
        assert_eq!(names(&other), ["theirs.txt"]);
        assert_eq!(names(root.path()), ["other", "out"]);
        // Nor is what lies there taken for an output that was written.
        let file = |name: &str| WrittenFile {
            name: name.into(),
            bytes: 6,
            digest: digest_of(b"theirs".as_slice()).unwrap(),
        };
        assert!(!folder.holds(&[file("link/theirs.txt")]));
        assert!(!folder.holds(&[file("../other/theirs.txt")]));
        assert!(OutputFolder::new(&other).holds(&[file("theirs.txt")]));
    }

    #[test]
    fn links_that_stay_inside_are_followed_and_one_at_the_name_is_replaced() {
        let (_root, out, other) = beside();
        fs::create_dir(out.join("maps")).unwrap();
        symlink("maps", out.join("pictures")).unwrap();
        symlink(other.join("theirs.txt"), out.join("a.txt")).unwrap();
        symlink(&other, out.join("b.txt")).unwrap();
        let folder = OutputFolder::new(&out);
        for name in ["pictures/x.txt", "a.txt", "b.txt"] {
            let mut file = folder.create(name).unwrap();
            file.write_all(b"ours").unwrap();
            file.finish().unwrap();
            let path = out.join(name);
            assert!(fs::symlink_metadata(&path).unwrap().is_file(), "{name}");
            assert_eq!(fs::read(path).unwrap(), b"ours");
        }
        assert_eq!(names(&out.join("maps")), ["x.txt"]);
        assert_eq!(names(&other), ["theirs.txt"]);
        assert_eq!(fs::read(other.join("theirs.txt")).unwrap(), b"theirs");
        // The output folder itself may be a link: it is the user who names it.
        symlink(&other, out.join("root")).unwrap();
        OutputFolder::new(out.join("root")).create("mine.txt").unwrap().finish().unwrap();
        assert_eq!(names(&other), ["mine.txt", "theirs.txt"]);
    }
}
