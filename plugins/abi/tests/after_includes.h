
/* Marks what a library exports, whatever the compiler hides by default. */
#if defined(_WIN32)
#define OROGRAPH_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define OROGRAPH_EXPORT __attribute__((visibility("default")))
#else
#define OROGRAPH_EXPORT
#endif
