/* Plugins that no host should take, one for each value of CASE. */
#include "orograph_plugin.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifndef OROGRAPH_EXPORT
#define OROGRAPH_EXPORT
#endif

#define NODE(id, more) \
  "(id: \"" id "\", version: 1, doc: \"A node.\", extent: Global, " \
  "outputs: [(name: \"number\", doc: \"A number.\", value_type: Number)]" more ")"
#define PLUGIN(name, nodes) "(name: \"" name "\", version: \"1.0\", nodes: [" nodes "])"

#define SOUND 0
#define CRASHES 1
#define HANGS 2
#define EXITS 3
#define NO_RON 4
#define HUGE 5
#define TWINS 6
#define LIES 7
#define BAD_NAME 8
#define BAD_DEFAULT 9
#define WRITES 10
#define EMPTY 11
#define NO_TEXT 12
#define CLASH 13

#if CASE == CRASHES
__attribute__((constructor)) static void at_once(void) { abort(); }
#endif

static OrographText text(const char *words) { return (OrographText){words, strlen(words)}; }

static OrographText describe(void) {
  switch (CASE) {
    case HANGS:
      for (volatile int i = 0;; i++) {}
    case EXITS:
      exit(7);
    case NO_RON:
      return text("{\"name\": \"JSON\"}");
    case HUGE: {
      const size_t len = 100u << 20;
      char *words = malloc(len);
      memset(words, '(', len);
      return (OrographText){words, len};
    }
    case TWINS:
      return text(PLUGIN("Twins", NODE("twin.node", "") ", " NODE("twin.node", "")));
    case LIES: {
      /* One thing to who looks at it, another to who runs it. */
      char line[4096] = {0};
      FILE *file = fopen("/proc/self/cmdline", "rb");
      size_t len = file ? fread(line, 1, sizeof line - 1, file) : 0;
      for (size_t i = 0; i < len; i++)
        if (line[i] == 0) line[i] = ' ';
      return text(strstr(line, " scan ") ? PLUGIN("Liar", NODE("liar.node", "")) : PLUGIN("Liar", NODE("liar.other", "")));
    }
    case BAD_NAME:
      return text(PLUGIN("Bad name", NODE("NoFamily", "")));
    case BAD_DEFAULT:
      return text(PLUGIN("Bad default", NODE("bad.default",
          ", params: [(name: \"size\", doc: \"Size.\", kind: Number(range: (0, 1), slider: (0, 1)), default: Number(2))]")));
    case WRITES:
      return text(PLUGIN("Writer", "(id: \"bad.writer\", version: 1, doc: \"Writes.\", extent: Global, writes: true)"));
    case EMPTY:
      return text(PLUGIN("Empty", ""));
    case NO_TEXT:
      return (OrographText){NULL, 5};
    case CLASH:
      return text(PLUGIN("Clash", NODE("adjust.clamp", "")));
    default:
      return text(PLUGIN("Sound", NODE("sound.node", "")));
  }
}

static int32_t run(const OrographJob *job) {
  OrographValue value = {.kind = OROGRAPH_NUMBER};
  value.data.number = ANSWER;
  return job->host->output(job->id, 0, &value);
}

#ifndef MAJOR
#define MAJOR OROGRAPH_ABI_MAJOR
#endif
#ifndef SIZE
#define SIZE sizeof(OrographPlugin)
#endif
#ifndef DESCRIBE
#define DESCRIBE describe
#endif
#ifndef NAME
#define NAME orograph_plugin
#endif

OROGRAPH_EXPORT const OrographPlugin NAME = {
    .size = SIZE, .abi_major = MAJOR, .abi_minor = 9, .describe = DESCRIBE, .run = run};

/* Functions that a case leaves out are no warning. */
OROGRAPH_EXPORT void *orograph_unused(void) { return (void *)(size_t)(&describe != NULL); }
