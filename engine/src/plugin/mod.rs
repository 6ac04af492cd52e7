//! Plugins: dynamic libraries that supply node types over the C ABI of `orograph-abi`.
//!
//! A library is looked at without running it, then scanned in a process of its own, then registered by what the scan
//! learnt; its code is loaded here when a node of it is first used, or never, when it runs apart ([`Limits`]).
//! Graphs name nodes alone: what is loaded is decided by the folders that the user names.

// Loading code and following its pointers is what this module is for; nothing else in the engine does it.
#![allow(unsafe_code)]

mod call;
mod examine;
mod host;
mod isolate;
mod library;
mod live;
mod node;
mod program;
mod scan;
mod store;

use std::{
    collections::BTreeMap,
    fs, io,
    path::{Path, PathBuf},
    sync::Arc,
};

use orograph_core::Digest;

pub use isolate::Limits;
pub use program::{Program, serve};

pub(crate) use {examine::examine, library::spec_in};

use crate::registry::Registry;
use isolate::Workers;
use node::{Calls, Here, Plugin};
use scan::{Scan, Scanned};
use store::Store;

/// Finds, scans and registers plugins.
pub struct Plugins {
    store: Arc<Store>,
    program: Program,
    limits: Limits,
    again: bool,
}

/// A library that was found, and what became of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// The library.
    pub path: PathBuf,
    /// Its plugin, or why it is refused.
    pub outcome: Result<Registered, String>,
}

/// A plugin whose nodes are registered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Registered {
    /// Its name.
    pub name: String,
    /// Its version.
    pub version: String,
    /// The content of its library.
    pub digest: Digest,
    /// The ids of its nodes.
    pub nodes: Vec<String>,
    /// Whether it runs in processes of its own.
    pub apart: bool,
}

impl Plugins {
    /// Plugins whose scans are remembered below `cache`, and that are looked at by `program`.
    ///
    /// # Errors
    /// When there is no folder to work in.
    pub fn new(cache: Option<&Path>, program: Program) -> io::Result<Self> {
        Ok(Self { store: Arc::new(Store::open(cache)?), program, limits: Limits::default(), again: false })
    }

    /// The same with limits for plugins that run apart.
    #[must_use]
    pub fn with_limits(self, limits: Limits) -> Self {
        Self { limits, ..self }
    }

    /// The same without remembering earlier scans.
    #[must_use]
    pub fn scanning_again(self, again: bool) -> Self {
        Self { again, ..self }
    }

    /// The libraries in a folder, by name.
    ///
    /// # Errors
    /// When the folder cannot be read.
    pub fn in_folder(folder: &Path) -> io::Result<Vec<PathBuf>> {
        let mut found = Vec::new();
        for entry in fs::read_dir(folder)? {
            let path = entry?.path();
            if examine::is_library(&path) && path.is_file() {
                found.push(path);
            }
        }
        found.sort();
        Ok(found)
    }

    /// Registers the nodes of each library that is a sound plugin, the first of two that clash going before the second.
    pub fn register(
        &self,
        libraries: &[PathBuf],
        registry: &mut Registry,
        apart: &dyn Fn(&str) -> bool,
    ) -> Vec<Found> {
        let mut suppliers = BTreeMap::new();
        let mut digests = BTreeMap::new();
        let mut found: Vec<Found> = Vec::new();
        for path in libraries {
            let outcome = match scan::scan(path, &self.store, &self.program, self.again) {
                Ok(scanned) if digests.contains_key(&scanned.digest) => {
                    let first: &PathBuf = &digests[&scanned.digest];
                    Err(format!("it is the same as {}", first.display()))
                }
                Ok(scanned) => {
                    digests.insert(scanned.digest, path.clone());
                    self.register_scanned(scanned, registry, &mut suppliers, apart)
                }
                Err(error) => Err(format!("it cannot be looked at: {error}")),
            };
            found.push(Found { path: path.clone(), outcome });
        }
        found
    }

    fn register_scanned(
        &self,
        scanned: Scanned,
        registry: &mut Registry,
        suppliers: &mut BTreeMap<String, String>,
        apart: &dyn Fn(&str) -> bool,
    ) -> Result<Registered, String> {
        let description = match scanned.scan {
            Scan::Sound(description) => description,
            Scan::Refused(reason) => return Err(reason),
        };
        let spec = &description.spec;
        for node in &spec.nodes {
            if registry.get(&node.id).is_some() {
                let supplier = suppliers.get(node.id.as_ref());
                return Err(format!(
                    "its node `{}` is there already, supplied by {}",
                    node.id,
                    supplier
                        .map_or_else(|| "Orograph itself".to_owned(), |name| format!("the plugin {name}"))
                ));
            }
        }
        let registered = Registered {
            name: spec.name.clone(),
            version: spec.version.clone(),
            digest: scanned.digest,
            nodes: spec.nodes.iter().map(|node| node.id.to_string()).collect(),
            apart: apart(&spec.name),
        };
        let calls: Box<dyn Calls> = if registered.apart {
            Box::new(Workers::new(scanned.copy, self.program.clone(), self.limits))
        } else {
            Box::new(Here::new(scanned.copy, spec.clone()))
        };
        for node_type in Plugin::new(description, calls, Arc::clone(&self.store)).node_types(&scanned.digest)
        {
            suppliers.insert(node_type.spec().id.to_string(), registered.name.clone());
            registry.register(node_type).map_err(|clash| clash.to_string())?;
        }
        Ok(registered)
    }
}
