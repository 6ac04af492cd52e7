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

#include <stddef.h>
#include <stdint.h>

/* Marks what a library exports, whatever the compiler hides by default. */
#if defined(_WIN32)
#define OROGRAPH_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define OROGRAPH_EXPORT __attribute__((visibility("default")))
#else
#define OROGRAPH_EXPORT
#endif

// The major version: a host refuses a plugin of another one.
#define OROGRAPH_ABI_MAJOR 1

// The minor version: rises with every addition.
#define OROGRAPH_ABI_MINOR 0

// Heights in metres on a grid, `float`; NaN is a void. See `OrographData.raster`.
#define OROGRAPH_HEIGHTFIELD 0

// Shares from 0 to 1 on a grid, `float`. See `OrographData.raster`.
#define OROGRAPH_MASK 1

// Colours on a grid: red, green, blue and alpha, a byte each, sRGB. See `OrographData.raster`.
#define OROGRAPH_TEXTURE 2

// Ridges or valleys. See `OrographData.features`.
#define OROGRAPH_FEATURES 3

// Scattered heights. See `OrographData.points`.
#define OROGRAPH_POINTS 4

// Provenance of a synthesis. See `OrographData.placement`.
#define OROGRAPH_PLACEMENT 5

// Named metrics. See `OrographData.table`.
#define OROGRAPH_TABLE 6

// Triangles. See `OrographData.mesh`.
#define OROGRAPH_MESH 7

// A number. See `OrographData.number`.
#define OROGRAPH_NUMBER 8

// An integer. See `OrographData.integer`.
#define OROGRAPH_INTEGER 9

// True or false. See `OrographData.boolean`.
#define OROGRAPH_BOOLEAN 10

// Text; also how a choice travels. See `OrographData.text`.
#define OROGRAPH_TEXT 11

// A parameter that is a number. See `OrographSetting.number`.
#define OROGRAPH_PARAM_NUMBER 0

// A parameter that is an integer. See `OrographSetting.integer`.
#define OROGRAPH_PARAM_INTEGER 1

// A parameter that is true or false. See `OrographSetting.boolean`.
#define OROGRAPH_PARAM_BOOLEAN 2

// A parameter that is text: free text, the name of a choice's option, or a file's name as the graph writes it.
// See `OrographSetting.text`.
#define OROGRAPH_PARAM_TEXT 3

// A parameter that is a curve through points. See `OrographSetting.curve`.
#define OROGRAPH_PARAM_CURVE 4

// A parameter that is a set of polylines. See `OrographSetting.lines`.
#define OROGRAPH_PARAM_LINES 5

// The features are crests.
#define OROGRAPH_RIDGES 0

// The features are talwegs.
#define OROGRAPH_VALLEYS 1

// Three or more lines meet at the point.
#define OROGRAPH_BRANCH 0

// One line ends at the point.
#define OROGRAPH_END 1

// The point lies along a line.
#define OROGRAPH_PATH 2

// All went well.
#define OROGRAPH_OK 0

// It failed; say why with `fail` or the reply.
#define OROGRAPH_FAILED 1

// The job was cancelled and the node stopped.
#define OROGRAPH_CANCELLED 2

// The plugin's code panicked behind its own fence; say more with `fail`.
#define OROGRAPH_PANICKED 3

// A message that only who looks for faults wants to see.
#define OROGRAPH_LOG_DEBUG 0

// A message for who watches the run.
#define OROGRAPH_LOG_INFO 1

// A remark that is kept with the outputs and told again when they come from the cache.
#define OROGRAPH_LOG_WARNING 2

// UTF-8 text of `len` bytes. It is not terminated, and `data` may be null where `len` is 0.
typedef struct OrographText {
    // Its first byte.
    const char *data;
    // Its bytes.
    size_t len;
} OrographText;

// The cells of a raster and their place in the world. Rows run from north to south, columns from west to east.
//
// To give a raster on the grid of an input, hand back that input's own `grid` pointer.
typedef struct OrographGrid {
    // `sizeof(OrographGrid)`.
    uint32_t size;
    // 1 when `transform` and `crs` hold a georeference, 0 when there is none.
    uint32_t georeferenced;
    // Number of rows.
    uint64_t rows;
    // Number of columns.
    uint64_t cols;
    // Row of the base grid that is this grid's row 0: a crop keeps its base grid.
    int64_t row0;
    // Column of the base grid that is this grid's column 0.
    int64_t col0;
    // Metres from one column to the next.
    double cell_x;
    // Metres from one row to the next; cells need not be square.
    double cell_y;
    // World x (east) of the centre of the base grid's first cell, in metres.
    double origin_x;
    // World y (north) of the centre of the base grid's first cell, in metres.
    double origin_y;
    // Affine transform from (column, row) of the base grid's cell corners to the coordinate system:
    // `x = t[0] + t[1] col + t[2] row`, `y = t[3] + t[4] col + t[5] row`.
    double transform[6];
    // The coordinate reference system: `EPSG:n`, or the source's own text.
    struct OrographText crs;
} OrographGrid;

