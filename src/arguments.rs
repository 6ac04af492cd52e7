//! The command line's grammar; the help texts are its manual.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;
use orograph_session::memory;

/// A node graph for terrain: deterministic, cached, scriptable to the end.
#[derive(Parser)]
#[command(name = "orograph", version, propagate_version = true, max_term_width = 100)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// What to do.
#[derive(Subcommand)]
pub(crate) enum Command {
    /// Run a graph: write its files and print its tables
    Run(RunOptions),
    /// Check graphs without running them
    Check(CheckOptions),
    /// List the node types, or tell everything about one
    Nodes(NodesOptions),
    /// Run a graph for every combination of parameter values; write a contact sheet and a table of metrics
    Sweep(SweepOptions),
    /// Print a graph: for Graphviz, or in the canonical form of a graph file
    Graph(GraphOptions),
    /// Look after the cache folder
    Cache(CacheOptions),
    /// List plugins, check one, or begin one
    Plugin(PluginCommand),
    /// Write the manual of all node types
    Manual(ManualOptions),
    /// Print a completion script for a shell
    Completions {
        /// The shell
        shell: Shell,
    },
}

/// Which plugins there are, and where they run.
#[derive(Args, Clone)]
pub(crate) struct PluginOptions {
    /// A folder of plugins; may be given many times, and goes before the folders of OROGRAPH_PLUGINS, of the settings and
    /// the user's own
    #[arg(long, value_name = "DIR")]
    pub(crate) plugins: Vec<PathBuf>,
    /// Run every plugin in a process of its own, so that what goes wrong there is its node's error
    #[arg(long)]
    pub(crate) isolate: bool,
    /// Seconds that such a plugin may neither ask whether to stop nor report progress
    #[arg(long, default_value_t = 60, value_name = "SECONDS", value_parser = clap::value_parser!(u64).range(1..=86_400))]
    pub(crate) isolate_silence: u64,
    /// Seconds that one node of such a plugin may run; by default as long as it likes
    #[arg(long, value_name = "SECONDS", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) isolate_timeout: Option<u64>,
    /// Memory that such a plugin may take beyond its inputs
    #[arg(long, default_value = "8GiB", value_name = "BYTES", value_parser = memory::parse)]
    pub(crate) isolate_memory: u64,
}

/// What fixes a graph's parameters and context.
#[derive(Args, Clone)]
pub(crate) struct GraphSettings {
    /// The graph file
    pub(crate) graph: PathBuf,
    /// Set a parameter: node.param=value, or the name of an exposed parameter; may be given many times
    #[arg(long = "set", value_name = "NAME=VALUE")]
    pub(crate) set: Vec<String>,
    /// Read parameters from a RON or JSON map of names to values; --set goes before it
    #[arg(long, value_name = "FILE")]
    pub(crate) vars: Option<PathBuf>,
}

/// How to evaluate.
#[derive(Args, Clone)]
pub(crate) struct EvaluationOptions {
    /// The run's seed
    #[arg(long, default_value_t = 0, value_name = "N", allow_negative_numbers = true)]
    pub(crate) seed: u64,
    /// Cells along the longer side that generators make, for previews
    #[arg(long, value_name = "CELLS", value_parser = clap::value_parser!(u32).range(1..=131_072))]
    pub(crate) resolution: Option<u32>,
    /// Threads; 0 is one for each core
    #[arg(long, default_value_t = 0, value_name = "N", allow_negative_numbers = true,
        value_parser = clap::value_parser!(u16).range(0..=1024))]
    pub(crate) jobs: u16,
    /// The cache folder, or `none` to keep results in memory alone; by default as the settings say, or the user's own
    #[arg(long, env = "OROGRAPH_CACHE", value_name = "DIR|none")]
    pub(crate) cache: Option<PathBuf>,
    /// Memory for results, such as 2GiB; by default as the settings say, or 8 GiB or three quarters of a smaller machine
    #[arg(long, value_name = "BYTES", value_parser = memory::parse)]
    pub(crate) memory: Option<u64>,
    /// The folder that files are written into
    #[arg(long, default_value = "out", value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Say nothing but errors
    #[arg(long, short)]
    pub(crate) quiet: bool,
    #[command(flatten)]
    pub(crate) plugins: PluginOptions,
}

#[derive(Args, Clone)]
pub(crate) struct RunOptions {
    #[command(flatten)]
    pub(crate) settings: GraphSettings,
    /// Outputs to make: a writer's name, node.port, or a named output; by default every writer and table
    pub(crate) outputs: Vec<String>,
    #[command(flatten)]
    pub(crate) evaluation: EvaluationOptions,
    /// Run the graph for every file that a pattern matches, each into a folder of its name: NAME is the parameter that names
    /// the file, the pattern may hold `*`, `?`, `[…]` and `**`, and `{stem}` in --set is the file's name up to its first dot
    #[arg(long, value_name = "NAME=PATTERN")]
    pub(crate) each: Option<String>,
    /// Print a JSON manifest of the run instead of tables; with --each one a line
    #[arg(long)]
    pub(crate) json: bool,
    /// Tell what would be computed, and compute nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Tell of every node whether it was found or computed, and why
    #[arg(long)]
    pub(crate) explain: bool,
    /// Tell how long every node took
    #[arg(long)]
    pub(crate) timings: bool,
    /// Write what ran when to this file, which chrome://tracing and Perfetto show
    #[arg(long, value_name = "FILE", conflicts_with_all = ["each", "dry_run", "watch"])]
    pub(crate) trace: Option<PathBuf>,
    /// Run again whenever the graph, a file that it reads or a plugin changes, until Ctrl-C
    #[arg(long, conflicts_with_all = ["each", "dry_run"])]
    pub(crate) watch: bool,
}

