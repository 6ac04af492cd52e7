//! `orograph plugin new`: a folder with a node that builds and runs.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use crate::{arguments::Language, console, failure::Failure};

/// The files of a new plugin: where each goes, and what stands in it before names are filled in.
type Template = &'static [(&'static str, &'static str)];

const RUST: Template = &[
    ("Cargo.toml", include_str!("../../../plugins/templates/rust/Cargo.toml.in")),
    ("src/lib.rs", include_str!("../../../plugins/templates/rust/lib.rs.in")),
    ("README.md", include_str!("../../../plugins/templates/rust/README.md.in")),
    ("graph.ron", include_str!("../../../plugins/templates/rust/graph.ron.in")),
    (".gitignore", include_str!("../../../plugins/templates/rust/gitignore.in")),
];

const C: Template = &[
    ("{{crate}}.c", include_str!("../../../plugins/templates/c/plugin.c.in")),
    ("Makefile", include_str!("../../../plugins/templates/c/Makefile.in")),
    ("README.md", include_str!("../../../plugins/templates/c/README.md.in")),
    ("graph.ron", include_str!("../../../plugins/templates/c/graph.ron.in")),
    ("orograph_plugin.h", include_str!("../../../plugins/orograph_plugin.h")),
];

pub(crate) fn run(name: &str, language: Language, sdk: Option<&Path>) -> Result<(), Failure> {
    let plain = name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || matches!(c, '-' | '_'));
    if !plain || name.len() > 64 {
        return Err(Failure::usage(
            format!("`{}` is no name for a plugin", name.escape_debug()),
            "give lower-case letters, digits and dashes, such as `coast-lines`",
        ));
    }
    let folder = PathBuf::from(name);
    if folder.exists() {
        return Err(Failure::usage(
            format!("there is a `{name}` here already"),
            "give another name, or move it away",
        ));
    }
    let sdk = dependency(sdk)?;
    let template = match language {
        Language::Rust => RUST,
        Language::C => C,
    };
    let fill = |text: &str| fill(text, name, &sdk);
    for (file, text) in template {
        let path = folder.join(fill(file));
        write(&path, &fill(text))
            .map_err(|error| Failure::Other(format!("writing {}: {error}", path.display())))?;
        console::result(&path.display().to_string());
    }
    console::note(&format!("{name}/README.md tells how to build and run it"));
    Ok(())
}

fn write(path: &Path, text: &str) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    fs::write(path, text)
}

/// Fills in names: `{{name}}` as given, `{{crate}}` with underscores, `{{family}}` as a node's family, `{{sdk}}` the
/// dependency.
fn fill(text: &str, name: &str, sdk: &str) -> String {
    let family: String = name.chars().filter(char::is_ascii_lowercase).collect();
    text.replace("{{name}}", name)
        .replace("{{crate}}", &name.replace('-', "_"))
        .replace("{{family}}", &family)
        .replace("{{sdk}}", sdk)
}

/// Where `orograph-plugin` comes from: as said, from where this program was built, or from the repository.
fn dependency(said: Option<&Path>) -> Result<String, Failure> {
    let built = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/plugins/sdk"));
    let folder = match said {
        Some(folder) if folder.join("Cargo.toml").is_file() => {
            let folder = fs::canonicalize(folder);
            Some(folder.map_err(|error| Failure::Other(format!("finding the SDK: {error}")))?)
        }
        Some(folder) => {
            return Err(Failure::usage(
                format!("{} holds no orograph-plugin", folder.display()),
                "give the folder `plugins/sdk` of a checkout",
            ));
        }
        None => built.join("Cargo.toml").is_file().then(|| built.to_owned()),
    };
    Ok(match folder {
        // A path in TOML: quotes and backslashes as in Rust.
        Some(folder) => format!("{{ path = {:?} }}", folder.display().to_string()),
        None => format!("{{ git = {:?} }}", env!("CARGO_PKG_REPOSITORY")),
    })
}
