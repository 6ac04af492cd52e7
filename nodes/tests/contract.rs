//! The contract that every built-in node keeps, swept over the registry.

use std::{collections::BTreeSet, path::Path};

use orograph_contract as contract;
use orograph_core::NodeType;

/// Runs `check` over every node and fails with the list of complaints, each headed by its node's id.
fn sweep(check: impl Fn(&NodeType) -> Vec<String>) {
    let complaints: Vec<String> = orograph_nodes::all()
        .iter()
        .flat_map(|node| {
            let id = node.spec().id.clone();
            check(node).into_iter().map(move |complaint| format!("{id}: {complaint}"))
        })
        .collect();
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

macro_rules! swept {
    ($($test:ident: $check:ident;)*) => {$(
        #[test]
        fn $test() {
            sweep(contract::$check);
        }
    )*};
}

swept! {
    names_limits_and_defaults_make_sense: names_and_limits;
    everything_has_docs_that_read_as_sentences: docs;
    specs_and_settings_survive_a_file: survives_a_file;
    a_change_of_any_parameter_changes_the_key: keys;
    values_beyond_the_range_are_refused: ranges_are_enforced;
    ordinary_terrain_gives_what_the_spec_declares: ordinary_terrain;
    tiny_and_void_terrain_never_panics: odd_terrain;
    a_cancelled_run_ends_as_cancelled: cancelled_run;
    writers_write_one_whole_file_or_say_why_not: writers;
    bands_join_to_the_whole: band_by_band;
    any_number_of_threads_gives_the_same_bits: any_number_of_threads;
    undeclared_context_does_not_count: undeclared_context;
    local_nodes_give_the_same_bits_tile_by_tile: tile_by_tile;
}

#[test]
fn ids_are_unique_and_name_their_file() {
    let mut seen = BTreeSet::new();
    for node in orograph_nodes::all() {
        assert!(seen.insert(node.spec().id.to_string()), "{} comes twice", node.spec().id);
    }
    sweep(|node| {
        let Some((family, algorithm)) = node.spec().id.split_once('.') else { return vec![] };
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src").join(family);
        let file = source.join(format!("{algorithm}.rs"));
        if file.exists() || source.join(algorithm).join("mod.rs").exists() {
            return vec![];
        }
        vec!["no file of its name in its family's folder".into()]
    });
}