// One value for each cell of a grid, row by row, without gaps.
typedef struct OrographRaster {
    // `sizeof(OrographRaster)`.
    uint32_t size;
    // 0.
    uint32_t reserved;
    // Where the cells lie.
    const struct OrographGrid *grid;
    // `rows * cols` cells: `float` in a heightfield or a mask, 4 bytes in a texture. Null when there is none.
    const void *cells;
} OrographRaster;

// A point of a network of features.
typedef struct OrographFeaturePoint {
    // Fractional row.
    double row;
    // Fractional column.
    double col;
    // Height in metres.
    float height;
    // `OROGRAPH_BRANCH`, `OROGRAPH_END` or `OROGRAPH_PATH`.
    int32_t kind;
} OrographFeaturePoint;

// A line between two points of a network.
typedef struct OrographLine {
    // Index of the point where it starts.
    uint32_t from;
    // Index of the point where it ends.
    uint32_t to;
    // Number of vertices, both ends included.
    size_t vertex_count;
    // Fractional (row, column) of the vertices.
    const double (*vertices)[2];
    // Number of profile samples: `vertex_count * profile_len`, or 0 when there are none.
    size_t profile_count;
    // Heights across the line, `profile_len` for each vertex.
    const float *profiles;
} OrographLine;

// A forest of ridges or valleys on a grid.
typedef struct OrographFeatures {
    // `sizeof(OrographFeatures)`.
    uint32_t size;
    // `OROGRAPH_RIDGES` or `OROGRAPH_VALLEYS`.
    int32_t kind;
    // The grid that rows and columns refer to.
    const struct OrographGrid *grid;
    // Number of points.
    size_t point_count;
    // The points.
    const struct OrographFeaturePoint *points;
    // Number of lines.
    size_t line_count;
    // The lines between the points.
    const struct OrographLine *lines;
    // Number of rings.
    size_t ring_count;
    // Pairs of end points that face each other where a closed ring was opened.
    const uint32_t (*rings)[2];
    // Side, in cells of the grid, of the working cells that the lines were found on.
    double scale;
    // Distance in cells between samples of a profile.
    double profile_step;
    // Samples in each profile.
    uint32_t profile_len;
    // 0.
    uint32_t reserved;
} OrographFeatures;

// Scattered heights.
typedef struct OrographPoints {
    // `sizeof(OrographPoints)`.
    uint32_t size;
    // 0.
    uint32_t reserved;
    // Number of points.
    size_t count;
    // World x of each, in metres.
    const double *x;
    // World y of each, in metres.
    const double *y;
    // Height of each, in metres.
    const double *heights;
} OrographPoints;

// One pasted patch of a synthesis.
typedef struct OrographPatch {
    // Which exemplar it came from.
    uint32_t exemplar;
    // Side of its square window, in cells.
    uint32_t window;
    // 1 when the source is reflected in x, else 0.
    uint32_t mirrored;
    // 0.
    uint32_t reserved;
    // Row and column of its centre in the exemplar.
    double source_center[2];
    // Row and column of its centre in the output.
    double target_center[2];
    // Added to the source's heights, in metres.
    double offset;
    // Number of control points.
    size_t control_count;
    // Control points (target row, target column, source row, source column) of its warp.
    const double (*controls)[4];
} OrographPatch;

// Which patch went where.
typedef struct OrographPlacement {
    // `sizeof(OrographPlacement)`.
    uint32_t size;
    // 0.
    uint32_t reserved;
    // The grid of the output.
    const struct OrographGrid *grid;
    // Number of exemplars.
    size_t scale_count;
    // For each exemplar how many rows and columns synthesis made of one of its own.
    const double (*scales)[2];
    // Number of patches.
    size_t patch_count;
    // The patches in the order in which they were pasted.
    const struct OrographPatch *patches;
    // Per cell: index of its patch plus one, 0 for none.
    const uint32_t *labels;
    // Per cell: row and column in the exemplar.
    const float (*sources)[2];
    // Number of cut edges.
    size_t seam_count;
    // Cut edges: indices of the two adjacent cells.
    const uint32_t (*seams)[2];
} OrographPlacement;

