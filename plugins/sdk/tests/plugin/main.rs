//! A plugin as an author writes it, called through nothing but the struct that it exports.

// The other side of a C ABI, and helpers that fail are tests that fail.
#![allow(unsafe_code, missing_docs, unreachable_pub, clippy::unwrap_used)]

mod host;
mod nodes;

use std::{process::Command, ptr};

use host::{Manner, reply, settings};
use nodes::{Everything, Keeps, Odd, one_of_each};
use orograph_plugin::{NodeType, ParamValue, Params, RawParams, Slot, Value, abi::*};

orograph_plugin::export!("Test nodes", [Everything, Odd, Keeps]);

unsafe extern "C" {
    #[link_name = "orograph_plugin"]
    static EXPORTED: OrographPlugin;
}

fn plugin() -> &'static OrographPlugin {
    // SAFETY: the line above exports it.
    unsafe { &EXPORTED }
}

fn run(node: u32, params: &[ParamValue], slots: &[Slot], manner: Manner) -> (i32, host::Heard) {
    host::run(plugin(), node, params, slots, manner)
}

fn odd(set: impl FnOnce(&mut Odd), manner: Manner) -> (i32, host::Heard) {
    let mut settings = Odd::default();
    set(&mut settings);
    run(1, &settings.to_values(), &[], manner)
}

#[test]
fn the_struct_says_what_it_is_and_describes_its_nodes() {
    assert_eq!(plugin().size as usize, size_of::<OrographPlugin>());
    assert_eq!((plugin().abi_major, plugin().abi_minor), (OROGRAPH_ABI_MAJOR, OROGRAPH_ABI_MINOR));
    let describe = plugin().describe.unwrap();
    let (once, again) = unsafe { (describe(), describe()) };
    assert_eq!((once.data, once.len), (again.data, again.len), "the text stays where it is");
    let spec: PluginSpec = ron::from_str(unsafe { read_text(once) }.unwrap()).unwrap();
    assert_eq!((&*spec.name, &*spec.version), ("Test nodes", env!("CARGO_PKG_VERSION")));
    let ids: Vec<_> = spec.nodes.iter().map(|node| &*node.id).collect();
    assert_eq!(ids, ["test.everything", "test.odd", "test.keeps"]);
    assert_eq!(&spec.nodes[0], NodeType::of::<Everything>().spec());
}

#[test]
fn every_type_of_value_goes_in_and_comes_out() {
    let slots = one_of_each();
    let (status, heard) = run(0, &Everything::default().to_values(), &slots, Manner::default());
    assert_eq!((status, heard.failure), (OROGRAPH_OK, None));
    assert_eq!(heard.outputs.len(), slots.len());
    for (output, slot) in heard.outputs.values().zip(&slots) {
        let given = match slot {
            Slot::One(value) => value,
            Slot::Many(values) => values.last().unwrap(),
            Slot::Empty => unreachable!(),
        };
        assert_eq!(output.digest(), given.digest());
    }
    assert_eq!(heard.warnings, ["seed 7 resolution Some(512)"]);
    assert!(heard.progress.contains(&0.5));
}

#[test]
fn what_is_not_connected_is_none_and_settings_arrive() {
    let mut slots = one_of_each();
    for at in [1, 8, 9, 10, 11] {
        slots[at] = Slot::Empty;
    }
    slots[2] = Slot::Many(Vec::new());
    let settings = Everything {
        number: 0.25,
        integer: 9,
        boolean: true,
        text: "grün".into(),
        curve: [[0.0, 0.0], [0.5, 0.8]].into(),
    };
    let (status, heard) = run(0, &settings.to_values(), &slots, Manner::default());
    assert_eq!((status, heard.failure), (OROGRAPH_OK, None));
    let Value::Mask(mask) = &heard.outputs[&1] else { panic!() };
    assert_eq!(mask.cells(), [0.25; 6]);
    let Value::Texture(texture) = &heard.outputs[&2] else { panic!() };
    assert_eq!(texture.at(1, 2), [1, 2, 3, 4]);
    assert!(matches!(heard.outputs[&8], Value::Number(0.4)));
    assert!(matches!(heard.outputs[&9], Value::Integer(9)));
    assert!(matches!(heard.outputs[&10], Value::Boolean(true)));
    assert!(matches!(&heard.outputs[&11], Value::Text(text) if &**text == "grün"));
}

#[test]
fn what_does_not_fit_the_spec_is_refused() {
    let values = Everything::default().to_values();
    let refused = |node, params: &[ParamValue], slots: &[Slot]| {
        let (status, heard) = run(node, params, slots, Manner::default());
        assert_eq!(status, OROGRAPH_FAILED);
        heard.failure.unwrap().0
    };
    let mut slots = one_of_each();
    assert!(refused(9, &[], &[]).contains("no node of index 9"));
    assert!(refused(0, &values[..4], &slots).contains("expected 5 parameters"));
    assert!(refused(0, &values, &slots[1..]).contains("expected 12 inputs"));
    slots[0] = Slot::Empty;
    assert!(refused(0, &values, &slots).contains("`terrain`"));
    slots[0] = Slot::One(Value::Number(1.0));
    assert!(refused(0, &values, &slots).contains("`terrain`"));
    let far = Everything { number: 2.0, ..Everything::default() };
    assert!(refused(0, &far.to_values(), &one_of_each()).contains("outside its range"));
}

