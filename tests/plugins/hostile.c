/* One plugin that misbehaves in the way that HOW names: a number, or a node chosen at run time. */
#include "orograph_plugin.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
#define SLEEP(ms) Sleep(ms)
#else
#include <pthread.h>
#include <unistd.h>
#define SLEEP(ms) usleep((ms) * 1000)
#endif

#ifndef HOW
#define HOW "well"
#endif
#ifndef OROGRAPH_EXPORT
#define OROGRAPH_EXPORT
#endif

#define TEXT(literal) ((OrographText){literal, sizeof(literal) - 1})

static const char SPEC[] =
    "(name: \"Hostile\", version: \"1.0\", nodes: ["
    "(id: \"hostile.node\", version: 1, doc: \"Misbehaves.\","
    " inputs: [(name: \"terrain\", doc: \"Terrain.\", value_type: Heightfield)],"
    " outputs: [(name: \"terrain\", doc: \"Terrain.\", value_type: Heightfield),"
    "           (name: \"mask\", doc: \"A mask.\", value_type: Mask)],"
    " params: [(name: \"how\", doc: \"In which way.\", kind: Text, default: Text(\"" HOW "\"))],"
    " extent: Global)])";

static OrographText describe(void) { return TEXT(SPEC); }

static int same(OrographText a, const char *b) { return a.len == strlen(b) && memcmp(a.data, b, a.len) == 0; }

static int32_t give(const OrographJob *job, uint32_t port, int32_t kind, const OrographRaster *raster) {
  OrographValue value = {.kind = kind};
  value.data.raster = raster;
  return job->host->output(job->id, port, &value);
}

#ifndef _WIN32
typedef struct {
  const OrographHost *host;
  uint64_t id;
} Late;

static void *call_late(void *context) {
  Late late = *(Late *)context;
  free(context);
  for (int i = 0; i < 200; i++) {
    OrographValue number = {.kind = OROGRAPH_NUMBER};
    late.host->progress(late.id, 0.5);
    late.host->log(late.id, OROGRAPH_LOG_WARNING, TEXT("late"));
    late.host->fail(late.id, TEXT("late"), TEXT(""));
    late.host->output(late.id, 0, &number);
    late.host->cancelled(late.id);
    SLEEP(1);
  }
  return NULL;
}

static void *call_now(void *context) {
  const OrographJob *job = context;
  for (int i = 0; i < 1000; i++) job->host->progress(job->id, i / 1000.0);
  job->host->log(job->id, OROGRAPH_LOG_WARNING, TEXT("from another thread"));
  give(job, 1, OROGRAPH_MASK, NULL);
  return NULL;
}
#endif

static void loop_for_ever(void *context, size_t index) {
  volatile size_t *sink = context;
  *sink += index;
}

