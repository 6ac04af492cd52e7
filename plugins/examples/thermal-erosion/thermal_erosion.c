/*
 * Thermal erosion: what is steeper than the talus angle breaks off and comes to rest below.
 *
 * Method: Musgrave, Kolb & Mace (1989), "The synthesis and rendering of eroded fractal terrains", section 4. In each
 * pass a cell gives material to those of its eight neighbours that lie below its talus slope, in proportion to how far
 * below they lie.
 *
 * Departures: all cells give at once, from the heights that the pass began with, so that neither the order of cells
 * nor the number of threads counts; distances are metres, so cells need not be square and diagonals are longer;
 * a mask of hard rock may hold material back.
 */

#include "orograph_plugin.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define TEXT(literal) {literal, sizeof(literal) - 1}

/* In the order of the spec below. */
enum { PARAM_TALUS, PARAM_RATE, PARAM_PASSES };
enum { INPUT_TERRAIN, INPUT_HARDNESS };
enum { OUTPUT_TERRAIN, OUTPUT_MOVED };

static const char SPEC[] =
    "(name: \"Thermal erosion\", version: \"1.0.0\", nodes: [(\n"
    "    id: \"erosion.thermal\", version: 1,\n"
    "    doc: \"Breaks off what is steeper than the talus angle and lets it come to rest below. Cliffs become even\n"
    "slopes of scree. Voids stay voids and neither give nor take, and nothing leaves at the borders.\",\n"
    "    inputs: [\n"
    "        (name: \"terrain\", doc: \"Terrain to erode.\", value_type: Heightfield),\n"
    "        (name: \"hardness\", doc: \"How firmly the rock holds: 0 gives way at the full rate, 1 never. Soft\n"
    "everywhere when unconnected.\", value_type: Mask, arity: Optional),\n"
    "    ],\n"
    "    outputs: [\n"
    "        (name: \"terrain\", doc: \"Eroded terrain.\", value_type: Heightfield),\n"
    "        (name: \"moved\", doc: \"Metres laid down, negative where rock broke off; void on voids.\",\n"
    "         value_type: Heightfield),\n"
    "    ],\n"
    "    params: [\n"
    "        (name: \"talus\", doc: \"The steepest slope that loose rock rests at.\", unit: Degree,\n"
    "         kind: Number(range: (0.0, 89.0), slider: (20.0, 50.0)), default: Number(35.0)),\n"
    "        (name: \"rate\", doc: \"Which share of the height above the talus slope breaks off in a pass.\",\n"
    "         kind: Number(range: (0.0, 0.5), slider: (0.1, 0.5)), default: Number(0.5)),\n"
    "        (name: \"passes\", doc: \"How often rock breaks off. Scree spreads by at most one cell in each pass.\",\n"
    "         kind: Integer(range: (0, 100000), slider: (1, 500)), default: Integer(100)),\n"
    "    ],\n"
    "    extent: Global,\n"
    ")])\n";

static OrographText describe(void) {
    OrographText text = TEXT(SPEC);
    return text;
}

/* One pass over the raster. Rows are shared out among threads; each writes rows of its own alone. */
typedef struct {
    const OrographJob *job;
    const float *hardness; /* or null */
    ptrdiff_t rows, cols;
    double distance[3][3]; /* metres to the neighbours */
    double gradient;       /* metres of height per metre that rest */
    double rate;
    const float *from; /* heights before the pass */
    float *to;         /* heights after it */
    float *given;      /* metres that each cell gives away in this pass */
    float *excess;     /* sum of how far its neighbours lie below its talus slope */
} Pass;

static int cancelled(const OrographJob *job) {
    return job->host->cancelled(job->id);
}

/* How far the neighbour lies below the talus slope of the cell; 0 where it does not, or where either is a void. */
static double excess_of(const Pass *pass, double here, double there, double distance) {
    double excess = here - there - pass->gradient * distance;
    return excess > 0.0 ? excess : 0.0; /* false for NaN */
}