// A column of a table: numbers or texts, the other pointer being null.
typedef struct OrographColumn {
    // Its name, in snake case.
    struct OrographText name;
    // The unit of its numbers: `1`, `m`, `deg`, `cells`, `px`, `%`, `seed`, `m/m`, `1/m`, `m2`, `B` or `s`.
    struct OrographText unit;
    // One number for each row, NaN for none; or null.
    const double *numbers;
    // One text for each row; or null.
    const struct OrographText *texts;
} OrographColumn;

// Named columns of equal length.
typedef struct OrographTable {
    // `sizeof(OrographTable)`.
    uint32_t size;
    // 0.
    uint32_t reserved;
    // Number of columns.
    size_t column_count;
    // Number of rows.
    size_t row_count;
    // The columns.
    const struct OrographColumn *columns;
} OrographTable;

// A triangle mesh in metres, x east, y north, z up.
typedef struct OrographMesh {
    // `sizeof(OrographMesh)`.
    uint32_t size;
    // 0.
    uint32_t reserved;
    // Number of vertices.
    size_t vertex_count;
    // Positions.
    const float (*vertices)[3];
    // Unit normals, one for each vertex, or null.
    const float (*normals)[3];
    // Texture coordinates from 0 to 1, one for each vertex, or null.
    const float (*uvs)[2];
    // Number of triangles.
    size_t triangle_count;
    // Vertex indices, counter-clockwise seen from above.
    const uint32_t (*triangles)[3];
} OrographMesh;

// What a value is: the member that goes with its kind.
typedef union OrographData {
    // Of a heightfield, a mask or a texture.
    const struct OrographRaster *raster;
    // Of features.
    const struct OrographFeatures *features;
    // Of points.
    const struct OrographPoints *points;
    // Of a placement.
    const struct OrographPlacement *placement;
    // Of a table.
    const struct OrographTable *table;
    // Of a mesh.
    const struct OrographMesh *mesh;
    // Of a number.
    double number;
    // Of an integer.
    int64_t integer;
    // Of a boolean: 0 is false, everything else true.
    int32_t boolean;
    // Of text.
    struct OrographText text;
} OrographData;

// A value on a wire.
typedef struct OrographValue {
    // `OROGRAPH_HEIGHTFIELD` to `OROGRAPH_TEXT`.
    int32_t kind;
    // 0.
    uint32_t reserved;
    // The value.
    union OrographData data;
} OrographValue;

// What is connected to an input port.
typedef struct OrographInput {
    // Number of wires: 1, 0 where an optional port is not connected, any number at a port that takes many.
    size_t count;
    // The values on them.
    const struct OrographValue *values;
} OrographInput;

// Points of a curve.
typedef struct OrographCurve {
    // Number of points, at least one.
    size_t count;
    // The points (x, y), x ascending.
    const double (*points)[2];
} OrographCurve;

// A polyline.
typedef struct OrographPolyline {
    // Number of vertices.
    size_t count;
    // Vertices (x, y, height).
    const double (*vertices)[3];
} OrographPolyline;

// A set of polylines.
typedef struct OrographLines {
    // Number of polylines.
    size_t count;
    // The polylines.
    const struct OrographPolyline *lines;
} OrographLines;

// What a parameter is set to: the member that goes with its kind.
typedef union OrographSetting {
    // Of a number, within its hard range.
    double number;
    // Of an integer, within its hard range.
    int64_t integer;
    // Of a boolean: 0 or 1.
    int32_t boolean;
    // Of text, an option or a file's name.
    struct OrographText text;
    // Of a curve.
    struct OrographCurve curve;
    // Of lines.
    struct OrographLines lines;
} OrographSetting;

// A parameter's value.
typedef struct OrographParam {
    // `OROGRAPH_PARAM_NUMBER` to `OROGRAPH_PARAM_LINES`, as the spec says.
    int32_t kind;
    // 0.
    uint32_t reserved;
    // The value.
    union OrographSetting value;
} OrographParam;

