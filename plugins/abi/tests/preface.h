/*
 * The C ABI of Orograph plugins, version 1.0.
 *
 * A plugin is a dynamic library that exports one constant, `orograph_plugin`. This header is all that it needs: it
 * links with nothing. What is here is frozen: a plugin built with this header loads in every 1.x.
 *
 *     static OrographText describe(void) { ... }
 *     static int32_t run(const OrographJob *job) { ... }
 *     const OrographPlugin orograph_plugin = {
 *         .size = sizeof(OrographPlugin), .abi_major = OROGRAPH_ABI_MAJOR, .abi_minor = OROGRAPH_ABI_MINOR,
 *         .describe = describe, .run = run,
 *     };
 *
 * How it goes
 *     The host loads the library once, never unloads it, and calls `describe` for the specs of its nodes, in RON.
 *     Then it calls `run` for each computation. `run` reads the job's parameters and inputs, hands each output to
 *     `host->output`, and returns a status. When it fails, it tells why through `host->fail` before it returns.
 *
 * Threads
 *     `run` and all other functions of a plugin are called from any thread, and from several at once, so a plugin
 *     keeps no state that is not guarded. The host's functions may be called from any thread of the plugin too, and
 *     from several at once, except where a function says otherwise. No thread of the plugin may use a job after its
 *     `run` has returned. If one calls a host function all the same, the call is ignored, or answered as if the job
 *     had been cancelled: jobs are named by number, and no number comes twice.
 *
 * Lifetimes
 *     A job, and all that its parameters and inputs point to, is there and unchanged from the call of `run` until it
 *     returns, and must not be written to. What an output points to need only be there until `host->output` returns,
 *     which copies it. Texts given to the host are copied before the call returns. The host's tables of functions are
 *     there for as long as the library is loaded, which is until the process ends.
 *
 * Equal bits
 *     Equal parameters, inputs, files, seed and resolution must give equal outputs to the bit, on any number of threads:
 *     results are cached by them. So no clock, no environment, no files but those that parameters name, and no sums
 *     in an order that threads decide. Compile without `-ffast-math`.
 *
 * Growth
 *     Structs begin with their size in bytes and grow at their end. A host and a plugin that were built with different
 *     minor versions look only at what both have. Everything else grows by extensions, which are asked for by name. Set
 *     every field called `reserved` to 0.
 *
 * Text
 *     Text is UTF-8 with a length, not terminated. Only the names of extensions are terminated.
 *
 * Specs
 *     `describe` gives the plugin's name and version, for people, and its nodes. This one shows every kind of
 *     parameter; fields marked with their default may be left out:
 *
 *     (name: "Rocks", version: "1.2.0", nodes: [(
 *         id: "erosion.rocks",        // `family.algorithm`, in snake case; never changes
 *         version: 1,                 // raise it whenever equal inputs may give other outputs
 *         doc: "What it does. The first sentence is its tooltip.",
 *         inputs: [                   // default: none
 *             (name: "terrain", doc: "Terrain to erode.", value_type: Heightfield),
 *             (name: "where", doc: "Where to.", value_type: Mask, arity: Optional), // One (default), Optional, Many
 *         ],
 *         outputs: [                  // value types: Heightfield, Mask, Texture, Features, Points, Placement, Table,
 *                                     // Mesh, Number, Integer, Boolean, Text
 *             (name: "terrain", doc: "Eroded terrain.", value_type: Heightfield),
 *         ],
 *         params: [                   // default: none
 *             (name: "talus", doc: "Steepest slope that stays.", unit: Degree,
 *              kind: Number(range: (0.0, 89.0), slider: (20.0, 50.0)), default: Number(35.0)),
 *             (name: "passes", doc: "How often.", kind: Integer(range: (1, 1000), slider: (1, 100)), default: Integer(20)),
 *             (name: "loose", doc: "Whether rocks roll.", kind: Boolean, default: Boolean(true)),
 *             (name: "label", doc: "A text.", kind: Text, default: Text("")),
 *             (name: "rock", doc: "Which rock.", kind: Choice(options: [
 *                 (name: "granite", doc: "Hard."), (name: "chalk", doc: "Soft."),
 *             ]), default: Text("granite")),
 *             (name: "table", doc: "A file to read.", kind: InputPath, default: Text("")),
 *             (name: "profile", doc: "A curve.", kind: Curve(x: (0.0, 1.0), y: (0.0, 1.0)),
 *              default: Curve([(0.0, 0.0), (1.0, 1.0)])),
 *             (name: "faults", doc: "Polylines of (x, y, height).", unit: Metre, kind: Lines(range: (-1e9, 1e9)),
 *              default: Lines([[(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)]])),
 *         ],
 *         extent: Global,             // Local: each output cell looks at cells near it alone, see `OrographSettings.halo`;
 *                                     // Global: any cell may depend on any other
 *         reads: [Seed, Resolution],  // what of the run's context the job shows it; default: nothing
 *     )])
 *
 *     Units: One (default), Metre, Degree, Cell, Pixel, Percent, Seed, Gradient, PerMetre, SquareMetre, Byte, Second.
 *     Ranges are hard: the host refuses values outside before the node runs. Sliders only suggest.
 *     Names of nodes, ports and parameters are written in graphs: they are promises.
 *
 * Generated from the crate `orograph-abi`. Change that, not this file.
 */

#ifndef OROGRAPH_PLUGIN_H
#define OROGRAPH_PLUGIN_H
