/* A node that hands its input on, to measure what a call costs. */
#include "orograph_plugin.h"

#include <string.h>

static const char SPEC[] =
    "(name: \"Pass through\", version: \"1.0\", nodes: [(id: \"pass.through\", version: 1, doc: \"Hands on.\","
    " inputs: [(name: \"terrain\", doc: \"Terrain.\", value_type: Heightfield)],"
    " outputs: [(name: \"terrain\", doc: \"Terrain.\", value_type: Heightfield)], extent: Local)])";

static OrographText describe(void) { return (OrographText){SPEC, sizeof SPEC - 1}; }

static int32_t run(const OrographJob *job) { return job->host->output(job->id, 0, job->inputs[0].values); }

const OrographPlugin orograph_plugin = {
    .size = sizeof(OrographPlugin), .abi_major = OROGRAPH_ABI_MAJOR, .describe = describe, .run = run};