// The host's functions. The table is valid for as long as the plugin is loaded.
typedef struct OrographHost {
    // `sizeof(OrographHost)` of the host: a function beyond it is not there.
    uint32_t size;
    // `OROGRAPH_ABI_MAJOR` of the host.
    uint32_t abi_major;
    // `OROGRAPH_ABI_MINOR` of the host.
    uint32_t abi_minor;
    // 0.
    uint32_t reserved;
    // Whether to stop: 1 once the run was cancelled. Ask at least every few milliseconds of work, and return
    // `OROGRAPH_CANCELLED` when it says so. From any thread.
    int32_t (*cancelled)(uint64_t job);
    // Tells how much of the work is done, from 0 to 1. From any thread.
    void (*progress)(uint64_t job, double done);
    // Tells the user something; `level` is `OROGRAPH_LOG_DEBUG`, `OROGRAPH_LOG_INFO` or `OROGRAPH_LOG_WARNING`.
    // The message is copied. From any thread.
    void (*log)(uint64_t job, int32_t level, struct OrographText message);
    // Says why the job fails, and what the user can do about it, before `run` returns `OROGRAPH_FAILED`. Both are
    // copied; `hint` may be empty. The first call counts. From any thread.
    void (*fail)(uint64_t job, struct OrographText message, struct OrographText hint);
    // Hands over the value of output port `port`, once for each port of the spec, in any order. All that it points to
    // is copied before this returns. Gives `OROGRAPH_OK`, or `OROGRAPH_FAILED` when the value is refused; then the
    // job has failed, and the host knows why. From any thread.
    int32_t (*output)(uint64_t job, uint32_t port, const struct OrographValue *value);
    // Gives the host's side of a named extension: an `OrographThreads` for `orograph.threads/1`, an `OrographScratch`
    // for `orograph.scratch/1`, an `OrographFiles` for `orograph.files/1`; or null where the host has none of that
    // name. `name` is terminated. What it gives is valid for as long as the plugin is loaded. From any thread.
    const void *(*extension)(const char *name);
} OrographHost;

// One run of one node.
typedef struct OrographJob {
    // `sizeof(OrographJob)` of the host: a field beyond it is not there.
    uint32_t size;
    // Which node to run: its index in the list that `describe` gives.
    uint32_t node;
    // The job's name in calls of host functions.
    uint64_t id;
    // The host's functions.
    const struct OrographHost *host;
    // Number of parameters, as the spec says.
    size_t param_count;
    // The parameters in the spec's order.
    const struct OrographParam *params;
    // Number of input ports, as the spec says.
    size_t input_count;
    // The input ports in the spec's order.
    const struct OrographInput *inputs;
    // The run's seed; 0 unless the spec says that the node reads it.
    uint64_t seed;
    // Cells along the longer side that generators should make; 0 unless the spec says that the node reads it and
    // the run sets it.
    uint32_t resolution;
    // 0.
    uint32_t reserved;
    // The most bytes that one value may take.
    uint64_t memory_limit;
} OrographJob;

// What a plugin exports, as a constant named `orograph_plugin`.
typedef struct OrographPlugin {
    // `sizeof(OrographPlugin)`.
    uint32_t size;
    // `OROGRAPH_ABI_MAJOR` of the header that it was built with.
    uint32_t abi_major;
    // `OROGRAPH_ABI_MINOR` of the header that it was built with.
    uint32_t abi_minor;
    // 0.
    uint32_t reserved;
    // Gives the plugin's name, version and nodes as RON text, which must stay valid and the same for as long as
    // the plugin is loaded. Called from any thread.
    struct OrographText (*describe)(void);
    // Runs a node: reads the job's parameters and inputs, hands each output to `host->output`, and returns
    // `OROGRAPH_OK`, `OROGRAPH_FAILED`, `OROGRAPH_CANCELLED` or `OROGRAPH_PANICKED`. The job and all that it
    // points to are valid until it returns. Called from any thread, and from several at once; equal jobs must
    // give equal outputs to the bit. No exception may leave it.
    int32_t (*run)(const struct OrographJob *job);
    // Gives the plugin's side of a named extension, such as an `OrographSettings` for `orograph.settings/1`, valid
    // for as long as the plugin is loaded; or null. `name` is terminated. May be null itself. Called from any thread.
    const void *(*extension)(const char *name);
} OrographPlugin;