#[derive(Args)]
pub(crate) struct CheckOptions {
    /// The graph files
    #[arg(required = true)]
    pub(crate) graphs: Vec<PathBuf>,
    /// Set a parameter, as for `run`
    #[arg(long = "set", value_name = "NAME=VALUE")]
    pub(crate) set: Vec<String>,
    #[command(flatten)]
    pub(crate) plugins: PluginOptions,
}

#[derive(Args)]
pub(crate) struct NodesOptions {
    /// The node type's id; a part of one, or a word, lists those that it fits
    pub(crate) id: Option<String>,
    /// Print specs as JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) plugins: PluginOptions,
}

#[derive(Args)]
pub(crate) struct SweepOptions {
    #[command(flatten)]
    pub(crate) settings: GraphSettings,
    /// The values of one parameter: name=v1,v2,v3 or name=from..to/count; several make a grid
    #[arg(long = "param", required = true, value_name = "NAME=VALUES")]
    pub(crate) params: Vec<String>,
    /// What to collect: pictures for the sheet, tables for the metrics; by default the named outputs, and where none of
    /// them is a picture those that the graph writes
    #[arg(long = "output", value_name = "OUTPUT")]
    pub(crate) outputs: Vec<String>,
    /// Most combinations that are run
    #[arg(long, default_value_t = 1024)]
    pub(crate) limit: usize,
    /// Cells along the longer side of a picture on the sheet
    #[arg(long, default_value_t = 256, value_parser = clap::value_parser!(u32).range(16..=4096))]
    pub(crate) thumbnail: u32,
    #[command(flatten)]
    pub(crate) evaluation: EvaluationOptions,
}

#[derive(Args)]
pub(crate) struct GraphOptions {
    #[command(flatten)]
    pub(crate) settings: GraphSettings,
    /// Print the graph for Graphviz; this is the default
    #[arg(long, conflicts_with = "ron")]
    pub(crate) dot: bool,
    /// Print the graph file in canonical form; of its comments those before the graph are kept
    #[arg(long)]
    pub(crate) ron: bool,
    #[command(flatten)]
    pub(crate) plugins: PluginOptions,
}

#[derive(Args)]
pub(crate) struct PluginCommand {
    #[command(subcommand)]
    pub(crate) action: PluginAction,
}

#[derive(Subcommand)]
pub(crate) enum PluginAction {
    /// Tell of every library in the plugin folders what it supplies, or why it is refused
    List {
        #[command(flatten)]
        plugins: PluginOptions,
        /// Look at every library anew, whatever is remembered of it
        #[arg(long)]
        rescan: bool,
        /// As JSON
        #[arg(long)]
        json: bool,
    },
    /// Put a plugin through everything that a built-in node must stand, and tell what to mend
    Check {
        /// The plugin's library
        library: PathBuf,
    },
    /// Begin a plugin: a folder with a node that builds and runs
    New {
        /// Its name: the folder's, and the library's
        name: String,
        /// The language
        #[arg(long, value_enum, default_value_t = Language::Rust)]
        lang: Language,
        /// For Rust, where `orograph-plugin` lies; by default where this program was built, or else its repository
        #[arg(long, value_name = "DIR")]
        sdk: Option<PathBuf>,
    },
}

/// What a plugin is written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Language {
    /// Rust, with `orograph-plugin`
    Rust,
    /// C, with `orograph_plugin.h`
    C,
}

#[derive(Args)]
pub(crate) struct CacheOptions {
    #[command(subcommand)]
    pub(crate) action: CacheAction,
    /// The cache folder
    #[arg(long, env = "OROGRAPH_CACHE", value_name = "DIR", global = true)]
    pub(crate) cache: Option<PathBuf>,
}

#[derive(Subcommand)]
pub(crate) enum CacheAction {
    /// Tell what lies in the folder
    Stat {
        /// As JSON
        #[arg(long)]
        json: bool,
    },
    /// Remove what was unused for longest, and what dead processes left
    Gc {
        /// Bytes to keep, such as 10GiB
        #[arg(long, default_value = "10GiB", value_parser = memory::parse)]
        max: u64,
    },
    /// Remove everything
    Clear,
}

#[derive(Args)]
pub(crate) struct ManualOptions {
    /// The folder that the pages are written into
    #[arg(long, default_value = "docs/manual", value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// The folder of graphs that are run for pictures, each named after its node; without it there are none
    #[arg(long, default_value = "graphs/nodes", value_name = "DIR")]
    pub(crate) graphs: PathBuf,
    /// Write nothing; fail unless pages and pictures there are as they would be written
    #[arg(long)]
    pub(crate) check: bool,
}
