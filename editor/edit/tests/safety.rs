//! Work that is not saved outlives the program, and no save writes over someone else's work.
#![allow(clippy::unwrap_used)]

mod common;

use std::{
    fs,
    process::{Command, Stdio},
    sync::Arc,
    time::{Duration, Instant},
};

use common::{chain, registry};
use orograph_edit::{Journal, OpenFile, file::SaveError};
use orograph_engine::Document;

#[test]
fn a_file_that_someone_else_changed_is_not_written_over_without_being_asked() {
    let registry = registry();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("graph.ron");
    fs::write(&path, chain(&registry).to_ron(&registry)).unwrap();
    let (mut file, mut document) = OpenFile::open(&path).unwrap();
    document.doc = "mine".into();
    file.save(&document, &registry).unwrap();
    assert!(!file.changed_on_disk());
    fs::write(&path, "(format: 1, doc: \"theirs\", nodes: {})").unwrap();
    assert!(file.changed_on_disk());
    assert!(matches!(file.save(&document, &registry), Err(SaveError::ChangedOnDisk(_))));
    assert_eq!(Document::load(&path).unwrap().doc, "theirs");
    file.accept();
    file.save(&document, &registry).unwrap();
    assert_eq!(Document::load(&path).unwrap(), document);
}

#[test]
fn a_save_that_fails_leaves_the_old_file() {
    let registry = registry();
    let folder = tempfile::tempdir().unwrap();
    let in_the_way = folder.path().join("graph.ron");
    fs::write(&in_the_way, "theirs").unwrap();
    let path = in_the_way.join("graph.ron");
    let error = OpenFile::new(path).save(&chain(&registry), &registry).unwrap_err();
    assert!(matches!(error, SaveError::Io { .. }));
    assert_eq!(fs::read_to_string(&in_the_way).unwrap(), "theirs");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left behind");
}

#[test]
#[cfg(unix)]
fn a_save_holds_nobody_up_however_slow_the_disk_is() {
    let registry = registry();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("graph.ron");
    let text = chain(&registry).to_ron(&registry);
    fs::write(&path, &text).unwrap();
    let (file, mut document) = OpenFile::open(&path).unwrap();
    document.doc = "mine".into();
    // A file that is read no sooner than someone fills it.
    fs::remove_file(&path).unwrap();
    assert!(Command::new("mkfifo").arg(&path).status().unwrap().success());
    let mut saving = file.save_beside(Arc::new(document.clone()), registry.clone(), false, Arc::new(|| ()));
    assert!(saving.poll().is_none());
    fs::write(&path, &text).unwrap();
    let saved = saving.wait();
    saved.outcome.unwrap();
    assert!(!saved.file.changed_on_disk());
    assert_eq!(Document::load(&path).unwrap(), document);
}

#[test]
fn a_save_beside_asks_as_well_before_it_writes_over_others() {
    let registry = registry();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("graph.ron");
    fs::write(&path, chain(&registry).to_ron(&registry)).unwrap();
    let (file, document) = OpenFile::open(&path).unwrap();
    fs::write(&path, "(format: 1, doc: \"theirs\", nodes: {})").unwrap();
    let document = Arc::new(document);
    let save = |over| file.save_beside(document.clone(), registry.clone(), over, Arc::new(|| ())).wait();
    assert!(matches!(save(false).outcome, Err(SaveError::ChangedOnDisk(_))));
    assert_eq!(Document::load(&path).unwrap().doc, "theirs");
    save(true).outcome.unwrap();
    assert_eq!(Document::load(&path).unwrap(), *document);
}

/// The program that is killed: it keeps a document and waits. Run by the test below alone.
#[test]
#[ignore = "runs as the child of another test"]
fn keeps_a_document_and_waits_to_be_killed() {
    let folder = std::env::var_os("OROGRAPH_TEST_JOURNAL").unwrap();
    let registry = registry();
    let journal = Journal::begin(folder.as_ref(), registry.clone()).unwrap();
    let mut document = chain(&registry);
    for edit in 0..1000 {
        document.doc = format!("edit {edit}");
        journal.keep(Some("graph.ron".as_ref()), Arc::new(document.clone()));
    }
    println!("edited");
    std::thread::sleep(Duration::from_secs(60));
}

#[test]
fn what_was_not_saved_is_found_after_kill_nine_with_all_but_the_last_second() {
    let registry = registry();
    let folder = tempfile::tempdir().unwrap();
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "keeps_a_document_and_waits_to_be_killed", "--ignored", "--nocapture"])
        .env("OROGRAPH_TEST_JOURNAL", folder.path())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut out = std::io::BufReader::new(child.stdout.take().unwrap());
    let mut line = String::new();
    while !line.contains("edited") {
        line.clear();
        assert!(std::io::BufRead::read_line(&mut out, &mut line).unwrap() > 0, "the child ended early");
    }
    // A running program's work is its own.
    assert!(Journal::left(folder.path()).unwrap().is_empty());
    std::thread::sleep(Duration::from_secs(1));
    child.kill().unwrap();
    child.wait().unwrap();
    let left = Journal::left(folder.path()).unwrap();
    assert_eq!(left.len(), 1);
    assert_eq!(left[0].recovery.path.as_deref(), Some("graph.ron".as_ref()));
    let mut expected = chain(&registry);
    expected.doc = "edit 999".into();
    assert_eq!(Document::parse(&left[0].recovery.text, "left").unwrap(), expected);
    left.into_iter().for_each(orograph_edit::Left::forget);
    assert!(Journal::left(folder.path()).unwrap().is_empty());
}

#[test]
fn what_was_saved_leaves_nothing_to_recover() {
    let registry = registry();
    let folder = tempfile::tempdir().unwrap();
    let journal = Journal::begin(folder.path(), registry.clone()).unwrap();
    journal.keep(None, Arc::new(chain(&registry)));
    journal.flush().unwrap();
    journal.forget();
    journal.flush().unwrap();
    drop(journal);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn edits_do_not_wait_for_the_disk() {
    let registry = registry();
    let folder = tempfile::tempdir().unwrap();
    let journal = Journal::begin(folder.path(), registry.clone()).unwrap();
    let document = Arc::new(chain(&registry));
    let begun = Instant::now();
    for _ in 0..10_000 {
        journal.keep(None, document.clone());
    }
    // Ten thousand files would take far longer: only the newest document is written.
    assert!(begun.elapsed() < Duration::from_secs(2));
}