// The host's extension `orograph.threads/1`: its thread pool.
typedef struct OrographThreads {
    // `sizeof(OrographThreads)`.
    uint32_t size;
    // 0.
    uint32_t reserved;
    // How many threads the run may use, at least 1. From any thread.
    uint32_t (*count)(uint64_t job);
    // Calls `body(context, i)` once for each `i` below `count`, on the host's threads, in any order and several at
    // once, and returns when all calls have. A result must not depend on their order. Called from the thread that
    // `run` was called on or from inside another `body`; from elsewhere the calls come one after the other.
    // `body` must not be null; no exception may leave it.
    void (*parallel_for)(uint64_t job, size_t count, void *context, void (*body)(void *context, size_t index));
} OrographThreads;

// The host's extension `orograph.scratch/1`: memory that the host counts and frees at the end of the job.
typedef struct OrographScratch {
    // `sizeof(OrographScratch)`.
    uint32_t size;
    // 0.
    uint32_t reserved;
    // Gives `bytes` of zeroed memory, aligned to 64 bytes, until the job ends or `free`; null where the run may not
    // take as much. From any thread.
    void *(*allocate)(uint64_t job, size_t bytes);
    // Gives memory back before the job ends. A pointer that `allocate` did not give is ignored. From any thread.
    void (*free)(uint64_t job, void *memory);
} OrographScratch;

// The host's extension `orograph.files/1`: the files that the node's parameters name.
typedef struct OrographFiles {
    // `sizeof(OrographFiles)`.
    uint32_t size;
    // 0.
    uint32_t reserved;
    // Where the file of a parameter of kind `InputPath` lies: `name` is the parameter's text, `path` becomes an
    // absolute path in the system's own form, valid until the job ends. Gives `OROGRAPH_OK`, or `OROGRAPH_FAILED`
    // when there is no such file; then the host knows why, and the node may just return `OROGRAPH_FAILED`. The
    // content of the file counts in the node's key, so a node must read no other files. From any thread.
    int32_t (*input_path)(uint64_t job, struct OrographText name, struct OrographText *path);
} OrographFiles;

// Takes a plugin's answer to a question about settings.
typedef struct OrographReply {
    // To be handed back to `put`.
    void *context;
    // Copies an answer: for a refusal its message and hint, for new parameters their text and nothing. Called from
    // the thread that was asked, before it returns.
    void (*put)(void *context, struct OrographText text, struct OrographText hint);
} OrographReply;

// The plugin's extension `orograph.settings/1`: what a node knows of its settings without running. Any function may
// be null. All are called from any thread, and from several at once.
typedef struct OrographSettings {
    // `sizeof(OrographSettings)`.
    uint32_t size;
    // 0.
    uint32_t reserved;
    // Checks settings against each other, after the host has checked each against its range. `OROGRAPH_OK`, or
    // `OROGRAPH_FAILED` after a `put` of message and hint.
    int32_t (*check)(uint32_t node,
                     size_t param_count,
                     const struct OrographParam *params,
                     const struct OrographReply *reply);
    // For a node of extent `Local`: how many cells beyond its own position an output cell looks, on cells of this
    // size in metres. 0 where it is null.
    uint64_t (*halo)(uint32_t node,
                     size_t param_count,
                     const struct OrographParam *params,
                     double cell_x,
                     double cell_y);
    // Rough work per cell relative to copying it; weighs the progress display. 1 where it is null.
    double (*cost)(uint32_t node, size_t param_count, const struct OrographParam *params);
    // Lifts parameters of version `from` of the node to its own version. `params` is a RON map from name to value,
    // such as `{"strength": Number(0.5)}`; the new map is `put` as text. `OROGRAPH_OK`, or `OROGRAPH_FAILED` after a
    // `put` of message and hint. Where it is null, parameters keep name and meaning.
    int32_t (*upgrade)(uint32_t node,
                       uint32_t from,
                       struct OrographText params,
                       const struct OrographReply *reply);
} OrographSettings;

// Name of an extension: the host's, an OrographThreads.
#define OROGRAPH_THREADS "orograph.threads/1"

// Name of an extension: the host's, an OrographScratch.
#define OROGRAPH_SCRATCH "orograph.scratch/1"

// Name of an extension: the host's, an OrographFiles.
#define OROGRAPH_FILES "orograph.files/1"

// Name of an extension: the plugin's, an OrographSettings.
#define OROGRAPH_SETTINGS "orograph.settings/1"

// What a plugin defines.
#ifdef __cplusplus
extern "C" {
#endif
extern OROGRAPH_EXPORT const OrographPlugin orograph_plugin;
#ifdef __cplusplus
}
#endif

#endif // OROGRAPH_PLUGIN_H
