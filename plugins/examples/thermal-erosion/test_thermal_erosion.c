/* Calls the plugin as a host would, and checks what comes out. */

#include "orograph_plugin.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHECK(condition) \
    do { \
        if (!(condition)) { \
            fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition); \
            exit(1); \
        } \
    } while (0)

enum { ROWS = 61, COLS = 83, CELLS = ROWS * COLS };

static float terrain_out[CELLS], moved_out[CELLS];
static char failure[200];
static int cancel_after = -1, without_memory;
static double progress_said;

static int32_t cancelled(uint64_t job) {
    (void)job;
    return cancel_after >= 0 && cancel_after-- == 0 ? (cancel_after = 0, 1) : 0;
}
static void progress(uint64_t job, double done) {
    (void)job;
    progress_said = done;
}
static void say(uint64_t job, int32_t level, OrographText message) {
    (void)job, (void)level, (void)message;
}
static void fail(uint64_t job, OrographText message, OrographText hint) {
    (void)job;
    CHECK(hint.len > 0);
    snprintf(failure, sizeof failure, "%.*s", (int)message.len, message.data);
}
static int32_t output(uint64_t job, uint32_t port, const OrographValue *value) {
    (void)job;
    CHECK(value->kind == OROGRAPH_HEIGHTFIELD && port < 2);
    const OrographRaster *raster = value->data.raster;
    size_t bytes = (size_t)(raster->grid->rows * raster->grid->cols) * sizeof(float);
    if (bytes) {
        memcpy(port ? moved_out : terrain_out, raster->cells, bytes);
    }
    return OROGRAPH_OK;
}
static void *scratch_memory;
static void *allocate(uint64_t job, size_t bytes) {
    (void)job;
    return without_memory ? NULL : (scratch_memory = calloc(1, bytes ? bytes : 1));
}
static void release(uint64_t job, void *memory) {
    (void)job, (void)memory;
}
static uint32_t count(uint64_t job) {
    (void)job;
    return 1;
}
/* Backwards: the order of rows must not count. */
static void parallel_for(uint64_t job, size_t n, void *context, void (*body)(void *, size_t)) {
    (void)job;
    while (n-- > 0) {
        body(context, n);
    }
}
static int without_threads;
static const void *extension(const char *name) {
    static const OrographScratch scratch = {sizeof scratch, 0, allocate, release};
    static const OrographThreads threads = {sizeof threads, 0, count, parallel_for};
    if (!strcmp(name, OROGRAPH_SCRATCH)) {
        return &scratch;
    }
    return !strcmp(name, OROGRAPH_THREADS) && !without_threads ? &threads : NULL;
}

static const OrographHost host = {
    sizeof host, OROGRAPH_ABI_MAJOR, OROGRAPH_ABI_MINOR, 0, cancelled, progress, say, fail, output, extension,
};

static int32_t erode_grid(const OrographGrid *grid, const float *cells, const OrographRaster *hardness,
                          double talus, int64_t passes) {
    OrographParam params[3] = {
        {OROGRAPH_PARAM_NUMBER, 0, {.number = talus}},
        {OROGRAPH_PARAM_NUMBER, 0, {.number = 0.5}},
        {OROGRAPH_PARAM_INTEGER, 0, {.integer = passes}},
    };
    OrographRaster raster = {sizeof raster, 0, grid, cells};
    OrographValue terrain = {OROGRAPH_HEIGHTFIELD, 0, {&raster}};
    OrographValue mask = {OROGRAPH_MASK, 0, {hardness}};
    OrographInput inputs[2] = {{1, &terrain}, {hardness ? 1 : 0, &mask}};
    OrographJob job = {.size = sizeof job, .id = 1, .host = &host, .param_count = 3, .params = params,
                       .input_count = 2, .inputs = inputs, .memory_limit = 1 << 30};
    int32_t status = orograph_plugin.run(&job);
    free(scratch_memory);
    scratch_memory = NULL;
    return status;
}

static const OrographGrid GRID = {
    .size = sizeof(OrographGrid), .rows = ROWS, .cols = COLS, .cell_x = 20.0, .cell_y = 30.0,
};

static int32_t erode(const float *cells, const OrographRaster *hardness, double talus, int64_t passes) {
    return erode_grid(&GRID, cells, hardness, talus, passes);
}

static void tower(float *cells) {
    for (int cell = 0; cell < CELLS; cell++) {
        int row = cell / COLS - ROWS / 2, col = cell % COLS - COLS / 2;
        cells[cell] = row * row < 36 && col * col < 36 ? 400.0f : 100.0f;
    }
}

