//! A plugin's library in this process.

use std::{ffi::c_void, path::Path, ptr};

use libloading::Library as Dynamic;
use orograph_abi::{
    ENTRY, OROGRAPH_ABI_MAJOR, OrographPlugin, OrographSettings, PluginSpec, SETTINGS, read_text,
};

/// A loaded plugin. It is never unloaded: threads, exit handlers and texts of it may live on.
#[derive(Debug)]
pub(crate) struct Library {
    pub(super) entry: &'static OrographPlugin,
    pub(super) settings: Option<&'static OrographSettings>,
    pub(super) spec: PluginSpec,
}

/// A spec of more bytes than this is a mistake or an attack.
pub(super) const MOST_TEXT: usize = 16 << 20;

impl Library {
    /// Loads the library and reads what it says of itself.
    ///
    /// # Errors
    /// A line that says why it is no plugin of this ABI.
    pub(crate) fn load(path: &Path) -> Result<Self, String> {
        // SAFETY: loading runs code that the user installed as a plugin; what it does is not ours to vouch for.
        let dynamic =
            unsafe { Dynamic::new(path) }.map_err(|error| format!("it does not load: {}", cause(&error)))?;
        // SAFETY: the symbol's address is taken; what lies there is checked below.
        let entry = unsafe { dynamic.get::<*const OrographPlugin>(ENTRY) }.map(|symbol| *symbol);
        std::mem::forget(dynamic);
        let entry = entry.map_err(|_| format!("it exports no `{}`", ENTRY.to_string_lossy()))?;
        // SAFETY: the constant lies in a library that stays loaded.
        let entry = unsafe { checked(entry) }?;
        let spec = describe(entry)?;
        let settings = entry.extension.map_or(ptr::null(), |extension| {
            // SAFETY: the name is terminated, as the ABI says.
            unsafe { extension(SETTINGS.as_ptr()) }
        });
        // SAFETY: as the ABI says, the extension is null or of this type and stays.
        let settings = unsafe { sized_extension::<OrographSettings>(settings) }?;
        Ok(Self { entry, settings, spec })
    }
}

/// The error's own words and those of its source.
fn cause(error: &libloading::Error) -> String {
    use std::error::Error;
    error.source().map_or_else(|| error.to_string(), ToString::to_string)
}

/// # Safety
/// `entry` must be null or lead to the plugin's constant.
unsafe fn checked(entry: *const OrographPlugin) -> Result<&'static OrographPlugin, String> {
    if entry.is_null() || !entry.is_aligned() {
        return Err("its `orograph_plugin` is no constant of the ABI".into());
    }
    // SAFETY: the first fields have stood there in every version of the ABI.
    let (size, major, minor) = unsafe { ((*entry).size, (*entry).abi_major, (*entry).abi_minor) };
    if major != OROGRAPH_ABI_MAJOR {
        return Err(format!(
            "it was built for ABI {major}.{minor}, and this is ABI {OROGRAPH_ABI_MAJOR}: get a build of it for this one"
        ));
    }
    if (size as usize) < size_of::<OrographPlugin>() {
        return Err(format!(
            "its `orograph_plugin` says that it has {size} bytes, but needs {}",
            size_of::<OrographPlugin>()
        ));
    }
    // SAFETY: not null, aligned, and as large as it needs.
    let entry = unsafe { &*entry };
    if entry.run.is_none() {
        return Err("its `run` is a null pointer".into());
    }
    Ok(entry)
}

fn describe(entry: &OrographPlugin) -> Result<PluginSpec, String> {
    let describe = entry.describe.ok_or("its `describe` is a null pointer")?;
    // SAFETY: a function of the plugin, called as the ABI says.
    let text = unsafe { describe() };
    if text.len > MOST_TEXT {
        return Err(format!("its spec is {} bytes long, more than the {MOST_TEXT} allowed", text.len));
    }
    // SAFETY: the text stays for as long as the plugin is loaded, as the ABI says.
    let text = unsafe { read_text(text) }.map_err(|malformed| format!("its spec: {}", malformed.0))?;
    spec_in(text)
}

/// The spec that a plugin gives as text.
///
/// # Errors
/// A line that says why nodes cannot be made of it.
pub(crate) fn spec_in(text: &str) -> Result<PluginSpec, String> {
    let spec: PluginSpec =
        ron::from_str(text).map_err(|error| format!("its spec is no RON of a plugin: {error}"))?;
    check(&spec)?;
    Ok(spec)
}

/// Whether the nodes can be used.
fn check(spec: &PluginSpec) -> Result<(), String> {
    if spec.name.trim().is_empty() {
        return Err("its spec gives no name".into());
    }
    if spec.nodes.is_empty() {
        return Err("it has no nodes".into());
    }
    for (index, node) in spec.nodes.iter().enumerate() {
        if spec.nodes[..index].iter().any(|earlier| earlier.id == node.id) {
            return Err(format!("two of its nodes are named `{}`", node.id));
        }
        if node.writes {
            return Err(format!(
                "its node `{}` writes files, which ABI 1.0 has no way for: give an output, and let a writer write it",
                node.id
            ));
        }
        if let Some(complaint) = node.complaints().first() {
            return Err(format!("its node `{}`: {complaint}", node.id));
        }
    }
    Ok(())
}

/// # Safety
/// `place` must be null or lead to a struct that begins with its size and is a `T` or what `T` became.
unsafe fn sized_extension<T>(place: *const c_void) -> Result<Option<&'static T>, String> {
    if place.is_null() {
        return Ok(None);
    }
    // SAFETY: as the caller vouches.
    let size = unsafe { *place.cast::<u32>() } as usize;
    if !place.cast::<T>().is_aligned() || size < size_of::<T>() {
        return Err(format!(
            "one of its extensions says that it has {size} bytes, but needs {}",
            size_of::<T>()
        ));
    }
    // SAFETY: as large as it needs.
    Ok(Some(unsafe { &*place.cast() }))
}
