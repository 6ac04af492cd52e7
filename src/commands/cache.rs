//! `orograph cache`: what lies in the cache folder, and keeping it small.

use orograph_engine::{DiskTier, cache::DiskStat};
use orograph_session::{Settings, memory};
use serde_json::json;

use crate::{
    arguments::{CacheAction, CacheOptions},
    console,
    failure::Failure,
};

pub(crate) fn run(options: &CacheOptions) -> Result<(), Failure> {
    let Some(folder) = Settings::load()?.cache_folder(options.cache.as_deref()) else {
        return Err(Failure::usage("there is no cache folder", "name one with --cache DIR"));
    };
    let fail =
        |error: std::io::Error| Failure::Other(format!("the cache folder {}: {error}", folder.display()));
    let disk = DiskTier::open(&folder).map_err(fail)?;
    match &options.action {
        CacheAction::Stat { json: true } => {
            let stat = disk.stat().map_err(fail)?;
            console::result(&json!({"folder": folder, "stat": stat, "bytes": stat.bytes()}).to_string());
        }
        CacheAction::Stat { json: false } => tell(&disk, &disk.stat().map_err(fail)?),
        CacheAction::Gc { max } => {
            let before = disk.stat().map_err(fail)?.bytes();
            let after = disk.collect(*max).map_err(fail)?;
            console::note(&format!("removed {}", memory::text(before.saturating_sub(after.bytes()))));
            tell(&disk, &after);
        }
        CacheAction::Clear => {
            disk.clear().map_err(fail)?;
            tell(&disk, &disk.stat().map_err(fail)?);
        }
    }
    Ok(())
}

fn tell(disk: &DiskTier, stat: &DiskStat) {
    console::result(&console::columns(&[
        vec!["folder".into(), disk.root().display().to_string()],
        vec!["values".into(), format!("{} ({})", stat.values, memory::text(stat.value_bytes))],
        vec!["records".into(), stat.records.to_string()],
        vec!["in all".into(), memory::text(stat.bytes())],
    ]));
}