/* First half: what every cell of a row gives. */
static void give(void *context, size_t index) {
    const Pass *pass = context;
    if (cancelled(pass->job)) {
        return;
    }
    ptrdiff_t row = (ptrdiff_t)index, cols = pass->cols;
    ptrdiff_t top = row > 0 ? row - 1 : row, bottom = row + 1 < pass->rows ? row + 1 : row;
    for (ptrdiff_t col = 0; col < cols; col++) {
        ptrdiff_t left = col > 0 ? col - 1 : col, right = col + 1 < cols ? col + 1 : col;
        ptrdiff_t cell = row * cols + col;
        double sum = 0.0, most = 0.0;
        for (ptrdiff_t r = top; r <= bottom; r++) {
            for (ptrdiff_t c = left; c <= right; c++) {
                /* The cell itself lies nowhere below itself. */
                double distance = pass->distance[r - row + 1][c - col + 1];
                double excess = excess_of(pass, pass->from[cell], pass->from[r * cols + c], distance);
                sum += excess;
                most = excess > most ? excess : most;
            }
        }
        double soft = pass->hardness ? 1.0 - (double)pass->hardness[cell] : 1.0;
        pass->given[cell] = (float)(pass->rate * most * soft);
        pass->excess[cell] = (float)sum;
    }
}

/* Second half: what every cell of a row has in the end. */
static void take(void *context, size_t index) {
    const Pass *pass = context;
    if (cancelled(pass->job)) {
        return;
    }
    ptrdiff_t row = (ptrdiff_t)index, cols = pass->cols;
    ptrdiff_t top = row > 0 ? row - 1 : row, bottom = row + 1 < pass->rows ? row + 1 : row;
    for (ptrdiff_t col = 0; col < cols; col++) {
        ptrdiff_t left = col > 0 ? col - 1 : col, right = col + 1 < cols ? col + 1 : col;
        ptrdiff_t cell = row * cols + col;
        double change = -(double)pass->given[cell];
        for (ptrdiff_t r = top; r <= bottom; r++) {
            for (ptrdiff_t c = left; c <= right; c++) {
                ptrdiff_t other = r * cols + c;
                if (pass->given[other] > 0.0f) {
                    double distance = pass->distance[r - row + 1][c - col + 1];
                    double excess = excess_of(pass, pass->from[other], pass->from[cell], distance);
                    change += (double)pass->given[other] * excess / (double)pass->excess[other];
                }
            }
        }
        pass->to[cell] = (float)((double)pass->from[cell] + change);
    }
}

/* Calls `body` for each row, on the host's threads where it lends any. */
static void for_each_row(Pass *pass, const OrographThreads *threads, void (*body)(void *, size_t)) {
    if (threads) {
        threads->parallel_for(pass->job->id, (size_t)pass->rows, pass, body);
        return;
    }
    for (ptrdiff_t row = 0; row < pass->rows; row++) {
        body(pass, (size_t)row);
    }
}

/* The job fails for this reason, and this would mend it. */
static int32_t fail(const OrographJob *job, const char *message, const char *hint) {
    OrographText text = {message, strlen(message)}, mend = {hint, strlen(hint)};
    job->host->fail(job->id, text, mend);
    return OROGRAPH_FAILED;
}

/* Hands over heights on the grid of the input. */
static int32_t put(const OrographJob *job, uint32_t port, const OrographGrid *grid, const float *cells) {
    OrographRaster raster = {sizeof raster, 0, grid, cells};
    OrographValue value = {OROGRAPH_HEIGHTFIELD, 0, {&raster}};
    return job->host->output(job->id, port, &value);
}