/* The steepest slope between neighbours, in metres per metre. */
static double steepest(const float *cells) {
    double most = 0.0;
    for (int row = 0; row < ROWS; row++) {
        for (int col = 0; col < COLS; col++) {
            for (int step = 0; step < 4; step++) {
                int r = row + (int[]){0, 1, 1, 1}[step], c = col + (int[]){1, -1, 0, 1}[step];
                if (r < ROWS && c >= 0 && c < COLS) {
                    double x = (c - col) * 20.0, y = (r - row) * 30.0;
                    double slope = fabs(cells[row * COLS + col] - cells[r * COLS + c]) / sqrt(x * x + y * y);
                    most = slope > most ? slope : most;
                }
            }
        }
    }
    return most;
}

static double sum(const float *cells) {
    double total = 0.0;
    for (int cell = 0; cell < CELLS; cell++) {
        total += cells[cell];
    }
    return total;
}

int main(void) {
    static float cells[CELLS], first[CELLS], mask[CELLS];
    OrographRaster hardness = {sizeof hardness, 0, &GRID, mask};

    /* A tower becomes a cone at the talus angle, and no rock is lost. */
    tower(cells);
    CHECK(erode(cells, NULL, 35.0, 4000) == OROGRAPH_OK);
    double rest = tan(35.0 * 3.14159265358979323846 / 180.0);
    CHECK(steepest(terrain_out) < rest * 1.01 && steepest(terrain_out) > rest * 0.9);
    CHECK(fabs(sum(terrain_out) - sum(cells)) < 1e-5 * sum(cells));
    CHECK(fabs(sum(moved_out)) < 1e-5 * sum(cells));
    CHECK(progress_said == 1.0);

    /* What rests already stays as it is. */
    memcpy(first, terrain_out, sizeof first);
    for (int cell = 0; cell < CELLS; cell++) {
        cells[cell] = (float)(0.3 * 20.0 * (cell % COLS));
    }
    CHECK(erode(cells, NULL, 35.0, 10) == OROGRAPH_OK && !memcmp(terrain_out, cells, sizeof cells));

    /* Rows in order or backwards give the same bits. */
    tower(cells);
    CHECK(erode(cells, NULL, 30.0, 25) == OROGRAPH_OK);
    memcpy(first, terrain_out, sizeof first);
    without_threads = 1;
    CHECK(erode(cells, NULL, 30.0, 25) == OROGRAPH_OK && !memcmp(terrain_out, first, sizeof first));
    without_threads = 0;

    /* Hard rock stays, and voids stay voids and let nothing through. */
    for (int cell = 0; cell < CELLS; cell++) {
        mask[cell] = 1.0f;
    }
    CHECK(erode(cells, &hardness, 35.0, 25) == OROGRAPH_OK && !memcmp(terrain_out, cells, sizeof cells));
    for (int cell = 0; cell < CELLS; cell++) {
        int row = cell / COLS - ROWS / 2, col = cell % COLS - COLS / 2;
        cells[cell] = row * row < 49 && col * col < 49 ? cells[cell] : NAN;
    }
    CHECK(erode(cells, NULL, 35.0, 500) == OROGRAPH_OK);
    double before = 0.0, after = 0.0;
    for (int cell = 0; cell < CELLS; cell++) {
        CHECK(isnan(cells[cell]) == isnan(terrain_out[cell]) && isnan(cells[cell]) == isnan(moved_out[cell]));
        before += isnan(cells[cell]) ? 0.0 : cells[cell];
        after += isnan(cells[cell]) ? 0.0 : terrain_out[cell];
    }
    CHECK(fabs(after - before) < 1e-5 * before);

    /* Cancelled, without memory, infinite, of another size, empty. */
    tower(cells);
    cancel_after = 20;
    CHECK(erode(cells, NULL, 35.0, 100) == OROGRAPH_CANCELLED);
    cancel_after = -1;
    without_memory = 1;
    CHECK(erode(cells, NULL, 35.0, 1) == OROGRAPH_FAILED && strstr(failure, "memory"));
    without_memory = 0;
    cells[7] = INFINITY;
    CHECK(erode(cells, NULL, 35.0, 1) == OROGRAPH_FAILED && strstr(failure, "infinite"));
    tower(cells);
    OrographGrid other = GRID, none = GRID;
    other.rows = 3;
    hardness.grid = &other;
    CHECK(erode(cells, &hardness, 35.0, 1) == OROGRAPH_FAILED && strstr(failure, "61 x 83"));
    none.rows = 0;
    CHECK(erode_grid(&none, NULL, NULL, 35.0, 5) == OROGRAPH_OK);

    puts("thermal erosion: all well");
    return 0;
}