#[test]
fn a_panic_becomes_a_message_with_its_place() {
    for (place, said) in [(nodes::Place::Here, "here it ends"), (nodes::Place::InThePool, "no 57")] {
        let (status, heard) = odd(|odd| odd.panic = place, Manner::default());
        assert_eq!(status, OROGRAPH_PANICKED);
        let message = heard.failure.unwrap().0;
        assert!(message.contains(said) && message.contains("nodes.rs:"), "{message}");
    }
    assert_eq!(odd(|_| {}, Manner::default()).0, OROGRAPH_OK, "the next run is as if nothing had been");
}

#[test]
fn errors_arrive_with_their_hints() {
    let (status, heard) = odd(|odd| odd.fail = true, Manner::default());
    assert_eq!(status, OROGRAPH_FAILED);
    assert_eq!(heard.failure.unwrap(), ("it must not be".into(), "let it be".into()));
    let small = Manner { memory_limit: 1000, ..Manner::default() };
    let (status, heard) = odd(|odd| odd.large = true, small);
    let (message, hint) = heard.failure.unwrap();
    assert_eq!(status, OROGRAPH_FAILED);
    assert!(message.contains("4000000 bytes") && hint.contains("--memory"), "{message}: {hint}");
}

#[test]
fn a_cancelled_run_stops() {
    let (status, heard) = odd(|odd| odd.wait = true, Manner { cancel: true, ..Manner::default() });
    assert_eq!((status, heard.failure), (OROGRAPH_CANCELLED, None));
}

#[test]
fn a_refused_output_ends_the_run_without_another_reason() {
    let (status, heard) = odd(|_| {}, Manner { refuse_outputs: true, ..Manner::default() });
    assert_eq!((status, heard.failure), (OROGRAPH_FAILED, None));
}

#[test]
fn the_pool_is_as_large_as_the_host_says() {
    for threads in [1, 3, 2, 3] {
        let (status, heard) = odd(|_| {}, Manner { threads, ..Manner::default() });
        assert_eq!(status, OROGRAPH_OK);
        assert!(matches!(heard.outputs[&0], Value::Integer(n) if n == i64::from(threads)));
    }
}

#[test]
fn files_are_where_the_host_says() {
    let (status, heard) = odd(|odd| odd.file.0 = "data/there.tif".into(), Manner::default());
    assert_eq!(status, OROGRAPH_OK);
    assert!(matches!(&heard.outputs[&1], Value::Text(path) if &**path == "/somewhere/data/there.tif"));
    let (status, heard) = odd(|odd| odd.file.0 = "gone.tif".into(), Manner::default());
    assert_eq!(status, OROGRAPH_FAILED);
    assert!(heard.failure.unwrap().0.contains("gone.tif"));
}

#[test]
fn settings_are_checked_and_upgraded_without_a_run() {
    let settings = settings(plugin());
    let mut lender = Lender::new();
    let asked = Everything { text: "refuse".into(), ..Everything::default() };
    let (asked, right) = (asked.to_values(), Everything::default().to_values());
    let (refused, fine) = (lender.params(&asked), lender.params(&right));
    let check = |params: &[OrographParam]| {
        reply(|to| unsafe { settings.check.unwrap()(0, params.len(), params.as_ptr(), to) })
    };
    assert_eq!(check(&fine), (OROGRAPH_OK, None));
    assert_eq!(
        check(&refused),
        (OROGRAPH_FAILED, Some(("it says `refuse`".into(), "say something else".into())))
    );
    let halo = unsafe { settings.halo.unwrap()(0, fine.len(), fine.as_ptr(), 10.0, 10.0) };
    assert_eq!(halo, 5);
    assert_eq!(unsafe { settings.cost.unwrap()(0, fine.len(), fine.as_ptr()) }, 5.0);
    let upgrade = |from, text: &str| {
        reply(|to| unsafe { settings.upgrade.unwrap()(0, from, OrographText::of(text), to) })
    };
    let (status, new) = upgrade(1, r#"{"share": Number(0.125)}"#);
    let map = ron::from_str(&new.unwrap().0).unwrap();
    assert_eq!(status, OROGRAPH_OK);
    assert_eq!(RawParams(map).remove("number"), Some(ParamValue::Number(0.125)));
    assert_eq!(upgrade(0, "{}").0, OROGRAPH_FAILED);
    assert!(upgrade(1, "no map").1.unwrap().0.contains("no map of values"));
    assert_eq!(reply(|to| unsafe { settings.check.unwrap()(77, 0, ptr::null(), to) }).0, OROGRAPH_FAILED);
}

#[test]
fn a_broken_job_is_refused_without_being_read() {
    assert_eq!(unsafe { plugin().run.unwrap()(ptr::null()) }, OROGRAPH_FAILED);
    let (status, _) = odd(|_| {}, Manner { size: 8, ..Manner::default() });
    assert_eq!(status, OROGRAPH_FAILED);
}

#[test]
fn a_kept_input_ends_the_process_with_its_reason() {
    const INSIDE: &str = "OROGRAPH_TEST_KEEPS_AN_INPUT";
    if std::env::var_os(INSIDE).is_some() {
        run(2, &[], &one_of_each()[..1], Manner::default());
        return;
    }
    let test = "a_kept_input_ends_the_process_with_its_reason";
    let child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", test, "--nocapture"])
        .env(INSIDE, "1")
        .output()
        .unwrap();
    assert!(!child.status.success());
    let said = String::from_utf8_lossy(&child.stderr);
    assert!(said.contains("kept an input after the end of its run"), "{said}");
}