static int32_t run(const OrographJob *job) {
  const OrographText how = job->params[0].value.text;
  const OrographRaster *terrain = job->inputs[0].values[0].data.raster;
  const size_t cells = (size_t)(terrain->grid->rows * terrain->grid->cols);
  float *shares = calloc(cells + 1, sizeof *shares);
  OrographGrid grid = *terrain->grid;
  OrographRaster mask = {.size = sizeof mask, .grid = &grid, .cells = shares};
  OrographRaster heights = *terrain;
  int32_t status = OROGRAPH_OK;

  if (same(how, "abort")) abort();
  if (same(how, "segfault")) *(volatile int *)16 = 1;
  if (same(how, "loop"))
    for (volatile int i = 0;; i++) {}
  if (same(how, "polite loop"))
    while (!job->host->cancelled(job->id)) SLEEP(1);
  if (same(how, "stubborn loop"))
    for (;;) {
      job->host->cancelled(job->id);
      SLEEP(1);
    }
  if (same(how, "hog"))
    for (;;) memset(malloc(64 << 20), 1, 64 << 20);
  if (same(how, "exit")) exit(0);
  if (same(how, "fail")) {
    job->host->fail(job->id, TEXT("the mountain is closed"), TEXT("come back in summer"));
    return OROGRAPH_FAILED;
  }
  if (same(how, "fail silently")) return OROGRAPH_FAILED;
  if (same(how, "panic")) return OROGRAPH_PANICKED;
  if (same(how, "cancelled")) return OROGRAPH_CANCELLED;
  if (same(how, "status")) return 77;
  if (same(how, "never")) return OROGRAPH_OK;
  if (same(how, "null host calls")) {
    job->host->output(job->id, 0, NULL);
    job->host->log(job->id, 5, (OrographText){NULL, 9});
    job->host->log(job->id, 0, TEXT("\xff\xfe"));
    job->host->progress(job->id, NAN);
    if (job->host->extension(NULL) != NULL || job->host->extension("nothing/1") != NULL) return 99;
    const OrographThreads *threads = job->host->extension("orograph.threads/1");
    threads->parallel_for(job->id, 10, NULL, NULL);
    const OrographScratch *scratch = job->host->extension("orograph.scratch/1");
    if (scratch->allocate(job->id, SIZE_MAX) != NULL) return 98;
    scratch->free(job->id, &grid);
    const OrographFiles *files = job->host->extension("orograph.files/1");
    if (files->input_path(job->id, TEXT("/etc/passwd"), NULL) == OROGRAPH_OK) return 97;
    return OROGRAPH_OK;
  }
  if (same(how, "null raster")) return give(job, 0, OROGRAPH_HEIGHTFIELD, NULL);
  if (same(how, "null cells")) heights.cells = NULL;
  if (same(how, "null grid")) heights.grid = NULL;
  if (same(how, "small struct")) heights.size = 4;
  if (same(how, "huge grid")) {
    grid.rows = grid.cols = UINT64_MAX;
    heights.grid = &grid;
  }
  if (same(how, "nan cell")) {
    grid.cell_x = NAN;
    heights.grid = &grid;
  }
  if (same(how, "nan mask")) shares[0] = NAN;
  if (same(how, "wrong port")) return give(job, 9, OROGRAPH_HEIGHTFIELD, &heights);
  if (same(how, "wrong type")) return give(job, 0, OROGRAPH_MASK, &mask);
  if (same(how, "unknown type")) return give(job, 0, 1234, &mask);
  if (same(how, "infinite")) {
    shares[0] = INFINITY;
    heights.cells = shares;
  }
#ifndef _WIN32
  if (same(how, "late")) {
    pthread_t thread;
    Late *late = malloc(sizeof *late);
    *late = (Late){job->host, job->id};
    pthread_create(&thread, NULL, call_late, late);
    pthread_detach(thread);
  }
  if (same(how, "other thread")) {
    pthread_t thread;
    pthread_create(&thread, NULL, call_now, (void *)job);
    pthread_join(thread, NULL);
  }
#endif
  if (same(how, "prints")) {
    static const char words[] = "the plugin prints\n";
    if (write(1, words, sizeof words - 1) < 0) return OROGRAPH_FAILED;
  }
  if (same(how, "leak")) {
    volatile size_t sink = 0;
    const OrographScratch *scratch = job->host->extension("orograph.scratch/1");
    const OrographThreads *threads = job->host->extension("orograph.threads/1");
    unsigned char *memory = scratch->allocate(job->id, 1 << 20);
    if (memory == NULL || memory[12345] != 0 || ((uintptr_t)memory & 63) != 0) return OROGRAPH_FAILED;
    threads->parallel_for(job->id, 1000, (void *)&sink, loop_for_ever);
  }
  give(job, 0, OROGRAPH_HEIGHTFIELD, &heights);
  if (same(how, "twice")) give(job, 0, OROGRAPH_HEIGHTFIELD, &heights);
  give(job, 1, OROGRAPH_MASK, &mask);
  free(shares);
  return status;
}

OROGRAPH_EXPORT const OrographPlugin orograph_plugin = {
    .size = sizeof(OrographPlugin),
    .abi_major = OROGRAPH_ABI_MAJOR,
    .abi_minor = OROGRAPH_ABI_MINOR,
    .describe = describe,
    .run = run,
};
