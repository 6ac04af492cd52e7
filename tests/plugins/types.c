/* Hands every type of value on, and tells the size of a file that a parameter names. */
#include "orograph_plugin.h"

#include <stdio.h>
#include <string.h>

#define ECHO(name, type) \
  "(id: \"echo." name "\", version: 1, doc: \"Hands on.\", extent: Global," \
  " inputs: [(name: \"one\", doc: \"A value.\", value_type: " type ")," \
  "          (name: \"maybe\", doc: \"Another.\", value_type: " type ", arity: Optional)," \
  "          (name: \"many\", doc: \"More.\", value_type: " type ", arity: Many)]," \
  " outputs: [(name: \"value\", doc: \"The last of them.\", value_type: " type ")," \
  "           (name: \"count\", doc: \"How many there are.\", value_type: Integer)]),"

static const char SPEC[] =
    "(name: \"Types\", version: \"1.0\", nodes: ["
    ECHO("heightfield", "Heightfield") ECHO("mask", "Mask") ECHO("texture", "Texture") ECHO("features", "Features")
    ECHO("points", "Points") ECHO("placement", "Placement") ECHO("table", "Table") ECHO("mesh", "Mesh")
    ECHO("number", "Number") ECHO("integer", "Integer") ECHO("boolean", "Boolean") ECHO("text", "Text")
    "(id: \"file.size\", version: 1, doc: \"Tells the size of a file.\", extent: Global,"
    " outputs: [(name: \"bytes\", doc: \"Its bytes.\", value_type: Integer)],"
    " params: [(name: \"file\", doc: \"The file.\", kind: InputPath, default: Text(\"\"))])])";

enum { FILE_SIZE = 12 };

static OrographText describe(void) { return (OrographText){SPEC, sizeof SPEC - 1}; }

static int32_t give_integer(const OrographJob *job, uint32_t port, int64_t integer) {
  OrographValue value = {.kind = OROGRAPH_INTEGER};
  value.data.integer = integer;
  return job->host->output(job->id, port, &value);
}

static int32_t file_size(const OrographJob *job) {
  const OrographFiles *files = job->host->extension("orograph.files/1");
  OrographText path;
  if (files->input_path(job->id, job->params[0].value.text, &path) != OROGRAPH_OK) return OROGRAPH_FAILED;
  char name[4096] = {0};
  if (path.len >= sizeof name) return OROGRAPH_FAILED;
  memcpy(name, path.data, path.len);
  FILE *file = fopen(name, "rb");
  if (file == NULL) return OROGRAPH_FAILED;
  fseek(file, 0, SEEK_END);
  const int64_t bytes = ftell(file);
  fclose(file);
  return give_integer(job, 0, bytes);
}

static int32_t run(const OrographJob *job) {
  if (job->node == FILE_SIZE) return file_size(job);
  const OrographValue *last = NULL;
  int64_t count = 0;
  for (size_t port = 0; port < job->input_count; port++)
    for (size_t i = 0; i < job->inputs[port].count; i++) {
      last = &job->inputs[port].values[i];
      count++;
    }
  /* The second output first: any order will do. */
  const int32_t status = give_integer(job, 1, count);
  return status == OROGRAPH_OK ? job->host->output(job->id, 0, last) : status;
}

OROGRAPH_EXPORT const OrographPlugin orograph_plugin = {
    .size = sizeof(OrographPlugin),
    .abi_major = OROGRAPH_ABI_MAJOR,
    .abi_minor = OROGRAPH_ABI_MINOR,
    .describe = describe,
    .run = run,
};