static int32_t run(const OrographJob *job) {
    const OrographHost *host = job->host;
    const OrographRaster *terrain = job->inputs[INPUT_TERRAIN].values->data.raster;
    const OrographGrid *grid = terrain->grid;
    const float *heights = terrain->cells;
    const float *hardness = NULL;
    if (job->inputs[INPUT_HARDNESS].count) {
        const OrographRaster *mask = job->inputs[INPUT_HARDNESS].values->data.raster;
        if (mask->grid->rows != grid->rows || mask->grid->cols != grid->cols) {
            char message[160];
            snprintf(message, sizeof message, "terrain has %llu x %llu cells but hardness has %llu x %llu",
                     (unsigned long long)grid->rows, (unsigned long long)grid->cols,
                     (unsigned long long)mask->grid->rows, (unsigned long long)mask->grid->cols);
            return fail(job, message, "resize or crop one of them to the other's grid");
        }
        hardness = mask->cells;
    }
    size_t cells = (size_t)(grid->rows * grid->cols); /* the host gives no more than fit in memory */
    for (size_t cell = 0; cell < cells; cell++) {
        if (isinf(heights[cell])) {
            return fail(job, "terrain holds an infinite height", "declare that value as nodata in the source");
        }
    }
    const OrographThreads *threads = host->extension(OROGRAPH_THREADS);
    const OrographScratch *scratch = host->extension(OROGRAPH_SCRATCH);
    /* Heights before and after the pass, what is given, and excess. */
    float *memory = scratch && cells <= SIZE_MAX / 16 ? scratch->allocate(job->id, cells * 16) : NULL;
    if (cells && !memory) {
        return fail(job, "there is no memory for four rasters as large as the terrain",
                    "lower the resolution, crop, or raise `--memory`");
    }

    Pass pass = {
        .job = job, .hardness = hardness,
        .rows = (ptrdiff_t)grid->rows, .cols = (ptrdiff_t)grid->cols,
        .gradient = tan(job->params[PARAM_TALUS].value.number * (3.14159265358979323846 / 180.0)),
        .rate = job->params[PARAM_RATE].value.number,
    };
    for (int dr = -1; dr <= 1; dr++) {
        for (int dc = -1; dc <= 1; dc++) {
            double x = dc * grid->cell_x, y = dr * grid->cell_y;
            pass.distance[dr + 1][dc + 1] = sqrt(x * x + y * y);
        }
    }
    float *now = memory, *next = NULL;
    if (cells) {
        next = memory + cells;
        pass.given = memory + 2 * cells;
        pass.excess = memory + 3 * cells;
        memcpy(now, heights, cells * sizeof(float));
    }
    int64_t passes = cells ? job->params[PARAM_PASSES].value.integer : 0;
    for (int64_t done = 0; done < passes; done++) {
        pass.from = now;
        pass.to = next;
        for_each_row(&pass, threads, give);
        for_each_row(&pass, threads, take);
        if (cancelled(job)) {
            return OROGRAPH_CANCELLED;
        }
        next = now;
        now = pass.to;
        host->progress(job->id, (double)(done + 1) / (double)passes);
    }

    if (put(job, OUTPUT_TERRAIN, grid, now) != OROGRAPH_OK) {
        return OROGRAPH_FAILED;
    }
    for (size_t cell = 0; cell < cells; cell++) {
        next[cell] = now[cell] - heights[cell];
    }
    return put(job, OUTPUT_MOVED, grid, next);
}

/* Weighs the host's display of progress. */
static double cost(uint32_t node, size_t param_count, const OrographParam *params) {
    (void)node, (void)param_count;
    return 20.0 * (double)params[PARAM_PASSES].value.integer;
}

static const void *extension(const char *name) {
    static const OrographSettings settings = {.size = sizeof settings, .cost = cost};
    return strcmp(name, OROGRAPH_SETTINGS) == 0 ? &settings : NULL;
}

const OrographPlugin orograph_plugin = {
    .size = sizeof(OrographPlugin),
    .abi_major = OROGRAPH_ABI_MAJOR,
    .abi_minor = OROGRAPH_ABI_MINOR,
    .describe = describe,
    .run = run,
    .extension = extension,
};
