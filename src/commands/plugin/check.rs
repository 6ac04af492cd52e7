//! `orograph plugin check`: a plugin put through everything that a built-in node must stand.

use std::{path::Path, time::Duration};

use orograph_contract::{CHECKS, Check, limits_of_settings, tile_by_tile};
use orograph_engine::plugin::{Found, Limits};
use orograph_session::{Settings, plugins};

use crate::{console, failure::Failure};

/// What is asked of plugins beyond what every node is asked.
const MORE: [(&str, Check); 2] = [
    ("the same bits tile by tile", tile_by_tile),
    ("settings at the ends of their ranges", limits_of_settings),
];

pub(crate) fn run(library: &Path) -> Result<(), Failure> {
    // It is tried in processes of its own, so that the worst ends no more than a line of this list.
    let limits =
        Limits { silence: Duration::from_secs(20), time: Some(Duration::from_secs(120)), memory: 2 << 30 };
    let cache = Settings::load()?.cache_folder(None);
    let plugins = plugins::plugins(cache.as_deref(), limits)?.scanning_again(true);
    let mut registry = orograph_session::built_in()?;
    let found = plugins.register(&[library.to_owned()], &mut registry, &|_| true);
    let Some(Found { outcome, .. }) = found.into_iter().next() else { return Ok(()) };
    let plugin = outcome.map_err(|reason| {
        Failure::usage(format!("{}: {reason}", library.display()), "mend that first: no host takes it so")
    })?;
    console::result(&format!("{} {}: {}", plugin.name, plugin.version, library.display()));
    let mut faults = 0;
    for node_type in plugin.nodes.iter().filter_map(|id| registry.get(id)) {
        console::result(&format!("{}:", node_type.spec().id));
        for (about, check) in CHECKS.into_iter().chain(MORE) {
            let complaints = check(node_type);
            faults += complaints.len();
            if complaints.is_empty() {
                console::result(&format!("  ok   {about}"));
            }
            for complaint in complaints {
                console::result(&format!("  MEND {about}: {complaint}"));
            }
        }
    }
    if faults == 0 {
        return Ok(());
    }
    Err(Failure::Other(format!("{faults} things to mend")))
}
